"""The Cartesian Parallel Manipulator, reduced model; with linear and with rotary motors.

A. Elkady, G. Elkobrosy, S. Hanna, T. Sobh: Cartesian Parallel Manipulator Modeling, Control and Simulation.
In: Parallel Manipulators, Towards New Applications, I-Tech, 2008, ISBN 978-3-902613-40-0.
"""

from cutjoint.papers.cpm.model import CpmModel, InferredCpmModel
from cutjoint.papers.cpm.parameters import CpmParameters
from cutjoint.papers.cpm.rotary_model import CpmRotaryModel

Parameters = CpmParameters

__all__ = ["CpmModel", "CpmParameters", "CpmRotaryModel", "InferredCpmModel", "Parameters"]
