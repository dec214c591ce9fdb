"""A plan, written, read by both sides: the chain and the oracle of the same files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from kit.blueprint import Blueprint
from kit.by_joint import oracle_of
from kit.physics import Rng, with_sized_physics
from kit.writing import Mounting
from oracles.maximal import Maximal
from oracles.physics import laws_of

from cutjoint.chain import ClosedChain
from cutjoint.description import load_description


def built(
    plan: Blueprint, folder: Path, mounting: Mounting | None = None, scale: float = 1.0, density: float = 1.0
) -> tuple[ClosedChain, Maximal]:
    """The chain of a plan at a mounting, lengths times `scale` and masses times `density`, and its oracle."""
    path = plan.write(folder, mounting, scale, density)
    chain = ClosedChain(load_description(path))
    return chain, oracle_of(chain, path, None if mounting is None else mounting.xyz)


def built_with_physics(
    plan: Blueprint,
    folder: Path,
    rng: Rng,
    mounting: Mounting | None = None,
    scale: float = 1.0,
    density: float = 1.0,
    rubber: tuple[str, ...] = (),
) -> tuple[ClosedChain, Maximal]:
    """The chain of a plan with physics everywhere, and its oracle; cuts named in `rubber` are bushings."""
    path = plan.write(folder, mounting, scale, density)
    length, weight = 0.3 * scale, 9.81 * density
    description = with_sized_physics(load_description(path), rng, length, weight, rubber)
    chain = ClosedChain(description)
    laws, bushings = laws_of(description)
    origin = None if mounting is None else mounting.xyz
    return chain, Maximal(path, length=chain.length, origin=origin, laws=laws, bushings=bushings)


def at_home(plan: Blueprint, oracle: Maximal) -> dict[str, object]:
    """Home of a plan as the oracle's coordinates."""
    from oracles.reading import rpy_rotation

    found: dict[str, object] = {}
    for joint in plan.joints:
        value: object = joint.start
        if joint.kind == "spherical":
            value = rpy_rotation(joint.start)
        elif joint.kind == "floating":
            value = np.eye(4)
            value[:3, :3], value[:3, 3] = rpy_rotation(joint.start[3:]), joint.start[:3]
        found[joint.name] = np.array(value) if np.ndim(value) else value
    return found


def choose_actuators(plan: Blueprint, folder: Path) -> None:
    """As many actuators as the plan's mobility at home where its joints of one coordinate allow it: the joints that
    tell its motions apart best."""
    plan.actuators = []
    oracle = Maximal(plan.write(folder))
    placed = oracle.at(at_home(plan, oracle))
    names, rows = plan.scalars, placed.joint_motions() / placed._velocity_scale[:, None]
    rows = np.array([rows[oracle.velocity[name]][0] for name in names]).reshape(len(names), placed.mobility)
    while len(plan.actuators) < placed.mobility and len(names):
        sizes = np.linalg.norm(rows, axis=1)
        best = int(np.argmax(sizes))
        if sizes[best] < 0.02 * max(float(sizes.max()), 1.0):
            break
        plan.actuators.append(names[best])
        direction = rows[best] / sizes[best]
        rows = rows - np.outer(rows @ direction, direction)
