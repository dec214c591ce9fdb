"""cutjoint: robots whose links form closed loops.

A URDF of the open tree plus the cut joints, closed with Pinocchio.  `load` gives the closed chain, `published` the
reduced model of a paper; both are a `Mechanism`.  Everything is imported on first use, so that the program `cutjoint`
watches signals before it loads anything.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from cutjoint.chain import ClosedChain, FullMotion, MobilityReport
    from cutjoint.chain.minimal import MinimalCoordinates
    from cutjoint.compile import CompiledChain, CompiledPaper, compiled_plant
    from cutjoint.compile.compiler import compiled
    from cutjoint.description import RobotDescription, load_description
    from cutjoint.description.check import check
    from cutjoint.errors import CutjointError
    from cutjoint.mechanism import Actuator, Load, Mechanism, Pose, Posture, Task, Terms, Tool, kinetic_energy
    from cutjoint.report import Plot, RunPage, plot, run_report
    from cutjoint.robots import load, published

__version__ = "0.1.0"

_LAZY = {
    **dict.fromkeys(
        ("Actuator", "Load", "Mechanism", "Pose", "Posture", "Task", "Terms", "Tool"), "cutjoint.mechanism"
    ),
    "ClosedChain": "cutjoint.chain",
    "CompiledChain": "cutjoint.compile",
    "CompiledPaper": "cutjoint.compile",
    "CutjointError": "cutjoint.errors",
    "FullMotion": "cutjoint.chain",
    "MinimalCoordinates": "cutjoint.chain.minimal",
    "MobilityReport": "cutjoint.chain",
    "RobotDescription": "cutjoint.description",
    "check": "cutjoint.description",
    "compiled": "cutjoint.compile",
    "compiled_plant": "cutjoint.compile",
    "kinetic_energy": "cutjoint.mechanism",
    "load_description": "cutjoint.description",
    "load": "cutjoint.robots",
    "published": "cutjoint.robots",
    **dict.fromkeys(("Plot", "RunPage", "plot", "run_report"), "cutjoint.report"),
}
_ROOMS = {"errors": "cutjoint.errors", "mechanism": "cutjoint.mechanism"}
"""At hand without an import of their own."""

__all__ = [
    "Actuator",
    "ClosedChain",
    "CompiledChain",
    "CompiledPaper",
    "CutjointError",
    "FullMotion",
    "Load",
    "Mechanism",
    "MinimalCoordinates",
    "MobilityReport",
    "Plot",
    "Pose",
    "Posture",
    "RobotDescription",
    "RunPage",
    "Task",
    "Terms",
    "Tool",
    "__version__",
    "check",
    "compiled",
    "compiled_plant",
    "kinetic_energy",
    "load",
    "load_description",
    "plot",
    "published",
    "run_report",
]


def __getattr__(name: str) -> Any:
    if name in _LAZY:
        return getattr(import_module(_LAZY[name]), name)
    if name in _ROOMS:
        return import_module(_ROOMS[name])
    raise AttributeError(f"module 'cutjoint' has no attribute '{name}'")
