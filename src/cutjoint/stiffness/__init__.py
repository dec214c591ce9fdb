"""Stiffness at the tool of closed robots whose actuators, joints and rods give way, and deflection under load."""

from cutjoint.stiffness.elastic import ElasticRobot, stiffness
from cutjoint.stiffness.springs import Beam, Springs
from cutjoint.stiffness.values import Contribution, Principal, PushedTool, ToolStiffness

__all__ = ["Beam", "Contribution", "ElasticRobot", "Principal", "PushedTool", "Springs", "ToolStiffness", "stiffness"]
