"""URDF, plain and in its dialects that have loops."""
