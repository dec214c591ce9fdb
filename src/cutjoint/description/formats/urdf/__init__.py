"""URDF, plain and in the two dialects that have loops."""
