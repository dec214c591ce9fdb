"""An object of every public class: found by looking at what a few robots, runs and pictures are made of."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields, is_dataclass

import numpy as np

import cutjoint
from cutjoint import chain, control, crosscheck, description, mechanism, motion, simulation
from cutjoint.chain.physics import ChainPhysics, Elastic
from cutjoint.compile import Options
from cutjoint.compile.many.closed_loop import ClosedLoop
from cutjoint.crosscheck import Cost, Reacher, workspace_box
from cutjoint.description.formats import FORMATS
from cutjoint.errors import Problem
from cutjoint.simulation import hardware, integrators

Maker = Callable[[], object]


def walked(seeds: Iterator[object], most: int = 4) -> dict[type, object]:
    """Objects of cutjoint's classes that seeds and their parts are, by class: fields, attributes, items."""
    found: dict[type, object] = {}
    seen: set[int] = set()
    todo = [(one, 0) for one in seeds]
    while todo:
        one, depth = todo.pop(0)
        if id(one) in seen or isinstance(one, str | bytes | int | float | np.ndarray | type):
            continue
        seen.add(id(one))
        if type(one).__module__.startswith("cutjoint."):
            found.setdefault(type(one), one)
        if depth < most:
            todo += [(part, depth + 1) for part in _inside(one)]
    return found


def _inside(one: object) -> list[object]:
    if isinstance(one, Mapping):
        return list(one.values())[:20]
    if isinstance(one, tuple | list):
        return list(one)[:20]
    if not type(one).__module__.startswith("cutjoint."):
        return []
    if is_dataclass(one):
        return [getattr(one, field.name) for field in fields(one)]
    return [value for name, value in getattr(one, "__dict__", {}).items()]


def quick_seeds() -> Iterator[object]:
    """What is made without compiling and without a picture."""
    robot, paper, other = cutjoint.load("fivebar"), cutjoint.published("omega3"), cutjoint.published("cpm")
    q, pose = robot.home.q, robot.task.home
    point, away = pose.position, pose.moved([0.02, 0.0, 0.0]).position
    corners = motion.Corners(np.array([point, away]), [1.0], 0.1)
    hold = motion.Hold.at_home(robot, 1.0)
    reference = motion.Reference(hold, robot)
    yield from (robot, robot.description, paper, other, cutjoint.published("cpm_rotary"), reference, hold)
    yield from (robot.home, robot.task, robot.tool(robot.home), robot.terms(robot.home), pose, robot.mobility())
    yield from (robot.minimal(), robot.reactions(robot.home), robot.working_modes(starts=4), robot.task.target(pose))
    yield from (robot.minimal().linearised(robot.home), robot.actuator_efforts(robot.home, [0.0, 0.0], [0.0, 0.0]))
    yield reference.at(0.0)
    yield cutjoint.Load([1.0, 0.0, 0.0])
    x, y = np.eye(3)[:2]
    yield motion.PointToPoint(point, away)
    yield motion.Trapezoidal(point, away)
    yield motion.Circle(point, 0.1, 1.0)
    yield motion.Lissajous(point, x, x, x, 1.0)
    yield motion.Spiral.from_home(robot, 0.01, 2.0, 1.0)
    yield motion.PoseMove(pose)
    yield motion.PickAndPlace(point, 0.01 * x, 0.01 * y, 1.0)
    yield motion.JointSine(q, 0.1 * q, q, q, 1.0)
    yield motion.JointChirp(q, 0.1 * q, [0.1, 1.0], 1.0)
    yield from (corners, motion.Waypoints(corners), motion.JointWaypoints(corners))
    yield motion.PointSpline([0.0, 1.0, 2.0], np.array([point, away, point]))
    yield motion.JointSpline([0.0, 1.0, 2.0], np.array([q, q + 0.1, q]))
    yield motion.PoseSpline([0.0, 1.0, 2.0], [pose, pose.moved([0.1, 0.0, 0.0]), pose])
    yield motion.JointMotion(q, q, q)
    yield from (control.PD(1.0, 2.0), control.PID(1.0, 2.0, 3.0), control.NoControl(), control.PDGravity(robot, 1.0, 2.0))
    yield from (control.Feedforward(robot, 1.0, 2.0), control.ComputedTorque(robot, 1.0, [2.0, 3.0]))
    yield control.as_law(lambda t, desired, q, v: [0.0, 0.0])
    yield control.GivenEfforts(control.EffortTable([0.0, 1.0], np.zeros((2, 2))))
