"""The robots under urdf/ as Python values: one module a robot, written to disk by tools/make_robots.py."""
