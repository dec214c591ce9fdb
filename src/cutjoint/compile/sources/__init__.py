"""Models that can be compiled, as sources of expressions."""
