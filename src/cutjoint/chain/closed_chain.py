"""A closed robot in Pinocchio, as users hold it: a `Mechanism`, and all joints of its tree.

This is the face alone; the parts behind it, each on its own, are told in docs/chain.md.
"""

# long: the public face of a robot, a line or two of code a method
from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
import pinocchio as pin

from cutjoint.arrays import Array, Sealed, as_vector, readonly, sized
from cutjoint.chain.about import chain_table
from cutjoint.chain.actuation import ActuatorEfforts, actuator_efforts, motion_of_tool, velocity_of_actuators
from cutjoint.chain.build import build_model, rough_home
from cutjoint.chain.closing.assembling import assembled
from cutjoint.chain.closing.closing import Closing
from cutjoint.chain.closing.reaching import Reaching
from cutjoint.chain.closing.rounding import check_rounding, lasting, trusted_rows
from cutjoint.chain.closing.ways import Near, Ways
from cutjoint.chain.contacts import constraint_datas, constraint_models
from cutjoint.chain.dynamics import FullDynamics, FullMotion
from cutjoint.chain.geometry import collision_model, visual_model
from cutjoint.chain.joints import limit_violations
from cutjoint.chain.kinematics import Kinematics
from cutjoint.chain.loads import ChainLoads
from cutjoint.chain.mobility import Mobility
from cutjoint.chain.mobility_report import MobilityReport
from cutjoint.chain.modes import MOST_STARTS, Held, Modes, ModeSeeker
from cutjoint.chain.postures import Actuated, Postures
from cutjoint.chain.qpos import MujocoOrder
from cutjoint.chain.reactions import ReactionFinder, Reactions, Stiffness
from cutjoint.chain.reduced import ReducedDynamics
from cutjoint.description.checks.physics import require_possible
from cutjoint.description.model import RobotDescription
from cutjoint.doors import door
from cutjoint.errors import ActuationError, CutjointError
from cutjoint.mechanism import NO_LOADS, ActuatedCoordinates, JointLimits, Loads, Posture, TargetLike, Task, Terms, Tool
from cutjoint.reprs import counted, one_line, quoted, short

if TYPE_CHECKING:
    from cutjoint import CompiledChain, MinimalCoordinates


# long: the public face of a robot, a line or two of code a method
@door
class ClosedChain(Sealed):
    """A robot with loops, built from its description.

    Args:
        description: the open tree, the cuts, the actuators.
        home: name of the home posture; default the first one, or the zero configuration.

    Attributes:
        name: robot and variant.
        n: number of actuated coordinates.
        actuators: the actuated joints in the order of the coordinates.
        home: the closed home posture.
        model: the open tree.
        nq, nv: size of a full configuration, number of velocities of the open tree.
        neutral: the zero configuration of the open tree, shape (nq,); its loops are open as a rule.
        length: characteristic length [m] that scales singular values.
        local_model: the open tree that is computed with: `model`, but for a fixed base far from the world's origin,
            which would cost digits; it stands near its own origin then.
        origin: where in the world the origin of `local_model` is, shape (3,) [m]; zero as a rule.

    Raises:
        UnknownNameError: there is no such home posture.
        DescriptionError: physics or limits of joints and cuts cannot be.
        ClosureError: the loops cannot be closed at home.
    """

    def __init__(self, description: RobotDescription, home: str | None = None) -> None:
        require_possible(description)
        self.description, self._home_name = description, home
        self.model = build_model(description)
        k = Kinematics(description)
        self._actuated = Actuated(self.model, description)
        rough, keep = rough_home(self.model, description, home)
        driver = self._actuated.hold(rough) if keep else None
        trusted = trusted_rows(k, rough, driver)
        k = k if trusted is None else Kinematics(description, trusted)
        at_home = assembled(k, k.tree.normalised(rough), driver)
        self._k, gap = k, _ = lasting(k, at_home)
        at_home = k.at(at_home.q)
        check_rounding(k, at_home, gap)
        self._postures = Postures(k, self._actuated, at_home)
        self._mobility = Mobility(self._postures)
        self._ways = Ways(self._mobility)
        self._closing, self._reaching = Closing(self._mobility, self._ways), Reaching(self._mobility, self._ways)
        self._reduced = ReducedDynamics(self._mobility)
        self._dynamics, self._loads = FullDynamics(k, at_home.q), ChainLoads(k)
        self.name, self.length, self.local_model, self.origin = k.name, k.length, k.model, k.origin
        self.n, self.actuators, self.home = self._actuated.n, self._actuated.joints, self._postures.home
        self.nq, self.nv, self.neutral = int(self.model.nq), int(self.model.nv), k.tree.neutral

    def __reduce__(self) -> tuple[Callable[..., ClosedChain], tuple[RobotDescription, str | None]]:
        """Built anew from its description, in another process too."""
        return type(self), (self.description, self._home_name)

    def __repr__(self) -> str:
        parts = [f"actuators={short([f'{one.name} [{one.unit}]' for one in self.actuators])}"]
        parts += [counted(len(self.description.cuts), "cut"), f"{self.nv} velocities"]
        return one_line("ClosedChain", [quoted(self.name), *parts])

    def _repr_html_(self) -> str:
        return chain_table(self.description, self.actuators, self._task_in_words)._repr_html_()

    def _task_in_words(self) -> str:
        try:
            return str(self.task)
        except CutjointError as error:
            return f"none: {error}"

    # ---- closing ---------------------------------------------------------------------------------------------------

    def close(self, q: ActuatedCoordinates, near: Near = None, *, limits: JointLimits = "respect") -> Posture:
        """The closed posture with actuated coordinates `q`, shape (n,) [m] or [rad], on the branch of `near`.

        `near` is a posture, such as one of `assembly_modes()`, or the name of a home of the description.

        The robot is walked there along a path without singular postures, which keeps it on its branch.

        Raises:
            InputError: wrong shape or not finite.
            ClosureError: on this branch the loops cannot be kept closed all the way.
            LimitError: a joint would go beyond its limits, and they are not to be ignored.
            SingularError: the way leads through a type-2 singularity, where branches meet.
        """
        return self._closing.close(q, near, limits)

    def reach(
        self, target: TargetLike, near: Near = None, *, free: bool = False, limits: JointLimits = "respect"
    ) -> Posture:
        """The closed posture with the tool at a target, on the branch of `near` (see `close`).

        The forms of a target are told in `Mechanism.reach`.

        The tool is walked there along a line (or two) inside the workspace, turning about one axis, which keeps the
        robot on its branch.  Where it can only move on a curve or a surface, it is walked along that.

        Raises:
            InputError: no target, not finite, it does not fix the task, or the robot has no tool.
            UnreachableError: the tool cannot come there on this branch, or cannot have that pose.
            LimitError: a joint would go beyond its limits, and they are not to be ignored.
            SingularError: the way leads through a type-1 singularity, where branches meet.
        """
        return self._reaching.reach(target, near, free, limits)

    def goes_beyond(self, start: Array, q_full: Array) -> bool:
        """Whether a joint is beyond its limits at the configuration `q_full`, and further than it was at `start`, shape
        (nq,) both."""
        return self._ways.limits.exceeded(sized("start", start, self.nq), sized("q_full", q_full, self.nq))

    @property
    def task(self) -> Task:
        """Which motions of the tool are led, as the description says or as they are at home.

        Raises:
            InputError: no tool, or the task cannot be told (the message says how to choose), or cannot be done.
        """
        return self._reaching.task

    @door
    def posture(self, at: Posture | npt.ArrayLike) -> Posture:
        """A configuration that is closed already, shape (nq,) or another robot's posture, as a posture of this one.

        Raises:
            InputError: wrong shape or not finite.
            ClosureError: it is open by more than the closure tolerance.
        """
        return self._closing.posture(at.q_full if isinstance(at, Posture) else at)

    @door
    def assemble(self, at: Posture | npt.ArrayLike, keep_actuators: bool = True) -> Posture:
        """A closed posture from any configuration, shape (nq,) or another robot's posture, loops open or not.

        With `keep_actuators` the actuated coordinates stay as given; otherwise they may move too.

        Raises:
            InputError: wrong shape or not finite.
            ClosureError: no closed posture was found from there.
        """
        return self._closing.assemble(at.q_full if isinstance(at, Posture) else at, keep_actuators)

    def project(self, q_full: Array, v_full: Array) -> tuple[Array, Array]:
        """Nearby closed configuration and velocity: removes the drift of an integrator, hence arrays.

        The actuated coordinates stay where they determine the motion; otherwise the correction is the least one.

        Raises:
            ClosureError: too far from closed for Newton's method.
            SingularError: type-2 singularity.
        """
        return self._closing.project(sized("q_full", q_full, self.nq), sized("v_full", v_full, self.nv))

    @door
    def working_modes(self, at: Posture | None = None, hold: Held | None = None, starts: int = MOST_STARTS) -> Modes:
        """Solutions of inverse kinematics: closed postures that hold the tool as `at` (default home) does, `at` first.

        Args:
            hold: "point", "pose" or "task" of the tool; default the task where the description declares one, else the
                point where it says where the tool is, else the pose.
            starts: at most as many starts; fewer where everything was found several times.

        Raises:
            InputError: no tool or no cuts, `hold` is none of them, or `starts` is not a whole number above 0.
            ActuationError: holding the tool leaves the robot movable, so the modes are not discrete.
        """
        task = self.task if hold == "task" or (hold is None and self.description.task) else None
        return ModeSeeker(self._postures).working_modes(self._postures.placed(at), hold, starts, task)

    @door
    def assembly_modes(self, at: Posture | None = None, limbs: bool = False, starts: int = MOST_STARTS) -> Modes:
        """Solutions of forward kinematics: closed postures with the actuated coordinates of `at` (default home), `at`
        first.

        Args:
            limbs: tell apart also postures that differ in limbs alone, the tool in one pose.  Otherwise each pose of
                the tool comes once, with the limbs as near to those of `at` as may be.
            starts: at most as many starts; fewer where everything was found several times.

        Raises:
            InputError: `starts` is not a whole number above 0.
            ActuationError: with its actuators held the robot can still move, so the modes are not discrete.
        """
        return ModeSeeker(self._postures).assembly_modes(self._postures.placed(at), limbs, starts)

    # ---- mobility --------------------------------------------------------------------------------------------------

    @door
    def mobility(self, at: Posture | None = None) -> MobilityReport:
        """Mobility, redundancy and distance to singularities at a posture (default home)."""
        return self._mobility.report(self._postures.placed(at), self._reaching.known_task)

    @cached_property
    def idle_is_cyclic(self) -> bool:
        """Whether neither masses nor weights notice the idle motions, as for a rod that is round.

        Idle motions that start without momentum then stay without, and the actuated coordinates tell the whole motion;
        else only full coordinates do.  True for a robot without idle motions.

        Raises:
            ActuationError: the actuators do not determine the motion.
        """
        return self._mobility.idle_is_cyclic

    @door
    def limit_violations(self, at: Posture) -> Mapping[str, tuple[float, float, float]]:
        """Joints beyond their limits: name -> (value, lower, upper), [m] or [rad]."""
        return limit_violations(self.model, sized("q_full of the posture", at.q_full, self.nq))

    # ---- in actuated coordinates (Mechanism) -----------------------------------------------------------------------

    def tangent(self, at: Posture) -> Array:
        """T with v_full = T @ v, shape (nv, n).

        Raises:
            ActuationError: the actuators do not determine the motion.
            SingularError: type-2 singularity.
        """
        return self._reduced.at(at).map

    def full_velocity(self, at: Posture, v: npt.ArrayLike) -> Array:
        """Velocity of all joints, shape (nv,)."""
        return self._reduced.velocity(at, v)

    def drift(self, at: Posture, v: npt.ArrayLike) -> Array:
        """d with a_full = T @ a + d, shape (nv,): what the passive joints accelerate at constant actuator speed."""
        return self._reduced.drift(at, v)

    def tool(self, at: Posture, v: npt.ArrayLike | None = None) -> Tool:
        """Pose, frame Jacobian (6, n), its drift and twist of the tool in world axes.

        Raises:
            InputError: the robot has no tool, or `at` is another robot's posture.
            ActuationError, SingularError: as `tangent`.
        """
        return self._reduced.tool(at, v)

    def terms(self, at: Posture, v: npt.ArrayLike | None = None) -> Terms:
        """Mass matrix (n, n), Coriolis vector, gravity, springs and friction (n,) in actuated coordinates.

        Raises:
            ActuationError, SingularError: as `tangent`.
        """
        return self._reduced.terms(at, v)

    def potential_energy(self, at: Posture | npt.ArrayLike) -> float:
        """Potential energy of gravity, zero at the world origin, less what is compensated, and of springs, bushings and
        stops [J], also with the loops open."""
        return self._k.potential_energy(self._configuration(at))

    @property
    def sticking(self) -> Mapping[int, float]:
        """Velocities of the tree whose friction holds what rests, and by how much: index -> [N] or [N m]."""
        return self._k.physics.sticking

    @property
    def dissipates(self) -> bool:
        """Whether joints or cuts have dampers, friction, springs, stops or bushings, which may take work."""
        return self._k.physics.acts

    def dissipation(self, at: Posture, v: npt.ArrayLike) -> float:
        """Power that dampers and friction take at a velocity of the actuators [W], at least 0.

        Raises:
            InputError, ActuationError, SingularError: as `tangent`.
        """
        v_full = self._reduced.velocity(at, v)
        return self.full_dissipation(at, v_full) if self._k.physics.acts else 0.0

    @door
    def full_dissipation(self, at: Posture | npt.ArrayLike, v_full: Array) -> float:
        """The same at a velocity of all joints, shape (nv,), also with the loops open [W]."""
        return self._k.dissipation(self._configuration(at), sized("v_full", v_full, self.nv))

    def spring_energy(self, at: Posture | npt.ArrayLike) -> float:
        """What of it is in springs, bushings and stops [J], also with the loops open."""
        return self._k.spring_energy(self._configuration(at))

    def load_effort(self, at: Posture, loads: Loads) -> Array:
        """Effort that does what `loads` do, shape (n,): T' J' wrench.

        Raises:
            InputError: they are no loads, or one acts at a tool that the robot does not have.
            UnknownNameError: there is no such link.
            ActuationError, SingularError: as `tangent`.
        """
        here = self._reduced.at(at)
        return here.transposed @ self._loads.forces(here.placed, loads)

    def pushes_idle(self, at: Posture, loads: Loads) -> bool:
        """Whether loads push an idle motion, which the actuated coordinates do not tell; errors as `load_effort`."""
        here = self._reduced.at(at)
        return here.pushes_idle(self._loads.forces(here.placed, loads))

    def inverse_dynamics(self, at: Posture, v: npt.ArrayLike, a: npt.ArrayLike, loads: Loads = NO_LOADS) -> Array:
        """Effort that gives the acceleration `a` against `loads`, shape (n,): T' (rnea(q, T v, T a + d) - J' wrench).

        Raises:
            InputError, ActuationError, SingularError, UnknownNameError: as `load_effort`.
        """
        effort = self._reduced.inverse(at, v, a)
        return effort if loads is NO_LOADS else effort - self.load_effort(at, loads)

    def forward_dynamics(self, at: Posture, v: npt.ArrayLike, effort: npt.ArrayLike, loads: Loads = NO_LOADS) -> Array:
        """Acceleration that `effort` and `loads` give, shape (n,): (T' M T)^-1 (effort - T' (rnea(q, T v, d) - J' w)).

        Raises:
            InputError, ActuationError, SingularError, UnknownNameError: as `load_effort`.
        """
        if loads is not NO_LOADS:
            effort = as_vector("effort", effort, self.n) + self.load_effort(at, loads)
        return self._reduced.forward(at, v, effort)

    @door
    def with_payload(self, mass: float) -> ClosedChain:
        """The same robot with a further point mass [kg] at the tool point.

        Raises:
            InputError: no tool, or not a mass.
        """
        return self.rebuilt(self.description.with_payload(mass))

    def rebuilt(self, description: RobotDescription) -> ClosedChain:
        """A chain of another description of this robot, with the same home; errors as of a new one."""
        return ClosedChain(description, self._home_name)

    def compile(self) -> CompiledChain:
        """This robot as straight-line machine code; `cutjoint.compiled` has the options.

        Raises:
            CompileError: the extra `compile` is not installed, or the robot cannot be compiled.
        """
        from cutjoint import CompiledChain, compiled

        robot = compiled(self)
        assert isinstance(robot, CompiledChain)
        return robot

    @door
    def minimal(self, joints: str | Sequence[str] = ()) -> MinimalCoordinates:
        """This robot in as many velocities as it has freedoms, also where its actuators do not determine its motion.

        They are those of the actuators where these determine it.  Otherwise those of what flies from the base, of the
        actuators as far as they are independent, and of the passive `joints` that are named.

        Raises:
            UnknownNameError: there is no such joint that moves.
            InputError: a joint is named twice, or counts among the coordinates anyway.
            ActuationError: a joint depends on the other coordinates, or some motion stays free; it names what serves.
        """
        from cutjoint import MinimalCoordinates

        return MinimalCoordinates(self, self._mobility, (joints,) if isinstance(joints, str) else joints)

    # ---- in full coordinates ---------------------------------------------------------------------------------------

    def full_load_effort(self, at: Posture | npt.ArrayLike, loads: Loads) -> Array:
        """Generalised forces of all joints that do what `loads` do: J' wrench, shape (nv,), [N] and [N m].

        Raises:
            InputError: they are no loads, or one acts at a tool that the robot does not have.
            UnknownNameError: there is no such link.
        """
        placed = self._postures.placed(at) if isinstance(at, Posture) else self._k.at(self._configuration(at))
        return self._loads.forces(placed, loads)

    def full_forward_dynamics(
        self, at: Posture, v_full: npt.ArrayLike, effort_full: npt.ArrayLike, loads: Loads = NO_LOADS
    ) -> FullMotion:
        """Acceleration of all joints and loop forces; velocity and effort are those of all joints, shape (nv,).

        Raises:
            InputError: `at` is no posture of this robot, wrong shape or not finite; or as `full_load_effort`.
            UnknownNameError: there is no such link.
            DynamicsError: the solution does not respect the cuts.
        """
        v, effort = self._motion("v_full", v_full), self._motion("effort_full", effort_full)
        if loads is not NO_LOADS:
            effort = effort + self.full_load_effort(at, loads)
        return self._dynamics.motion(self._postures.placed(at).q, v, effort)

    def full_acceleration(self, q_full: Array, v_full: Array, effort_full: Array) -> Array:
        """As `full_forward_dynamics`, the acceleration alone, shape (nv,), for the inner loops of integrators: arrays
        of which only the size is checked, the loops as open as they have drifted."""
        q, v = sized("q_full", q_full, self.nq), sized("v_full", v_full, self.nv)
        return self._dynamics.acceleration(q, v, sized("effort_full", effort_full, self.nv))

    def full_inverse_dynamics(
        self, at: Posture, v_full: npt.ArrayLike, a_full: npt.ArrayLike, loads: Loads = NO_LOADS
    ) -> ActuatorEfforts:
        """Least actuator efforts for a motion of all joints that the loops allow, and the space of internal preload.

        For any number of actuators; `full_motion` makes such a motion from that of the tool.

        Raises:
            InputError: `at` is no posture of this robot, wrong shape or not finite; or as `full_load_effort`.
            UnknownNameError: there is no such link.
            ActuationError: the actuators cannot produce the motion; it names the joints that would need a motor.
        """
        v, a = self._motion("v_full", v_full), self._motion("a_full", a_full)
        push = self.full_load_effort(at, loads)
        return actuator_efforts(self._k, self._actuated.v_index, self._postures.placed(at).q, v, a, push)

    def full_motion(self, at: Posture, velocity: npt.ArrayLike, acceleration: npt.ArrayLike) -> tuple[Array, Array]:
        """Least motion of all joints, v and a (nv,) each, with which the tool point moves as asked, (3,) each.

        Raises:
            InputError: the robot has no tool, or the tool cannot move like that here.
        """
        self._k.need_tool()
        wanted = as_vector("velocity", velocity, 3, "m/s"), as_vector("acceleration", acceleration, 3, "m/s2")
        return motion_of_tool(self._k, self._postures.placed(at), *wanted)

    def led_velocity(self, at: Posture, v: npt.ArrayLike) -> Array:
        """Velocity of all joints, shape (nv,), as `full_velocity`, also with more actuators than freedoms.

        Raises:
            InputError: the loops do not let the actuators move so.
            ActuationError: something moves while the actuators rest.
        """
        try:
            return self.full_velocity(at, v)
        except ActuationError:
            wanted = as_vector("v", v, self.n)
            return velocity_of_actuators(self._k, self._actuated.v_index, self._postures.placed(at), wanted)

    def full_effort(self, effort: npt.ArrayLike) -> Array:
        """Actuator efforts (n,) as generalised forces of all joints, shape (nv,)."""
        full = np.zeros(self.nv)
        full[self._actuated.v_index] = as_vector("effort", effort, self.n)
        return full

    # ---- reactions -------------------------------------------------------------------------------------------------

    @door
    def reactions(
        self,
        at: Posture,
        v: npt.ArrayLike | None = None,
        a: npt.ArrayLike | None = None,
        effort: npt.ArrayLike | None = None,
        loads: Loads = NO_LOADS,
        stiffness: Stiffness | None = None,
    ) -> Reactions:
        """Force and moment in every joint, cut and coupling; motion and effort of the actuators, shape (n,), at rest
        where no `v` is given.

        Of acceleration and effort one is enough, the other follows: with neither, the actuators do not accelerate.
        Where loops are redundant the least reactions are taken, or those by stated stiffnesses (`Stiffness`).

        Raises:
            InputError, ActuationError, SingularError, UnknownNameError: as `inverse_dynamics`, or wrong stiffnesses.
            DynamicsError: the effort does not make the acceleration.
        """
        still = np.zeros(self.n)
        v = still if v is None else as_vector("v", v, self.n)
        if effort is not None and a is None:
            a = self.forward_dynamics(at, v, effort, loads)
        a = still if a is None else as_vector("a", a, self.n)
        effort = self.inverse_dynamics(at, v, a, loads) if effort is None else effort
        a_full = self.tangent(at) @ a + self.drift(at, v)
        return self._reactions(at, self.full_velocity(at, v), a_full, self.full_effort(effort), loads, stiffness)

    def full_reactions(
        self,
        at: Posture,
        v_full: npt.ArrayLike | None = None,
        a_full: npt.ArrayLike | None = None,
        effort_full: npt.ArrayLike | None = None,
        loads: Loads = NO_LOADS,
        stiffness: Stiffness | None = None,
    ) -> Reactions:
        """The same from motion and effort of all joints, shape (nv,), for any number of actuators.  The effort that
        makes an acceleration is the least one of the actuators.

        Raises:
            InputError, DynamicsError, ActuationError, UnknownNameError: as `full_forward_dynamics` and
                `full_inverse_dynamics`, wrong stiffnesses, or the effort does not make the acceleration.
        """
        v = np.zeros(self.nv) if v_full is None else self._motion("v_full", v_full)
        if effort_full is not None and a_full is None:
            a_full = self.full_forward_dynamics(at, v, effort_full, loads).acceleration
        a = np.zeros(self.nv) if a_full is None else self._motion("a_full", a_full)
        if effort_full is None:
            effort_full = self.full_effort(self.full_inverse_dynamics(at, v, a, loads).effort)
        return self._reactions(at, v, a, self._motion("effort_full", effort_full), loads, stiffness)

    def _reactions(
        self, at: Posture, v: Array, a: Array, effort: Array, loads: Loads, stiffness: Stiffness | None
    ) -> Reactions:
        placed = self._k.moving(self._postures.placed(at).q, v)
        return self._finder.find(placed, a, effort, loads, stiffness or {})

    @cached_property
    def _finder(self) -> ReactionFinder:
        return ReactionFinder(self._k)

    def actuated(self, q_full: Array) -> Array:
        """Actuated coordinates of a full configuration, shape (n,); a posture has them as `q`."""
        return self._actuated.of(sized("q_full", q_full, self.nq))

    def actuated_velocity(self, v_full: Array) -> Array:
        """Actuated part of a full velocity or acceleration, shape (n,)."""
        columns = isinstance(v_full, np.ndarray) and v_full.ndim == 2 and len(v_full) == self.nv
        return np.asarray((v_full if columns else sized("v_full", v_full, self.nv))[self._actuated.v_index])

    def integrate(self, q_full: Array, motion: Array) -> Array:
        """Configuration after the tangent motion (nv,), on the manifold, shape (nq,)."""
        return self._k.tree.integrate(sized("q_full", q_full, self.nq), sized("motion", motion, self.nv))

    def from_mujoco(self, qpos: npt.ArrayLike) -> Array:
        """The configuration (nq,), loops open or not, of a `qpos` of MuJoCo for the MJCF that this robot was read from
        (or written to): `robot.assemble(robot.from_mujoco(data.qpos))` closes it.

        Quaternions of any length are taken, as MuJoCo takes them.  Lengths of tendons that are joints here are no part
        of a qpos.

        Raises:
            InputError: wrong shape, not finite, or a quaternion of zeros.
        """
        return self._mujoco.configuration(qpos)

    def to_mujoco(self, at: Posture | npt.ArrayLike) -> Array:
        """The `qpos` of a posture or of any configuration (nq,), for MuJoCo (see `from_mujoco`)."""
        return self._mujoco.qpos(self._configuration(at))

    @cached_property
    def _mujoco(self) -> MujocoOrder:
        return MujocoOrder(self.model, self.description)

    # ---- for programs that work with Pinocchio (docs/neighbours.md); all fresh, and the caller's own -----------------

    def constraint_models(self) -> pin.StdVec_RigidConstraintModel:
        """The cuts as Pinocchio's constraint models for `model`, which `pin.constraintDynamics` and others take.

        Fixed cuts are contacts of 6 rows, spherical ones of 3, revolute ones two of 3 that share their name, `length`
        apart on the axis.  Their Baumgarte gains are 0.  Redundant rows stay in.

        Raises:
            InputError: a cut or coupling is none in Pinocchio; it names them.
        """
        return constraint_models(self.model, self.description, self.length)

    def constraint_datas(self, models: Iterable[pin.RigidConstraintModel]) -> pin.StdVec_RigidConstraintData:
        """Workspaces of constraint models, in their order.

        Raises:
            InputError: something else is among them.
        """
        return constraint_datas(models)

    def visual_model(self) -> pin.GeometryModel:
        """The visual shapes of all links on the joints of `model`, such as a visualizer of Pinocchio takes.

        Raises:
            InputError: a mesh cannot be read.
            MissingPackageError: there are meshes, and trimesh is not installed.
        """
        return visual_model(self.model, self.description)

    def collision_model(self) -> pin.GeometryModel:
        """The collision shapes of all links, with the pairs of bodies that no joint and no cut joins.

        Raises:
            InputError, MissingPackageError: as `visual_model`.
        """
        return collision_model(self.model, self.description)

    @property
    def actuation(self) -> Array:
        """B with effort_full = B @ effort, shape (nv, n): a column of one 1 for every actuator."""
        return readonly(np.eye(self.nv)[:, self._actuated.v_index])

    # Of the open tree: a posture, or any configuration (nq,) with the loops open.

    def gap(self, at: Posture | npt.ArrayLike) -> tuple[float, float]:
        """Worst loop gap, ([m], [rad])."""
        return self._k.at(self._configuration(at)).gap[:2]

    def constraint_residual(self, at: Posture | npt.ArrayLike) -> Array:
        """By how much every constraint row is open, shape (rows,), [m] and [rad] (the sine of the angle for a universal
        cut)."""
        return readonly(self._k.at(self._configuration(at)).residual)

    def constraint_jacobian(self, at: Posture | npt.ArrayLike) -> Array:
        """Derivative of all constraint rows, unscaled, shape (rows, nv)."""
        return self._k.at(self._configuration(at)).jacobian

    def link_placements(self, at: Posture | npt.ArrayLike) -> dict[str, Array]:
        """World placement (4, 4) of every link."""
        return self._k.world.links(self._configuration(at))

    def cut_placements(self, at: Posture | npt.ArrayLike) -> list[tuple[str, Array, Array]]:
        """Name and world placements (4, 4) of both frames of every cut."""
        return self._k.world.cuts(self._configuration(at))

    def centre_of_mass(self, at: Posture | npt.ArrayLike) -> Array:
        """Centre of mass of all moving links, shape (3,) [m].

        Raises:
            InputError: none of them has mass.
        """
        return self._k.centre_of_mass(self._configuration(at))

    # ---- inside ----------------------------------------------------------------------------------------------------

    def _configuration(self, at: Posture | npt.ArrayLike) -> Array:
        """That of a posture of this robot, or the one that is given, shape (nq,)."""
        return self._postures.placed(at).q if isinstance(at, Posture) else as_vector("q_full", at, self.nq)

    def _motion(self, name: str, values: npt.ArrayLike) -> Array:
        return as_vector(name, values, self.nv)
