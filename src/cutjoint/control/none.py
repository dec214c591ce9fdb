"""No control: the actuators are free.  For free fall and for tests of conservation laws."""

from __future__ import annotations

import numpy as np

from cutjoint.arrays import Array
from cutjoint.control.pd import NOTHING
from cutjoint.motion import Desired
from cutjoint.reprs import line


class NoControl:
    """Zero effort at every actuator."""

    name = "none"

    __repr__ = line("gains")

    @property
    def gains(self) -> dict[str, list[list[float]]]:
        """None."""
        return {}

    def memory(self, n: int) -> int:
        """No memory."""
        return 0

    def effort(self, desired: Desired, q: Array, v: Array, memory: Array) -> Array:
        """Zeros, shape (n,)."""
        return np.zeros(q.shape)

    def memory_rate(self, desired: Desired, q: Array, v: Array, asked: Array, given: Array) -> Array:
        """Nothing to remember."""
        return NOTHING
