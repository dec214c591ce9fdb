"""The functions that are compiled of a model: what they are, how they are checked, and where they are kept."""
