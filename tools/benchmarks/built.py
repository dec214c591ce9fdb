"""The task with friction in the motors and hardware between the law and them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from benchmarks import peers
from benchmarks.rounds import Contender, duration, measure
from benchmarks.section import Section, Size
from benchmarks.task import KD, KP, Task
from cutjoint.arrays import Array
from cutjoint.chain import ClosedChain
from cutjoint.compile import ClosedLoop, compiled
from cutjoint.control import PD
from cutjoint.description import JointPhysics
from cutjoint.papers.cpm import CpmModel
from cutjoint.robots import load
from cutjoint.simulation.hardware import Clock, Differences, Drive, Encoder, Hardware

MOTORS = JointPhysics(damping=2.0, friction=5.0, friction_speed=0.02)
"""Of every slider: [N s/m], [N], [m/s]."""
IDEAL = Hardware(Clock(1000.0))
"""Efforts held for a millisecond, and nothing else: what a rollout of 1 ms steps does."""
REAL = Hardware(
    Clock(1000.0),
    Encoder(resolution=1e-5, noise=2e-6, delay=1e-3),
    Differences(cutoff=200.0),
    Drive(limits=300.0, resolution=0.1, delay=1e-3),
)
"""Delays of two periods in all, steps of 10 um and 0.1 N, noise of 2 um, limits of 300 N."""
GENTLE = 0.6
"""Part of the task's gains, with which the delays are still stable."""


@dataclass(frozen=True)
class BuiltTask(Task):
    """The task with friction."""

    @cached_property
    def chain(self) -> ClosedChain:
        """The closed chain."""
        description = load("cpm", "lumped").description
        rubbed = (
            replace(one, physics=MOTORS) if one.name in description.actuators else one for one in description.joints
        )
        return ClosedChain(replace(description, joints=tuple(rubbed)))

    @cached_property
    def paper(self) -> CpmModel:
        """The published model."""
        return CpmModel().with_motors(MOTORS)


def built_loops(size: Size) -> Section:
    """Many runs of the loop as it is built, and with efforts that are held and nothing else, as a rollout has them."""
    task, span = BuiltTask(size.span), f"{size.span:g} s at 1 ms"
    section = Section(
        f"{size.built} runs of {span} with friction, CPU time of all",
        ("engine", "loop", "CPU time", "of a step of a run"),
    )
    contenders, finals, steps = dict[str, Contender](), dict[str, Array](), round(task.span / 1e-3)
    for label, model in (("paper, compiled", task.paper), ("chain, compiled", task.chain)):
        plant = compiled(model)
        for told, hardware, part in (("noise, quantisation, delays", REAL, GENTLE), ("held efforts", IDEAL, 1.0)):
            gains = {"kp": part * np.linspace(0.9 * KP, KP, size.built)}
            for method in ("midpoint", "rk4"):
                law, name = PD(1.0, part * KD), f"{label} | {told}, {method}"
                loop = ClosedLoop(plant, law, task.paper, gains=("kp",), hardware=hardware, method=method)
                table = loop.reference_table(task.reference, 1e-3, steps)
                contenders[name] = Contender(partial(loop.run, table, gains=gains))
                finals[name] = loop.run(table, gains=gains).q[:, -1]
    if peers.has_mujoco():
        for method in ("implicitfast", "RK4"):
            other = peers.MujocoRun(task, 1e-3, method, runs=size.sweep_sample)
            name = f"MuJoCo rollout | held efforts, {method}"
            contenders[name] = Contender(other.run, scale=size.built / size.sweep_sample)
        alike = finals["paper, compiled | held efforts, rk4"][-1]
        section.differences["MuJoCo RK4"] = float(np.abs(other.run()[-1] - alike).max())
    for name, values in finals.items():
        if name.startswith("chain"):
            paper = finals[name.replace("chain", "paper")]
            section.differences[name.split(" | ")[1]] = float(np.abs(values - paper).max())
    times = measure(contenders, max(2, size.rounds // 2))
    for name, timing in times.items():
        row = (*name.split(" | "), duration(timing.median), duration(timing.median / (size.built * steps)))
        section.rows.append(row)
        for rollout in (one for one in times if one.startswith("MuJoCo") and not name.startswith("MuJoCo")):
            told = f"{name.replace(' | ', ', ')}, quicker than {rollout.replace(' | ', ', ')}"
            section.ratios[told] = timing.ratio(times[rollout])
    return section
