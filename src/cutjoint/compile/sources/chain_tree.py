"""The tree of a closed chain with what of it is an argument of compiled functions."""

from __future__ import annotations

import threading
from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from cutjoint.arrays import Array, readonly
from cutjoint.chain import ClosedChain
from cutjoint.chain.build import bind_frame, held_up_model
from cutjoint.chain.joints import velocity_scale
from cutjoint.compile.equations.inertia import BodyInertia, PointMass
from cutjoint.compile.equations.physics import TreePhysics
from cutjoint.compile.equations.pose import Arguments, TreePose
from cutjoint.compile.equations.tree import JointTree
from cutjoint.compile.expressions import vectors
from cutjoint.compile.expressions.graph import Number
from cutjoint.compile.once import once
from cutjoint.compile.sources.interface import PAYLOAD
from cutjoint.compile.sources.parameters import Parameters, Ranges, RobotScale
from cutjoint.compile.sources.varied import Varied
from cutjoint.description.paths import PLACE


class ChainTree:
    """The tree of a chain; its local model stands near its origin, however far away its base is.

    Args:
        chain: any closed chain.
        parameters, ranges: see `ChainSource`.

    Attributes:
        origin: where the local model stands (3,) [m]; it is added to tool positions and to the height of the masses,
            not carried through the arithmetic.
        positions, nv: sizes of configuration and velocity.
        rate_scale: factor per rate that makes it dimensionless, shape (nv,).
        actuated, actuated_rates: where the actuated coordinates stand in them.
        arguments: what stays an argument of the compiled functions; `parameters` are their names.
        nominal, low, high: the chain's own values of them, and the range that they are compiled for, (parameters,).
        varied: what of the tree they touch.
    """

    def __init__(self, chain: ClosedChain, parameters: Sequence[str] = (), ranges: Ranges | None = None) -> None:
        self.chain = chain
        self._lock = threading.RLock()
        self.model: pin.Model = chain.local_model
        self.origin = vectors.constant_vector(chain.origin)
        self.name = chain.name
        self.positions, self.nv = chain.nq, chain.nv
        self.rate_scale = velocity_scale(self.model, chain.length)
        self.actuated = tuple(int(i) for i in chain.actuated(np.arange(float(chain.nq))))
        self.actuated_rates = tuple(int(i) for i in chain.actuated_velocity(np.arange(float(chain.nv))))
        self.arguments = Parameters(chain.description, parameters)
        self.parameters, self.nominal = self.arguments.names, self.arguments.nominal
        self.low, self.high = self.arguments.bounds(ranges or {}, self.scale)
        self.varied = Varied(self.model, self.arguments)

    @property
    def placing(self) -> list[int]:
        """Which parameters are places of joints and cuts, or couplings."""
        return [self.parameters.index(name) for name in self.arguments.placing]

    def displaced(self, values: Array) -> bool:
        """Whether such a parameter differs from the chain's own, at values of all, shape (parameters,) or (N,
        parameters)."""
        return bool((values[..., self.placing] != self.nominal[self.placing]).any())

    def keeps_task(self, values: Array) -> bool:
        """Whether the task is the chain's own at values of the parameters, shape (parameters,) or (N, parameters): some
        rotations alone are led from how the tool is at home, which may depend on them."""
        turning = {f"tool.{angle}" for angle in PLACE[3:]}
        tool = [k for k, name in enumerate(self.parameters) if name in turning]
        moved = self.displaced(values) or bool((values[..., tool] != self.nominal[tool]).any())
        return not moved or sum(row >= 3 for row in self.chain.task.rows) in (0, 3)

    @property
    def scale(self) -> RobotScale:
        """How heavy, large and quick the robot is."""
        mass = sum(float(inertia.mass) for inertia in list(self.model.inertias)[1:])
        gravity = float(np.linalg.norm(self.model.gravity.linear))
        return RobotScale(mass, self.chain.length, float(np.sqrt(self.chain.length / gravity)) if gravity else 1.0)

    @once
    def tree(self) -> JointTree:
        """The tree without the links whose inertias are expressions."""
        apart = self.varied.links
        return JointTree(self._without(apart) if apart else self.model, self.varied.loose)

    def _without(self, links: Sequence[str]) -> pin.Model:
        """The model without the inertias of some links."""
        model = pin.Model(self.model)
        frames = {link.name: self.frame(link.name) for link in self.chain.description.links}
        for joint in {int(frames[name].parentJoint) for name in links}:
            total = pin.Inertia.Zero()
            for link in self.chain.description.links:
                inertial, frame = link.inertial, frames[link.name]
                if inertial is not None and link.name not in links and int(frame.parentJoint) == joint:
                    own = pin.Inertia(inertial.mass, np.array(inertial.com), np.array(inertial.inertia))
                    total = total + frame.placement.act(own)
            model.inertias[joint] = total
        return model

    def pose(self, q: Sequence[Number], parameters: Sequence[Number]) -> TreePose:
        """The tree at the configuration `q`, with the values of the parameters."""
        if not self.parameters:
            return TreePose(self.tree, q, Arguments(held_up=self.held_up, rotors=self.physics.rotors({})))
        values, tree, varied = dict(zip(self.parameters, parameters, strict=True)), self.tree, self.varied
        numbers = self.arguments.numbers(values)
        frames = varied.frames(tree, numbers)
        bodies = tuple(varied.body(tree, name, numbers, values.get(name)) for name in varied.links)
        points: tuple[PointMass, ...] = ()
        if PAYLOAD in values:
            step, _, lever = frames.get("tool", self.tool_frame)
            points = (PointMass(step, values[PAYLOAD], lever),)
        placed, rotors = varied.placed(tree, numbers), self.physics.rotors(numbers)
        shares = [self.chain.description.link(name).gravity_compensation for name in varied.links]
        held_up = (one.scaled(share) for one, share in zip(bodies, shares, strict=True) if share)
        own = Arguments(numbers, bodies, points, (*self.held_up, *held_up), placed, frames, rotors)
        return TreePose(tree, q, own)

    @once
    def held_up(self) -> tuple[BodyInertia, ...]:
        """Bodies of the masses whose weight is compensated, of links whose inertia is no expression."""
        links = [link for link in self.chain.description.links if link.name not in self.varied.links]
        model, found = held_up_model(self.model, links), []
        for joint, body in enumerate(() if model is None else model.inertias):
            if joint and body.mass:
                step, centre = self.tree.point(joint, np.asarray(body.lever))
                mass = float(body.mass)
                found.append(BodyInertia(step, mass, vectors.scale(mass, centre), 0.0, ()))
        return tuple(found)

    @once
    def physics(self) -> TreePhysics:
        """What its joints and cuts do by themselves."""
        return TreePhysics(self.tree, self.model, self.chain.description)

    @once
    def tool_frame(self) -> tuple[int, vectors.Matrix, vectors.Vector]:
        """Step, rotation and lever of the tool."""
        tool = self.chain.description.tool
        assert tool is not None, "see `lacks`"
        return self.tree.frame(*bind_frame(self.model, tool))

    def frame(self, link: str) -> pin.Frame:
        """Where a link is in the model."""
        return self.model.frames[self.model.getFrameId(link, pin.FrameType.BODY)]

    @once
    def limits(self) -> tuple[Array, Array]:
        """Least and largest value of every configuration coordinate, shape (nq,) each; infinite for what has none."""
        single = np.zeros(self.positions, dtype=bool)
        single[[int(self.model.idx_qs[i]) for i in range(1, self.model.njoints) if self.model.nqs[i] == 1]] = True
        lower, upper = self.model.lowerPositionLimit, self.model.upperPositionLimit
        return readonly(np.where(single, lower, -np.inf)), readonly(np.where(single, upper, np.inf))

    @once
    def position_scale(self) -> Array:
        """Robot's length for configuration coordinates that are lengths, 1 for the others, shape (nq,)."""
        scale = np.ones(self.positions)
        for step in self.tree.steps[1:]:
            scale[step.q : step.q + step.kind.lengths] = self.chain.length
        return readonly(scale)
