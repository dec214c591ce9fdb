"""Published robots with closed loops, tried one by one; tools/corpus.py is the command."""
