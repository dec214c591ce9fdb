"""Limits of a motion: speed, acceleration, jerk, effort and power of the actuators, and speed and acceleration of the
tool point.  What nobody says is without a limit, but for speeds and efforts that the robot's own file tells."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import LARGEST, Array, Frozen
from cutjoint.chain import ClosedChain
from cutjoint.doors import described
from cutjoint.errors import InputError, UnknownNameError
from cutjoint.mechanism import Actuator, Mechanism
from cutjoint.reprs import line

LimitLike: TypeAlias = npt.ArrayLike | Mapping[str, float]
"""One number for all actuators, a number each, or numbers by name."""
OF_ACTUATORS = ("speed", "acceleration", "jerk", "effort", "power")
OF_TOOL = ("tool_speed", "tool_acceleration")
UNITS: Mapping[str, tuple[str, str]] = {
    "speed": ("rad/s", "m/s"),
    "acceleration": ("rad/s2", "m/s2"),
    "jerk": ("rad/s3", "m/s3"),
    "effort": ("N m", "N"),
    "power": ("W", "W"),
    "tool_speed": ("m/s", "m/s"),
    "tool_acceleration": ("m/s2", "m/s2"),
}
"""Quantity -> its unit for an actuator that turns, and for one that slides."""


@dataclass(frozen=True, eq=False)
class MotionLimits(Frozen):
    """What a motion must keep, the same in both directions; infinite where there is no limit.

    Attributes:
        actuators: whose limits they are, in the robot's order.
        speed: shape (n,), [m/s] or [rad/s].
        acceleration: shape (n,), [m/s2] or [rad/s2].
        jerk: shape (n,), [m/s3] or [rad/s3].
        effort: shape (n,), [N] or [N m].
        power: mechanical power of each actuator, |effort * speed|, shape (n,), [W].
        tool_speed: of the tool point [m/s].
        tool_acceleration: of the tool point [m/s2].
        told: where each limit is from.
    """

    actuators: tuple[Actuator, ...]
    speed: Array
    acceleration: Array
    jerk: Array
    effort: Array
    power: Array
    tool_speed: float = np.inf
    tool_acceleration: float = np.inf
    told: tuple[str, ...] = ()

    __repr__ = line(
        "speed",
        "acceleration",
        "jerk",
        "effort",
        "power",
        "tool_speed",
        "tool_acceleration",
        speed="m/s or rad/s",
        acceleration="m/s2 or rad/s2",
        jerk="m/s3 or rad/s3",
        effort="N or N m",
        power="W",
        tool_speed="m/s",
        tool_acceleration="m/s2",
    )

    def of(self, quantity: str) -> Array:
        """The limits of a quantity: shape (n,), or (1,) for one of the tool."""
        return np.atleast_1d(np.asarray(getattr(self, quantity), dtype=np.float64))

    def named(self, quantity: str, which: int) -> str:
        """What number `which` of a quantity is, in words, such as `effort of arm1`."""
        if quantity in OF_TOOL:
            return quantity.replace("_", " ")
        return f"{quantity} of {self.actuators[which].name}"

    def unit(self, quantity: str, which: int) -> str:
        """Its unit."""
        return UNITS[quantity][1 if self.actuators[which].kind == "translation" else 0]


# long: a limit a line, and where it is from
def limits_of(
    robot: Mechanism,
    *,
    speed: LimitLike | None = None,
    acceleration: LimitLike | None = None,
    jerk: LimitLike | None = None,
    effort: LimitLike | None = None,
    power: LimitLike | None = None,
    tool_speed: float | None = None,
    tool_acceleration: float | None = None,
) -> MotionLimits:
    """The limits of a motion of a robot.

    Args:
        robot: whose actuators they are.
        speed: largest [m/s] or [rad/s]: one number, a number each, or some by name, and so are those below;
            `numpy.inf` is no limit.  Where none is given, those of the robot's description, if it tells any.
        acceleration: largest [m/s2] or [rad/s2].
        jerk: largest [m/s3] or [rad/s3].
        effort: largest [N] or [N m]; where none is given, those of the description.
        power: largest [W].
        tool_speed: of the tool point [m/s].
        tool_acceleration: of the tool point [m/s2].

    Raises:
        InputError: a limit is not > 0, there are too many or too few, or nothing limits the acceleration.
        UnknownNameError: there is no actuator of a name.
    """
    given_of_tool = dict(zip(OF_TOOL, (tool_speed, tool_acceleration), strict=True))
    given = dict(zip(OF_ACTUATORS, (speed, acceleration, jerk, effort, power), strict=True))
    found: dict[str, Array] = {}
    told: list[str] = []
    for quantity, value in given.items():
        whole = np.full(robot.n, np.inf)
        if quantity in ("speed", "effort"):
            whole, where = _described(robot, quantity)
            told += where if value is None or isinstance(value, Mapping) else []
        if value is not None:
            whole = _as_limits(quantity, value, robot.actuators, whole)
            told.append(f"{quantity}: as given")
        found[quantity] = whole
    of_tool = [np.inf if one is None else _positive(name, one) for name, one in given_of_tool.items()]
    told += [f"{name.replace('_', ' ')}: as given" for name, one in given_of_tool.items() if one is not None]
    if not (any(np.isfinite(found[one]).any() for one in ("acceleration", "effort")) or np.isfinite(of_tool[1])):
        raise InputError(
            f"nothing limits the acceleration of {robot.name}: its description tells no largest effort; give a limit "
            "of effort, acceleration or tool acceleration"
        )
    of_each = (found["speed"], found["acceleration"], found["jerk"], found["effort"], found["power"])
    return MotionLimits(robot.actuators, *of_each, of_tool[0], of_tool[1], tuple(told))


def _described(robot: Mechanism, quantity: str) -> tuple[Array, list[str]]:
    """Limits of the description, and what is said of them."""
    whole, told = np.full(robot.n, np.inf), []
    chain = robot if isinstance(robot, ClosedChain) else getattr(robot, "chain", None)
    if not isinstance(chain, ClosedChain):
        return whole, [f"{quantity}: no limit, since {robot.name} has no description"]
    for at, actuator in enumerate(robot.actuators):
        limits = chain.description.joint(actuator.name).limits
        value = None if limits is None else limits.velocity if quantity == "speed" else limits.effort
        unit = UNITS[quantity][1 if actuator.kind == "translation" else 0]
        if value is None or not np.isfinite(value):
            told.append(f"{quantity} of {actuator.name}: no limit, the description tells none")
        elif value <= 0.0:
            told.append(f"{quantity} of {actuator.name}: no limit, {value:g} in the description is none")
        else:
            whole[at] = value
            told.append(f"{quantity} of {actuator.name}: {value:g} {unit}, from the description")
    return whole, told


def _as_limits(quantity: str, value: LimitLike, actuators: tuple[Actuator, ...], usual: Array) -> Array:
    if isinstance(value, Mapping):
        whole, names = usual.copy(), [one.name for one in actuators]
        for name, number in value.items():
            if name not in names:
                raise UnknownNameError("actuator", str(name), names)
            whole[names.index(name)] = _positive(f"{quantity} of {name}", number)
        return whole
    try:
        numbers = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"{quantity} must be numbers > 0, found {described(value)}") from error
    if np.asarray(value).dtype.kind not in "iuf":
        raise InputError(f"{quantity} must be numbers > 0, found {described(value)}")
    if numbers.ndim > 1 or numbers.size not in (1, len(actuators)):
        raise InputError(
            f"{quantity} must be one number, or {len(actuators)} of them, or some by name; found {described(value)}"
        )
    for number in numbers.ravel().tolist():
        _positive(quantity, number)
    return np.broadcast_to(numbers.ravel(), len(actuators)).copy()


def _positive(name: str, value: object) -> float:
    number = float(value) if isinstance(value, int | float | np.number) and not isinstance(value, bool) else np.nan
    if not (number > 0.0 and (number == np.inf or 1.0 / LARGEST < number < LARGEST)):
        raise InputError(f"a limit of {name.replace('_', ' ')} must be a number > 0, found {described(value)}")
    return number
