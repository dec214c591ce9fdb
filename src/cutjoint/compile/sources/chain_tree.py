"""The tree of a closed chain, with the inertial parameters that stay arguments of the compiled functions."""

from __future__ import annotations

import threading
from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from cutjoint.arrays import Array, readonly
from cutjoint.chain import ClosedChain
from cutjoint.chain.build import bind_frame
from cutjoint.chain.joints import velocity_scale
from cutjoint.compile.equations.inertia import BodyInertia, PointMass
from cutjoint.compile.equations.pose import Pose
from cutjoint.compile.equations.tree import JointTree
from cutjoint.compile.expressions import vectors
from cutjoint.compile.expressions.graph import Number
from cutjoint.compile.once import once
from cutjoint.compile.sources.interface import PAYLOAD
from cutjoint.description.model import Inertial
from cutjoint.errors import InputError, UnknownNameError


class ChainTree:
    """The tree of a chain; its local model stands near its origin, however far away its base is.

    Args:
        chain: any closed chain.
        parameters: see `ChainSource`.

    Attributes:
        origin: where the local model stands (3,) [m]; it is added to tool positions and to the height of the masses,
            not carried through the arithmetic.
        positions, nv: sizes of configuration and velocity.
        rate_scale: factor per rate that makes it dimensionless, shape (nv,).
        actuated, actuated_rates: where the actuated coordinates stand in them.
    """

    def __init__(self, chain: ClosedChain, parameters: Sequence[str] = ()) -> None:
        self.chain = chain
        self._lock = threading.RLock()
        self.model: pin.Model = chain.local_model
        self.origin = vectors.constant_vector(chain.origin)
        self.name, self.parameters = chain.name, tuple(parameters)
        self.positions, self.nv = chain.nq, chain.nv
        self.rate_scale = velocity_scale(self.model, chain.length)
        self.actuated = tuple(int(i) for i in chain.actuated(np.arange(float(chain.nq))))
        self.actuated_rates = tuple(int(i) for i in chain.actuated_velocity(np.arange(float(chain.nv))))
        known = [link.name for link in chain.description.links]
        for name in self.parameters:
            if name == PAYLOAD:
                if chain.description.tool is None:
                    raise InputError(f"{chain.name} has no tool frame to carry a payload")
            elif name not in known:
                raise UnknownNameError("inertial parameter", name, [PAYLOAD, *known])
            elif (chain.description.link(name).inertial or Inertial(0.0)).mass <= 0.0:
                raise InputError(f"link '{name}' of {chain.name} has no mass to vary")

    @once
    def tree(self) -> JointTree:
        """The tree without the links whose masses are arguments."""
        varied = [name for name in self.parameters if name != PAYLOAD]
        return JointTree(self._without(varied) if varied else self.model)

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

    def pose(self, q: Sequence[Number], parameters: Sequence[Number]) -> Pose:
        """The tree at the configuration `q`, with the values of the inertial parameters."""
        points: list[PointMass] = []
        bodies: list[BodyInertia] = []
        for name, value in zip(self.parameters, parameters, strict=True):
            if name == PAYLOAD:
                step, lever = self.tool_point
                points.append(PointMass(step, value, lever))
            else:
                bodies.append(self._body(name, value))
        return Pose(self.tree, q, bodies, points)

    @once
    def tool_point(self) -> tuple[int, vectors.Vector]:
        """Step and lever of the tool point."""
        tool = self.chain.description.tool
        assert tool is not None, "see `lacks`"
        joint, placement = bind_frame(self.model, tool)
        return self.tree.point(joint, np.asarray(placement.translation))

    def frame(self, link: str) -> pin.Frame:
        """Where a link is in the model."""
        return self.model.frames[self.model.getFrameId(link, pin.FrameType.BODY)]

    def _body(self, name: str, mass: Number) -> BodyInertia:
        """A link whose mass is an argument."""
        inertial = self.chain.description.link(name).inertial
        assert inertial is not None
        frame = self.frame(name)
        rotation, at = np.asarray(frame.placement.rotation), np.asarray(frame.placement.translation)
        centre = rotation @ inertial.com + at
        inertia = rotation @ inertial.inertia @ rotation.T / inertial.mass
        inertia = inertia + centre @ centre * np.eye(3) - np.outer(centre, centre)
        return self.tree.scaled_body(frame.parentJoint, mass, centre, inertia)

    def nominal(self, parameter: str) -> float:
        """The chain's own value of an inertial parameter [kg]."""
        inertial = None if parameter == PAYLOAD else self.chain.description.link(parameter).inertial
        return 0.0 if inertial is None else float(inertial.mass)

    @once
    def position_scale(self) -> Array:
        """Robot's length for configuration coordinates that are lengths, 1 for the others, shape (nq,)."""
        scale = np.ones(self.positions)
        for step in self.tree.steps[1:]:
            scale[step.q : step.q + step.kind.lengths] = self.chain.length
        return readonly(scale)
