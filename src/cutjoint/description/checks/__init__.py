"""What must hold of a description whatever file it came from; a topic a module."""
