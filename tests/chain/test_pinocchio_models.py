"""What a chain hands to those who work with Pinocchio: right, complete or refused by name, and the caller's own."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from kit.two_bodies import FRAME_A, FRAME_B, two_bodies

import cutjoint
from cutjoint.chain import ClosedChain
from cutjoint.chain.build import build_model
from cutjoint.chain.contacts import constraint_models
from cutjoint.description import Coupling, CutType, Frame, Home, Link, Shape
from cutjoint.errors import InputError

CONTACTS = (CutType.FIXED, CutType.SPHERICAL, CutType.REVOLUTE)
SHIPPED = ("fourbar", "fivebar", "cpm", "omega3", "stewart", "redundant", "underactuated")


def theirs(chain: ClosedChain, q: np.ndarray, v: np.ndarray, effort: np.ndarray) -> np.ndarray:
    """Acceleration of all joints by Pinocchio alone."""
    model, data, models = chain.model, chain.model.createData(), chain.constraint_models()
    datas = chain.constraint_datas(models)
    pin.initConstraintDynamics(model, data, models, datas)
    return np.array(
        pin.constraintDynamics(model, data, q, v, effort, models, datas, pin.ProximalSettings(1e-13, 1e-13, 1e-8, 30))
    )


def motion(chain: ClosedChain, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """A velocity that the loops allow, whatever drives the robot, and efforts of all joints, shape (nv,) each."""
    random = np.random.default_rng(seed)
    _, size, right = np.linalg.svd(chain.constraint_jacobian(chain.home))
    free = right[int(np.count_nonzero(size > 1e-9 * size[0])) :].T
    return free @ random.normal(size=free.shape[1]), random.normal(size=chain.nv)


@pytest.mark.parametrize("kind", list(CutType))
def test_a_cut_is_held_as_it_is_here_or_refused_by_name(kind: CutType) -> None:
    chain = ClosedChain(two_bodies(kind))
    if kind not in CONTACTS:
        with pytest.raises(InputError, match=re.escape(f"cut 'cut' ({kind})")):
            chain.constraint_models()
        return
    v, effort = motion(chain, 1)
    ours = chain.full_forward_dynamics(chain.home, v, effort).acceleration
    found = theirs(chain, np.array(chain.home.q_full), v, effort)
    np.testing.assert_allclose(found, ours, rtol=0, atol=1e-8 * np.abs(ours).max())
    without = pin.aba(chain.model, chain.model.createData(), np.array(chain.home.q_full), v, effort)
    assert np.abs(without - ours).max() > 1e-2 * np.abs(ours).max()  # the loops do something


@pytest.mark.slow
@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_robots_move_alike(name: str) -> None:
    chain = cutjoint.load(name)
    v, effort = motion(chain, 2)
    ours = chain.full_forward_dynamics(chain.home, v, effort).acceleration
    found = theirs(chain, np.array(chain.home.q_full), v, effort)
    np.testing.assert_allclose(found, ours, rtol=0, atol=1e-9 * np.abs(ours).max())


def test_a_coupling_is_refused_by_name() -> None:
    plain = cutjoint.load("fivebar").description
    gear = Coupling.geared("gear", "right_shoulder", "left_shoulder", -1.0, 0.0)
    described = replace(plain, couplings=(gear,))
    with pytest.raises(InputError, match="coupling 'gear'"):
        constraint_models(build_model(described), described, 1.0)


def test_a_robot_far_from_the_origin_has_its_constraints_in_the_world() -> None:
    far = np.array([300.0, -200.0, 50.0])
    at_base = np.array(FRAME_A)
    at_base[:3, 3] += far
    plain = two_bodies("spherical")
    hung = replace(
        plain,
        links=plain.links[:2],
        joints=plain.joints[:1],
        cuts=(replace(plain.cuts[0], a=Frame("base", at_base), b=Frame("one", FRAME_B)),),
        homes=(Home("default", {}, {"f1": (*far, 0.1, 0.2, 0.3)}),),
    )
    chain = ClosedChain(hung)
    assert np.linalg.norm(chain.origin) > 100.0
    v, effort = motion(chain, 3)
    ours = chain.full_forward_dynamics(chain.home, v, effort).acceleration
    found = theirs(chain, np.array(chain.home.q_full), v, effort)
    np.testing.assert_allclose(found, ours, rtol=0, atol=1e-7 * np.abs(ours).max())
    (model,) = chain.constraint_models()
    np.testing.assert_array_equal(model.joint1_placement.translation, at_base[:3, 3])


def test_workspaces_are_of_constraint_models_alone() -> None:
    with pytest.raises(InputError, match="found 7"):
        cutjoint.load("fivebar").constraint_datas([7])


def test_what_is_handed_out_is_the_callers_own() -> None:
    chain = cutjoint.load("fivebar")
    v, effort = motion(chain, 4)
    before = chain.full_forward_dynamics(chain.home, v, effort).acceleration
    for one in chain.constraint_models():
        one.joint1_placement = pin.SE3.Random()
        one.setBaumgarteCorrectorParameters(pin.BaumgarteCorrectorParameters(1e3, 1e2))
    assert np.array_equal(chain.full_forward_dynamics(chain.home, v, effort).acceleration, before)
    assert chain.constraint_models()[0].m_baumgarte_parameters.Kp == 0.0
    with pytest.raises(ValueError, match="read-only"):
        chain.actuation[0, 0] = 7.0


def test_the_actuation_matrix_is_what_efforts_do() -> None:
    chain = cutjoint.load("stewart")
    effort = np.arange(1.0, 7.0)
    assert np.array_equal(chain.actuation @ effort, chain.full_effort(effort))
    assert chain.actuation.shape == (chain.nv, chain.n)


def test_rows_are_open_by_what_the_gap_says() -> None:
    chain, step = cutjoint.load("fivebar"), 1e-6
    q, random = np.array(chain.home.q_full), np.random.default_rng(5).normal(size=chain.nv)
    opened = chain.constraint_residual(chain.integrate(q, step * random))
    np.testing.assert_allclose(opened, step * chain.constraint_jacobian(q) @ random, atol=1e-11)
    assert max(chain.gap(q)) < 1e-12 < 1e-8 < np.abs(opened).max()


# ---- shapes ----------------------------------------------------------------------------------------------------------


def with_collisions(shape: Shape) -> ClosedChain:
    """A five-bar with one collision shape on every link."""
    plain = cutjoint.load("fivebar").description
    links = tuple(Link(one.name, one.inertial, one.visuals, (shape,)) for one in plain.links)
    return ClosedChain(replace(plain, links=links))


def test_bodies_that_a_joint_or_a_cut_joins_are_no_pair() -> None:
    chain = with_collisions(Shape("sphere", (0.03,)))
    shapes = chain.collision_model()
    names = [one.name.rpartition("_")[0] for one in shapes.geometryObjects]
    pairs = {frozenset((names[pair.first], names[pair.second])) for pair in shapes.collisionPairs}
    # tool is fixed to left_distal; the cut joins that to right_distal
    assert pairs == {
        frozenset(pair)
        for pair in (
            ("base", "left_distal"),
            ("base", "tool"),
            ("base", "right_distal"),
            ("left_proximal", "right_proximal"),
            ("left_proximal", "right_distal"),
            ("left_distal", "right_proximal"),
            ("tool", "right_proximal"),
        )
    }


def test_what_touches_is_found() -> None:
    chain = with_collisions(Shape("sphere", (0.03,)))
    shapes = chain.collision_model()
    q, data = np.array(chain.home.q_full), chain.model.createData()
    assert not pin.computeCollisions(chain.model, data, shapes, pin.GeometryData(shapes), q, False)
    wide = with_collisions(Shape("sphere", (0.12,)))
    shapes = wide.collision_model()
    assert pin.computeCollisions(wide.model, data, shapes, pin.GeometryData(shapes), q, False)


def test_shapes_are_where_the_links_are() -> None:
    chain = cutjoint.load("fivebar")
    shapes = chain.visual_model()
    placed = pin.GeometryData(shapes)
    pin.updateGeometryPlacements(chain.model, chain.model.createData(), shapes, placed, np.array(chain.home.q_full))
    assert shapes.ngeoms == sum(len(link.visuals) for link in chain.description.links)
    there, count = chain.link_placements(chain.home), 0
    for link in chain.description.links:
        for number, shape in enumerate(link.visuals):
            one = shapes.getGeometryId(f"{link.name}_{number}")
            found = placed.oMg[one].homogeneous
            np.testing.assert_allclose(found, there[link.name] @ shape.placement, atol=1e-12)
            np.testing.assert_array_equal(shapes.geometryObjects[one].meshColor, shape.colour)
            count += 1
    assert count == shapes.ngeoms


TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


@pytest.mark.slow
def test_a_mesh_has_its_triangles_and_its_scale(tmp_path: Path) -> None:
    file = tmp_path / "part.obj"
    file.write_text(TETRAHEDRON)
    chain = with_collisions(Shape("mesh", (0.1, 0.2, 0.3), mesh=file))
    one = chain.collision_model().geometryObjects[0]
    assert one.geometry.num_tris == 4
    corners = np.array([one.geometry.vertex(k) for k in range(one.geometry.num_vertices)])
    np.testing.assert_allclose(np.sort(corners.max(axis=0)), [0.1, 0.2, 0.3])
    assert one.meshPath == str(file)
    np.testing.assert_allclose(one.meshScale, [0.1, 0.2, 0.3])


def test_a_mesh_that_is_not_there_is_named(tmp_path: Path) -> None:
    chain = with_collisions(Shape("mesh", (1.0, 1.0, 1.0), mesh=tmp_path / "lost.stl"))
    with pytest.raises(InputError, match=r"lost\.stl"):
        chain.collision_model()


# ---- what Pinocchio does wrong, so that the documents may say so -----------------------------------------------------


def derivative_error(name: str) -> float:
    """How wrong Pinocchio's derivative of the acceleration by the configuration is, relative."""
    chain, step = cutjoint.load(name), 1e-6
    model, data, models = chain.model, chain.model.createData(), chain.constraint_models()
    datas, settings = chain.constraint_datas(models), pin.ProximalSettings(1e-14, 1e-14, 1e-8, 30)
    pin.initConstraintDynamics(model, data, models, datas)
    (v, effort), q = motion(chain, 6), np.array(chain.home.q_full)

    def at(change: np.ndarray) -> np.ndarray:
        moved = pin.integrate(model, q, change)
        return np.array(pin.constraintDynamics(model, data, moved, v, effort, models, datas, settings))

    wanted = np.column_stack([(at(step * one) - at(-step * one)) / (2 * step) for one in np.eye(chain.nv)])
    at(np.zeros(chain.nv))
    pin.computeConstraintDynamicsDerivatives(model, data, models, datas, settings)
    return float(np.abs(data.ddq_dq - wanted).max() / np.abs(wanted).max())


def test_derivatives_of_contacts_with_three_rows_are_wrong_in_pinocchio() -> None:
    """Where this fails Pinocchio was mended: docs/neighbours.md and the example for crocoddyl may take them then."""
    assert derivative_error("fivebar") > 0.1
    assert derivative_error("cpm") < 1e-3  # six rows: right
