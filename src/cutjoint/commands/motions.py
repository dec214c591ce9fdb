"""Trajectories as the command line names them: `paper`, `hold`, `line:X,Y,Z[,SECONDS]`, `circle:RADIUS[,SECONDS]`."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cutjoint.chain import ClosedChain
    from cutjoint.mechanism import Mechanism
    from cutjoint.motion import Trajectory

HELP = (
    "paper (the robot's own), hold, line:X,Y,Z[,SECONDS] by so many metres from home, circle:RADIUS[,SECONDS] in "
    "metres through home."
)
NAMES = ("paper", "hold", "line", "circle")


def trajectory_of(chain: ClosedChain, spec: str, mechanism: Mechanism | None = None) -> Trajectory:
    """The trajectory that `spec` names, for a robot that starts in the home posture of `mechanism` (default: `chain`).

    Raises:
        UnknownNameError: no such trajectory.
        InputError: its numbers are wrong, or the robot has no published trajectory.
    """
    from cutjoint.arrays import readonly
    from cutjoint.errors import InputError, UnknownNameError
    from cutjoint.motion import Hold, PointToPoint
    from cutjoint.robots import PUBLISHED

    name, _, rest = spec.partition(":")
    if name not in NAMES:
        raise UnknownNameError("trajectory", name, NAMES)
    numbers = _numbers(spec, rest, {"paper": (0,), "hold": (0, 1), "line": (3, 4), "circle": (1, 2)}[name])
    if name == "paper":
        robot = chain.description.name
        if robot not in PUBLISHED:
            raise InputError(
                f"{robot} has no published trajectory (known: {', '.join(PUBLISHED)}); "
                "use hold, line:X,Y,Z or circle:RADIUS"
            )
        return PUBLISHED[robot].trajectory()
    robot_model: Mechanism = chain if mechanism is None else mechanism
    home = robot_model.tool(robot_model.home).position
    if name == "hold":
        return Hold(home, numbers[0]) if numbers else Hold(home)
    if name == "line":
        return PointToPoint(home, readonly(numbers[:3]), numbers[3] if len(numbers) > 3 else 1.0)
    return _circle(robot_model, *numbers)


def _numbers(spec: str, text: str, counts: tuple[int, ...]) -> list[float]:
    from cutjoint.errors import InputError

    try:
        found = [float(one) for one in text.split(",")] if text else []
    except ValueError:
        found = []
        counts = ()
    if len(found) not in counts:
        raise InputError(f"'{spec}' is no trajectory; write {HELP}")
    return found


def _circle(mechanism: Mechanism, radius: float, seconds: float = 2.0) -> Trajectory:
    """A circle through the home position, in the plane in which the tool moves most easily."""
    import numpy as np

    from cutjoint.arrays import positive
    from cutjoint.errors import InputError
    from cutjoint.motion import Circle

    positive("radius", radius, "m")
    positive("seconds", seconds, "s")
    tool = mechanism.tool(mechanism.home)
    directions, sizes, _ = np.linalg.svd(tool.jacobian)
    if mechanism.n < 2 or sizes[1] < 1e-9 * sizes[0]:
        raise InputError(f"the tool of {mechanism.name} moves along a line; it cannot follow a circle")
    first, second = (axis * np.sign(axis[np.argmax(np.abs(axis))]) for axis in directions.T[:2])
    return Circle(tool.position - radius * first, radius, 2.0 * np.pi / seconds, first, second)
