"""Sizing: what motors, gears, brakes and bearings of a robot must give along trajectories."""
