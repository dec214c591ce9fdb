"""Natural units: robots that differ by units alone are one robot."""

from dataclasses import astuple

import numpy as np
import pytest

from cutjoint.description import (
    Bushing,
    Coupling,
    CutJoint,
    CutType,
    Frame,
    Inertial,
    Joint,
    JointPhysics,
    JointType,
    Link,
    RobotDescription,
)
from cutjoint.engines.mujoco import natural, units_of

TURN = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


def at(*position):
    placement = np.eye(4)
    placement[:3, :3], placement[:3, 3] = TURN, position
    return placement


def robot(length=1.0, mass=1.0, time=1.0):
    """A slider and a crank that drives it, written down in units of a length, a mass and a time."""
    inertial = Inertial(2.0 * mass, np.array([0.1, 0.2, 0.3]) * length, np.diag([0.3, 0.4, 0.5]) * mass * length**2)
    turning, sliding = mass * length**2 / time, mass / time
    return RobotDescription(
        "slider",
        (Link("base"), Link("crank", inertial), Link("block", Inertial(0.5 * mass))),
        (
            Joint("turn", JointType.REVOLUTE, "base", "crank", at(0.3 * length, 0.0, 0.1 * length),
                  physics=JointPhysics(0.2 * turning, 0.3 * turning / time, 0.4 / time, 0.5 * turning / time, 0.6,
                                       0.7 * turning * time, 8.0, 0.9 * turning / time, 1.1 * turning)),
            Joint("slide", JointType.PRISMATIC, "base", "block", at(0.0, length, 0.0),
                  physics=JointPhysics(0.4 * sliding, 0.5 * sliding * length / time, 0.4 * length / time,
                                       0.5 * sliding / time, 0.6 * length, 0.7 * turning * time, 8.0 / length,
                                       0.9 * sliding / time, 1.1 * sliding)),
        ),
        cuts=(
            CutJoint("pin", CutType.SPHERICAL, Frame("crank", at(length, 0.0, 0.0)), Frame("block", np.eye(4)),
                     physics=JointPhysics(1.2 * turning, 0.1 * turning / time, 0.2 / time,
                                          stiffness=1.3 * turning / time, rest=0.0),
                     bushing=Bushing(1.4 * sliding / time, 1.5 * sliding, 1.6 * turning / time, 1.7 * turning)),
            CutJoint("rail", CutType.PRISMATIC, Frame("crank", at(length, 0.0, 0.0)), Frame("block", np.eye(4)),
                     physics=JointPhysics(1.2 * sliding, 0.1 * sliding * length / time, 0.2 * length / time,
                                          stiffness=1.3 * sliding / time, rest=0.4 * length)),
        ),
        couplings=(
            Coupling.geared("rack", "slide", "turn", 0.7 * length, 0.1 * length),
            Coupling.geared("pinion", "turn", "slide", 0.7 / length, 0.1),
        ),
        tool=Frame("block", at(0.0, 0.0, 0.2 * length)),
        gravity=np.array([0.0, 0.6, -0.8]) * length / time**2,
    )  # fmt: skip


def physics(of):
    """The numbers of what it does by itself; no rest position is one that is nowhere."""
    return [value for value in astuple(of.physics) if value is not None]


def numbers(one):
    """All numbers of a description in one row."""
    rows = [one.gravity, one.tool.placement]
    rows += [[link.inertial.mass, *link.inertial.com, *link.inertial.inertia.flat] for link in one.links[1:]]
    rows += [[*physics(joint), joint.physics.armature, *joint.placement.flat, *joint.axis] for joint in one.joints]
    rows += [[*physics(cut), *cut.a.placement.flat, *cut.b.placement.flat] for cut in one.cuts]
    rows += [astuple(cut.bushing) for cut in one.cuts if cut.bushing is not None]
    rows += [[coupling.gear[1], coupling.offset] for coupling in one.couplings]
    return np.concatenate([np.ravel(row) for row in rows])


@pytest.mark.parametrize("length", [1e-4, 3.0, 1e4])
@pytest.mark.parametrize("mass", [1e-6, 5.0, 1e6])
@pytest.mark.parametrize("time", [1e-3, 7.0])
def test_robots_that_differ_by_units_are_one(length, mass, time):
    written = robot(length, mass, time)
    units = units_of(written, length)
    assert (units.length, units.mass) == (length, 2.0 * mass)
    assert units.time == pytest.approx(time)
    assert units.energy == pytest.approx(2.0 * mass * (length / time) ** 2)
    wanted = numbers(natural(robot(), units_of(robot(), 1.0)))
    np.testing.assert_allclose(numbers(natural(written, units)), wanted, rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(np.linalg.norm(natural(written, units).gravity), 1.0)


def test_units_of_a_robot_without_masses_or_gravity():
    empty = RobotDescription("empty", (Link("base"),), (), gravity=np.zeros(3))
    units = units_of(empty, 2.0)
    assert (units.length, units.mass, units.time) == (2.0, 1.0, 1.0)
