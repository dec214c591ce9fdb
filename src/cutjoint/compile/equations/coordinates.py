"""Between Pinocchio's coordinates and the rates of the expressions.

Pinocchio has the velocities of a joint in the axes of its moving body; rates are in world axes, or in those of the
joint's placement (`cutjoint.compile.equations.joints`).
"""

from __future__ import annotations

from collections.abc import Sequence

from cutjoint.compile.equations.dynamics import Motion
from cutjoint.compile.equations.joints import StepKind, TreeStep
from cutjoint.compile.equations.pose import TreePose
from cutjoint.compile.expressions import functions
from cutjoint.compile.expressions.functions import is_zero
from cutjoint.compile.expressions.graph import Number
from cutjoint.compile.expressions.vectors import Vector, cross, dot, transposed, turn


def to_rates(pose: TreePose, v: Sequence[Number]) -> list[Number]:
    """Pinocchio's velocities (or, dually, forces) as rates `u`."""
    u = list(v)
    for k, first in _turned(pose):
        u[first : first + 3] = turn(pose.rotation[k], (v[first], v[first + 1], v[first + 2]))
    for first, spin in _flat(pose):
        cosine, sine = pose.q[spin.q : spin.q + 2]
        x, y = v[first], v[first + 1]
        u[first : first + 2] = (cosine * x - sine * y, sine * x + cosine * y)
    return u


def from_rates(pose: TreePose, u: Sequence[Number]) -> list[Number]:
    """Rates `u` as Pinocchio's velocities."""
    v = list(u)
    for k, first in _turned(pose):
        back = transposed(pose.rotation[k])
        v[first : first + 3] = turn(back, (u[first], u[first + 1], u[first + 2]))
    for first, spin in _flat(pose):
        cosine, sine = pose.q[spin.q : spin.q + 2]
        x, y = u[first], u[first + 1]
        v[first : first + 2] = (cosine * x + sine * y, cosine * y - sine * x)
    return v


def from_rate_derivatives(pose: TreePose, u: Sequence[Number], motion: Motion, du: Sequence[Number]) -> list[Number]:
    """Derivatives of the rates as Pinocchio's accelerations (time derivative of its velocities)."""
    turned = turning_axes(pose, u, motion)
    return from_rates(pose, [x if is_zero(y) else x + y for x, y in zip(du, turned, strict=True)])


def turning_axes(pose: TreePose, u: Sequence[Number], motion: Motion) -> list[Number]:
    """What Pinocchio's accelerations are beside the derivatives of the rates, because its axes turn, length nv."""
    changed: list[Number] = [0.0] * pose.tree.nv
    for k, first in _turned(pose):
        rate: Vector = (u[first], u[first + 1], u[first + 2])
        changed[first : first + 3] = cross(rate, motion.angular[k])
    for first, spin in _flat(pose):
        w = u[spin.u]
        changed[first] = w * u[first + 1]
        changed[first + 1] = -(w * u[first])
    return changed


def _turned(pose: TreePose) -> list[tuple[int, int]]:
    """(step whose axes Pinocchio uses, first rate) of every triple of rates in world axes."""
    return [(step.body, step.u) for step in pose.tree.steps if step.kind.in_world]


def _flat(pose: TreePose) -> list[tuple[int, TreeStep]]:
    """(first rate, step that turns the plane) of every pair of rates in a plane that turns."""
    steps = pose.tree.steps
    return [(step.u, steps[step.body]) for k, step in enumerate(steps) if step.kind is StepKind.FLAT and step.body > k]


def configuration_rate(pose: TreePose, u: Sequence[Number]) -> list[Number]:
    """Time derivative of the configuration (quaternions and cosines included), length nq."""
    rate: list[Number] = [0.0] * pose.tree.nq
    for k, step in enumerate(pose.tree.steps[1:], start=1):
        rate[step.q : step.q + step.kind.coordinates] = step.coordinate_rates(pose.placed[k], pose.q, u)
    return rate


def moved(pose: TreePose, u: Sequence[Number]) -> list[Number]:
    """The configuration after a small step `u`: exact for angles and lengths, to first order for the others, whose
    quaternions and cosines are brought back to unit length."""
    q: list[Number] = [x + dx for x, dx in zip(pose.q, configuration_rate(pose, u), strict=True)]
    for step in pose.tree.steps:
        if step.kind.coordinates > step.kind.rates:
            span = slice(step.q, step.q + step.kind.coordinates)
            factor = 1.0 / functions.sqrt(dot(q[span], q[span]))
            q[span] = [factor * x for x in q[span]]
    return q
