"""The four-bar with dampers, friction, springs and rotors in all hinges, the cut too: Lagrange's equation of its crank
angle, the chain, and the maximal-coordinate oracle."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from kit.quickly import few
from oracles.fourbar import HINGES, FourBar
from oracles.maximal import Maximal
from oracles.physics import Law, laws_of
from oracles.tree import URDF

from cutjoint.chain import ClosedChain
from cutjoint.description import load_description
from cutjoint.mechanism.physics import JointPhysics


def everything(rng: np.random.Generator, rotor: bool) -> JointPhysics:
    """All that a hinge may have, of the size of the four-bar's weights; its friction is full or rising."""
    damping, friction, stiffness, rest, inertia, gear = rng.uniform(0.1, 1.0, 6) * (0.3, 0.5, 2.0, 3.0, 1e-5, 100.0)
    speed = float(rng.choice([0.01, 20.0]))
    return JointPhysics(damping, friction, speed, stiffness, rest, inertia if rotor else 0.0, gear if rotor else 1.0)


def robots(seed: int) -> tuple[ClosedChain, FourBar, Maximal]:
    rng, plain = np.random.default_rng(seed), load_description("fourbar")
    joints = tuple(replace(one, physics=everything(rng, rotor=True)) if one.type.moves else one for one in plain.joints)
    cuts = tuple(replace(one, physics=everything(rng, rotor=False)) for one in plain.cuts)
    description = replace(plain, joints=joints, cuts=cuts)
    laws, _ = laws_of(description)
    bar = FourBar({name: laws[name] for name in HINGES})
    return ClosedChain(description), bar, Maximal(URDF / "fourbar", length=0.2, laws=laws)


def states(rng: np.random.Generator, count: int) -> list[tuple[float, float, float, float]]:
    scales = (1.0, 6.0, 60.0, 3.0)
    return [(float(rng.uniform(1.6, 2.4)), *(scale * rng.normal() for scale in scales[1:])) for _ in range(count)]


@pytest.mark.parametrize("seed", few(range(20), 0, 1))
def test_lagrange_the_chain_and_the_oracle(seed: int) -> None:
    chain, bar, oracle = robots(seed)
    for q, v, a, torque in states(np.random.default_rng(seed + 100), 8):
        at = chain.close([q])
        wanted = bar.inverse_dynamics(q, v, a)
        assert chain.inverse_dynamics(at, [v], [a])[0] == pytest.approx(wanted, rel=1e-10, abs=1e-10)
        assert chain.forward_dynamics(at, [v], [torque])[0] == pytest.approx(
            bar.forward_dynamics(q, v, torque), rel=1e-10, abs=1e-9
        )
        terms, (rotors, _, springs, losses) = chain.terms(at, [v]), bar.physics(q, v)
        assert terms.mass[0, 0] == pytest.approx(bar.terms(q, v)[0] + rotors, rel=1e-11)
        assert terms.springs[0] == pytest.approx(springs, rel=1e-10, abs=1e-11)
        assert terms.friction[0] == pytest.approx(losses, rel=1e-10, abs=1e-11)
        assert chain.potential_energy(at) == pytest.approx(bar.potential_energy(q), rel=1e-11, abs=1e-12)
        state = oracle.at({name: one[0] for name, one in bar.joints(q, v, a).items()}).with_actuators({"crank": v})
        effort, _ = state.led({"crank": a})
        assert effort["crank"] == pytest.approx(wanted, rel=1e-10, abs=1e-10)
        assert state.wasted == pytest.approx(losses * v, rel=1e-10, abs=1e-11)


def test_a_rotor_at_the_cut_of_the_oracles() -> None:
    """What descriptions do not have, both oracles do alike: a rotor between coupler and rocker."""
    laws = {"coupler_to_rocker": Law(armature=0.03)}
    bar, oracle = FourBar(laws), Maximal(URDF / "fourbar", length=0.2, laws=laws)
    for q, v, a, _ in states(np.random.default_rng(3), 8):
        placed = oracle.at({name: one[0] for name, one in bar.joints(q, v, a).items()})
        effort, _ = placed.with_actuators({"crank": v}).led({"crank": a})
        assert effort["crank"] == pytest.approx(bar.inverse_dynamics(q, v, a), rel=1e-10)
        assert abs(effort["crank"] - FourBar().inverse_dynamics(q, v, a)) > 1e-4 * abs(a)


def test_torques_of_springs_are_the_slope_of_their_energy() -> None:
    _, bar, _ = robots(5)
    h = 1e-4
    for q, *_ in states(np.random.default_rng(4), 8):
        energies = [bar.potential_energy(q + step * h) for step in (-2, -1, 1, 2)]
        slope = (energies[0] - 8 * energies[1] + 8 * energies[2] - energies[3]) / (12 * h)
        assert bar.inverse_dynamics(q, 0.0, 0.0) == pytest.approx(slope, abs=1e-9)
