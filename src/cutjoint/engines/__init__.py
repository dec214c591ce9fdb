"""Other physics engines as further opinions on a closed chain.  Each is an optional dependency, imported when asked."""
