"""Robots on disk and as values: readers, checks, and the catalogue of robots that ship with cutjoint."""
