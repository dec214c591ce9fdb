"""Expressions: the graph they live in, their derivatives, vectors of them, and the straight line they make."""
