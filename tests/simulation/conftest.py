"""Both robots as paper model and as closed chain, with each paper's own trajectory."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pytest

from cutjoint.chain import ClosedChain
from cutjoint.control import PD, ComputedTorque, Feedforward, PDGravity
from cutjoint.description import load_description
from cutjoint.motion import Circle, Lissajous, Reference
from cutjoint.papers.cpm import CpmModel
from cutjoint.papers.omega3 import Omega3Model
from cutjoint.robots import load


@dataclass(frozen=True)
class Robot:
    name: str
    model: type
    trajectory: object
    gains: dict

    @cached_property
    def paper(self):
        return self.model()

    @cached_property
    def chain(self):
        return load(self.name, "lumped")

    @cached_property
    def description(self):
        return load_description(self.name)

    @cached_property
    def reference(self):
        return Reference(self.trajectory, self.paper)

    def law(self, name, model=None):
        inside = self.paper if model is None else model
        make = {
            "pd": lambda kp, kd: PD(kp, kd),
            "pd-gravity": lambda kp, kd: PDGravity(inside, kp, kd),
            "feedforward": lambda kp, kd: Feedforward(inside, kp, kd),
            "computed-torque": lambda kp, kd: ComputedTorque(inside, kp, kd),
        }[name]
        return make(*self.gains[name])

    def spoiled(self, factor=1.01):
        """The chain with one mass scaled, that of the heaviest moving link."""
        from dataclasses import replace

        lumped = self.description.variant("lumped")
        link = max((one for one in lumped.links if one.inertial), key=lambda one: one.inertial.mass)
        heavier = replace(link.inertial, mass=factor * link.inertial.mass)
        return ClosedChain(lumped.with_inertial(link.name, heavier))


LAWS = ("pd", "pd-gravity", "feedforward", "computed-torque")
ROBOTS = {
    "cpm": Robot(
        "cpm",
        CpmModel,
        Circle([0.425, 0.425, 0.3], 0.175, 0.5 * np.pi),
        dict(zip(LAWS, ((12691, 436), (8507, 436), (7053, 436), (2550.25, 101)), strict=True)),
    ),
    "omega3": Robot(
        "omega3",
        Omega3Model,
        Lissajous([0.1, 0, 0], [0, 0.06, 0.06], [0, np.pi, 2 * np.pi], [0, 0, -np.pi / 2], 2.0),
        dict(zip(LAWS, ((1.0, 0.05), (1.0, 0.05), (1.0, 0.05), (400.0, 40.0)), strict=True)),
    ),
}


@pytest.fixture(params=ROBOTS)
def robot(request):
    return ROBOTS[request.param]


@pytest.fixture
def cpm():
    return ROBOTS["cpm"]


@pytest.fixture
def omega3():
    return ROBOTS["omega3"]
