"""From closed configurations to the postures that users hold, and back."""

from __future__ import annotations

from cutjoint.chain.actuated import Actuated
from cutjoint.chain.closing.equations import System
from cutjoint.chain.kinematics import Kinematics, Placed
from cutjoint.errors import InputError
from cutjoint.mechanism import Posture


class Postures:
    """Postures of one robot, and the tree at them.

    Attributes:
        home: the home posture.
        at_home: the tree there.
    """

    def __init__(self, kinematics: Kinematics, actuated: Actuated, at_home: Placed) -> None:
        self._k, self._actuated = kinematics, actuated
        self.home, self.at_home = self.make(at_home), at_home

    def make(self, placed: Placed) -> Posture:
        """A closed configuration as a posture."""
        distance, angle, _ = placed.gap
        posture = Posture(self._actuated.of(placed.q), placed.q, (distance, angle))
        self._known = posture, placed
        return posture

    def placed(self, at: Posture | None) -> Placed:
        """The tree at a posture (default home) that this robot, or one of the same geometry, made.

        That of the last posture is kept, since several calls at one posture are the rule.

        Raises:
            InputError: it is no posture, or not closed for this robot.
        """
        if at is None or at is self.home:
            return self.at_home
        known, placed = self._known
        if at is known:
            return placed
        if not isinstance(at, Posture):
            raise InputError(f"a posture is wanted, such as {self._k.name} makes by close() or reach(); found {at!r}")
        size = len(self.at_home.q)
        if at.q_full.shape != (size,):
            raise InputError(
                f"this posture has {at.q_full.size} coordinates, {self._k.name} has {size}; make it with this robot's "
                "close() or reach()"
            )
        placed = self._k.at(at.q_full)
        if not System(self._k, None).at(placed).openness < 10.0:
            distance, angle, cut = placed.gap
            raise InputError(
                f"this posture leaves cut '{cut}' of {self._k.name} open by {distance:.3g} m, {angle:.3g} rad; make it "
                "with this robot's close() or reach()"
            )
        self._known = at, placed
        return placed
