"""Retiming: the quickest motion along a path within limits of speed, acceleration, jerk, effort and power."""
