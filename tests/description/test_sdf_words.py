"""One mechanism in the many words of SDF is the same robot as its tree with cuts in a loops.toml."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from kit.by_joint import by_joint
from kit.in_sdf import Sdf, as_description, random_mechanism

from cutjoint.chain import ClosedChain
from cutjoint.description import RobotDescription, load_description
from cutjoint.description.formats import write


def both(seed: int, folder: Path) -> tuple[ClosedChain, ClosedChain, dict[str, str]]:
    """The mechanism from its loops.toml, from its SDF, and what the joints are called there."""
    rng = np.random.default_rng(seed)
    made = random_mechanism(rng)
    write(as_description(made), folder / "plain")
    sdf = Sdf(made, rng, folder, old=seed % 4 == 3)
    path = sdf.write()
    return ClosedChain(load_description(folder / "plain")), ClosedChain(load_description(path)), sdf.names


def carried(one: ClosedChain, vector: np.ndarray, other: ClosedChain, names: dict[str, str], kind: str) -> np.ndarray:
    """A configuration (kind q) or velocity (v) of one chain as that of the other."""
    found = np.zeros(other.model.nq if kind == "q" else other.model.nv)
    for index in range(1, one.model.njoints):
        there = other.model.getJointId(names[one.model.names[index]])
        starts, sizes = (m := one.model, f"idx_{kind}s"), f"n{kind}s"
        size = getattr(m, sizes)[index]
        assert getattr(other.model, sizes)[there] == size
        found[getattr(other.model, starts[1])[there] :][:size] = vector[getattr(m, starts[1])[index] :][:size]
    return found


def moving(description: RobotDescription) -> int:
    return sum(joint.type.dof for joint in description.joints)


def apart(seed: int, folder: Path) -> float:
    """The largest difference of accelerations, as a part of the largest."""
    plain, said, names = both(seed, folder)
    rng = np.random.default_rng(seed + 1)
    assert moving(said.description) == moving(plain.description)
    masses = [sum(link.inertial.mass for link in one.description.links if link.inertial) for one in (plain, said)]
    assert masses[1] == pytest.approx(masses[0], rel=1e-14)
    assert {cut.type for cut in said.description.cuts} == {cut.type for cut in plain.description.cuts}
    v = rng.normal(size=plain.nv)
    q, v = plain.project(plain.home.q_full, v)
    effort = rng.normal(size=plain.nv)
    wanted = plain.full_acceleration(q, v, effort)
    q2, v2, effort2 = (carried(plain, one, said, names, kind) for one, kind in ((q, "q"), (v, "v"), (effort, "v")))
    found = said.full_acceleration(q2, v2, effort2)
    there = by_joint(said, found)
    back = {name: there[names[name]] for name in by_joint(plain, wanted)}
    wanted_by = by_joint(plain, wanted)
    size = max(float(np.abs(wanted).max()), 1e-3)
    return max(float(np.abs(back[name] - wanted_by[name]).max(initial=0.0)) for name in back) / size


def test_a_mechanism_in_other_words(tmp_path: Path) -> None:
    assert apart(0, tmp_path) < 1e-12


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(1, 200))
def test_mechanisms_in_other_words(seed: int, tmp_path: Path) -> None:
    assert apart(seed, tmp_path) < 1e-12
