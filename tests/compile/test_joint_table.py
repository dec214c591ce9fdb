"""The table of joints: every row moves as Pinocchio says, and a type made of known motions is one row."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from cutjoint.chain import joints
from cutjoint.compile.equations.coordinates import configuration_rate, from_rates, moved, to_rates
from cutjoint.compile.equations.dynamics import accelerations, generalised_forces, mass_matrix, velocities
from cutjoint.compile.equations.joints import JOINTS, StepKind
from cutjoint.compile.equations.pose import TreePose
from cutjoint.compile.equations.tree import JointTree
from cutjoint.description.joints import JointType
from cutjoint.errors import InputError

SLANTED = np.array([0.3, -0.5, 0.8]) / np.linalg.norm([0.3, -0.5, 0.8])
ACROSS = np.cross(SLANTED, [1.0, 0.0, 0.0]) / np.linalg.norm(np.cross(SLANTED, [1.0, 0.0, 0.0]))


def limb(kind: type[pin.JointModel]) -> pin.Model:
    """A turn, a slide, the joint, and a turn, oblique to one another, with a body each."""
    model, rng, name = pin.Model(), np.random.default_rng(3), kind.__name__
    axes = {"JointModelUniversal": (SLANTED, ACROSS)}.get(name, (SLANTED,) if name.endswith("Unaligned") else ())
    parent = 0
    around = pin.JointModelRevoluteUnaligned(ACROSS)
    for k, one in enumerate((pin.JointModelRX(), pin.JointModelPY(), kind(*axes), around)):
        parent = model.addJoint(parent, one, pin.SE3.Random(), f"joint {k}")
        square = rng.normal(size=(3, 3))
        model.appendBodyToJoint(parent, pin.Inertia(0.7, rng.normal(size=3), square @ square.T), pin.SE3.Identity())
    return model


def agrees(model: pin.Model) -> None:
    """Mass matrix, forces and the way a configuration changes, in numbers, against Pinocchio."""
    rng = np.random.default_rng(4)
    data, tree = model.createData(), JointTree(model)
    q = pin.integrate(model, pin.neutral(model), rng.normal(size=model.nv))
    v, a = rng.normal(size=model.nv), rng.normal(size=model.nv)
    pose = TreePose(tree, q.tolist())
    units = [to_rates(pose, one.tolist()) for one in np.eye(model.nv)]
    mass = mass_matrix(pose, [velocities(pose, one) for one in units])
    upper = np.triu(pin.crba(model, data, q))
    np.testing.assert_allclose(np.array(mass, dtype=float), upper + np.triu(upper, 1).T, rtol=1e-12, atol=1e-12)
    assert from_rates(pose, to_rates(pose, v.tolist())) == pytest.approx(v.tolist(), abs=1e-14)

    u = to_rates(pose, v.tolist())
    h = 1e-6
    ahead, behind = (
        to_rates(TreePose(tree, pin.integrate(model, q, s * h * v).tolist()), (v + s * h * a).tolist()) for s in (1, -1)
    )
    du = ((np.array(ahead) - np.array(behind)) / (2 * h)).tolist()
    base = (-float(tree.gravity[0]), -float(tree.gravity[1]), -float(tree.gravity[2]))
    forces = generalised_forces(pose, motion := velocities(pose, u), accelerations(pose, u, motion, du, base))
    wanted = pin.rnea(model, data, q, v, a)
    found = [sum(f * x for f, x in zip(forces, unit, strict=True)) for unit in units]
    np.testing.assert_allclose(np.array(found, dtype=float), wanted, rtol=1e-7, atol=1e-7)

    slope = (pin.integrate(model, q, h * v) - pin.integrate(model, q, -h * v)) / (2 * h)
    np.testing.assert_allclose(np.array(configuration_rate(pose, u), dtype=float), slope, atol=1e-8)
    stepped = np.array(moved(pose, [h * x for x in u]), dtype=float)
    np.testing.assert_allclose(stepped, pin.integrate(model, q, h * v), atol=1e-10)


@pytest.mark.parametrize("kind", sorted({kind for one in JOINTS for kind in joints.JOINTS[one].models}, key=str))
def test_every_joint_moves_as_in_pinocchio(kind: type[pin.JointModel]) -> None:
    pin.seed(5)
    agrees(limb(kind))


def test_every_type_can_be_compiled() -> None:
    assert set(JOINTS) == set(joints.JOINTS)


@pytest.mark.parametrize("row", [(StepKind.SLIDE,) * 3, (StepKind.SHIFT,)], ids=["slides", "shift"])
def test_a_type_made_of_known_motions_is_one_row(row: tuple[StepKind, ...], monkeypatch: pytest.MonkeyPatch) -> None:
    pin.seed(6)
    model = limb(pin.JointModelTranslation)
    monkeypatch.setitem(joints._TYPES, "JointModelTranslation", JointType.FLOATING)
    monkeypatch.delitem(JOINTS, JointType.FLOATING)  # type: ignore[misc]
    with pytest.raises(InputError, match=r"'joint 2' of type floating cannot be compiled"):
        JointTree(model)
    monkeypatch.setitem(JOINTS, JointType.FLOATING, row)  # type: ignore[misc]
    agrees(model)


def test_kinds_say_what_the_expressions_rely_on() -> None:
    for kind in StepKind:
        assert kind.lengths in (0, kind.rates)
        assert kind.coordinates - kind.rates == (kind in (StepKind.SPIN, StepKind.BALL))
        assert kind.has_axis == (kind in (StepKind.TURN, StepKind.SLIDE))
