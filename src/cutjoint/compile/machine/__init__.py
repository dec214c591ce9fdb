"""From a program to something that can be called: the order of instructions, and the back ends."""
