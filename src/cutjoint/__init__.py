"""Robots whose links form closed loops.

A URDF of the open tree plus the cut joints, closed with Pinocchio.  What there is, by what is wanted:

    cutjoint.load("omega3")         a robot by name, or by a path to its folder or file: a `ClosedChain`
    cutjoint.published("omega3")    the reduced model of a paper; both are a `Mechanism`
    robot.reach, close, terms, inverse_dynamics, forward_dynamics, mobility, reactions, compile, minimal

    cutjoint.motion                 trajectories of tool and actuators; `Reference` looks at one through a robot
    cutjoint.control                laws that follow it: `PD`, `PDGravity`, `ComputedTorque`, ..., or a function
    cutjoint.simulation             `run` puts them together and gives a `Result`; `save` and `load` keep it
    cutjoint.viewer                 `show` and `play` robots, motions and results in a browser, notebook or file

    cutjoint.workspace, sizing, retiming, stiffness, accuracy, tuning, studies, synthesis      what engineers ask of it

    cutjoint.description            the robot's files as values, and their checks
    cutjoint.errors                 every error that is raised on purpose, all of them `CutjointError`

Everything is imported on first use, so that the program `cutjoint` watches signals before it loads anything.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from cutjoint import accuracy as accuracy
    from cutjoint import chain as chain
    from cutjoint import compile as compile
    from cutjoint import control as control
    from cutjoint import crosscheck as crosscheck
    from cutjoint import description as description
    from cutjoint import errors as errors
    from cutjoint import mechanism as mechanism
    from cutjoint import motion as motion
    from cutjoint import papers as papers
    from cutjoint import retiming as retiming
    from cutjoint import robots as robots
    from cutjoint import simulation as simulation
    from cutjoint import sizing as sizing
    from cutjoint import stiffness as stiffness
    from cutjoint import studies as studies
    from cutjoint import synthesis as synthesis
    from cutjoint import tuning as tuning
    from cutjoint import viewer as viewer
    from cutjoint import workspace as workspace
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
_ROOMS = {
    room: f"cutjoint.{room}"
    for room in (
        *("chain", "compile", "control", "crosscheck", "description", "errors", "mechanism", "motion", "papers"),
        *("robots", "simulation", "viewer"),
        *("accuracy", "retiming", "sizing", "stiffness", "studies", "synthesis", "tuning", "workspace"),
    )
}
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
    if name.startswith("_"):
        raise AttributeError(f"module 'cutjoint' has no attribute '{name}'")
    from difflib import get_close_matches

    near = get_close_matches(name, [*__all__, *_ROOMS], n=1)
    hint = f"; did you mean '{near[0]}'?" if near else "; dir(cutjoint) lists what it has"
    raise AttributeError(f"module 'cutjoint' has no attribute '{name}'{hint}")


def __dir__() -> list[str]:
    return sorted({*__all__, *_ROOMS, *(name for name in globals() if name.startswith("__"))})
