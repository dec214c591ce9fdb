"""Accuracy: how far off the tool is for tolerances of lengths, backlash and warmth, and what causes how much of it."""
