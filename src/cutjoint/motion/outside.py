"""Trajectories from outside the package, looked at before anything moves.

A part from outside makes a trajectory as make(mechanism, *numbers): a class, or a function that gives an object.  What
it says is checked at every instant for its form; its rates are compared with differences of its positions at some.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cutjoint.arrays import Array, as_vector, positive
from cutjoint.errors import InputError, UnknownNameError
from cutjoint.mechanism import Mechanism
from cutjoint.mechanism.rotations import rotation_from, vector_of
from cutjoint.motion.values import JointMotion, ToolMotion
from cutjoint.plugins import guarded, installed, installed_part, is_outside, made_by, part

GROUP = "cutjoint.trajectories"
"""The entry points of installed packages that make trajectories."""
WANTED = (
    "a trajectory is made by NAME(mechanism, *numbers), and has a duration [s] and at(t), which gives a ToolMotion, a "
    "JointMotion, or position, velocity and acceleration of the tool point, (3,) each"
)
INSTANTS = (0.0713, 0.2137, 0.3819, 0.5201, 0.6691, 0.8513, 0.9377)
"""Parts of the duration at which rates are compared; hardly any trajectory is pieced together there."""
APART = 1e-4
"""Half of what lies between two positions that are subtracted, of the duration."""
ALLOWED = 0.05
"""How much of the largest rate a rate may differ from differences of positions.  This finds a wrong derivative."""


@dataclass(frozen=True)
class OutsideTrajectory:
    """A trajectory from outside, whose answers are looked at.

    Attributes:
        inner: what was made outside.
        told: how it was written.
        n: number of actuators.
    """

    inner: object
    told: str
    n: int

    @property
    def name(self) -> str:
        """For messages, tables and file names."""
        return str(getattr(self.inner, "name", type(self.inner).__name__))

    @property
    def duration(self) -> float:
        """Time after which it repeats or rests [s]."""
        return positive(f"duration of {self.told}", guarded(self.told, lambda: self.inner.duration), "s")  # type: ignore

    def at(self, t: float) -> ToolMotion | JointMotion:
        """The desired motion at time `t` [s].

        Raises:
            InputError: it raises, or its answer is none.
        """
        told = f"{self.told}.at({t:.6g})"
        answer = guarded(told, self.inner.at, t)  # type: ignore[attr-defined]
        if isinstance(answer, JointMotion):
            for name in ("q", "v", "a"):
                as_vector(f"{name} of {told}", getattr(answer, name), self.n)
            return answer
        if not isinstance(answer, ToolMotion):
            if not (isinstance(answer, tuple | list) and len(answer) == 3):
                raise InputError(f"{told} gives {answer!r}; {WANTED}")
            place, velocity, acceleration = (
                as_vector(f"{name} of {told}", one, 3) for name, one in zip(NAMES, answer, strict=True)
            )
            answer = ToolMotion(place, velocity, acceleration)
        turning = ("angular_velocity", "angular_acceleration") if answer.rotation is not None else ()
        for name in (*NAMES, *turning):
            as_vector(f"{name} of {told}", getattr(answer, name), 3)
        if answer.rotation is not None:
            rotation_from(answer.rotation)
        return answer


NAMES = ("position", "velocity", "acceleration")


def outside_trajectory(spec: str, mechanism: Mechanism, known: list[str]) -> OutsideTrajectory:
    """The trajectory that `spec`, FILE.py:NAME[:NUMBERS], PACKAGE.MODULE:NAME[:NUMBERS] or the name of an entry point
    with or without numbers, makes for `mechanism`.

    Args:
        known: names of the trajectories that are no parts from outside, for messages.

    Raises:
        UnknownNameError: no such trajectory.
        InputError: what is found is no trajectory.
    """
    others = installed(GROUP)
    name, _, rest = spec.partition(":")
    if name in others:
        found = installed_part(GROUP, name)
    elif is_outside(spec):
        found = part(spec)
        rest = found.rest
    else:
        raise UnknownNameError("trajectory", name, [*known, *others])
    try:
        numbers = [float(one) for one in rest.split(",")] if rest else []
    except ValueError as error:
        raise InputError(f"behind {found.told} there must be numbers with commas, found '{rest}'") from error
    if not callable(found.value):
        raise InputError(f"{found.told} is {found.value!r}, which cannot be called; {WANTED}")
    inner = made_by(found.value, found.told, WANTED, mechanism, *numbers)
    missing = [one for one in ("duration", "at") if not hasattr(inner, one)]
    if missing or not callable(inner.at):  # type: ignore[attr-defined]
        raise InputError(f"{found.told} makes {inner!r}, which has no {' and no '.join(missing)}; {WANTED}")
    made = OutsideTrajectory(inner, found.told, mechanism.n)
    made.at(0.0)
    check_rates(made)
    return made


def check_rates(trajectory: OutsideTrajectory) -> None:
    """Raises InputError where velocities or accelerations are not the derivatives that they should be."""
    span = trajectory.duration
    h = APART * span
    at = [[_parts(trajectory.at(share * span + shift)) for shift in (-h, 0.0, h)] for share in INSTANTS]
    for rate, name in ((1, "velocity"), (2, "acceleration")):
        told = np.array([now[rate] for _, now, _ in at])
        found = np.array(
            [_change(before[0], after[0]) if rate == 1 else after[1] - before[1] for before, _, after in at]
        )
        found /= 2.0 * h
        allowed = ALLOWED * max(float(np.abs(told).max()), float(np.abs(found).max())) + 1e-9
        off = np.abs(told - found).max(axis=1)
        if (off > allowed).sum() > len(INSTANTS) // 2:
            worst = int(off.argmax())
            of = "position" if rate == 1 else "velocity"
            raise InputError(
                f"the {name} of {trajectory.told} is not the derivative of its {of}: at {INSTANTS[worst] * span:.4g} s "
                f"it says {np.round(told[worst], 6).tolist()}, differences of the {of} give "
                f"{np.round(found[worst], 6).tolist()}"
            )


Parts = tuple[tuple[Array, Array | None], Array, Array]


def _parts(motion: ToolMotion | JointMotion) -> Parts:
    """Place and rotation, and both rates."""
    if isinstance(motion, JointMotion):
        return (motion.q, None), motion.v, motion.a
    if motion.angular_velocity is None or motion.angular_acceleration is None:
        return (motion.position, None), motion.velocity, motion.acceleration
    v = np.concatenate([motion.velocity, motion.angular_velocity])
    return (motion.position, motion.rotation), v, np.concatenate([motion.acceleration, motion.angular_acceleration])


def _change(before: tuple[Array, Array | None], after: tuple[Array, Array | None]) -> Array:
    away = after[0] - before[0]
    if before[1] is None or after[1] is None:
        return away
    return np.concatenate([away, vector_of(after[1] @ before[1].T)])
