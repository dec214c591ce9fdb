"""The instants of the hardware in a run: sensors are read, the law is asked, commands take effect.

What happens at each is in `cutjoint.simulation.hardware`; here it meets the equations that it drives.  Under continuous
control there are no instants.
"""

from __future__ import annotations

import math

import numpy as np

from cutjoint.arrays import Array
from cutjoint.simulation.coupled import Coupled
from cutjoint.simulation.hardware.electronics import Signals


class Sampling:
    """The hardware between a law and a robot, over time.

    Args:
        coupled: the equations; their memory moves on whenever the law is asked.
    """

    def __init__(self, coupled: Coupled) -> None:
        self._coupled, self._hardware = coupled, coupled.asking.electronics

    def begin(self) -> None:
        """The instant 0.  Where commands come late or through play, the law has held the robot for long."""
        hardware, coupled = self._hardware, self._coupled
        if hardware is None:
            return
        q, v = coupled.plant.measured(coupled.origin)
        hardware.begin(q, v)
        if hardware.rotors or hardware.equations.fitted.ticks.delayed:
            asking = coupled.asking
            asked = asking.ask(asking.desired(0.0), *hardware.see(), coupled.y[coupled.memory]).asked
            hardware.hold(asked)
        if hardware.rotors:
            coupled.y[coupled.rotors] = np.concatenate(hardware.resting(q, v))
            hardware.begin(*self._sensed())
            hardware.hold(asked)
        self.sample(0.0)

    def next_instant(self) -> float:
        """When something falls due next [s]; never under continuous control."""
        return math.inf if self._hardware is None else self._hardware.schedule.next

    def sample(self, t: float) -> None:
        """What falls due at `t` [s].  The law's memory moves on by one period when it is asked."""
        hardware, coupled, asking = self._hardware, self._coupled, self._coupled.asking
        assert hardware is not None, "continuous control has no samples"
        for stage in hardware.due():
            if stage == "capture":
                hardware.capture(*self._sensed())
            elif stage == "compute":
                answer = asking.ask(asking.desired(t), *hardware.see(), coupled.y[coupled.memory])
                hardware.command(answer.asked)
                if answer.memory_rate.size:
                    coupled.y = coupled.y.copy()
                    coupled.y[coupled.memory] += hardware.equations.fitted.period * answer.memory_rate
            else:
                hardware.apply()

    def held(self) -> Array | None:
        """Effort until the next instant, shape (n,); None where it changes with the motion."""
        return self._hardware.held if self._hardware is not None and self._coupled.holds else None

    def signals(self, y: Array) -> Signals | None:
        """What passes between law and joints in a state whose flat vector is `y`."""
        return None if self._hardware is None else self._hardware.signals(y[self._coupled.rotors])

    def _sensed(self) -> tuple[Array, Array]:
        """Where the sensors are, and how fast: at the joints, or at rotors before play; shape (n,) each."""
        hardware, coupled = self._hardware, self._coupled
        rotors = coupled.y[coupled.rotors]
        if hardware is not None and hardware.equations.fitted.at_motor:
            return rotors[: rotors.size // 2], rotors[rotors.size // 2 :]
        return coupled.plant.measured(coupled.origin)
