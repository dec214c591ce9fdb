"""A plant in full coordinates: every joint of the tree, held together by the constraint forces of the cut joints.

Accelerations respect the constraints only to second order, so positions and velocities drift off.  Each accepted step
is therefore put back: Newton's method moves the passive joints onto the loops while actuated coordinates and speeds
stay as they are, and passive speeds follow from them.  No gain has to be chosen, and the order of the integrator is
kept, because the correction is as small as its error.
"""

from __future__ import annotations

import threading
from collections.abc import Mapping
from functools import partial

import numpy as np
import numpy.typing as npt
import pinocchio as pin

from cutjoint.arrays import Array
from cutjoint.chain import ClosedChain
from cutjoint.chain.build import bind_frame
from cutjoint.doors import door
from cutjoint.errors import InputError
from cutjoint.mechanism import Loads, Posture
from cutjoint.mechanism.rotations import quaternion_of
from cutjoint.reprs import line
from cutjoint.simulation.plant import Observation, State, tool_turns


# long: what every `Plant` has, a few lines a method
@door
class ConstrainedPlant:
    """The robot in all joints of its tree, by `pin.constraintDynamics`.

    Args:
        chain: the closed robot.
        project: put every accepted step back onto the loops.  Without it the loops drift; for measuring that.
    """

    __repr__ = line("name")

    def __init__(self, chain: ClosedChain, *, project: bool = True) -> None:
        self.chain = chain
        self.project = project
        self._workspaces = threading.local()
        self._flat = chain.model.nq == chain.model.nv
        if chain.description.tool is None:
            raise InputError(f"{chain.name} has no tool frame to simulate; name one under [tool] in its loops.toml")
        self.actuated = np.rint(chain.actuated_velocity(np.arange(chain.nv, dtype=np.float64))).astype(np.intp)
        self._turns = tool_turns(chain, chain.home, chain.length)
        self._rotors, self._bare = np.array(chain.model.armature), pin.Model(chain.model)
        self._bare.armature[:] = 0.0
        self._tool_joint, self._tool_place = bind_frame(chain.model, chain.description.tool)

    def __reduce__(self) -> tuple[object, ...]:
        return partial(type(self), project=self.project), (self.chain,)

    @property
    def _data(self) -> pin.Data:
        """Pinocchio's workspace of the thread that asks: plants are shared between threads, workspaces cannot be."""
        found: pin.Data | None = getattr(self._workspaces, "data", None)
        if found is None:
            found = self._workspaces.data = self.chain.model.createData()
        return found

    @property
    def mechanism(self) -> ClosedChain:
        """The closed robot."""
        return self.chain

    @property
    def name(self) -> str:
        """For messages and tables."""
        return f"{self.chain.name}, constrained{'' if self.project else ', not projected'}"

    def start(self, posture: Posture, v: Array) -> State:
        """See `Plant.start`.  At rest any robot can start, also one whose actuators do not determine its motion."""
        moving = self.chain.full_velocity(posture, v) if v.any() else np.zeros(self.chain.nv)
        return State(posture.q_full, np.asarray(moving))

    def chart(self, state: State) -> Array:
        """The configuration itself where it is a vector space, else exponential coordinates around it."""
        return state.q if self._flat else np.zeros(self.chain.model.nv)

    def moved(self, origin: State, u: Array, v: Array) -> State:
        """On the manifold of the tree's joints."""
        return State(u if self._flat else np.asarray(pin.integrate(self.chain.model, origin.q, u)), v)

    def chart_rate(self, origin: State, state: State) -> Array:
        """du/dt = v, on rotations times the inverse of the exponential's derivative."""
        if self._flat:
            return state.v
        rate = pin.dDifference(self.chain.model, origin.q, state.q, pin.ArgumentPosition.ARG1) @ state.v
        return np.asarray(rate)

    def measured(self, state: State) -> tuple[Array, Array]:
        """Sensors sit at the actuators."""
        return self.chain.actuated(state.q), self.chain.actuated_velocity(state.v)

    def acceleration(self, state: State, effort: Array, push: Array | None = None) -> Array:
        """Of all joints, shape (nv,)."""
        full = self.chain.full_effort(effort)
        return self.chain.full_acceleration(state.q, state.v, full if push is None else full + push)

    def pushed(self, state: State, loads: Loads) -> Array:
        """Generalised forces of all joints, shape (nv,)."""
        return self.chain.full_load_effort(state.q, loads)

    @property
    def sticking(self) -> Mapping[int, float]:
        """See `Plant.sticking`."""
        return self.chain.sticking

    def joint_rows(self, state: State, joints: npt.NDArray[np.intp]) -> tuple[Array, Array]:
        """See `Plant.joint_rows`."""
        return np.eye(self.chain.nv)[joints], np.zeros(len(joints))

    @property
    def dissipates(self) -> bool:
        """See `Plant.dissipates`."""
        return self.chain.dissipates

    def dissipation(self, state: State) -> float:
        """See `Plant.dissipation`."""
        return self.chain.full_dissipation(state.q, state.v)

    def settled(self, state: State) -> tuple[State, float]:
        """Back onto the loops, and the gap that was found."""
        gap = self.chain.gap(state.q)
        if not self.project:
            return state, 0.0
        q, v = self.chain.project(state.q, state.v)
        return State(np.asarray(q), np.asarray(v)), max(gap[0], np.finfo(float).tiny)

    def observe(self, state: State) -> Observation:
        """What to record.  Energies and tool come from the full state, drift and all."""
        data = self._data
        # Pinocchio 4.1 leaves out the rotors (armature) of joints about a slanted axis
        kinetic = float(pin.computeKineticEnergy(self._bare, data, state.q, state.v))
        kinetic += 0.5 * float(self._rotors @ state.v**2)
        potential = self.chain.potential_energy(state.q)
        tool = data.oMi[self._tool_joint] * self._tool_place
        motion = self._tool_place.actInv(data.v[self._tool_joint])
        turned = (quaternion_of(tool.rotation), tool.rotation @ motion.angular) if self._turns else ()
        return Observation(
            *self.measured(state),
            np.array(tool.translation),
            tool.rotation @ motion.linear,
            kinetic,
            potential,
            self.chain.gap(state.q),
            state.q,
            *turned,
        )
