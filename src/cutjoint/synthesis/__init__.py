"""Synthesis: lengths, mounting and masses of a robot chosen for what it shall be able to do."""
