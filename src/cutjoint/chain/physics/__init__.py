"""What the joints and cuts of a chain do by themselves: dampers, friction, springs, stops and bushings."""

from cutjoint.chain.physics.chain_physics import ChainPhysics, Elastic

__all__ = ["ChainPhysics", "Elastic"]
