"""The task with friction in the motors and hardware between the law and them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

from benchmarks.task import Task
from cutjoint.chain import ClosedChain
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
