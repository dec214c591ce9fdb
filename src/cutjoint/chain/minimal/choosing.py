"""Which velocities of a robot are taken as independent: of what flies, of the motors, and of joints that are named.

Let N be an orthonormal basis of the motions that the loops allow, at a regular posture.  Velocities are independent
where their rows of N are.  They are taken one after another: all of a body that flies from the base, then each motor
whose row is not made of those before, then what is named.  Motors that are left over act through the effort map.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cutjoint import tolerances
from cutjoint.arrays import Array
from cutjoint.chain.joints import joints_of, travelling
from cutjoint.chain.kinematics import Kinematics
from cutjoint.chain.minimal.independent import Independent
from cutjoint.chain.mobility import Mobility
from cutjoint.chain.rank import Split, null_space
from cutjoint.errors import ActuationError, InputError, UnknownNameError

AS_GOOD = 0.1
"""A motor is left out for a later one where what it adds is smaller than this part of what that one adds."""


def chosen(mobility: Mobility, names: Sequence[str]) -> Mobility:
    """Mobility of a robot by minimal coordinates, those of the actuators where they determine the motion.

    Args:
        mobility: by the actuators.
        names: of further joints whose velocities are independent.

    Raises:
        UnknownNameError: there is no such joint that moves.
        InputError: a joint is named twice, or counts among the coordinates anyway.
        ActuationError: joints that are named depend on the other coordinates, or some motion stays free.
    """
    k, actuators = mobility.postures.k, mobility.postures.actuated
    known = [joint.name for joint in k.description.joints if joint.type.moves]
    for name in names:
        if name not in known:
            raise UnknownNameError(f"moving joint of {k.name}", str(name), known)
        if list(names).count(name) > 1:
            raise InputError(f"joint '{name}' is named twice among the minimal coordinates of {k.name}")
    if mobility.is_determined and not names:
        return Mobility(mobility.postures, Independent(k, [one.name for one in actuators.joints]))
    taken = _Taken(k, _motions(mobility))
    taken.add_flying()
    taken.add_motors([one.name for one in actuators.joints])
    for name in names:
        taken.add_named(name)
    found = Mobility(mobility.postures, Independent(k, taken.names))
    if not found.is_determined or (found.structure.idle and not found.idle_is_cyclic):
        raise taken.still_free()
    return found


def _motions(mobility: Mobility) -> Array:
    """Orthonormal basis of the motions, dimensionless, shape (nv, m), at the posture that is furthest from singular."""
    splits = [Split.of(placed.scaled) for placed in mobility.regular]
    return max(splits, key=lambda split: (split.rank, float(split.values[-1:].sum()))).null


class _Taken:
    """The joints that were taken so far."""

    def __init__(self, kinematics: Kinematics, motions: Array) -> None:
        self._k, self._motions, self.names = kinematics, motions, list[str]()
        self._left = motions  # what their rows add to those of the joints that were taken
        self._rows = np.zeros((0, motions.shape[1]))

    def add_flying(self) -> None:
        """Bodies that fly from the base, where nothing holds them."""
        model, lengths = self._k.model, set(travelling(self._k.model).tolist())
        for joint in range(1, model.njoints):
            if model.parents[joint] == 0 and int(model.idx_qs[joint]) in lengths:
                name = str(model.names[joint])
                if self._adds(name):
                    self._take(name)

    def add_motors(self, motors: Sequence[str]) -> None:
        """Motors as long as they add to what there is."""
        left = list(motors)
        while left:
            sizes = [float(np.linalg.norm(self._left[self._own(name)])) for name in left]
            if not max(sizes) > tolerances.SINGULAR.value:
                return
            self._take(left.pop(next(i for i, size in enumerate(sizes) if size >= AS_GOOD * max(sizes))))

    def add_named(self, name: str) -> None:
        """A joint that somebody wants."""
        k = self._k
        if name in self.names:
            raise InputError(f"joint '{name}' counts among the minimal coordinates of {k.name} anyway; do not name it")
        if not self._adds(name):
            raise ActuationError(
                f"joint '{name}' of {k.name} moves as {', '.join(self.names) or 'the loops'} make it move, so it is no "
                f"further coordinate; {self._would_serve()}",
                mobility=self._motions.shape[1],
                actuators=len(self._rows),
                free=(),
            )
        self._take(name)

    def still_free(self) -> ActuationError:
        """What to raise where motions are left."""
        k, free = self._k, null_space(self._rows)
        moving = joints_of(k.model, self._motions @ free)
        told = ", ".join(self.names) or "no joint"
        return ActuationError(
            f"{self._motions.shape[1]} velocities of {k.name} are independent, and {len(self._rows)} are coordinates "
            f"({told}): with those held, these joints still move: {', '.join(moving)}; {self._would_serve()}",
            mobility=self._motions.shape[1],
            actuators=len(self._rows),
            free=moving,
        )

    def _would_serve(self) -> str:
        """Which joints could be named."""
        names = [joint.name for joint in self._k.description.joints if joint.type.moves]
        serve = [name for name in names if name not in self.names and self._adds(name)]
        return f"each of these could be named: {', '.join(serve)}" if serve else "nothing is left to name"

    def _own(self, name: str) -> slice:
        model = self._k.model
        joint = model.getJointId(name)
        return slice(int(model.idx_vs[joint]), int(model.idx_vs[joint] + model.nvs[joint]))

    def _adds(self, name: str) -> bool:
        """Whether all velocities of a joint are independent of those that were taken."""
        rows = self._left[self._own(name)]
        values = np.linalg.svd(rows, compute_uv=False)
        return len(values) == len(rows) and bool(values.min(initial=np.inf) > tolerances.SINGULAR.value)

    def _take(self, name: str) -> None:
        self.names.append(name)
        self._rows = np.concatenate([self._rows, self._motions[self._own(name)]])
        along = Split.of(self._rows).right
        self._left = self._motions - (self._motions @ along) @ along.T
