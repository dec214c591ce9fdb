"""Plant, law, reference, hardware and loads as one set of equations for an integrator:
y = (u, v, memory, rotors, works).

u are coordinates in the plant's chart around the last accepted state, v its velocity, memory the law's own state,
rotors positions and speeds of motors before gears with play.  Works are integrals of power: what friction takes, where
the plant has any; what loads from outside do, where there are any; and effort times actuator speed, the last.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from cutjoint.arrays import Array
from cutjoint.control import Law
from cutjoint.errors import CutjointError, InputError
from cutjoint.motion import Desired, Reference
from cutjoint.plugins import guarded
from cutjoint.simulation.hardware.electronics import Electronics, Signals
from cutjoint.simulation.locks import Locks
from cutjoint.simulation.observables import Works
from cutjoint.simulation.plant import Advanced, Plant, State
from cutjoint.simulation.pushing import Pushing
from cutjoint.simulation.stiction import Stiction
from cutjoint.simulation.undesired import Undesired


class Coupled:
    """The closed loop from one accepted state to the next.

    Attributes:
        origin: last accepted state.
        y: the same as a flat vector, shape (2 nv + memory + rotors + works,).
        electronics: what is between law and joints, or None under continuous control.
        failure: why the last evaluation was not a number, if it was not.
        evaluations: of the right hand side so far.
        strayed: worst loop gap that was found before a state was put back [m].
    """

    def __init__(
        self,
        plant: Plant,
        law: Law,
        reference: Reference | None,
        control: Array | Electronics | None,
        locks: Locks,
        start: State,
        pushing: Pushing | None = None,
    ) -> None:
        """`control` is the hardware of sampled control, or the limits of efforts under continuous control."""
        self.plant, self.law, self.reference, self.locks = plant, law, reference, locks
        self.electronics = control if isinstance(control, Electronics) else None
        self._limits = None if isinstance(control, Electronics) else control
        self.pushing = pushing
        self.stiction = Stiction(plant, locks, start) if plant.sticking else None
        memory = law.memory(plant.mechanism.n)
        rotors = 0 if self.electronics is None else self.electronics.rotors
        self._nv = start.v.size
        self._memory = slice(2 * self._nv, 2 * self._nv + memory)
        self._rotors = slice(self._memory.stop, self._memory.stop + rotors)
        self.origin = start
        works = 1 + (pushing is not None) + plant.dissipates
        self.y = np.concatenate([plant.chart(start), start.v, np.zeros(memory + rotors + works)])
        self.failure: CutjointError | None = None
        self.evaluations = 0
        self.strayed = 0.0
        self._given: tuple[Array, Array] | None = None

    def desired(self, t: float) -> Desired:
        """The reference at `t` [s], or what stands for it where there is none."""
        return Undesired(t, self.law.name) if self.reference is None else self.reference.at(t)

    def state(self, y: Array) -> State:
        """The plant's state of a flat vector."""
        return self.plant.moved(self.origin, y[: self._nv], y[self._nv : 2 * self._nv])

    def ask(self, desired: Desired, q: Array, v: Array, y: Array) -> tuple[Array, Array, Array]:
        """What the law, shown `q` and `v`, asks for; the same within limits, shape (n,); and the rate of its memory.

        Raises:
            InputError: shapes do not fit, or efforts are not finite.
        """
        memory, told = y[self._memory], f"controller '{self.law.name}'"
        asked = np.asarray(guarded(told, self.law.effort, desired, q, v, memory))
        if asked.shape != q.shape:
            raise InputError(
                f"{told} asks for efforts of shape {asked.shape}; the robot has {q.size} "
                f"actuators, so they must have shape {q.shape}"
            )
        if not np.isfinite(asked).all():
            raise InputError(f"{told} asks for an effort that is not finite: {asked.tolist()}")
        if self.electronics is not None:
            given = self.electronics.equations.saturated(asked)
        else:
            given = asked if self._limits is None else np.clip(asked, -self._limits, self._limits)
        rate = np.asarray(guarded(told, self.law.memory_rate, desired, q, v, asked, given))
        if rate.shape != memory.shape:
            raise InputError(f"{told} has a memory of shape {memory.shape} and its rate is of shape {rate.shape}")
        return asked, given, rate

    def actuation(self, t: float, state: State, y: Array) -> tuple[Array, Array]:
        """Effort at the joints without brakes, shape (n,), and the rate of memory and rotors."""
        q, v = self.plant.measured(state)
        if self.electronics is None:
            return self.ask(self.desired(t), q, v, y)[1:]
        effort, rate = self.electronics.effort(q, v, y[self._rotors])
        return effort, np.concatenate([np.zeros(self._memory.stop - self._memory.start), rate])

    def field(self, t: float, y: Array) -> Array:
        """dy/dt; not a number where plant, law or reference cannot go, so that adaptive methods try a shorter step."""
        self.evaluations += 1
        nv = self._nv
        out = np.full(y.size, np.nan)
        if not np.isfinite(y).all():
            return out
        try:
            state = self.state(y)
            asked, out[self._memory.start : self._rotors.stop] = self.actuation(t, state, y)
            out[:nv] = self.plant.chart_rate(self.origin, state)
            push = None if self.pushing is None else self.pushing.on(t, state)
            moved = self.locks.motion if self.stiction is None else self.stiction.motion
            effort, out[nv : 2 * nv] = moved(state, asked, push)
            self._given = (y, effort)
            if push is not None:
                out[-2] = push @ state.v
            if self.plant.dissipates:
                out[self._rotors.stop] = self.plant.dissipation(state)
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
        if self.electronics is None and self._given is not None and self._given[0] is y:
            return self._given[1]
        asked = self.actuation(t, state, y)[0]
        if not self.locks.names:
            return asked
        push = None if self.pushing is None else self.pushing.on(t, state)
        return (
            self.locks.holding(state, asked, push)
            if self.stiction is None
            else self.stiction.motion(state, asked, push)[0]
        )

    def let_go(self, t: float) -> bool:
        """Joints that stick and are not held by their friction start to slip at `t` [s]; whether any does."""
        return self.stiction is not None and self.stiction.settle(*self._acting(t, self.origin, self.y))

    def switch(self, t: float, joint: int) -> None:
        """The mode of a joint with stiction has ended at `t` [s]."""
        assert self.stiction is not None
        acting = self._acting(t, self.origin, self.y)
        self.stiction.switch(joint, *acting)
        self.accept(self.y)
        self.stiction.settle(*self._acting(t, self.origin, self.y))

    def late(self, t: float, y: Array, joint: int) -> float:
        """How long ago the rate of a joint with stiction that slips was zero [s], at `t` [s] in a state whose flat
        vector is `y`; 0 for one that sticks."""
        assert self.stiction is not None
        return self.stiction.late(joint, *self._acting(t, self.state(y), y))

    def mode_ends(self, t: float, y: Array) -> int | None:
        """A joint with stiction whose mode has ended at `t` [s] in a state whose flat vector is `y`, or None."""
        assert self.stiction is not None
        return self.stiction.passed(*self._acting(t, self.state(y), y))

    def _acting(self, t: float, state: State, y: Array) -> tuple[State, Array, Array | None]:
        push = None if self.pushing is None else self.pushing.on(t, state)
        return state, self.actuation(t, state, y)[0], push

    def works(self, y: Array) -> Works:
        """Work since the start."""
        lost = float(y[self._rotors.stop]) if self.plant.dissipates else None
        return Works(float(y[-1]), None if self.pushing is None else float(y[-2]), lost)

    def begin(self) -> None:
        """The instant 0.  Where commands come late or through play, the law has held the robot for long."""
        hardware = self.electronics
        if hardware is None:
            return
        q, v = self.plant.measured(self.origin)
        hardware.begin(q, v)
        if hardware.rotors or hardware.equations.fitted.ticks.delayed:
            asked = self.ask(self.desired(0.0), *hardware.see(), self.y)[0]
            hardware.hold(asked)
        if hardware.rotors:
            self.y[self._rotors] = np.concatenate(hardware.resting(q, v))
            hardware.begin(*self.sensed())
            hardware.hold(asked)
        self.sample(0.0)

    def sample(self, t: float) -> None:
        """What falls due in the hardware at `t` [s]: sensors are read, the law is asked, commands take effect.

        The law's memory moves on by one period when it is asked.
        """
        hardware = self.electronics
        assert hardware is not None, "continuous control has no samples"
        for stage in hardware.due():
            if stage == "capture":
                hardware.capture(*self.sensed())
            elif stage == "compute":
                asked, _, rate = self.ask(self.desired(t), *hardware.see(), self.y)
                hardware.command(asked)
                if rate.size:
                    self.y = self.y.copy()
                    self.y[self._memory] += hardware.equations.fitted.period * rate
            else:
                hardware.apply()

    def next_instant(self) -> float:
        """When something falls due in the hardware next [s]; never under continuous control."""
        return math.inf if self.electronics is None else self.electronics.schedule.next

    def signals(self, y: Array) -> Signals | None:
        """What passes between law and joints in a state whose flat vector is `y`."""
        return None if self.electronics is None else self.electronics.signals(y[self._rotors])

    def sensed(self) -> tuple[Array, Array]:
        """Where the sensors are, and how fast: at the joints, or at rotors before play; shape (n,) each."""
        hardware, rotors = self.electronics, self.y[self._rotors]
        if hardware is not None and hardware.equations.fitted.at_motor:
            return rotors[: rotors.size // 2], rotors[rotors.size // 2 :]
        return self.plant.measured(self.origin)

    def held(self) -> Array | None:
        """Effort until the next instant of the hardware, shape (n,); None where it changes with the motion."""
        return self.electronics.held if self.electronics is not None and self.holds else None

    @property
    def holds(self) -> bool:
        """Whether efforts only change at instants of the hardware."""
        return (
            self.electronics is not None
            and self.electronics.holds
            and self.pushing is None
            and not self.locks.names
            and self.stiction is None
        )

    def put(self, done: Advanced) -> None:
        """Take what became of the plant, which integrated itself."""
        self.origin, self.evaluations = done.state, self.evaluations + done.evaluations
        self.strayed = max(self.strayed, done.strayed)
        rest = self.y[2 * self._nv :].copy()
        rest[-1] += done.work
        if self.plant.dissipates:
            rest[self._rotors.stop - 2 * self._nv] += done.lost
        self.y = np.concatenate([self.plant.chart(done.state), done.state.v, rest])

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
