"""A robot as a scene: shapes, the scene by path, and the figure of one robot."""
