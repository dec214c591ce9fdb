"""What the motors of a published model do that the papers leave out: dampers, friction, springs and rotors.

The forces are those of `cutjoint.mechanism.physics`, along the actuated coordinates; the papers' own equations stay as
they are, and these stand beside them.  The functions work on floats, arrays and symbols alike.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from numbers import Real
from typing import Protocol, cast

import numpy as np

from cutjoint.errors import InputError
from cutjoint.mechanism.names import Actuator
from cutjoint.mechanism.physics import JointPhysics
from cutjoint.papers.scalars import Scalar, Vector


class Bounds(Protocol):
    """The smaller and the larger of two numbers: numpy has them, and the tracer of `cutjoint.compile`."""

    minimum: Callable[..., Scalar]
    maximum: Callable[..., Scalar]


ARRAYS = cast(Bounds, np)
"""Floats and arrays."""


def checked(motors: JointPhysics | Sequence[JointPhysics], actuators: Sequence[Actuator]) -> tuple[JointPhysics, ...]:
    """One for every actuator, from one for all or a sequence.

    Raises:
        InputError: not as many as actuators, a number that is negative or not finite, a spring without rest
            position, or what only joints with limits and events have.
    """
    wanted = f"motors must be one JointPhysics, or {len(actuators)} of them; found "
    if not isinstance(motors, JointPhysics | Sequence):
        raise InputError(f"{wanted}the {type(motors).__name__} {motors!r}")
    given = (motors,) * len(actuators) if isinstance(motors, JointPhysics) else tuple(motors)
    if strangers := [one for one in given if not isinstance(one, JointPhysics)]:
        raise InputError(f"{wanted}the {type(strangers[0]).__name__} {strangers[0]!r}")
    if len(given) != len(actuators):
        raise InputError(f"{wanted}{len(given)}")
    for one, actuator in zip(given, actuators, strict=True):
        numbers = {name: getattr(one, name) for name in ("damping", "friction", "stiffness", "rotor")}
        for name, value in (*numbers.items(), ("friction_speed", one.speed)):
            if not (_is_number(value) and value >= 0.0):
                raise InputError(f"{name} of motor '{actuator.name}' must be a number >= 0, found {value!r}")
        if not _is_number(one.gear) or one.gear == 0.0:
            raise InputError(f"gear of motor '{actuator.name}' must be a number other than 0, found {one.gear!r}")
        if one.stiffness and one.rest is None:
            raise InputError(f"the spring of motor '{actuator.name}' has no rest position; give rest")
        if one.rest is not None and not _is_number(one.rest):
            raise InputError(f"rest of motor '{actuator.name}' must be a number, found {one.rest!r}")
        if one.sticks:
            raise InputError(
                f"motor '{actuator.name}' has friction at a friction speed of 0 (stiction), which published models do "
                "not have; give a speed above 0, or take the chain"
            )
        if one.stop_stiffness or one.stop_damping:
            raise InputError(f"motor '{actuator.name}' has stops, but published models have no limits of joints")
    return given


def _is_number(value: object) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool) and bool(np.isfinite(float(value)))


def springs(motors: Sequence[JointPhysics], q: Vector) -> Vector:
    """Effort that holds the springs, (n,)."""
    return tuple(one.stiffness * (x - (one.rest or 0.0)) for one, x in zip(motors, q, strict=True))


def friction(motors: Sequence[JointPhysics], v: Vector, fn: Bounds = ARRAYS) -> Vector:
    """Effort that overcomes dampers and friction, (n,)."""
    return tuple(one.damping * x + _rubbed(one, x, fn) for one, x in zip(motors, v, strict=True))


def spring_energy(motors: Sequence[JointPhysics], q: Vector) -> Scalar:
    """Energy in the springs [J]."""
    stretched = [(one.stiffness, x - (one.rest or 0.0)) for one, x in zip(motors, q, strict=True)]
    return sum(0.5 * stiffness * x * x for stiffness, x in stretched if stiffness)


def _rubbed(physics: JointPhysics, v: Scalar, fn: Bounds) -> Scalar:
    if not physics.friction:
        return 0.0
    x = fn.maximum(-1.0, fn.minimum(1.0, v * (1.0 / physics.speed)))
    square = x * x
    return physics.friction * 0.125 * x * (15.0 - square * (10.0 - 3.0 * square))
