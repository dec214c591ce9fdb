"""Closing the loops: from any configuration, on one branch, in short steps, and up to rounding."""
