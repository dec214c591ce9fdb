"""Time derivatives of joint Jacobians against finite differences, for every joint of a tree."""

from __future__ import annotations

import numpy as np
import pytest

from cutjoint.chain import ClosedChain
from cutjoint.description import Frame, Inertial, Joint, JointType, Link, RobotDescription

MOVING = [kind for kind in JointType if kind is not JointType.FIXED]


def chain_of(kind: JointType) -> ClosedChain:
    """A hinge that carries a joint of this kind, which carries the same kind again and another hinge."""
    kinds = [JointType.REVOLUTE, kind, kind, JointType.REVOLUTE]
    random = np.random.default_rng(4)
    links, joints = [Link("base")], []
    for i, one in enumerate(kinds):
        placement = np.eye(4)
        placement[:3, 3] = random.uniform(-0.3, 0.3, 3)
        parent = links[-1].name
        links.append(Link(f"body{i}", Inertial(1.0, np.array([0.1, 0.2, 0.1 * i]), 0.02 * np.eye(3))))
        joints.append(Joint(f"joint{i}", one, parent, f"body{i}", placement, axis=np.array([0.0, 0.6, 0.8])))
    joints = [
        Joint(
            j.name, j.type, j.parent, j.child, j.placement, axis=np.array([0.0, 0.6, 0.8]), axis2=np.array([1.0, 0, 0])
        )
        for j in joints
    ]
    return ClosedChain(RobotDescription("tree", tuple(links), tuple(joints), tool=Frame("body3")))


@pytest.mark.parametrize("kind", MOVING)
def test_rates_are_those_of_finite_differences(kind: JointType) -> None:
    chain, random, step = chain_of(kind), np.random.default_rng(5), 1e-6
    k = chain._k
    q = chain.integrate(chain.neutral, random.uniform(-0.7, 0.7, chain.nv))
    v = random.normal(size=chain.nv)
    rates = k.moving(q, v).rates
    sides = [k.at(chain.integrate(q, sign * step * v)).twists for sign in (1.0, -1.0)]
    np.testing.assert_allclose(rates, (sides[0] - sides[1]) / (2.0 * step), rtol=0, atol=2e-8)
