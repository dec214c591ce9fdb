"""Random MJCF against MuJoCo: where bodies are, how they accelerate, and what MuJoCo saves of it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest
from kit.described import differences
from kit.mjcf import Random, accelerations, jacobian, random_model
from kit.quickly import few

from cutjoint import ClosedChain
from cutjoint.description import JointType, load_description, read_checked, write
from cutjoint.description.formats.mjcf.types import TENDON
from cutjoint.errors import ClosureError, InputError


def compiled(path: Path):
    model = mujoco.MjModel.from_xml_path(str(path))
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
    return model, mujoco.MjData(model)


def turned(chain: ClosedChain, q: np.ndarray, v: np.ndarray, rate: np.ndarray | None = None) -> np.ndarray:
    """Velocities of the chain as MuJoCo has them, or accelerations `rate`: those of free bodies in the world's axes."""
    joints, found = {joint.name: joint for joint in chain.description.joints}, []
    for index in range(1, chain.model.njoints):
        joint, at = joints[chain.model.names[index]], chain.model.idx_vs[index]
        part = slice(at, at + chain.model.nvs[index])
        if joint.child.startswith(TENDON):
            continue
        own = np.array(v[part] if rate is None else rate[part])
        if joint.type is JointType.FLOATING:
            x, y, z, w = q[chain.model.idx_qs[index] + 3 : chain.model.idx_qs[index] + 7]
            matrix = np.zeros(9)
            mujoco.mju_quat2Mat(matrix, np.array([w, x, y, z]))
            spun = np.zeros(3) if rate is None else np.cross(v[at + 3 : at + 6], v[at : at + 3])
            own[:3] = matrix.reshape(3, 3) @ (own[:3] + spun)
        found.append(own)
    return np.concatenate(found)


@pytest.mark.parametrize("seed", few(range(400), 0, 1, 2))
def test_a_qpos_goes_in_and_out(seed: int, tmp_path: Path) -> None:
    """Unchanged, and every body is where MuJoCo has it."""
    rng = np.random.default_rng(seed)
    path = tmp_path / "model.xml"
    path.write_text(random_model(rng, ties=False).text, encoding="utf-8")
    chain = ClosedChain(load_description(path))
    model, data = compiled(path)
    for _ in range(3):
        mujoco.mj_integratePos(model, data.qpos, rng.normal(size=model.nv), 1.0)
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        q = chain.from_mujoco(data.qpos)
        np.testing.assert_allclose(chain.to_mujoco(q), data.qpos, rtol=0.0, atol=2e-15)
        placements = chain.link_placements(q)
        for body in range(1, model.nbody):
            found = placements[mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_BODY, body)]
            np.testing.assert_allclose(found[:3, 3], data.xpos[body], rtol=0.0, atol=1e-13)
            np.testing.assert_allclose(found[:3, :3], data.xmat[body].reshape(3, 3), rtol=0.0, atol=1e-13)


@pytest.mark.parametrize("seed", few(range(400), 0, 4, 7))
def test_accelerations_are_those_of_mujocos_matrices(seed: int, tmp_path: Path) -> None:
    """And as many rows of its constraints are independent, and none of them is violated where ours are not."""
    rng = np.random.default_rng(seed)
    path = tmp_path / "model.xml"
    path.write_text(random_model(rng).text, encoding="utf-8")
    robot = load_description(path)
    try:
        chain = ClosedChain(robot)
        away = chain.integrate(chain.home.q_full, 0.2 * rng.normal(size=chain.nv))
        q = chain.assemble(away, keep_actuators=False).q_full
    except ClosureError:
        pytest.skip("these equalities cannot all be met")
    model, data = compiled(path)
    rows, v = chain.constraint_jacobian(q), rng.normal(size=chain.nv)
    rank = int(np.linalg.matrix_rank(rows, 1e-7)) if len(rows) else 0
    free = np.linalg.svd(rows)[2][rank:] if len(rows) else np.eye(chain.nv)
    v = free.T @ (free @ v)
    qpos, qvel = chain.to_mujoco(q), turned(chain, q, v)
    wanted = accelerations(model, data, qpos, qvel, np.zeros(model.nv))
    found = turned(chain, q, v, chain.full_acceleration(q, v, np.zeros(chain.nv)))
    np.testing.assert_allclose(found, wanted, rtol=0.0, atol=1e-8 * max(1.0, np.abs(wanted).max()))
    data.qpos[:], data.qvel[:] = qpos, qvel
    mujoco.mj_forward(model, data)
    theirs = jacobian(model, data)
    tendons = sum(link.name.startswith(TENDON) for link in robot.links)
    assert rank - tendons == (np.linalg.matrix_rank(theirs, 1e-7) if len(theirs) else 0)
    assert np.abs(data.efc_pos[: len(theirs)]).max(initial=0.0) < 1e-9
    assert np.abs(theirs @ qvel).max(initial=0.0) < 1e-9


def motors(model: Random) -> str:
    """The model with a motor of a tendon of its own, where it has two joints for one."""
    if len(model.single) < 2:
        return model.text
    terms = "".join(
        f'<joint joint="{one}" coef="{coef}"/>' for one, coef in zip(model.single, (2.0, -0.3), strict=False)
    )
    pull = f'<fixed name="pull" range="-1 2">{terms}</fixed></tendon><'
    text = model.text.replace("</tendon><", pull)
    return text.replace("</actuator>", '<motor tendon="pull" forcerange="-3 3"/></actuator>')


@pytest.mark.parametrize("seed", few(range(100), 1))
def test_what_is_written_is_the_same_robot(seed: int, tmp_path: Path) -> None:
    """Tendons and all, and to MuJoCo too: a qpos of the written file puts every body where it is."""
    rng = np.random.default_rng(seed)
    path = tmp_path / "model.xml"
    path.write_text(motors(random_model(rng)), encoding="utf-8")
    robot = load_description(path)
    (written,) = write(robot, tmp_path / "written.xml", to="mjcf")
    again = load_description(written)
    assert differences(robot, again) == []
    assert not any("moves nothing" in one.found for one in read_checked(written).problems)
    model, data = compiled(written)
    mujoco.mj_integratePos(model, data.qpos, rng.normal(size=model.nv), 1.0)
    mujoco.mj_kinematics(model, data)
    tree = replace(again, couplings=tuple(one for one in again.couplings if one.name.endswith("_length")), cuts=())
    chain = ClosedChain(replace(tree, actuators=(), homes=()))
    placements = chain.link_placements(chain.from_mujoco(data.qpos))
    for body in range(1, model.nbody):
        found = placements[mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_BODY, body)]
        np.testing.assert_allclose(found[:3, 3], data.xpos[body], rtol=0.0, atol=1e-13)


@pytest.mark.parametrize("seed", few(range(100), 0))
def test_what_mujoco_saves_is_the_same_robot(seed: int, tmp_path: Path) -> None:
    path, again = tmp_path / "model.xml", tmp_path / "saved.xml"
    path.write_text(random_model(np.random.default_rng(seed)).text, encoding="utf-8")
    spec = mujoco.MjSpec.from_file(str(path))
    spec.compile()
    again.write_text(spec.to_xml(), encoding="utf-8")
    robot, saved = load_description(path), load_description(again)
    assert [(one.name, one.type) for one in saved.joints] == [(one.name, one.type) for one in robot.joints]
    for one, other in zip(robot.joints, saved.joints, strict=True):
        np.testing.assert_allclose(other.placement, one.placement, atol=1e-5)
    for one, other in zip(robot.links, saved.links, strict=True):
        assert (one.inertial is None) == (other.inertial is None)
        if one.inertial is not None and other.inertial is not None:
            assert other.inertial.mass == pytest.approx(one.inertial.mass, rel=1e-5)
            np.testing.assert_allclose(other.inertial.inertia, one.inertial.inertia, atol=1e-5 * one.inertial.mass)
    assert [(one.name, one.type) for one in saved.cuts] == [(one.name, one.type) for one in robot.cuts]
    assert [one.joint for one in saved.couplings] == [one.joint for one in robot.couplings]


def test_a_qpos_that_cannot_be_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "model.xml"
    body = '<body><joint name="s" type="slide"/><joint name="b" type="ball"/><geom size="1"/></body>'
    path.write_text(f"<mujoco><worldbody>{body}</worldbody></mujoco>", encoding="utf-8")
    chain = ClosedChain(load_description(path))
    np.testing.assert_allclose(chain.from_mujoco([0.5, 3.0, 0.0, 4.0, 0.0])[1:], [0.0, 0.8, 0.0, 0.6], atol=1e-15)
    for qpos in ([0.5, 1.0, 0.0, 0.0], [0.5, np.nan, 0.0, 0.0, 1.0], [0.5, 0.0, 0.0, 0.0, 0.0], "x"):
        with pytest.raises(InputError, match="qpos"):
            chain.from_mujoco(qpos)


def test_a_model_without_keyframes_starts_as_it_is_written(tmp_path: Path) -> None:
    path = tmp_path / "model.xml"
    free = '<body name="f" pos="1 2 3" euler="0 0 90"><freejoint/><geom size="1"/></body>'
    hinge = '<body name="h"><joint name="j" ref="30"/><geom size="1" pos="1 0 0"/></body>'
    path.write_text(f"<mujoco><worldbody>{free}{hinge}</worldbody></mujoco>", encoding="utf-8")
    assert read_checked(path).problems == ()
    chain = ClosedChain(load_description(path))
    model, _ = compiled(path)
    np.testing.assert_allclose(chain.to_mujoco(chain.home), model.qpos0, atol=1e-15)
    placed = chain.link_placements(chain.home)
    np.testing.assert_allclose(placed["f"][:3, 3], [1.0, 2.0, 3.0], atol=1e-15)
    np.testing.assert_allclose(placed["h"], np.eye(4), atol=1e-15)
