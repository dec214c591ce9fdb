"""Working modes: all closed postures that hold the tool in one pose.

With the tool's pose prescribed the limbs fall apart into independent pieces, each with a few discrete solutions (elbow
up or down).  They are searched from random starts within the joint limits (Levenberg-Marquardt), and what was found for
one limb is combined with what was found for the others.  Solutions beyond a joint limit are not modes of the robot and
are left out.  The search proves what it finds, not that nothing else exists.
"""

from __future__ import annotations

from itertools import product

import numpy as np
import pinocchio as pin

from cutjoint.arrays import Array
from cutjoint.chain.assembly import Assembler, PoseDriver
from cutjoint.chain.kinematics import Kinematics, Placed
from cutjoint.chain.rank import null_space

SAME = 1e-6


def working_modes(kinematics: Kinematics, assembler: Assembler, q: Array, starts: int, seed: int) -> list[Array]:
    """Configurations (nq,) that hold the tool where `q` holds it; `q` first, then by distance from it."""
    pose = kinematics.at(q).tool
    driver = PoseDriver(pose, pose)
    limbs = independent_parts(kinematics, q)
    random = np.random.default_rng(seed)
    found = [q]
    for _ in range(starts):
        guess = _random_start(kinematics.model, q, random)
        closed = assembler.assemble(guess, driver)
        if closed is not None:
            _add(kinematics, found, closed)
    if len(limbs) > 1:
        _combine(kinematics, assembler, driver, found, limbs)
    return [found[0], *sorted(found[1:], key=lambda other: float(np.linalg.norm(_wrapped(other - q))))]


def independent_parts(kinematics: Kinematics, q: Array) -> list[list[int]]:
    """Groups of joints that the loops couple while the tool's body is held still."""
    k = kinematics
    placed = k.at(q)
    free = null_space(placed.tool_jacobian * k.column_scale)
    label = np.arange(k.model.nv)
    assert k.tool_support is not None
    for chain in [k.tool_support, *_loops(k, placed, free)]:
        members = np.flatnonzero(chain)
        if len(members):
            label[np.isin(label, label[members])] = label[members[0]]
    parts: dict[int, list[int]] = {}
    for joint in range(1, k.model.njoints):
        parts.setdefault(int(label[k.model.idx_vs[joint]]), []).append(joint)
    return list(parts.values())


def _loops(kinematics: Kinematics, placed: Placed, free: Array) -> list[Array]:
    """Velocities that each cut or coupling ties together, shape (nv,) of flags; a side whose body is held ties none."""
    k = kinematics
    twist = placed.twists * k.column_scale
    loops: list[Array] = []
    for cut in k.closure.cuts:
        sides = [
            side for side in (cut.support_a, cut.support_b) if np.abs((twist * side) @ free).max(initial=0.0) > 1e-9
        ]
        loops.append(np.sum(sides, axis=0) > 0.0 if sides else np.zeros(k.model.nv, dtype=bool))
    for ratio in k.closure.ratios:
        flags = np.zeros(k.model.nv, dtype=bool)
        flags[[ratio.v_joint, ratio.v_driver]] = True
        loops.append(flags)
    return loops


def _random_start(model: pin.Model, q: Array, random: np.random.Generator) -> Array:
    """`q` with every revolute joint anywhere within its limits."""
    guess = q.copy()
    for index in _angles(model):
        lower, upper = max(model.lowerPositionLimit[index], -np.pi), min(model.upperPositionLimit[index], np.pi)
        guess[index] = random.uniform(lower, upper) if lower < upper else q[index]
    return guess


def _angles(model: pin.Model) -> list[int]:
    """Indices in q of the joints that turn about one axis."""
    return [
        model.idx_qs[joint]
        for joint in range(1, model.njoints)
        if model.nqs[joint] == 1 and not model.joints[joint].shortname().startswith("JointModelP")
    ]


def _add(kinematics: Kinematics, found: list[Array], q: Array) -> None:
    """Keep `q`, its angles turned as near to those of the first solution as the limits allow, unless a limit forbids
    it or it is already there."""
    model, first = kinematics.model, found[0]
    q = q.copy()
    for index in _angles(model):
        q[index] = first[index] + _wrapped(q[index] - first[index])
        if not model.lowerPositionLimit[index] <= q[index] <= model.upperPositionLimit[index]:
            q[index] += 2.0 * np.pi if q[index] < model.lowerPositionLimit[index] else -2.0 * np.pi
    inside = (q >= model.lowerPositionLimit - SAME) & (q <= model.upperPositionLimit + SAME)
    bounded = model.upperPositionLimit > model.lowerPositionLimit
    if (inside | ~bounded).all() and all(np.abs(_wrapped(q - other)).max() > SAME for other in found):
        found.append(q)


def _combine(
    kinematics: Kinematics, assembler: Assembler, driver: PoseDriver, found: list[Array], parts: list[list[int]]
) -> None:
    model = kinematics.model
    choices: list[list[Array]] = []
    for part in parts:
        index = np.concatenate([np.arange(model.idx_qs[j], model.idx_qs[j] + model.nqs[j]) for j in part])
        distinct: list[Array] = []
        for q in found:
            if all(np.abs(_wrapped(q[index] - other[index])).max() > SAME for other in distinct):
                distinct.append(q)
        choices.append(distinct)
    for pick in product(*choices):
        q = found[0].copy()
        for part, source in zip(parts, pick, strict=True):
            for joint in part:
                where = slice(model.idx_qs[joint], model.idx_qs[joint] + model.nqs[joint])
                q[where] = source[where]
        closed = assembler.assemble(q, driver)
        if closed is not None:
            _add(kinematics, found, closed)


def _wrapped(difference: Array) -> Array:
    return np.asarray((difference + np.pi) % (2.0 * np.pi) - np.pi)
