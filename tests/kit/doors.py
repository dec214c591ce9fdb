"""Public functions, methods and classes with usual arguments, and what is given in place of each of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

import cutjoint
from cutjoint import accuracy, control, crosscheck, mechanism, motion, simulation, sizing, stiffness
from cutjoint.compile import Options
from cutjoint.simulation import hardware


class Door(NamedTuple):
    """A call as it is meant.

    Attributes:
        name: of it, for messages.
        call: what is called.
        usual: its arguments by name; positional-only ones by their number.
    """

    name: str
    call: Callable[..., object]
    usual: Mapping[str, object]


@cache
def odd_values() -> dict[str, object]:
    """What is given in place of an argument."""
    robot, other = fivebar(), cutjoint.load("fourbar")
    return {
        "None": None,
        "text": "text",
        "number": 3.5,
        "negative": -1,
        "flag": True,
        "object": object(),
        "list": [],
        "dict": {},
        "nan": np.array([np.nan]),
        "texts": ["1", "2"],
        "class": dict,
        "function": len,
        "posture": other.home,
        "chain": robot,
        "description": robot.description,
        "trajectory": motion.Hold.at_home(robot, 1.0),
        "reference": reference(),
        "law": control.NoControl(),
        "result": result(),
        "bytes": b"\x00",
    }


@cache
def fivebar() -> cutjoint.ClosedChain:
    return cutjoint.load("fivebar")


@cache
def reference() -> motion.Reference:
    return motion.Reference(motion.Hold.at_home(fivebar(), 1.0), fivebar())


@cache
def result() -> simulation.Result:
    plant = simulation.ReducedPlant(fivebar())
    return simulation.run(plant, control.PD(10.0, 1.0), reference(), rate=100.0, duration=0.02)


def of_package() -> Iterator[Door]:
    robot = fivebar()
    usual = {"robot": "fivebar", "variant": None, "home": None, "dynamics": "real", "lenient": False}
    yield Door("load", cutjoint.load, usual)
    yield Door("published", cutjoint.published, {"robot": "cpm"})
    yield Door("check", cutjoint.check, {"robot": "fivebar", "lenient": False})
    usual = {"source": "fivebar"}
    yield Door("load_description", cutjoint.load_description, usual)
    yield Door("compiled", cutjoint.compiled, {"model": robot, "quick": True})
    yield Door("compiled_plant", cutjoint.compiled_plant, {"robot": robot.compile()})
    yield Door("kinetic_energy", cutjoint.kinetic_energy, {"mechanism": robot, "at": robot.home, "v": [1.0, 2.0]})
    yield Door("ClosedChain", cutjoint.ClosedChain, {"description": robot.description, "home": None})
    yield Door("Options", Options, {"parameters": (), "ranges": {}})
    usual = {"mechanism": robot, "samples": 2, "seed": 0}
    yield Door("sample_states", lambda **given: list(crosscheck.sample_states(**given)), usual)
    states = list(crosscheck.sample_states(robot, 2, 0))
    yield Door("compare", crosscheck.compare, {"checked": robot, "reference": robot, "states": states})
    yield Door("workspace_box", crosscheck.workspace_box, {"mechanism": robot})


def of_mechanisms() -> Iterator[Door]:
    robot = fivebar()
    v, a, down = [0.1, 0.2], [0.0, 0.1], cutjoint.Load([0.0, 0.0, -5.0])
    for kind, one in (("chain", robot), ("compiled", robot.compile()), ("paper", cutjoint.published("omega3"))):
        n, at = one.n, one.home
        v, a = np.full(n, 0.1).tolist(), np.full(n, 0.2).tolist()
        target = one.tool(at).position
        yield Door(f"{kind}.close", one.close, {"q": at.q, "near": None, "limits": "respect"})
        usual = {"target": target, "near": None, "free": False, "limits": "respect"}
        yield Door(f"{kind}.reach", one.reach, usual)
        yield Door(f"{kind}.tool", one.tool, {"at": at, "v": None})
        yield Door(f"{kind}.terms", one.terms, {"at": at, "v": None})
        yield Door(f"{kind}.potential_energy", one.potential_energy, {"at": at})
        yield Door(f"{kind}.dissipation", one.dissipation, {"at": at, "v": v})
        yield Door(f"{kind}.load_effort", one.load_effort, {"at": at, "loads": down})
        yield Door(f"{kind}.inverse_dynamics", one.inverse_dynamics, {"at": at, "v": v, "a": a, "loads": ()})
        yield Door(f"{kind}.forward_dynamics", one.forward_dynamics, {"at": at, "v": v, "effort": a, "loads": ()})
        yield Door(f"{kind}.with_payload", one.with_payload, {"mass": 0.1})


def of_chain() -> Iterator[Door]:
    robot = fivebar()
    at, v, a = robot.home, [0.1, 0.2], [0.0, 0.1]
    full = np.zeros(robot.nv)
    methods: dict[str, dict[str, object]] = {
        "posture": {"at": at},
        "assemble": {"at": at, "keep_actuators": True},
        "project": {"q_full": at.q_full, "v_full": full},
        "goes_beyond": {"start": at.q_full, "q_full": at.q_full},
        "working_modes": {"at": None, "hold": None, "starts": 5},
        "assembly_modes": {"at": None, "limbs": False, "starts": 5},
        "mobility": {"at": None},
        "limit_violations": {"at": at},
        "tangent": {"at": at},
        "full_velocity": {"at": at, "v": v},
        "drift": {"at": at, "v": v},
        "full_dissipation": {"at": at, "v_full": full},
        "spring_energy": {"at": at},
        "reactions": {"at": at, "v": v, "a": a},
        "minimal": {},
        "compile": {},
    }
    for name, usual in methods.items():
        yield Door(f"chain.{name}", getattr(robot, name), usual)
    minimal = robot.minimal()
    for name, usual in {
        "of": {"values_full": full},
        "tangent": {"at": at},
        "full_velocity": {"at": at, "v": v},
        "terms": {"at": at, "v": None},
        "forward_dynamics": {"at": at, "v": v, "effort": a},
    }.items():
        yield Door(f"minimal.{name}", getattr(minimal, name), usual)


def of_values() -> Iterator[Door]:
    robot = fivebar()
    pose = robot.task.home
    yield Door("Load", cutjoint.Load, {"force": [0.0, 0.0, 1.0]})
    yield Door("Pose", cutjoint.Pose, {"position": np.zeros(3), "rotation": np.eye(3)})
    yield Door("Pose.of", cutjoint.Pose.of, {"given": pose})
    yield Door("Pose.moved", pose.moved, {"by": [0.1, 0.0, 0.0], "turn": [0.0, 0.0, 0.1]})
    yield Door("Task.target", robot.task.target, {"given": {"x": 0.03, "z": 0.3}})
    yield Door("Task.coordinates", robot.task.coordinates, {"pose": pose})
    yield Door("posture[]", robot.home.__getitem__, {"0": "left_shoulder"})
    yield Door("Task", mechanism.Task, {"names": ("x", "y"), "home": pose, "robot": "robot"})


def of_motion() -> Iterator[Door]:
    robot = fivebar()
    pose, n, q = robot.task.home, robot.n, robot.home.q
    hold = motion.Hold.at_home(robot, 1.0)
    point, away = pose.position, pose.moved([0.02, 0.0, 0.0]).position
    yield Door("Hold", motion.Hold, {"position": point, "duration": 1.0, "name": "hold"})
    yield Door("PointToPoint", motion.PointToPoint, {"start": point, "goal": away, "duration": 1.0, "name": "line"})
    usual = {"start": point, "goal": away, "duration": 1.0, "name": "line", "ramp": 0.2}
    yield Door("Trapezoidal", motion.Trapezoidal, usual)
    x, y = np.eye(3)[:2]
    usual = {"centre": point, "radius": 0.1, "rate": 1.0, "first": x, "second": y, "name": "circle"}
    yield Door("Circle", motion.Circle, usual)
    usual = {
        "centre": point,
        "amplitude": x,
        "rate": x,
        "phase": x,
        "duration": 1.0,
        "name": "curve",
        "axes": np.eye(3),
    }
    yield Door("Lissajous", motion.Lissajous, usual)
    usual = {"start": pose, "by": x, "turn": y, "duration": 1.0, "given": None, "name": "move"}
    yield Door("PoseMove", motion.PoseMove, usual)
    usual = {"start": point, "up": 0.01 * y, "across": 0.01 * x, "duration": 1.0}
    yield Door("PickAndPlace", motion.PickAndPlace, usual)
    zero = np.zeros(n)
    usual = {"centre": q, "amplitude": zero, "rate": zero, "phase": zero, "duration": 1.0, "name": "sine"}
    yield Door("JointSine", motion.JointSine, usual)
    usual = {"centre": q, "amplitude": zero, "hertz": [0.1, 1.0], "duration": 1.0, "name": "chirp"}
    yield Door("JointChirp", motion.JointChirp, usual)
    corners = motion.Corners(np.array([point, away]), [1.0], 0.1)
    yield Door("Corners", motion.Corners, {"points": np.array([point, away]), "seconds": [1.0], "blend": 0.1})
    yield Door("Waypoints", motion.Waypoints, {"corners": corners, "name": "points"})
    yield Door("JointWaypoints", motion.JointWaypoints, {"corners": corners, "name": "points"})
    times = [0.0, 0.5, 1.0]
    yield Door("PointSpline", motion.PointSpline, {"times": times, "points": np.array([point, away, point])})
    yield Door("JointSpline", motion.JointSpline, {"times": times, "q": np.array([q, q + 0.1, q])})
    yield Door("PoseSpline", motion.PoseSpline, {"times": times, "poses": [pose, pose.moved([0.01, 0, 0]), pose]})
    yield Door("ToolMotion", motion.ToolMotion, {"position": point, "velocity": x, "acceleration": x})
    yield Door("JointMotion", motion.JointMotion, {"q": q, "v": q, "a": q})
    yield Door("Hold.at_home", motion.Hold.at_home, {"mechanism": robot, "seconds": 1.0})
    yield Door("Circle.through_home", motion.Circle.through_home, {"mechanism": robot, "radius": 0.01, "seconds": 1.0})
    usual = {"mechanism": robot, "width": 0.01, "height": 0.01, "seconds": 1.0}
    yield Door("Lissajous.through_home", motion.Lissajous.through_home, usual)
    usual = {"mechanism": robot, "x": 0.01, "y": 0.01, "z": 0.0, "seconds": 1.0}
    yield Door("PointToPoint.from_home", motion.PointToPoint.from_home, usual)
    yield Door("Trapezoidal.from_home", motion.Trapezoidal.from_home, usual)
    yield Door(
        "Spiral.from_home", motion.Spiral.from_home, {"mechanism": robot, "radius": 0.01, "turns": 2.0, "seconds": 1.0}
    )
    yield Door(
        "PickAndPlace.from_home", motion.PickAndPlace.from_home, {"mechanism": robot, "seconds": 1.0, "width": 0.01}
    )
    yield Door("JointSine.from_home", motion.JointSine.from_home, {"mechanism": robot, "amplitude": 0.1, "hertz": 1.0})
    usual = {"mechanism": robot, "amplitude": 0.1, "low": 0.1, "high": 2.0, "seconds": 10.0}
    yield Door("JointChirp.from_home", motion.JointChirp.from_home, usual)
    yield Door(
        "Reference", motion.Reference, {"trajectory": hold, "mechanism": robot, "duration": None, "limits": "respect"}
    )
    yield Door("Reference.at", reference().at, {"t": 0.1})
    yield Door("Desired.posture_of", reference().at(0.0).posture_of, {"model": robot})


def of_control() -> Iterator[Door]:
    robot = fivebar()
    gains = {"kp": 10.0, "kd": 1.0}
    yield Door("PD", control.PD, gains)
    yield Door("PID", control.PID, {**gains, "ki": 1.0})
    for kind in (control.PDGravity, control.Feedforward, control.ComputedTorque):
        yield Door(kind.__name__, kind, {"model": robot, **gains})
    yield Door("critically_damped", control.ComputedTorque.critically_damped, {"model": robot, "kd": 1.0})
    yield Door("as_law", control.as_law, {"given": control.NoControl()})
    yield Door("law", control.law, {"name": "pd", "model": robot, "gains": gains})
    yield Door("GivenEfforts", control.GivenEfforts, {"efforts": lambda t: [0.0, 0.0]})
    yield Door("EffortTable", control.EffortTable, {"time": [0.0, 1.0], "efforts": np.zeros((2, 2))})


def of_simulation(folder: Path) -> Iterator[Door]:
    robot = fivebar()
    usual = {"robot": robot, "law": control.PD(10.0, 1.0), "reference": reference(), "duration": 0.005}
    more: dict[str, object] = {
        "integrator": None,
        "rate": None,
        "limits": None,
        "hardware": None,
        "run_number": 0,
        "every": None,
        "start": None,
        "start_velocity": None,
        "lock": (),
        "loads": None,
        "joint_limits": "respect",
        "progress": None,
    }
    yield Door("run", simulation.run, {**usual, **more})
    yield Door("save", simulation.save, {"result": result(), "path": folder / "kept.npz"})
    simulation.save(result(), folder / "there.npz")
    yield Door("simulation.load", simulation.load, {"path": folder / "there.npz"})
    yield Door("reactions_of", simulation.reactions_of, {"result": result(), "chain": robot})
    yield Door("worst_error", result().worst_error, {"after": 0.0})
    for kind in (simulation.ReducedPlant, simulation.ConstrainedPlant):
        name = "mechanism" if kind is simulation.ReducedPlant else "chain"
        yield Door(kind.__name__, kind, {name: robot})
    yield Door("MinimalPlant", simulation.MinimalPlant, {"minimal": robot.minimal()})


def of_hardware() -> Iterator[Door]:
    yield Door("Clock", hardware.Clock, {"rate": 1000.0})
    yield Door("Encoder", hardware.Encoder, {"resolution": 1e-4, "noise": 1e-5, "delay": 1e-3})
    yield Door("Drive", hardware.Drive, {"limits": 20.0, "delay": 1e-3})
    usual = {"clock": hardware.Clock(1000.0), "encoder": hardware.Encoder(), "drive": hardware.Drive()}
    yield Door("Hardware", hardware.Hardware, usual)


def of_sizing(folder: Path) -> Iterator[Door]:
    robot = fivebar()
    motor = {"name": "m", "kind": "rotation", "rated": 1.0, "peak": 4.0, "max_speed": 300.0, "rotor": 1e-5}
    yield Door("ServoMotor", sizing.ServoMotor, motor)
    between = {"efficiency": 0.9, "inertia": 0.0, "pitch": None, "brake_factor": 1.5, "ambient": 40.0}
    yield Door("Gearing", sizing.Gearing, {"ratios": (2.0,), **between})
    more = {"motors": (), "gearing": None, "payload": 0.0, "samples": 2, "progress": None}
    yield Door("size", sizing.size, {"robot": robot, "references": reference(), "loads": (), **more})
    bounds = {"tool_speed": 1.0, "tool_acceleration": 1.0, "condition": 10.0, "samples": 2, "seed": 0}
    yield Door("size_anywhere", sizing.size_anywhere, {"robot": robot, **bounds})
    headings = "name,rated_torque [N m],peak_torque [N m],max_speed [rpm],rotor_inertia [kg cm2]"
    (folder / "motors.csv").write_text(f"{headings}\na,1,2,3,4\n", encoding="utf-8")
    yield Door("motors_from_file", sizing.motors_from_file, {"path": folder / "motors.csv"})


def of_stiffness() -> Iterator[Door]:
    robot = fivebar()
    usual = {"chain": robot, "at": None}
    springs = stiffness.Springs({"*": 1e4}, {"tip": 1e6})
    yield Door("ElasticRobot", stiffness.ElasticRobot, {"chain": robot, "springs": springs})
    yield Door("stiffness", stiffness.stiffness, {**usual, "springs": springs, "loads": ()})
    tolerances = {"tool.x": accuracy.Deviation(1e-4)}
    sampling = {"samples": 2, "seed": 0, "exact": False, "springs": None}
    yield Door("accuracy", accuracy.accuracy, {**usual, "tolerances": tolerances, **sampling})
    yield Door("sensitivity", accuracy.sensitivity, {**usual, "names": ["tool.x"], "springs": None})
    yield Door("backlash", accuracy.backlash, {**usual, "halves": {"*": 1e-4}, "springs": None})
    warm = {"warm": {"base": 10.0}, "expansion": "steel", "springs": None}
    yield Door("growth", accuracy.growth, {**usual, **warm})


GROUPS: dict[str, Callable[[Path], Iterator[Door]]] = {
    "package": lambda folder: of_package(),
    "mechanisms": lambda folder: of_mechanisms(),
    "chain": lambda folder: of_chain(),
    "values": lambda folder: of_values(),
    "motion": lambda folder: of_motion(),
    "control": lambda folder: of_control(),
    "simulation": of_simulation,
    "hardware": lambda folder: of_hardware(),
    "sizing": of_sizing,
    "stiffness": lambda folder: of_stiffness(),
}
"""The doors by room; they may write into a folder."""
