"""Plant, law, hardware and loads as one set of equations for an integrator: y = (u, v, memory, rotors, works).

u are coordinates in the plant's chart around the last accepted state, v its velocity, memory the law's own state,
rotors positions and speeds of motors before gears with play.  Works are integrals of power: what friction takes, where
the plant has any; what loads from outside do, where there are any; and effort times actuator speed, the last.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cutjoint.arrays import Array
from cutjoint.errors import CutjointError, InputError
from cutjoint.simulation.asking import Asking
from cutjoint.simulation.locks import Locks
from cutjoint.simulation.observables import Works
from cutjoint.simulation.plant import Advanced, Plant, State
from cutjoint.simulation.pushing import Pushing
from cutjoint.simulation.stiction import Stiction


class Coupled:
    """The closed loop from one accepted state to the next.

    Attributes:
        origin: last accepted state.
        y: the same as a flat vector, shape (2 nv + memory + rotors + works,).
        memory, rotors: where those are in y.
        stiction: which joints stick, or None where none can.
        failure: why the last evaluation was not a number, if it was not.
        evaluations: of the right hand side so far.
        strayed: worst loop gap that was found before a state was put back [m].
    """

    def __init__(
        self, plant: Plant, asking: Asking, locks: Locks, start: State, pushing: Pushing | None = None
    ) -> None:
        self.plant, self.asking, self.locks, self.pushing = plant, asking, locks, pushing
        self.stiction = Stiction(plant, locks, start) if plant.sticking else None
        memory = asking.law.memory(plant.mechanism.n)
        rotors = 0 if asking.electronics is None else asking.electronics.rotors
        self._nv = start.v.size
        self.memory = slice(2 * self._nv, 2 * self._nv + memory)
        self.rotors = slice(self.memory.stop, self.memory.stop + rotors)
        self.origin = start
        works = 1 + (pushing is not None) + plant.dissipates
        self.y = np.concatenate([plant.chart(start), start.v, np.zeros(memory + rotors + works)])
        self.failure: CutjointError | None = None
        self.evaluations = 0
        self.strayed = 0.0
        self._given: tuple[Array, Array] | None = None

    def state(self, y: Array) -> State:
        """The plant's state of a flat vector."""
        return self.plant.moved(self.origin, y[: self._nv], y[self._nv : 2 * self._nv])

    def actuation(self, t: float, state: State, y: Array) -> tuple[Array, Array]:
        """Effort at the joints without brakes, shape (n,), and the rate of memory and rotors."""
        q, v = self.plant.measured(state)
        electronics = self.asking.electronics
        if electronics is None:
            answer = self.asking.ask(self.asking.desired(t), q, v, y[self.memory])
            return answer.given, answer.memory_rate
        effort, rate = electronics.effort(q, v, y[self.rotors])
        return effort, np.concatenate([np.zeros(self.memory.stop - self.memory.start), rate])

    def acting(self, t: float, y: Array) -> tuple[State, Array, Array | None]:
        """The state of a flat vector at `t` [s], the effort at its joints without brakes, and what loads do."""
        state = self.origin if y is self.y else self.state(y)
        return state, self.actuation(t, state, y)[0], self._push(t, state)

    def field(self, t: float, y: Array) -> Array:
        """dy/dt; not a number where plant, law or reference cannot go, so that adaptive methods try a shorter step."""
        self.evaluations += 1
        nv = self._nv
        out = np.full(y.size, np.nan)
        if not np.isfinite(y).all():
            return out
        try:
            state = self.state(y)
            asked, out[self.memory.start : self.rotors.stop] = self.actuation(t, state, y)
            out[:nv] = self.plant.chart_rate(self.origin, state)
            push = self._push(t, state)
            moved = self.locks.motion if self.stiction is None else self.stiction.motion
            effort, out[nv : 2 * nv] = moved(state, asked, push)
            self._given = (y, effort)
            if push is not None:
                out[-2] = push @ state.v
            if self.plant.dissipates:
                out[self.rotors.stop] = self.plant.dissipation(state)
            out[-1] = effort @ self.plant.measured(state)[1]
        except CutjointError as error:
            self.failure = error
            out[:] = np.nan
        except np.linalg.LinAlgError as error:
            self.failure = InputError(f"the equations of motion are singular: {error}")
            out[:] = np.nan
        return out

    def effort_at(self, t: float, state: State, y: Array) -> Array:
        """Effort at `t` [s] in a state, whose flat vector is `y`, brakes included, shape (n,)."""
        if self.asking.electronics is None and self._given is not None and self._given[0] is y:
            return self._given[1]
        asked = self.actuation(t, state, y)[0]
        if not self.locks.names:
            return asked
        push = self._push(t, state)
        return (
            self.locks.holding(state, asked, push)
            if self.stiction is None
            else self.stiction.motion(state, asked, push)[0]
        )

    @property
    def holds(self) -> bool:
        """Whether efforts only change at instants of the hardware, so that a plant may integrate itself in between."""
        electronics = self.asking.electronics
        return (
            electronics is not None
            and electronics.holds
            and self.pushing is None
            and not self.locks.names
            and self.stiction is None
        )

    def works(self, y: Array) -> Works:
        """Work since the start."""
        lost = float(y[self.rotors.stop]) if self.plant.dissipates else None
        return Works(float(y[-1]), None if self.pushing is None else float(y[-2]), lost)

    def accept(self, y: Array) -> bool:
        """Take `y` as the new state, put back on its loops.  True where dy/dt did not change by that.

        Raises:
            ClosureError, SingularError: it cannot be put back.
        """
        state, gap = self.plant.settled(self.state(y))
        if self.stiction is not None:
            state = replace(state, v=self.stiction.at_rest(state))
        self.strayed = max(self.strayed, gap)
        self.origin = state
        u = self.plant.chart(state)
        same = np.array_equal(u, y[: self._nv]) and np.array_equal(state.v, y[self._nv : 2 * self._nv])
        self.y = y if same else np.concatenate([u, state.v, y[2 * self._nv :]])
        return bool(same)

    def put(self, done: Advanced) -> None:
        """Take what became of the plant, which integrated itself."""
        self.origin, self.evaluations = done.state, self.evaluations + done.evaluations
        self.strayed = max(self.strayed, done.strayed)
        rest = self.y[2 * self._nv :].copy()
        rest[-1] += done.work
        if self.plant.dissipates:
            rest[self.rotors.stop - 2 * self._nv] += done.lost
        self.y = np.concatenate([self.plant.chart(done.state), done.state.v, rest])

    def _push(self, t: float, state: State) -> Array | None:
        return None if self.pushing is None else self.pushing.on(t, state)
