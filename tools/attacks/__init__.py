"""Spoiled and hostile input, made at random from seeds: a module a kind, run by `tools/fuzz.py` and by the tests."""
