"""How far the tool of a robot gives way that has springs at actuators, in joints and along rods.

All velocities u of the soft robot (`softening`) keep the loops closed, J u = 0, so u = N z.  At rest the springs carry
forces f0, the loops multipliers l, and with the weights and loads P

    P(q) + J(q)' l + f0 = 0,     (N' (K + H) N) dz = N' T' w,     tool: T N dz

for a small further wrench w at the tool, with K the springs and H the derivative of P + J' l along closed motions with
l held: the geometric stiffness of weights, loads and internal forces.  H is found by central differences of sixth order
of forces that are exact, the springs themselves enter as they are; on closed motions this is the exact second
derivative of the potential energy.

Where loops are redundant, springs share the forces: of all l that balance the passive joints that which stores the
least energy (Castigliano 1879, Menabrea 1858), the robot being without stress when nothing pulls.  What gives way
carries f0 in this posture and is at zero there: `at` is the posture under weight and standing loads.
"""

from __future__ import annotations

import numpy as np

from cutjoint import tolerances
from cutjoint.arrays import Array, Sealed
from cutjoint.chain import ClosedChain
from cutjoint.chain.joints import joints_of
from cutjoint.chain.kinematics import Kinematics, Placed
from cutjoint.chain.loads import ChainLoads
from cutjoint.chain.rank import Split
from cutjoint.doors import door
from cutjoint.errors import ActuationError, DynamicsError, InputError
from cutjoint.mechanism import NO_LOADS, Load, Loads, Posture
from cutjoint.mechanism.loads import as_loads
from cutjoint.reprs import line, listed
from cutjoint.stiffness.response import SoftResponse, evened, solved
from cutjoint.stiffness.rounding import trusted
from cutjoint.stiffness.softening import soften
from cutjoint.stiffness.springs import Springs
from cutjoint.stiffness.values import BALANCE, PushedTool, ToolStiffness, ranked

STEP = 0.01
"""Step of the differences, in radians or robot lengths."""
_STENCIL = ((1.0, 45.0 / 60.0), (2.0, -9.0 / 60.0), (3.0, 1.0 / 60.0))
NEAR = 1e-3
"""Step, in radians or robot lengths, at which redundant rows are looked at."""
JAMMED = 1e-4
"""Curvature of redundant rows, dimensionless, above which they are redundant in one posture alone."""
UNHELD = 1e-8
"""Energy of a motion without strain, as part of that of the loads, below which nothing holds it."""


@door
class ElasticRobot(Sealed):
    """A robot whose parts give way.

    Args:
        chain: the robot.
        springs: what gives way, and how hard it is; all else is rigid, actuators that are not named held still.

    Attributes:
        chain, springs: as given.

    Raises:
        InputError: the robot has no tool, nothing gives way, or a spring does nothing.
        UnknownNameError: springs name what the robot does not have.
    """

    __repr__ = line("chain", "springs")

    def __init__(self, chain: ClosedChain, springs: Springs) -> None:
        self.chain, self.springs = chain, springs
        description = chain.description
        if description.tool is None:
            raise InputError(f"{chain.name} has no tool frame; name one under [tool] in its loops.toml")
        if springs.empty:
            raise InputError(
                f"nothing of {chain.name} gives way; state springs, such as Springs(actuators={{'*': 1e5}}) [N/m] or "
                "[N m/rad]"
            )
        soft = soften(description, springs, chain.length)
        self.description, self.gives = soft.description, soft.gives
        self.kinematics = k = Kinematics(soft.description)
        self._loads = ChainLoads(k)
        self._scale = k.column_scale
        index = {name: slice(k.model.idx_vs[i], k.model.idx_vs[i] + k.model.nvs[i]) for i, name in _moving(k)}
        nv = int(k.model.nv)
        self._places = [np.arange(nv)[[index[one].start for one in give.joints]] for give in self.gives]
        self._springs = np.zeros((nv, nv))
        for where, give in zip(self._places, self.gives, strict=True):
            self._springs[np.ix_(where, where)] = give.matrix
        self._springs *= self._scale[:, None] * self._scale
        own = {give.name for give in self.gives if give.kind == "actuator"}
        held = [index[name].start for name in description.actuators if name not in own]
        self.free = np.setdiff1d(np.arange(nv), held)
        """Velocities that are not held by rigid actuators."""
        self._stiff = np.flatnonzero(np.diag(self._springs) > 0.0)
        self._slack = np.setdiff1d(self.free, self._stiff)

    def placed(self, at: Posture | None = None) -> Placed:
        """The soft robot in a posture of the chain (default home), nothing strained."""
        k, chain = self.kinematics, self.chain
        there = (chain.home if at is None else chain.posture(at)).q_full
        q = np.array(k.tree.neutral)
        for i, name in _moving(k):
            if chain.model.existJointName(name):
                old = chain.model.getJointId(name)
                start, count = int(chain.model.idx_qs[old]), int(chain.model.nqs[old])
                q[k.model.idx_qs[i] : k.model.idx_qs[i] + count] = there[start : start + count]
        return k.at(q)

    def at(self, at: Posture | None = None, loads: Loads = NO_LOADS) -> ToolStiffness:
        """Stiffness in a posture (default home), at rest there under its weight and standing `loads`.

        Raises:
            InputError: `at` is no posture of this robot, loads that are none, or springs with which loops jam.
            ActuationError: the tool can move without anything that resists.
            DynamicsError: the robot cannot rest there.
        """
        response = self.response(at, loads)
        placed, basis, scale = response.placed, response.basis, self._scale
        tool = placed.tool_jacobian * scale
        answer = basis @ solved(response.stiffness, basis.T @ tool.T)
        names, kinds = self._parts
        even = 0.5 * (response.stiffness + response.stiffness.T)
        stable = bool((np.linalg.eigvalsh(evened(even)) > 0.0).all()) if even.size else True
        where = self.chain.home if at is None else self.chain.posture(at)
        position = placed.tool_position + self.kinematics.origin
        return ToolStiffness(
            self.chain.name,
            where,
            position,
            tool @ answer,
            names,
            kinds,
            self._each(response, answer),
            stable,
            self.chain.length,
        )

    def deflection(self, further: Loads, at: Posture | None = None, loads: Loads = NO_LOADS) -> Array:
        """Displacement [m] and rotation [rad] of the tool, shape (6,), world axes, by a `further` small load anywhere;
        errors as of `pushed`."""
        return self.pushed(further, at, loads).deflection

    def pushed(self, further: Loads, at: Posture | None = None, loads: Loads = NO_LOADS) -> PushedTool:
        """What `further` small loads anywhere do to the tool, and which parts that is due to.

        Raises:
            InputError, ActuationError, DynamicsError, UnknownNameError: as `at`, or a load on a link that is not there.
        """
        response = self.response(at, loads)
        pull = self._loads.forces(response.placed, further) * self._scale
        answer = response.basis @ solved(response.stiffness, response.basis.T @ pull)
        moved = np.asarray((response.placed.tool_jacobian * self._scale) @ answer)
        return PushedTool(moved, ranked(*self._parts, moved, self._each(response, answer)))

    def response(self, at: Posture | None = None, loads: Loads = NO_LOADS) -> SoftResponse:
        """How the robot answers small forces in a posture; errors as of `at`."""
        k, standing, placed = self.kinematics, as_loads(loads), self.placed(at)
        split = Split.of(trusted(k, placed, placed.scaled[:, self.free]))
        motions = np.zeros((len(self._scale), split.null.shape[1]))
        motions[self.free] = split.null
        strained = Split.of(motions[self._stiff])
        motions = motions @ np.column_stack([strained.right, strained.null])
        self._need_regular(placed, motions)
        multipliers = self._multipliers(placed, standing)
        bending = self._bending(placed, standing, multipliers, motions)
        kept = self._held(placed, standing, motions, bending, strained.rank)
        basis, bending = motions @ kept, bending @ kept
        return SoftResponse(placed, basis, basis.T @ (self._springs @ basis + bending), bending)

    @property
    def _parts(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Names and kinds of what `_each` tells, in its order."""
        names, kinds = (give.name for give in self.gives), (give.kind for give in self.gives)
        return (*names, BALANCE), (*kinds, "balance")

    def _each(self, response: SoftResponse, answer: Array) -> Array:
        """What each part adds to the deflection that comes with motions `answer` (nv, ...), shape (parts, 6, ...)."""
        basis, tool = response.basis, response.placed.tool_jacobian * self._scale
        other = basis @ solved(response.stiffness.T, basis.T @ tool.T)
        parts = [other[w].T @ self._springs[np.ix_(w, w)] @ answer[w] for w in self._places]
        coordinates = np.linalg.lstsq(basis, answer, rcond=None)[0]
        return np.array([*parts, other.T @ response.bending @ coordinates])

    # ---- inside ----------------------------------------------------------------------------------------------------

    def _need_regular(self, placed: Placed, motions: Array) -> None:
        """Rows that depend on others here must do so nearby too: n' J = 0 for n along the motions.

        Raises:
            InputError: they do not, so that the loops would jam as soon as the robot gives way.
        """
        k = self.kinematics
        stresses = Split.of(trusted(k, placed, placed.scaled[:, self.free]).T).null
        if not stresses.size:
            return
        for motion in motions.T:
            sides = [k.at(k.after(placed.q, sign * NEAR * motion)).scaled for sign in (1.0, -1.0)]
            bent = motions.T @ (sides[0] - sides[1]).T @ stresses / (2.0 * NEAR)
            if np.abs(bent).max(initial=0.0) > JAMMED:
                raise InputError(
                    f"with these springs some loops of {self.chain.name} are redundant in this posture alone: they jam "
                    "as soon as it gives way, and what they hold nobody can tell; let more of its joints or rods give "
                    "way, or fewer"
                )

    def _pull(self, placed: Placed, loads: tuple[Load, ...]) -> Array:
        """Weights, springs of the robot's own and loads as what resists a motion, dimensionless in it (nv,) [J]."""
        k = self.kinematics
        force = k.tree.gravity(placed.q)
        if k.physics.acts:
            force = force + placed.springs
        if loads:
            force = force - self._loads.forces(placed, loads)
        return force * self._scale

    def _multipliers(self, placed: Placed, loads: tuple[Load, ...]) -> Array:
        """Forces of the loops [J], shape (rows,), which balance what no spring and no actuator holds.

        Raises:
            DynamicsError: none do.
        """
        k, pull = self.kinematics, self._pull(placed, loads)
        rows = placed.scaled
        split = Split.of(trusted(k, placed, rows[:, self._slack]).T)
        least = split.solve(-pull[self._slack])
        left = np.abs(pull[self._slack] + rows[:, self._slack].T @ least).max(initial=0.0)
        if left > 1e-6 * self._energy(placed, loads):
            free = np.zeros((len(pull), 1))
            free[self._slack, 0] = pull[self._slack] + rows[:, self._slack].T @ least
            names = joints_of(self.kinematics.model, free / left)
            raise DynamicsError(
                f"{self.chain.name} cannot rest here: no actuator, spring or loop holds its weight and loads at "
                f"{listed(names)}; it would move by itself",
                residual=float(left),
            )
        if not (split.null.size and len(self._stiff)):
            return least
        springs = self._springs[np.ix_(self._stiff, self._stiff)]
        root = np.linalg.inv(np.linalg.cholesky(springs))
        force, ways = pull[self._stiff] + rows[:, self._stiff].T @ least, rows[:, self._stiff].T @ split.null
        size = float(np.abs(root).max())
        chosen = np.linalg.lstsq(root @ ways / size, -(root @ force) / size, rcond=1e-12)[0]
        return np.asarray(least + split.null @ chosen)

    def _bending(self, placed: Placed, loads: tuple[Load, ...], multipliers: Array, motions: Array) -> Array:
        """Derivative of weights, loads and the pull of loop forces along motions, shape (nv, d) [J]."""
        k, found = self.kinematics, np.zeros_like(motions)
        weightless = k.tree.mass == 0.0 or not np.linalg.norm(k.model.gravity.linear)
        if weightless and not (loads or k.physics.acts or multipliers.any()):
            return found

        def pull(motion: Array) -> Array:
            there = k.at(k.after(placed.q, motion))
            return self._pull(there, loads) + there.scaled.T @ multipliers

        for column, motion in enumerate(motions.T):
            for many, weight in _STENCIL:
                step = many * STEP
                found[:, column] += weight / STEP * (pull(step * motion) - pull(-step * motion))
        return found

    def _energy(self, placed: Placed, loads: tuple[Load, ...]) -> float:
        """How large the energies of weights and loads are over a robot length or a radian [J]."""
        k = self.kinematics
        weight = k.tree.mass * float(np.linalg.norm(k.model.gravity.linear)) * k.length
        return weight + float(np.abs(self._pull(placed, loads)).max(initial=0.0))

    def _held(self, placed: Placed, loads: tuple[Load, ...], motions: Array, bending: Array, strained: int) -> Array:
        """Combinations of the motions, shape (d, kept), without those that nothing holds and that nobody sees.

        Raises:
            ActuationError: the tool moves along one of those.
        """
        count = motions.shape[1]
        loose = motions[:, strained:]
        if not loose.shape[1]:
            return np.eye(count)
        own = loose.T @ bending[:, strained:]
        values, ways = np.linalg.eigh(0.5 * (own + own.T))
        idle = np.abs(values) <= UNHELD * self._energy(placed, loads)
        tool = placed.tool_jacobian * self._scale
        tool[:3] /= self.kinematics.length
        seen = np.abs(tool @ loose @ ways[:, idle]).max(initial=0.0)
        if seen > tolerances.RANK.value:
            free = joints_of(self.kinematics.model, loose @ ways[:, idle])
            raise ActuationError(
                f"the tool of {self.chain.name} moves although all that is stated holds: nothing resists at "
                f"{listed(free)}; state springs there",
                mobility=self.chain.mobility().mobility,
                actuators=self.chain.n,
                free=free,
            )
        kept = np.zeros((count, strained + int(np.count_nonzero(~idle))))
        kept[:strained, :strained] = np.eye(strained)
        kept[strained:, strained:] = ways[:, ~idle]
        return kept


def _moving(k: Kinematics) -> list[tuple[int, str]]:
    return [(i, str(k.model.names[i])) for i in range(1, k.model.njoints)]


@door
def stiffness(
    chain: ClosedChain, springs: Springs, at: Posture | None = None, loads: Loads = NO_LOADS
) -> ToolStiffness:
    """How far the tool of a robot gives way in a posture (default home).

    Args:
        springs: what gives way, and how hard it is.
        loads: standing loads under which the robot rests there, besides its weight.

    Raises:
        InputError: no tool, nothing gives way, a spring that does nothing, springs with which loops jam, or no posture
            of this robot.
        UnknownNameError: springs name what the robot does not have.
        ActuationError: the tool can move without anything that resists.
        DynamicsError: the robot cannot rest there.
    """
    return ElasticRobot(chain, springs).at(at, loads)
