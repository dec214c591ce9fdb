"""Kinematics of a robot: the tree at one configuration, as values, its closure equations, and their scales.

What `Kinematics.at(q)` and `.moving(q, v)` return holds its own arrays and never changes.

A fixed base far from the world origin would cost digits in every product, so the model that is computed with stands
near the robot (`origin`); positions are given back in the world by the chain.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
import numpy.typing as npt
import pinocchio as pin

from cutjoint import tolerances
from cutjoint.arrays import Array, readonly
from cutjoint.chain.build import base_of, bind_frame, build_model, characteristic_length, cut_sides, held_up_model
from cutjoint.chain.closure import Closure, CutFrames
from cutjoint.chain.joints import support, travelling, velocity_scale
from cutjoint.chain.physics import ChainPhysics, Elastic
from cutjoint.chain.rank import singular_values, threshold
from cutjoint.chain.tree import TreeModel
from cutjoint.chain.world import World
from cutjoint.description.model import RobotDescription
from cutjoint.errors import InputError
from cutjoint.mechanism import Pose
from cutjoint.reprs import line

_UNIT = np.eye(6)
MAGNIFIED = 1e-2
"""Part of an acceleration that rows which are left out may make wrong: their gap over the square of how near the others
are to a singularity."""


class Placed:
    """The tree at one configuration.

    Attributes:
        q: configuration, shape (nq,).
        twists: joint Jacobians about the origin in its axes, shape (6, nv).
        frames: of the cuts.
        tool_position: of the tool point in the model, shape (3,) [m].
        tool_axes: axes of the tool as columns, shape (3, 3).
    """

    __repr__ = line("q", q="m or rad")

    def __init__(self, kinematics: Kinematics, q: Array, placements: Array, twists: Array) -> None:
        k = self._k = kinematics
        self.q, self.twists = q, twists
        count = len(k.closure.cuts)
        axes, at = placements[:, :3, :3], placements[:, :3, 3]
        self.frames = CutFrames(axes[:count], axes[count : 2 * count], at[:count], at[count : 2 * count])
        self.tool_axes, self.tool_position = axes[-1], at[-1]
        self._axes, self._at = axes, at

    @cached_property
    def gather(self) -> Array:
        """G of `cutjoint.chain.closure`, shape (cut rows, 12 cuts)."""
        return self._k.closure.gather(self.frames)

    @cached_property
    def jacobian(self) -> Array:
        """Of all rows, [m] and [rad] per velocity, shape (rows, nv)."""
        return self._k.closure.jacobian(self.gather, self.twists, self.q)

    @cached_property
    def scaled(self) -> Array:
        """The same, dimensionless."""
        return np.asarray(self.jacobian * self._k.scale)

    @cached_property
    def residual_of_all(self) -> Array:
        """Residual of all rows, also of those that are left out, [m] and [rad]."""
        return self._k.closure.residual(self.frames, self.q)

    @property
    def residual(self) -> Array:
        """Residual of the rows, shape (rows,), [m] and [rad]."""
        return self._k.closure.kept(self.residual_of_all)

    @property
    def gap(self) -> tuple[float, float, str]:
        """Worst distance [m] and angle [rad] of any cut, and the name of the worst cut."""
        lengths, angles = self._k.closure.gaps(self.residual_of_all)
        if not len(lengths):
            return 0.0, 0.0, ""
        worst = int(np.argmax(lengths / self._k.length + angles))
        return float(lengths.max()), float(angles.max()), self._k.closure.names[worst]

    @cached_property
    def elastic(self) -> Elastic | None:
        """The frames of the cuts that do something by themselves; None where no cut does."""
        cuts = len(self._k.physics.cuts)
        if not cuts:
            return None
        first, second = slice(-1 - 2 * cuts, -1 - cuts), slice(-1 - cuts, -1)
        frames = CutFrames(self._axes[first], self._axes[second], self._at[first], self._at[second])
        return Elastic(frames, self.twists)

    @cached_property
    def springs(self) -> Array:
        """Effort that holds springs, bushings and stops, shape (nv,)."""
        return self._k.physics.springs(self.q, self.elastic)

    def friction(self, v: Array) -> Array:
        """Effort that overcomes dampers and friction at the velocity `v` (nv,), shape (nv,)."""
        return self._k.physics.friction(self.q, v, self.elastic)

    @property
    def tool(self) -> pin.SE3:
        """Placement of the tool frame in the model, away from the world by its origin."""
        return pin.SE3(self.tool_axes, self.tool_position)

    @property
    def tool_pose(self) -> Pose:
        """The same as a value."""
        return Pose(self.tool_position, self.tool_axes)

    @property
    def tool_jacobian(self) -> Array:
        """Linear velocity of the tool point and angular velocity of its body per velocity, shape (6, nv)."""
        assert self._k.tool_support is not None
        x, y, z = self.tool_position.tolist()
        shift = _UNIT.copy()
        shift[0, 4], shift[0, 5], shift[1, 5] = z, -y, x
        shift[1, 3], shift[2, 3], shift[2, 4] = -z, y, -x
        return np.asarray(shift.dot(self.twists * self._k.tool_support))


class Moving(Placed):
    """The tree at one configuration and velocity.

    Attributes:
        v: velocity, shape (nv,).
        rates: time derivatives of the joint Jacobians, shape (6, nv).
    """

    def __init__(
        self, kinematics: Kinematics, q: Array, v: Array, placements: Array, twists: Array, rates: Array
    ) -> None:
        super().__init__(kinematics, q, placements, twists)
        self.v, self.rates = v, rates

    @property
    def drift(self) -> Array:
        """Time derivative of the constraint Jacobian times v, shape (rows,), [m/s2] and [rad/s2]."""
        return self._k.closure.drift(self.frames, self.gather, self.twists, self.rates, self.q, self.v)

    @property
    def tool_drift(self) -> Array:
        """Classical acceleration of the tool point and angular acceleration of its body with zero joint accelerations,
        shape (6,), [m/s2] and [rad/s2]."""
        assert self._k.tool_support is not None
        masked = self._k.tool_support * self.v
        twist, rate = self.twists @ masked, self.rates @ masked
        velocity = twist[:3] + np.cross(twist[3:], self.tool_position)
        classical = rate[:3] + np.cross(rate[3:], self.tool_position) + np.cross(twist[3:], velocity)
        return np.concatenate([classical, rate[3:]])


class Kinematics:
    """The model of a robot that is computed with, its closure equations and its scales.

    Attributes:
        name: of the robot and its variant.
        model: the open tree, standing near the origin.
        tree: that model with Pinocchio's workspaces.
        physics: what its joints and cuts do by themselves.
        world: where its links and cuts are in the world.
        origin: where the model's origin is in the world, shape (3,) [m].
        length: characteristic length [m].
        reach: longest way along the tree's and the cuts' frames [m], the size of the robot.
        tool_joint: the joint that moves the tool's body, 0 for the base.
        tool_support: 1 for every velocity that moves the tool, shape (nv,); None where there is no tool.
        row_scale, column_scale: factors per row and per velocity that make the constraint Jacobian dimensionless.
        scales: what systems of equations have in common, by the kind of their driver; filled as they are met.
        travels: whether bodies of it may be anywhere.
        rounded: distance [m] to which a point in the world is rounded, where the base stands far from its origin.
        closed_length: distance [m] below which a cut counts as closed; `tolerances.CLOSURE` is the same for angles.
    """

    def __init__(self, description: RobotDescription, trusted: Array | None = None, home: Array | None = None) -> None:
        model = build_model(description)
        centre, far = base_of(model, description)
        self.origin = readonly(centre if far else np.zeros(3))
        self.model = build_model(description, self.origin) if far else model
        self.tree = TreeModel(self.model, held_up_model(self.model, description.links))
        self.rounded = float(np.spacing(np.abs(self.origin).max())) if far else 0.0
        self.description = description
        variant = description.variant_name
        self.name = f"{description.name} ({variant})" if variant else description.name
        self.closure = Closure(self.model, description, trusted)
        self.physics = ChainPhysics(self.model, description)
        self.length, self.reach = characteristic_length(self.model, description)
        self.tool_support: Array | None = None
        if description.tool is not None:
            joint, placement = bind_frame(self.model, description.tool)
            self.tool_support = support(self.model, joint)
        else:
            joint, placement = 0, pin.SE3.Identity()
        self.tool_joint = joint
        rigid, elastic = (cut_sides(self.model, cuts) for cuts in (description.closing, self.physics.cuts))
        sides = [*rigid[::2], *rigid[1::2], *elastic[::2], *elastic[1::2], (joint, placement)]
        self._joints = sorted({joint for joint, _ in sides})
        self._frame_joint = np.array([self._joints.index(joint) for joint, _ in sides])
        self._frame_place = np.array([place.homogeneous for _, place in sides])
        self.world = World(self.tree, description, self.origin)
        self._travelling = travelling(self.model)
        self.travels = bool(len(self._travelling))
        self.closed_length = tolerances.CLOSURE.value * self.reach
        self._furthest = 0.1 * tolerances.RANK.value * self.length / float(np.finfo(float).eps)
        self.row_scale = np.where(self.closure.is_length, 1.0 / self.length, 1.0)
        self.column_scale = velocity_scale(self.model, self.length)
        self.scale = self.row_scale[:, None] * self.column_scale
        self.scales: dict[object, object] = {}
        self._usual: tuple[int, float] | None = None
        if home is not None and self.closure.left_out:
            values = singular_values(self.at(home).scaled)
            rank = int(np.count_nonzero(values > threshold(values)))
            self._usual = rank, float(values[rank - 1])

    def at(self, q: Array) -> Placed:
        """The tree at `q`, shape (nq,)."""
        self._refuse_far(q)
        twists = self.tree.jacobians(q)
        return Placed(self, q, self._placements(), twists)

    def moving(self, q: Array, v: Array) -> Moving:
        """The tree at `q` (nq,) and `v` (nv,)."""
        self._refuse_far(q)
        rates = self.tree.rates(q, v)
        return Moving(self, q, v, self._placements(), self.tree.twists(), rates)

    def after(self, q: Array, motion: npt.NDArray[np.floating]) -> Array:
        """Configuration after the dimensionless motion (nv,), on the manifold."""
        return self.tree.integrate(q, motion * self.column_scale)

    def need_tool(self) -> None:
        """Raises InputError for a robot without a tool."""
        if self.tool_support is None:
            raise InputError(f"{self.name} has no tool frame; name one under [tool] in its loops.toml")

    def load(self, mass: Array, v: Array, a: Array) -> float:
        """How large the loads of a motion `v`, `a` (nv,) are that inverse dynamics adds up: what its rounding is
        relative to.  Dimensionless in the motions, as `mass` is, the mass matrix, shape (nv, nv)."""
        speed = float(np.abs(v / self.column_scale).max(initial=0.0))
        change = float(np.abs(a / self.column_scale).max(initial=0.0))
        weight = self.tree.mass * self.length
        pull = float(np.linalg.norm(self.model.gravity.linear))
        return float(np.abs(mass).max(initial=0.0)) * (speed**2 + change) + weight * pull

    @cached_property
    def whole(self) -> Kinematics:
        """The same with all rows."""
        closure = self.closure
        return Kinematics(self.description, np.arange(closure.all_rows)) if closure.left_out else self

    def left_open(self, placed: Placed) -> float:
        """How far rows that are left out are open beyond what rounding explains, or what they are open by is magnified
        where the others nearly leave a motion free that home does not; 1 is the limit, and 0 what is below it."""
        if self._usual is None:
            return 0.0
        distance, angle, _ = placed.gap
        (rank, size), gap = self._usual, max(distance / self.reach, angle)
        least = min(float(singular_values(placed.scaled)[rank - 1]) / size, 1.0)
        share = max(gap / tolerances.ROUNDING.value, gap / (MAGNIFIED * max(least, 1e-9) ** 2))
        return share if share > 1.0 else 0.0

    def closed_within(self, q: Array) -> float:
        """Distance [m] below which a cut counts as closed at `q`: bodies that travel far from the origin are rounded to
        their distance from it.  For angles it is `tolerances.CLOSURE`."""
        if not self.travels:
            return self.closed_length
        return self.closed_length + tolerances.CLOSURE.value * float(np.abs(q[self._travelling]).max())

    # ---- mass and energy -------------------------------------------------------------------------------------------

    def centre_of_mass(self, q: Array) -> Array:
        """Of all links that move, shape (3,) [m].

        Raises:
            InputError: none of them has mass.
        """
        if not self.tree.mass > 0.0:
            raise InputError(f"{self.name} has no moving link with mass, so no centre of mass")
        return self.tree.centre_of_mass(q) + self.origin

    def potential_energy(self, q: Array) -> float:
        """Of gravity, zero at the world origin, and of springs, bushings and stops [J]."""
        near = self.tree.potential_energy(q)
        near += self.spring_energy(q)
        if not self.origin.any():
            return near
        return near - float(self.tree.weighing * np.array(self.model.gravity.linear) @ self.origin)

    def spring_energy(self, q: Array) -> float:
        """In springs, bushings and stops [J]."""
        physics = self.physics
        if not physics.acts:
            return 0.0
        return physics.potential(q, self.at(q).elastic if physics.cuts else None)

    def dissipation(self, q: Array, v: Array) -> float:
        """Power that dampers and friction take at a velocity (nv,) [W]."""
        physics = self.physics
        if not physics.acts:
            return 0.0
        return float(physics.friction(q, v, self.at(q).elastic if physics.cuts else None) @ v)

    def _refuse_far(self, q: Array) -> None:
        """Bodies so far away that the rounding of their place is not small against RANK have no rank.

        Raises:
            InputError: `q` (nq,) has one.
        """
        if self.travels and (far := float(np.abs(q[self._travelling]).max())) > self._furthest:
            raise InputError(
                f"{self.description.name} is {far:.3g} m from where its coordinates count from, where positions are "
                f"rounded to {np.spacing(far):.2g} m: too coarse for a robot whose links are {self.length:.3g} m long; "
                f"keep it within {self._furthest:.2g} m"
            )

    def _placements(self) -> Array:
        """Placements of the frames a and b of all cuts and of the tool where the tree is now, shape (frames, 4, 4)."""
        joints = self.tree.joints_at(self._joints)
        found: Array = joints.take(self._frame_joint, 0) @ self._frame_place
        return found
