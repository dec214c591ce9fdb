"""Plant, law, reference and loads as one set of equations for an integrator: y = (u, v, memory, load work, work).

u are coordinates in the plant's chart around the last accepted state, v its velocity, memory the law's own state, work
the integral of effort times actuator speed, and load work that of what loads from outside do, where there are any.
"""

from __future__ import annotations

import numpy as np

from cutjoint.arrays import Array
from cutjoint.control import Law
from cutjoint.errors import CutjointError, InputError
from cutjoint.motion import Desired, Reference
from cutjoint.plugins import guarded
from cutjoint.simulation.locks import Locks
from cutjoint.simulation.plant import Plant, State
from cutjoint.simulation.pushing import Pushing
from cutjoint.simulation.undesired import Undesired


class Coupled:
    """The closed loop from one accepted state to the next.

    Attributes:
        origin: last accepted state.
        y: the same as a flat vector, shape (2 nv + memory + 1 or 2,).
        held: effort that the law holds since the last sample, shape (n,), or None under continuous control.
        failure: why the last evaluation was not a number, if it was not.
        evaluations: of the right hand side so far.
        strayed: worst loop gap that was found before a state was put back [m].
    """

    def __init__(
        self,
        plant: Plant,
        law: Law,
        reference: Reference | None,
        limits: Array | None,
        locks: Locks,
        start: State,
        pushing: Pushing | None = None,
    ) -> None:
        self.plant, self.law, self.reference, self.limits, self.locks = plant, law, reference, limits, locks
        self.pushing = pushing
        memory = law.memory(plant.mechanism.n)
        self.origin = start
        self._memory = slice(2 * start.v.size, 2 * start.v.size + memory)
        works = 1 if pushing is None else 2
        self.y = np.concatenate([plant.chart(start), start.v, np.zeros(memory + works)])
        self.held: Array | None = None
        self.failure: CutjointError | None = None
        self.evaluations = 0
        self.strayed = 0.0
        self._nv = start.v.size
        self._given: tuple[Array, Array] | None = None

    def desired(self, t: float) -> Desired:
        """The reference at `t` [s], or what stands for it where there is none."""
        return Undesired(t, self.law.name) if self.reference is None else self.reference.at(t)

    def state(self, y: Array) -> State:
        """The plant's state of a flat vector."""
        return self.plant.moved(self.origin, y[: self._nv], y[self._nv : 2 * self._nv])

    def control(self, t: float, state: State, y: Array) -> tuple[Array, Array]:
        """Effort after saturation, shape (n,), and rate of the law's memory; brakes come on top."""
        q, v = self.plant.measured(state)
        desired = self.desired(t)
        memory, told = y[self._memory], f"controller '{self.law.name}'"
        asked = np.asarray(guarded(told, self.law.effort, desired, q, v, memory))
        if asked.shape != q.shape:
            raise InputError(
                f"{told} asks for efforts of shape {asked.shape}; the robot has {q.size} "
                f"actuators, so they must have shape {q.shape}"
            )
        if not np.isfinite(asked).all():
            raise InputError(f"{told} asks for an effort that is not finite: {asked.tolist()}")
        given = asked if self.limits is None else np.clip(asked, -self.limits, self.limits)
        rate = np.asarray(guarded(told, self.law.memory_rate, desired, q, v, asked, given))
        if rate.shape != memory.shape:
            raise InputError(f"{told} has a memory of shape {memory.shape} and its rate is of shape {rate.shape}")
        return given, rate

    def field(self, t: float, y: Array) -> Array:
        """dy/dt; not a number where plant, law or reference cannot go, so that adaptive methods try a shorter step."""
        self.evaluations += 1
        nv = self._nv
        out = np.full(y.size, np.nan)
        if not np.isfinite(y).all():
            return out
        try:
            state = self.state(y)
            asked, out[self._memory] = self.control(t, state, y) if self.held is None else (self.held, 0.0)
            out[:nv] = self.plant.chart_rate(self.origin, state)
            push = None if self.pushing is None else self.pushing.on(t, state)
            effort, out[nv : 2 * nv] = self.locks.motion(state, asked, push)
            self._given = (y, effort)
            if push is not None:
                out[-2] = push @ state.v
            out[-1] = effort @ self.plant.measured(state)[1]
        except CutjointError as error:
            self.failure = error
            out[:] = np.nan
        except np.linalg.LinAlgError as error:
            self.failure = InputError(f"the equations of motion are singular: {error}")
            out[:] = np.nan
        return out

    def effort(self, t: float) -> Array:
        """Effort from the accepted state at `t` on, shape (n,)."""
        if self.held is None and self._given is not None and self._given[0] is self.y:
            return self._given[1]
        return self.effort_at(t, self.origin, self.y)

    def effort_at(self, t: float, state: State, y: Array) -> Array:
        """Effort at `t` [s] in a state, whose flat vector is `y`, brakes included, shape (n,)."""
        asked = self.control(t, state, y)[0] if self.held is None else self.held
        push = None if self.pushing is None or not self.locks.names else self.pushing.on(t, state)
        return self.locks.holding(state, asked, push)

    def works(self, y: Array) -> tuple[float, float | None]:
        """Work of the actuators and of the loads, if there are any, since the start [J]."""
        return float(y[-1]), None if self.pushing is None else float(y[-2])

    def sample(self, t: float, period: float) -> None:
        """Read the sensors and hold the effort for a period [s]; the law's memory moves on by one period."""
        self.held, memory_rate = self.control(t, self.origin, self.y)
        if memory_rate.size:
            self.y = self.y.copy()
            self.y[self._memory] += period * memory_rate

    def accept(self, y: Array) -> bool:
        """Take `y` as the new state, put back on its loops.  True where dy/dt did not change by that.

        Raises:
            ClosureError, SingularError: it cannot be put back.
        """
        state, gap = self.plant.settled(self.state(y))
        self.strayed = max(self.strayed, gap)
        self.origin = state
        u = self.plant.chart(state)
        same = np.array_equal(u, y[: self._nv]) and np.array_equal(state.v, y[self._nv : 2 * self._nv])
        self.y = y if same else np.concatenate([u, state.v, y[2 * self._nv :]])
        return bool(same)
