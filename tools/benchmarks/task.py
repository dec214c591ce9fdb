"""The common task: the CPM on its circle for 4 s under PD control, from rest on the path.

All contenders simulate the same robot (uniform first rods, second rods lumped at their ends, so that the paper's model
and the multibody models are one and the same), the same gains and the same path.  The reference is DOP853 at rtol 1e-12
on the paper's model; the error is the largest distance of the tool from it, over samples every 10 ms.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cutjoint.arrays import Array
from cutjoint.chain import ClosedChain
from cutjoint.control import PD
from cutjoint.motion import Circle, Reference
from cutjoint.papers.cpm import CpmModel
from cutjoint.papers.cpm.published import CIRCLE
from cutjoint.robots import load
from cutjoint.simulation import Adaptive, ReducedPlant, run

KP, KD = 12691.0, 436.0
SAMPLE = 0.01


@dataclass(frozen=True)
class Task:
    """The circle for `span` seconds."""

    span: float

    @cached_property
    def chain(self) -> ClosedChain:
        """The closed chain."""
        return load("cpm", "lumped")

    @cached_property
    def paper(self) -> CpmModel:
        """The published model."""
        return CpmModel()

    @cached_property
    def reference(self) -> Reference:
        """The path as the sliders have to follow it; for the CPM they are the tool's coordinates."""
        circle = Circle(np.array(CIRCLE.centre), CIRCLE.radius, CIRCLE.omega)
        return Reference(circle, self.paper, self.span)

    @cached_property
    def law(self) -> PD:
        """PD, the first row of the paper's table 3."""
        return PD(KP, KD)

    @cached_property
    def exact(self) -> Array:
        """Tool positions every SAMPLE seconds, shape (k, 3), to about 1e-12 m."""
        method = Adaptive(1e-12, 1e-14)
        result = run(ReducedPlant(self.paper), self.law, self.reference, integrator=method, every=SAMPLE)
        return result.tool

    def error(self, tool: Array) -> float:
        """Largest distance from the exact path [m]; `tool` every SAMPLE seconds, shape (k, 3)."""
        return float(np.linalg.norm(tool - self.exact, axis=1).max())

    def path(self, t: Array) -> tuple[Array, Array]:
        """Desired position and velocity, shape (k, 3) each, at times of shape (k,)."""
        angle = CIRCLE.omega * t
        out = CIRCLE.radius * np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
        along = CIRCLE.radius * CIRCLE.omega * np.stack([-np.sin(angle), np.cos(angle), 0.0 * angle], axis=1)
        return np.array(CIRCLE.centre) + out, along
