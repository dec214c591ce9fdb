"""The sections of a benchmark run: what is compared, and that the answers agree."""

from __future__ import annotations

from functools import partial
from importlib.util import find_spec

import numpy as np

from benchmarks import lengths, many_studies, more_peers, motion_files, peers
from benchmarks.built import built_loops
from benchmarks.ladder import ladder
from benchmarks.rounds import Contender, Timing, duration, measure, repeated
from benchmarks.section import SMALL, Section, Size
from benchmarks.spaces import workspaces
from benchmarks.task import KD, KP, SAMPLE, Task
from benchmarks.whole_process import WAYS, seconds
from cutjoint.arrays import Array
from cutjoint.chain import ClosedChain
from cutjoint.compile import ClosedLoop, compiled
from cutjoint.control import PD
from cutjoint.robots import load, published

WORDS = {"scalar": "one by one", "batch": "batch"}


def _states(chain: ClosedChain, count: int) -> tuple[Array, Array, Array]:
    """Closed configurations, velocities and efforts of the actuators."""
    rng = np.random.default_rng(0)
    scale = np.array([chain.length if one.kind == "translation" else 1.0 for one in chain.actuators])
    q = chain.home.q + 0.05 * scale * rng.uniform(-1, 1, (min(count, 256), chain.n))
    closed = np.array([chain.close(one).q_full for one in q])
    rows = rng.integers(len(closed), size=count)
    return closed[rows], rng.normal(size=(count, chain.n)), rng.normal(size=(count, chain.n))


def forward_dynamics(size: Size, robots: tuple[str, ...] = ("cpm", "omega3")) -> Section:
    """Forward dynamics of the chains: compiled, Pinocchio, MuJoCo."""
    section = Section(
        "Forward dynamics of a closed chain, CPU time a state",
        ("robot", "operations", "compiled, one by one", "batch", "pin.constraintDynamics", "mj_forward", "difference"),
    )
    for name in robots:
        chain = load(name)
        machine = compiled(chain)
        kernel = machine.kernel("forward")
        q, v, effort = _states(chain, size.states)
        none = np.zeros(0)
        solve = peers.constraint_dynamics(chain)
        v_full, full = chain.full_velocity(chain.posture(q[0]), v[0]), chain.full_effort(effort[0])
        contenders = {
            "scalar": Contender(partial(kernel.batch, [q, v, effort, none], lanes=False), size.states),
            "batch": Contender(partial(kernel.batch, [q, v, effort, none]), size.states),
            "pin": Contender(repeated(partial(solve, q[0], v_full, full), size.calls), size.calls),
        }
        if peers.has_mujoco():
            import mujoco

            model = peers.mujoco_model(chain, 1e-3)
            data = peers.mujoco_state(chain, model)
            contenders["mujoco"] = Contender(repeated(partial(mujoco.mj_forward, model, data), size.calls), size.calls)
        times = measure(contenders, size.rounds)
        found = kernel.batch([q, v, effort, none])[0]
        worst = 0.0
        for k in range(0, size.states, max(1, size.states // 200)):
            at = chain.posture(q[k])
            wanted = chain.forward_dynamics(at, v[k], effort[k])
            worst = max(worst, float(np.abs(found[k] - wanted).max() / max(1.0, np.abs(wanted).max())))
        section.differences[name] = worst
        for kind in ("scalar", "batch"):
            section.ratios[f"{name}, {WORDS[kind]}, quicker than pin.constraintDynamics"] = times[kind].ratio(
                times["pin"]
            )
        section.rows.append(
            (
                name,
                str(kernel.program.operations),
                duration(times["scalar"].median),
                duration(times["batch"].median),
                duration(times["pin"].median),
                duration(times["mujoco"].median) if "mujoco" in times else "-",
                f"{worst:.0e}",
            )
        )
    return section


def work_precision(size: Size) -> Section:
    """The closed loop of 4 s: error against CPU time."""
    task = Task(size.span)
    section = Section(f"Closed loop of {size.span:g} s: CPU time and error", ("engine", "step", "CPU time", "error"))
    contenders: dict[str, Contender] = {}
    errors: dict[str, float] = {}
    for label, model in (("paper, compiled", task.paper), ("chain, compiled", task.chain)):
        loop = ClosedLoop(compiled(model), task.law, task.reference.mechanism)
        for step in size.steps:
            steps = round(task.span / step)
            table = loop.reference_table(task.reference, step, steps)
            name = f"{label} | {step * 1e3:g} ms"
            contenders[name] = Contender(partial(loop.run, table, step=step))
            result = loop.run(table, step=step, every=SAMPLE)
            errors[name] = task.error(result.q[0])
    for step in size.peer_steps[:2]:
        run = peers.PinocchioRun(task, step)
        name = f"Pinocchio, Python loop | {step * 1e3:g} ms"
        contenders[name] = Contender(run.run)
        errors[name] = run.error()
    if peers.has_mujoco():
        for method in ("RK4", "implicitfast"):
            for step in size.peer_steps:
                other = peers.MujocoRun(task, step, method)
                name = f"MuJoCo {method} | {step * 1e3:g} ms"
                contenders[name] = Contender(other.run)
                errors[name] = other.error()
    for engine, (module, kind) in more_peers.RUNS.items():
        if find_spec(module) is not None:
            for step in size.peer_steps[:2]:
                run_it = kind(task, step)
                name = f"{engine} | {step * 1e3:g} ms"
                contenders[name] = Contender(run_it.run)
                errors[name] = run_it.error()
    times = measure(contenders, max(2, size.rounds // 2))
    for name, timing in times.items():
        engine, how = name.split(" | ")
        section.rows.append((engine, how, duration(timing.median), f"{errors[name]:.1e} m"))
        section.points.setdefault(engine, []).append((timing.median, errors[name]))
    section.differences = {"paper, finest step": min(e for name, e in errors.items() if name.startswith("paper"))}
    section.differences["chain, finest step"] = min(e for name, e in errors.items() if name.startswith("chain"))
    _compare_at(section, errors, times)
    return section


def _compare_at(section: Section, errors: dict[str, float], times: dict[str, Timing]) -> None:
    """Ratios at equal precision: ours at the longest step with an error of at most 1e-8 m, MuJoCo's quickest RK4."""
    theirs = [name for name in times if name.startswith("MuJoCo RK4")]
    if not theirs:
        return
    best = min(theirs, key=lambda name: errors[name])
    for ours in ("paper", "chain"):
        good = [name for name in times if name.startswith(ours) and errors[name] <= 1e-8]
        if good:
            quickest = min(good, key=lambda name: times[name].median)
            for name in {best, *(name for name in theirs if name.endswith(" 1 ms"))}:
                section.ratios[_beside(quickest, name, errors)] = times[quickest].ratio(times[name])


def _beside(ours: str, theirs: str, errors: dict[str, float]) -> str:
    """Two runs and their errors, in words."""
    one, other = (f"{name.replace(' | ', ', ')} ({errors[name]:.0e} m)" for name in (ours, theirs))
    return f"{one} quicker than {other}"


def gain_sweep(size: Size) -> Section:
    """Many gain settings of the closed loop."""
    task = Task(size.span)
    section = Section(
        f"{size.sweep} gain settings, {size.span:g} s each at 1 ms steps, CPU time of all", ("engine", "CPU time")
    )
    gains = {"kp": np.linspace(0.6 * KP, KP, size.sweep), "kd": np.linspace(0.6 * KD, KD, size.sweep)}
    contenders: dict[str, Contender] = {}
    finals = {}
    for label, model in (("paper, compiled", task.paper), ("chain, compiled", task.chain)):
        loop = ClosedLoop(compiled(model), PD(1.0, 1.0), task.reference.mechanism, gains=("kp", "kd"))
        table = loop.reference_table(task.reference, 1e-3, round(task.span / 1e-3))
        contenders[label] = Contender(partial(loop.run, table, gains=gains))
        finals[label] = loop.run(table, gains=gains).q[:, -1]
    if peers.has_mujoco():
        other = peers.MujocoRun(task, 1e-3, "RK4", runs=size.sweep_sample)
        scale = size.sweep / size.sweep_sample
        contenders["MuJoCo RK4 rollout"] = Contender(other.run, scale=scale)
    times = measure(contenders, max(2, size.rounds // 2))
    section.differences["chain against paper"] = float(np.abs(np.subtract(*finals.values())).max())
    for name, timing in times.items():
        section.rows.append((name, duration(timing.median)))
    if "MuJoCo RK4 rollout" in times:
        for name in finals:
            section.ratios[f"{name} quicker than MuJoCo RK4 rollout"] = times[name].ratio(times["MuJoCo RK4 rollout"])
    return section


def inverse_dynamics(size: Size) -> Section:
    """Inverse dynamics of many states by the published models."""
    section = Section(
        f"Inverse dynamics of {size.inverse} states, CPU time of all", ("model", "operations", "CPU time", "difference")
    )
    rng = np.random.default_rng(0)
    for name in ("cpm", "omega3"):
        model = published(name)
        kernel = compiled(model).kernel("inverse")
        q = model.home.q + 0.05 * rng.uniform(-1, 1, (size.inverse, 3))
        v, a = rng.normal(size=q.shape), rng.normal(size=q.shape)
        none = np.zeros(0)
        times = measure({"batch": Contender(partial(kernel.batch, [q, v, a, none]))}, size.rounds)
        found = kernel.batch([q[:50], v[:50], a[:50], none])[0]
        few = zip(q[:50], v[:50], a[:50], strict=True)
        wanted = np.array([model.inverse_dynamics(model.close(x), y, z) for x, y, z in few])
        worst = float(np.abs(found - wanted).max() / np.abs(wanted).max())
        section.differences[name] = worst
        section.rows.append((name, str(kernel.program.operations), duration(times["batch"].median), f"{worst:.0e}"))
    return section


def growth(size: Size) -> Section:
    """Cost of forward dynamics against the number of loops."""
    section = Section(
        "Forward dynamics of planar linkages with k loops, CPU time a state",
        ("loops", "velocities", "operations", "compiled, one by one", "batch", "pin.constraintDynamics", "mj_forward"),
    )
    for loops in size.loops:
        chain = ladder(loops)
        kernel = compiled(chain, cached=False).kernel("forward")
        count = max(64, size.states // (4 * loops))
        calls = max(3, size.calls // loops)
        q = np.tile(chain.home.q_full, (count, 1))
        v, effort, none = np.full((count, 1), 0.5), np.ones((count, 1)), np.zeros(0)
        solve = peers.constraint_dynamics(chain)
        v_full, full = chain.full_velocity(chain.home, v[0]), chain.full_effort(effort[0])
        contenders = {
            "scalar": Contender(partial(kernel.batch, [q, v, effort, none], lanes=False), count),
            "batch": Contender(partial(kernel.batch, [q, v, effort, none]), count),
            "pin": Contender(repeated(partial(solve, chain.home.q_full, v_full, full), calls), calls),
        }
        if peers.has_mujoco():
            import mujoco

            model = peers.mujoco_model(chain, 1e-3)
            data = peers.mujoco_state(chain, model)
            contenders["mujoco"] = Contender(repeated(partial(mujoco.mj_forward, model, data), calls), calls)
        times = measure(contenders, max(2, size.rounds // 2))
        found = kernel(q[0], v[0], effort[0], none)[0]
        wanted = solve(chain.home.q_full, v_full, full)[int(chain.actuated_velocity(np.arange(float(chain.nv)))[0])]
        section.differences[f"{loops} loops"] = float(abs(found - wanted) / max(1.0, abs(wanted)))
        section.ratios[f"{loops} loops, one by one, quicker than pin.constraintDynamics"] = times["scalar"].ratio(
            times["pin"]
        )
        section.rows.append(
            (
                str(loops),
                str(chain.nv),
                str(kernel.program.operations),
                duration(times["scalar"].median),
                duration(times["batch"].median),
                duration(times["pin"].median),
                duration(times["mujoco"].median) if "mujoco" in times else "-",
            )
        )
    return section


def motions(size: Size) -> Section:
    """Motions from files."""
    section = Section("Motions from files, CPU time", ("what", "CPU time"))
    times, away = motion_files.timings(size.inverse, size.calls, max(2, size.rounds // 2))
    section.rows = motion_files.table_rows(times)
    section.differences["rotation against scipy's spline"] = away
    return section


def tolerances(size: Size) -> Section:
    """Lengths as arguments."""
    section = Section("Tool of the Omega-3 chain at random tolerances, CPU time a sample", ("what", "CPU time"))
    times, away = lengths.timings(size.inverse, min(size.calls, 10), max(2, size.rounds // 2))
    section.rows = [
        (f"batch of {size.inverse}, one core", duration(times["batch"].median)),
        ("chain built anew", duration(times["anew"].median)),
    ]
    section.ratios["batch, quicker than a chain built anew"] = times["batch"].ratio(times["anew"])
    section.differences["tool"] = away
    return section


def whole_process(size: Size) -> Section:
    """`cutjoint simulate` from the shell, on the compiled plant and on the chain."""
    section = Section(
        "One second under control at 1 kHz, whole process",
        ("robot", "compiled: clock", "CPU", "chain: clock", "CPU"),
    )
    for robot in WAYS if size.rounds > SMALL.rounds else ("fourbar",):
        times: list[float] = []
        for plant in ("compiled", "chain"):
            clock, work, drift = seconds(robot, plant, size.rounds, min(size.span, 1.0))
            section.differences[f"{robot}, {plant}: energy"] = drift
            times += [clock, work]
        section.rows.append((robot, *map(duration, times)))
        section.ratios[f"{robot}: chain over compiled"] = times[2] / times[0]
    return section


def studies(size: Size) -> Section:
    """The same study three ways, with the same files."""
    section = Section(
        f"A study of {size.study} runs of the CPM's chain, {size.span:g} s each, behind hardware at 1 kHz",
        ("how", "clock", "CPU, all processes"),
    )
    rows, differing = many_studies.timings(size.study, size.span)
    section.rows = [(name, duration(wall), duration(used)) for name, wall, used in rows]
    section.differences["tables that are not those of the plain run"] = differing
    return section


SECTIONS = {
    "forward": forward_dynamics,
    "loop": work_precision,
    "sweep": gain_sweep,
    "built": built_loops,
    "inverse": inverse_dynamics,
    "growth": growth,
    "motions": motions,
    "tolerances": tolerances,
    "process": whole_process,
    "workspace": workspaces,
    "studies": studies,
}
