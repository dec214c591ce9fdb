"""An object of every public class: found by looking at what a few robots, runs and pictures are made of."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from kit.regions import ball, region
from matplotlib.figure import Figure

import cutjoint
from cutjoint import (
    accuracy,
    control,
    crosscheck,
    description,
    drafting,
    motion,
    retiming,
    simulation,
    sizing,
    stiffness,
    studies,
    synthesis,
    tuning,
    workspace,
)
from cutjoint.accuracy.reading import errors_of
from cutjoint.chain import GearForce
from cutjoint.chain.modes import ModeSeeker
from cutjoint.chain.physics import Elastic
from cutjoint.compile import ClosedLoop, Options, simulate_many
from cutjoint.description.catalogue import resolve
from cutjoint.description.formats import FORMATS, read
from cutjoint.errors import Problem
from cutjoint.handover import joint_states
from cutjoint.motion.catalogue import trajectory
from cutjoint.papers.cpm.model import InferredCpmModel
from cutjoint.report import Section, ToolPath
from cutjoint.report.figures import Drawing
from cutjoint.retiming.path import way_of
from cutjoint.retiming.rows import Margins, rows_of
from cutjoint.retiming.smoothing import smoothed
from cutjoint.retiming.terms import terms_along
from cutjoint.simulation import hardware, integrators, reactions_of
from cutjoint.simulation.panel import Shown
from cutjoint.simulation.panels import PANELS, panels_of
from cutjoint.tables import TextTable
from cutjoint.viewer import LiveView, Places, show
from cutjoint.viewer.film.recording import from_result
from cutjoint.workspace import MAPS, FieldMap, GridAxis, Workspace, certify
from cutjoint.workspace.exploring import Question
from cutjoint.workspace.goals import Goals
from cutjoint.workspace.lattice import Lattice


def walked(seeds: Iterator[object], most: int = 4) -> dict[type, object]:
    """Objects of cutjoint's classes that seeds and their parts are, by class: fields, attributes, items."""
    found: dict[type, object] = {}
    seen: set[int] = set()
    todo = [(one, 0) for one in seeds]
    while todo:
        one, depth = todo.pop(0)
        if id(one) in seen or (
            isinstance(one, str | bytes | int | float | np.ndarray | type) and not isinstance(one, Enum)
        ):
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
    yield robot.minimal().linearised(robot.home)
    full = np.zeros(robot.nv)
    yield from (
        robot.full_forward_dynamics(robot.home, full, full),
        robot.full_inverse_dynamics(robot.home, full, full),
    )
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
    yield from (
        control.PD(1.0, 2.0),
        control.PID(1.0, 2.0, 3.0),
        control.NoControl(),
        control.PDGravity(robot, 1.0, 2.0),
    )
    yield from (control.Feedforward(robot, 1.0, 2.0), control.ComputedTorque(robot, 1.0, [2.0, 3.0]))
    yield control.as_law(lambda t, desired, q, v: [0.0, 0.0])
    yield control.GivenEfforts(control.EffortTable([0.0, 1.0], np.zeros((2, 2))))
    yield from _of_descriptions(robot)
    yield from _of_stiffness(robot)
    yield from _of_papers(paper, other)
    yield from _of_runs(robot, reference)
    yield from _sizing(robot, reference)
    yield from _of_answers(robot)


def _sizing(robot: cutjoint.ClosedChain, reference: motion.Reference) -> Iterator[object]:
    """Sizing along a way, with a motor."""
    motor = sizing.ServoMotor("motor", "rotation", 1.0, 3.0, 300.0, 1e-5)
    found = sizing.size(robot, reference, motors=[motor], bearings=True, samples=2)
    yield from (found, found.cycles, found.worst, found.fits, found.bearings, found.worst[0].effort)
    yield sizing.size_anywhere(robot, 1.0, 1.0, samples=2)


def _of_descriptions(robot: cutjoint.ClosedChain) -> Iterator[object]:
    """Parts that not every robot has."""
    yield from (robot.description, FORMATS)
    yield description.Inertial(1.0, np.zeros(3), np.eye(3))
    yield description.Shape("box", (1.0, 2.0, 3.0))
    yield description.Limits(0.0, 1.0)
    yield description.Variant("light", "of paper", {})
    yield description.Bushing(1.0, 2.0)
    yield GearForce(1.0, True)
    yield description.JointPhysics(damping=1.0, friction=2.0)
    yield description.Coupling.geared("gear", "a", "b", 2.0)
    yield read(resolve("fivebar"))
    yield from (robot.task.towards(robot.task.home, (0, 1)), ModeSeeker(robot._postures), Drawing(Figure()))
    frames = robot._postures.at_home.frames
    yield from (Elastic(frames, np.zeros((6, robot.nv))), TextTable("title", ("a",), [("1",)]))
    yield Problem("found", "expected", "mend", "file.toml", 3)
    axis, goals = GridAxis("x", "m", np.array([0.0, 0.1])), Goals(robot.task, ("x",), {"z": 0.3}, np.zeros(3))
    reached, field = np.array([True, False]), FieldMap("condition number", "", np.array([1.5, np.nan]), "low")
    yield Workspace("fivebar", (axis,), {"z": 0.3}, reached, 0.1, np.zeros((2, 2)), {"condition": field})
    yield from (goals, Lattice(np.zeros(1), np.full(1, 0.1), (2,), (False,)), MAPS["condition"], Question())


def _of_stiffness(robot: cutjoint.ClosedChain) -> Iterator[object]:
    """What gives way, and what is off."""
    springs = stiffness.Springs({"*": 1e4}, {"tip": 1e6}, {"left_distal": stiffness.Beam.tube(7e10, 2.6e10, 0.02)})
    elastic = stiffness.ElasticRobot(robot, springs)
    found = elastic.at()
    yield from (springs, elastic, elastic.response(), found, found.translation)
    yield found.contributions([1.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    yield elastic.pushed(cutjoint.Load([1.0, 0.0, 0.0]))
    off = accuracy.accuracy(robot, {"tool.x": accuracy.Deviation(1e-4)}, samples=2)
    yield from (off, off.sensitivity, off.ranked, accuracy.backlash(robot, {"*": 1e-4}))
    yield accuracy.growth(robot, {"base": 10.0}, "steel")
    yield errors_of(robot.description, {"tool.x": "0.1 mm"}, {"*": 1e-4}, {"base": 10.0}, {"*": "steel"})


def _of_papers(paper: object, other: object) -> Iterator[object]:
    rotary = cutjoint.published("cpm_rotary")
    for one in (paper, other, rotary, InferredCpmModel()):
        yield from (one, one.parameters)  # type: ignore[attr-defined]
    for one in (paper, other, rotary):
        yield from (one.state(one.home), one.branch(one.home))  # type: ignore[attr-defined]
    yield paper.parameters.coefficients
    yield other.limb_energies(other.home, np.zeros(3))


def _of_runs(robot: cutjoint.ClosedChain, reference: motion.Reference) -> Iterator[object]:
    """Plants, integrators, hardware, a run, and what is made of it."""
    plant = simulation.ReducedPlant(robot)
    result = simulation.run(plant, control.PD(10.0, 1.0), reference, rate=100.0, duration=0.02)
    yield from (plant, simulation.ConstrainedPlant(robot), simulation.MinimalPlant(robot.minimal()), result)
    yield from (result.rmse(), panels_of(result))
    start = plant.start(robot.home, np.zeros(2))
    yield from (start, plant.observe(start))
    yield from (integrators.Adaptive(), integrators.DormandPrince(), integrators.RungeKutta4(1e-3))
    yield integrators.Midpoint(1e-3)
    backlash = hardware.Backlash(1e-3, 1e5, 1.0, 1e-3)
    drive = hardware.Drive(20.0, torque_speed=hardware.TorqueSpeed(10.0, 20.0), backlash=backlash)
    loop = hardware.Hardware(
        hardware.Clock(1000.0),
        hardware.Encoder(noise=1e-5),
        hardware.Differences(100.0),
        drive,
    )
    yield from (loop, loop.ticks, hardware.Tachometer(1e-3))
    history = reactions_of(result, robot)
    yield from (history, history.peaks)
    states = list(crosscheck.sample_states(robot, 2, 0))
    yield from (
        states,
        crosscheck.compare(robot, robot, states),
        crosscheck.workspace_box(robot),
        certify(cutjoint.load("fivebar"), {"x": (-0.6, 0.6)}),
        crosscheck.Reacher(robot),
    )
    path = [(np.array(reference.at(0.0).tool.position), np.zeros(3), np.zeros(3))]
    yield crosscheck.hypothesis_cost(robot, robot, path)
    yield from (
        ToolPath("path", "xy", result.tool),
        TextTable("title", ("a",), [("1",)]),
        Section("section", ("words",)),
    )
    yield from_result(robot, result)
    yield from _of_workspaces()


def _of_workspaces() -> Iterator[object]:
    """A workspace, and what is fitted into, drawn and shown of it."""
    space = region(ball, 8)
    yield from (space, workspace.largest(space, "cylinder"), workspace.surface(space), Places("Workspace"))
    yield workspace.in_world(space, cutjoint.published("omega3").task)


def slow_seeds() -> Iterator[object]:
    """What is compiled, shown or served."""
    robot, paper = cutjoint.load("fivebar"), cutjoint.published("cpm")
    fast, fast_paper, made = robot.compile(), cutjoint.compiled(paper), list[object]()
    cutjoint.compiled(robot, cached=False, report=made.append).kernel("tool")
    yield from (Options(), made)
    yield from (fast, fast_paper, cutjoint.compiled(robot.minimal()))
    plants = [cutjoint.compiled_plant(one) for one in (fast, fast_paper)]
    yield plants
    start = plants[0].start(robot.home, np.zeros(2))
    yield plants[0].advance(start, np.zeros(2), 0.001, 1e-4)
    n, at, v = robot.n, robot.home, np.zeros(2)
    yield from (
        fast.forward_derivatives(at, v, v),
        fast.forward_loaded(at, v, v, np.zeros(6)),
        fast.batch,
        fast_paper.batch,
    )
    library = fast.library()
    yield from (library, library["forward"], library["forward"].kernel)
    q = np.tile(at.q_full, (2, 1))
    yield from (fast.batch.tool(q), fast.batch.terms(q, np.zeros((2, n))))
    hold = motion.Reference(motion.Hold.at_home(robot, 1.0), robot)
    law = control.PD(10.0, 1.0)
    yield from (ClosedLoop(fast, law, robot), simulate_many(fast, law, hold, duration=0.01, runs=2))
    yield simulate_many(fast, law, hold, duration=0.01, runs=4, chunk=2, into=lambda number, many: None)
    method = integrators.RungeKutta4(1e-3)
    yield method.step(lambda t, y: -y, 0.0, np.ones(2), -np.ones(2), 1e-3, 1.0, 1.0)
    swing = motion.Reference(motion.about_home(robot, 0.05, 0.2), robot)
    placed = tuning.tune(robot, "pd", swing, by=tuning.PolePlacement(), after=0.1)
    about = tuning.linear_law(law, tuning.at_rest(robot, robot.home.q))
    yield from (placed, *placed.found.margins.actuators, *placed.found.steps)
    yield from (tuning.PaperRule(1e-3), tuning.PolePlacement(), tuning.GainSearch(), about)
    yield from (tuning.LinearLoop(tuning.linear_plant(fast), about), tuning.Timing(1e-3))
    document = show(robot)
    yield from (document, document.files())
    yield from _in_hand(robot)
    yield from _of_studies()
    yield from _retimed(robot)
    with LiveView(robot) as view:
        yield from (view, view.bridge)


def _of_answers(robot: cutjoint.ClosedChain) -> Iterator[object]:
    """Settings, and a synthesis."""
    lighter = synthesis.Variable("mass", "path", ("links.left_distal.mass",), 0.1, 0.9)
    problem = synthesis.problem_of(robot, [lighter], [synthesis.Want("mass", {}, "least")])
    design = synthesis.judged(problem, problem.now)
    yield from (problem, design, synthesis.Synthesis(problem, (design,)), synthesis.SynthesisOrder(problem, 2, 1))
    yield from (synthesis.Subject(robot, {}), synthesis.QUANTITIES["mass"])


def _of_studies() -> Iterator[object]:
    """A study, what it will take, and its summary."""
    with TemporaryDirectory() as place:
        file = Path(place) / "light.toml"
        file.write_text(
            'robot = "cpm"\nmodel = "published"\nruns = 30\nduration = 0.01\ncontroller = { name = "pd" }\n'
            'vary = [{ path = "payload", uniform = [0.0, 1.0] }]\n'
        )
        with studies.begun(file, Path(place) / "runs") as ready:
            yield from (ready, ready.plan, ready.estimate, ready.prepared.recipe, ready.run())
        yield studies.summary_of(Path(place) / "runs")


def _retimed(robot: cutjoint.ClosedChain) -> Iterator[object]:
    """A motion that was retimed, and what it is made of."""
    units, limits = np.ones(robot.n), retiming.limits_of(robot, effort=8.0)
    path = trajectory("line:0.02,0,0.02", robot)
    way = way_of(motion.Reference(path, robot), units)
    terms = terms_along(robot, way.pieces[0])
    squares = np.ones(len(terms.s))
    rows = rows_of(terms, limits, Margins(len(terms.s), robot.n), squares)
    yield from (way, terms, rows, smoothed([(way.pieces[0], squares)], 0.01, limits.jerk, goes_round=False))
    yield from (limits, retiming.retime(robot, path, limits))
    bounded = retiming.limits_of(robot, acceleration=9.0, jerk=90.0)
    yield retiming.quickest_moves(robot, [robot.home.q + 0.05], bounded)


def _in_hand(robot: cutjoint.ClosedChain) -> Iterator[object]:
    """Drafts, swings about home, plots, pages and joint states of runs."""
    yield from (drafting.draft("arm", "fivebar"), drafting.TEMPLATES["fivebar"], control.GainHelp("stiffness", "N/m"))
    yield from (PANELS["error"], trajectory("about-home", robot), trajectory("about-home", cutjoint.load("fourbar")))
    stewart = cutjoint.load("stewart")
    hold = motion.Reference(motion.Hold.at_home(stewart, 0.01), stewart)
    run = simulation.run(stewart, control.PDGravity(stewart, 100.0, 10.0), hold, rate=100.0)
    states = joint_states(run, stewart)
    yield from (Shown(run, stewart), run.plot(), run.report(), states, states.carried)
