"""A closed robot in full coordinates: all joints of the tree, for any actuation.

Closing from any configuration, mobility, constrained forward dynamics with loop forces, working modes, placements.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property

import numpy as np
import numpy.typing as npt
import pinocchio as pin

from cutjoint import tolerances
from cutjoint.arrays import Array, as_vector, readonly
from cutjoint.chain.actuation import ActuatorEfforts, actuator_efforts, motion_of_tool
from cutjoint.chain.build import build_model, rough_home
from cutjoint.chain.closing.continuation import ActuatedDriver, Assembler, System
from cutjoint.chain.closing.rounding import check_rounding, trusted_rows
from cutjoint.chain.closing.short_steps import Nearby
from cutjoint.chain.dynamics import FullDynamics, FullMotion
from cutjoint.chain.idle import is_cyclic
from cutjoint.chain.kinematics import Kinematics, Placed
from cutjoint.chain.mobility import MobilityReport, mobility_report
from cutjoint.chain.modes import MOST_STARTS, Held, Modes, Robot, assembly_modes, working_modes
from cutjoint.chain.rank import null_space
from cutjoint.chain.structure import AROUND, SHIFT, Structure, is_steady
from cutjoint.chain.tangent import TangentMap, tangent_map
from cutjoint.description.model import JointType, RobotDescription
from cutjoint.errors import ActuationError, ClosureError, InputError, SingularError
from cutjoint.mechanism import Actuator, Posture


class FullChain:
    """A robot with loops in the coordinates of its open tree; `ClosedChain` adds the actuated ones.

    Args:
        description: the open tree, the cuts, the actuators.
        home: name of the home posture; default the first one, or the zero configuration.

    Raises:
        UnknownNameError: there is no such home posture.
        ClosureError: the loops cannot be closed at home.
    """

    def __init__(self, description: RobotDescription, home: str | None = None) -> None:
        self.description = description
        self.model = build_model(description)
        self._k = Kinematics(description)
        ids = [self.model.getJointId(name) for name in description.actuators]
        self._q_index = np.array([self.model.idx_qs[i] for i in ids], dtype=int)
        self._v_index = np.array([self.model.idx_vs[i] for i in ids], dtype=int)
        self._passive = np.setdiff1d(np.arange(self.model.nv), self._v_index)
        self._selection = np.eye(self.model.nv)[self._v_index]
        rough, keep = rough_home(self.model, description, home)
        trusted = trusted_rows(self._k, rough, self._hold(rough) if keep else None)
        if trusted is not None:
            self._k = Kinematics(description, trusted)
        self._assembler = Assembler(self._k)
        self._home_name = home
        self._known: tuple[Posture, Placed]
        self._home = self.assemble(rough, keep_actuators=keep)
        self._at_home: Placed = self._known[1]
        self._dynamics = FullDynamics(self._k, np.array(self._home.q_full))
        check_rounding(self.name, self._k, self._home.q_full)

    # ---- names and sizes -------------------------------------------------------------------------------------------

    @property
    def name(self) -> str:
        """Robot and variant."""
        variant = self.description.variant_name
        return f"{self.description.name} ({variant})" if variant else self.description.name

    @property
    def n(self) -> int:
        """Number of actuated coordinates."""
        return len(self._v_index)

    @cached_property
    def actuators(self) -> tuple[Actuator, ...]:
        """The actuated joints in the order of the coordinates."""
        types = {joint.name: joint.type for joint in self.description.joints}
        return tuple(
            Actuator(name, "translation" if types[name] is JointType.PRISMATIC else "rotation")
            for name in self.description.actuators
        )

    @property
    def home(self) -> Posture:
        """The closed home posture."""
        return self._home

    @property
    def length(self) -> float:
        """Characteristic length [m] that scales singular values."""
        return self._k.length

    @property
    def local_model(self) -> pin.Model:
        """The open tree that is computed with: `model`, but for a fixed base far from the world's origin, which would
        cost digits; it stands near its own origin then, which is `origin` in the world."""
        return self._k.model

    @property
    def origin(self) -> Array:
        """Where in the world the origin of `local_model` is, shape (3,) [m]; zero as a rule."""
        return self._k.origin

    @property
    def nq(self) -> int:
        """Size of a full configuration."""
        return int(self.model.nq)

    @property
    def neutral(self) -> Array:
        """The zero configuration of the open tree, shape (nq,); its loops are open as a rule."""
        return readonly(pin.neutral(self.model))

    @property
    def nv(self) -> int:
        """Number of velocities of the open tree."""
        return int(self.model.nv)

    # ---- closing ---------------------------------------------------------------------------------------------------

    def posture(self, q_full: npt.ArrayLike) -> Posture:
        """A configuration that is closed already, as a posture.

        Raises:
            ClosureError: it is open by more than the closure tolerance.
        """
        q = readonly(as_vector("q_full", q_full, self.nq))
        placed = self._k.at(q)
        if System(self._k, None).at(placed).openness > 1.0:
            distance, angle, cut = placed.gap
            raise ClosureError(
                f"{self.name}: cut '{cut}' is open by {distance:.3g} m, {angle:.3g} rad; use close(), reach() or "
                "assemble()",
                gap=(distance, angle),
                cut=cut,
            )
        return self._posture(placed)

    def assemble(self, q_full: npt.ArrayLike, keep_actuators: bool = True) -> Posture:
        """A closed posture from any configuration `q_full`, shape (nq,), loops open or not.

        With `keep_actuators` the actuated coordinates stay as given; otherwise they may move too.

        Raises:
            InputError: wrong shape or not finite.
            ClosureError: no closed posture was found from there.
        """
        start = self._normalised(as_vector("q_full", q_full, self.nq))
        driver = self._hold(start) if keep_actuators else None
        found = self._assembler.assemble(start, driver)
        if found is None:
            found = self._assembler.assemble_around(start, driver)
        if found is None:
            rest, _ = self._assembler.nearest(start, driver)
            distance, angle, cut = self._k.at(rest).gap
            raise ClosureError(
                f"{self.name}: no closed posture found from this configuration or around it; it comes to rest with "
                f"gaps of up to {distance:.3g} m and {angle:.3g} rad, the worst at cut '{cut}'. Give a start nearer "
                "to a closed posture, or mend the frames of that cut",
                gap=(distance, angle),
                cut=cut,
            )
        return self._posture(self._k.at(found))

    def project(self, q_full: Array, v_full: Array) -> tuple[Array, Array]:
        """Nearby closed configuration and velocity: removes the drift of an integrator.

        The actuated coordinates stay where they determine the motion; otherwise the correction is the least one.

        Raises:
            ClosureError: too far from closed for Newton's method.
            SingularError: type-2 singularity.
        """
        determined = self._is_determined
        driver = self._hold(q_full) if determined else None
        placed = (
            self._nearby.follow(self._k.at(q_full), driver) if self._nearby is not None and driver is not None else None
        )
        if placed is None:
            found = self._assembler.settle(q_full, driver)
            if found is None:
                distance, angle, cut = self._k.at(q_full).gap
                raise ClosureError(
                    f"{self.name} cannot be projected onto its loops: cut '{cut}' is open by {distance:.3g} m, "
                    f"{angle:.3g} rad",
                    gap=(distance, angle),
                    cut=cut,
                )
            placed = self._k.at(found)
        scale = self._k.column_scale
        if not determined:
            free = null_space(placed.scaled)
            return placed.q, scale * (free @ (free.T @ (v_full / scale)))
        quick = self._nearby.tangent(placed) if self._nearby is not None else None
        if quick is not None:
            return placed.q, quick.map @ v_full[self._v_index]
        tangent = self._map(placed)
        driven = tangent.map @ v_full[self._v_index]
        momentum = tangent.idle.T @ (self._k.mass(placed.q) @ (v_full - driven)) if tangent.idle.size else np.zeros(0)
        return placed.q, driven + tangent.idle @ momentum

    def working_modes(self, at: Posture | None = None, hold: Held | None = None, starts: int = MOST_STARTS) -> Modes:
        """Solutions of inverse kinematics: closed postures that hold the tool as `at` (default home) does, `at` first.

        Args:
            hold: "point" or "pose" of the tool; default the point where it says where the tool is, else the pose.
            starts: at most as many starts; fewer where everything was found several times.

        Raises:
            InputError: the robot has no tool or no cuts, `hold` is neither, or `starts` not a whole number above 0.
            ActuationError: holding the tool leaves the robot movable, so the modes are not discrete.
        """
        self._need_tool()
        if not self._k.closure.rows:
            raise InputError(f"{self.name} has no cut joints; working modes are those of closed robots")
        return working_modes(self._searched, self._placed(at), self._at_home, hold, starts)

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
        placed = self._placed(at)
        return assembly_modes(self._searched, self._hold(placed.q), placed.q, limbs, starts)

    # ---- mobility --------------------------------------------------------------------------------------------------

    def mobility(self, at: Posture | None = None) -> MobilityReport:
        """Mobility, redundancy and distance to singularities at a posture (default home)."""
        return mobility_report(self._k, self._v_index, self._structure, self._placed(at))

    @cached_property
    def idle_is_cyclic(self) -> bool:
        """Whether neither masses nor weights notice the idle motions, as for a rod that is round.

        Idle motions that start without momentum then stay without, and the actuated coordinates tell the whole motion;
        else only full coordinates do.  True for a robot without idle motions.

        Raises:
            ActuationError: the actuators do not determine the motion.
        """
        if not self._structure.idle:
            return True
        return is_cyclic(self._k, self._regular, self._map, lambda q: self._assembler.settle(q, self._hold(q), 1.0))

    def limit_violations(self, at: Posture) -> Mapping[str, tuple[float, float, float]]:
        """Joints beyond their limits: name -> (value, lower, upper), [m] or [rad]."""
        q, model = at.q_full, self.model
        found: dict[str, tuple[float, float, float]] = {}
        for joint in range(1, model.njoints):
            if model.nqs[joint] == 1:
                i = model.idx_qs[joint]
                lower, upper = float(model.lowerPositionLimit[i]), float(model.upperPositionLimit[i])
                if not lower <= q[i] <= upper:
                    found[model.names[joint]] = (float(q[i]), lower, upper)
        return found

    # ---- in full coordinates ---------------------------------------------------------------------------------------

    def full_forward_dynamics(self, q_full: Array, v_full: Array, effort_full: Array) -> FullMotion:
        """Acceleration of all joints and loop forces at a closed configuration; all arguments in full coordinates.

        Raises:
            DynamicsError: the solution does not respect the cuts.
        """
        v, effort = as_vector("v_full", v_full, self.nv), as_vector("effort_full", effort_full, self.nv)
        return self._dynamics.motion(self._whole(q_full), v, effort)

    def full_acceleration(self, q_full: Array, v_full: Array, effort_full: Array) -> Array:
        """As `full_forward_dynamics`, the acceleration alone, for inner loops, shape (nv,); the arguments are not
        checked."""
        return self._dynamics.acceleration(q_full, v_full, effort_full)

    def full_inverse_dynamics(self, q_full: Array, v_full: Array, a_full: Array) -> ActuatorEfforts:
        """Least actuator efforts for a motion of all joints that the loops allow, and the space of internal preload.

        For any number of actuators; `full_motion` makes such a motion from that of the tool.

        Raises:
            ActuationError: the actuators cannot produce the motion; it names the joints that would need a motor.
        """
        q, v, a = self._whole(q_full), as_vector("v_full", v_full, self.nv), as_vector("a_full", a_full, self.nv)
        return actuator_efforts(self.name, self._k, self._v_index, q, v, a)

    def full_motion(self, at: Posture, velocity: npt.ArrayLike, acceleration: npt.ArrayLike) -> tuple[Array, Array]:
        """Least motion of all joints, v and a (nv,) each, with which the tool point moves as asked, (3,) each.

        Raises:
            InputError: the robot has no tool, or the tool cannot move like that here.
        """
        self._need_tool()
        wanted = as_vector("velocity", velocity, 3, "m/s"), as_vector("acceleration", acceleration, 3, "m/s2")
        return motion_of_tool(self.name, self._k, self._placed(at), *wanted)

    def full_effort(self, effort: npt.ArrayLike) -> Array:
        """Actuator efforts (n,) as generalised forces of all joints, shape (nv,)."""
        full = np.zeros(self.nv)
        full[self._v_index] = as_vector("effort", effort, self.n)
        return full

    def actuated(self, q_full: Array) -> Array:
        """Actuated coordinates of a full configuration, shape (n,)."""
        return np.asarray(q_full[self._q_index])

    def actuated_velocity(self, v_full: Array) -> Array:
        """Actuated part of a full velocity or acceleration, shape (n,)."""
        return np.asarray(v_full[self._v_index])

    def integrate(self, q_full: Array, motion: Array) -> Array:
        """Configuration after the tangent motion (nv,), on the manifold, shape (nq,)."""
        return self._k.integrate(q_full, motion)

    def gap(self, q_full: Array) -> tuple[float, float]:
        """Worst loop gap of a configuration, ([m], [rad])."""
        return self._k.at(self._whole(q_full)).gap[:2]

    def constraint_jacobian(self, q_full: Array) -> Array:
        """Derivative of all constraint rows, unscaled, shape (rows, nv)."""
        return self._k.at(self._whole(q_full)).jacobian

    def link_placements(self, q_full: Array) -> dict[str, Array]:
        """World placement (4, 4) of every link."""
        model, data = self._k.model, self._k.data
        pin.forwardKinematics(model, data, self._whole(q_full))
        return {
            frame.name: self._in_world(data.oMi[frame.parentJoint] * frame.placement)
            for frame in model.frames
            if frame.type == pin.FrameType.BODY and frame.name != "universe"
        }

    def cut_placements(self, q_full: Array) -> list[tuple[str, Array, Array]]:
        """Name and world placements (4, 4) of both frames of every cut."""
        frames = self._k.at(self._whole(q_full)).frames
        return [
            (
                cut.name,
                self._in_world(pin.SE3(frames.axes_a[i], frames.at_a[i])),
                self._in_world(pin.SE3(frames.axes_b[i], frames.at_b[i])),
            )
            for i, cut in enumerate(self._k.closure.cuts)
        ]

    def centre_of_mass(self, q_full: Array) -> Array:
        """Centre of mass of all moving links, shape (3,) [m].

        Raises:
            InputError: none of them has mass.
        """
        if not any(inertia.mass > 0.0 for inertia in list(self.model.inertias)[1:]):
            raise InputError(f"{self.name} has no moving link with mass, so no centre of mass")
        return np.array(pin.centerOfMass(self._k.model, self._k.data, self._whole(q_full))) + self._k.origin

    # ---- inside ----------------------------------------------------------------------------------------------------

    def _whole(self, q_full: npt.ArrayLike) -> Array:
        return as_vector("q_full", q_full, self.nq)

    @cached_property
    def _actuated_lengths(self) -> Array:
        return np.array([actuator.kind == "translation" for actuator in self.actuators], dtype=bool)

    def _in_world(self, placement: pin.SE3) -> Array:
        """A placement in the model that is computed with as one in the world, shape (4, 4)."""
        found = np.array(placement.homogeneous)
        found[:3, 3] += self._k.origin
        return found

    @cached_property
    def _regular(self) -> tuple[Placed, ...]:
        """Home and closed postures around it, home first."""
        home, found = self._home.q_full, [self._at_home]
        for start in self._assembler.around(home, np.full(2 * AROUND, SHIFT)):
            closed = self._assembler.settle(start, None, 3.0 * SHIFT) if len(found) <= AROUND else None
            if closed is not None:
                found.append(self._k.at(closed))
        return tuple(found)

    @cached_property
    def _structure(self) -> Structure:
        return Structure.of(self._k, self._v_index, list(self._regular))

    @cached_property
    def _is_determined(self) -> bool:
        """Whether the actuators determine the motion at nearly every posture, but for idle motions."""
        usual = self._structure
        return usual.locked == usual.idle and usual.rank + usual.idle + self.n == self.nv

    @cached_property
    def _nearby(self) -> Nearby | None:
        if not self._is_determined or self._structure.idle or not (self.n and len(self._passive)):
            return None
        steady = [placed for placed in self._regular if is_steady(self._k, placed)]
        if not steady:
            return None
        regular = max(steady, key=lambda one: tangent_map(self._k, self._v_index, self._passive, one, 0).type2)
        return Nearby(self._k, self._v_index, self._passive, regular)

    def _map(self, placed: Placed) -> TangentMap:
        """Tangent map at a configuration where the actuators determine the motion.

        Raises:
            SingularError: type-2 singularity.
            ActuationError: the actuators do not determine the motion, here or anywhere.
        """
        usual = self._structure
        found = tangent_map(self._k, self._v_index, self._passive, placed, usual.idle)
        if usual.locked > usual.idle and not found.type2 > tolerances.SINGULAR.value:
            raise self._not_determined(placed)
        if found.type2 < tolerances.SINGULAR.value:
            raise SingularError(
                f"{self.name} at {self._show(placed.q[self._q_index])} is in a type-2 singularity: with the actuators "
                f"locked it still moves (singular value {found.type2:.2g}, limit {tolerances.SINGULAR.value:.0e})",
                kind="type-2",
                measure=found.type2,
                limit=tolerances.SINGULAR.value,
            )
        if not found.consistent:
            raise self._not_determined(placed)
        return found

    def _not_determined(self, placed: Placed) -> ActuationError:
        report = mobility_report(self._k, self._v_index, self._structure, placed)
        moving = [joint for joint in report.free if joint not in report.idle]
        if moving:
            why = f"with all actuators locked these joints still move: {', '.join(moving)}"
        else:
            needed = report.mobility - report.idle_mobility
            why = f"{report.actuators - needed} actuators more than the mobility depend on the others"
        return ActuationError(
            f"the actuators of {self.name} do not determine its motion: mobility {report.mobility}, actuators "
            f"{report.actuators}; {why}. Full coordinates still work",
            mobility=report.mobility,
            actuators=report.actuators,
            free=report.free,
        )

    @property
    def _searched(self) -> Robot:
        return Robot(self.name, self._k, self._assembler, self._v_index, lambda q: self._posture(self._k.at(q)))

    def _hold(self, q: Array) -> ActuatedDriver:
        """Keeps the actuated coordinates where they are."""
        values = q[self._q_index]
        return ActuatedDriver(self._q_index, self._selection, self._actuated_lengths, values, values)

    def _need_tool(self) -> None:
        if self._k.tool_support is None:
            raise InputError(f"{self.name} has no tool frame; name one under [tool] in its loops.toml")

    def _placed(self, at: Posture | None) -> Placed:
        """The tree at a posture (default home) that this robot, or one of the same geometry, made.

        That of the last posture is kept, since several calls at one posture are the rule.
        """
        if at is None or at is self._home:
            return self._at_home
        known, placed = self._known
        if at is known:
            return placed
        if not isinstance(at, Posture):
            raise InputError(f"a posture is wanted, such as {self.name} makes by close() or reach(); found {at!r}")
        if at.q_full.shape != (self.nq,):
            raise InputError(
                f"this posture has {at.q_full.size} coordinates, {self.name} has {self.nq}; make it with this robot's "
                "close() or reach()"
            )
        placed = self._k.at(at.q_full)
        if not System(self._k, None).at(placed).openness < 10.0:
            distance, angle, cut = placed.gap
            raise InputError(
                f"this posture leaves cut '{cut}' of {self.name} open by {distance:.3g} m, {angle:.3g} rad; make it "
                "with this robot's close() or reach()"
            )
        self._known = at, placed
        return placed

    def _posture(self, placed: Placed) -> Posture:
        distance, angle, _ = placed.gap
        posture = Posture(placed.q[self._q_index], placed.q, (distance, angle))
        self._known = posture, placed
        return posture

    def _type2(self, placed: Placed) -> float:
        """Distance to a type-2 singularity."""
        return tangent_map(self._k, self._v_index, self._passive, placed, self._structure.idle).type2

    def _show(self, q: Array) -> str:
        return ", ".join(
            f"{actuator.name} {value:.6g} {actuator.unit}" for actuator, value in zip(self.actuators, q, strict=True)
        )

    def _normalised(self, q: Array) -> Array:
        return np.asarray(pin.normalize(self.model, q))
