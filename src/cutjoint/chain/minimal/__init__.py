"""Minimal coordinates: a closed robot, whatever drives it, in as many velocities as it has freedoms."""

from cutjoint.chain.minimal.coordinates import MinimalCoordinates
from cutjoint.chain.minimal.linearisation import Linearisation

__all__ = ["Linearisation", "MinimalCoordinates"]
