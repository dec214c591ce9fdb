"""The robot moved by hand: walks along a branch, the puppet of the control panel, and its live page."""
