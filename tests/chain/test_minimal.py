"""Which velocities are independent: who is taken in which order, and what is wrong with those that are named."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest
from kit.built import built
from kit.mechanisms import MECHANISMS
from kit.two_bodies import two_bodies

import cutjoint
from cutjoint.chain import ClosedChain
from cutjoint.errors import ActuationError, InputError, UnknownNameError


def test_what_flies_comes_first_and_motors_only_as_far_as_they_add(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    hexapod = built(MECHANISMS["hexapod"](rng).plan, tmp_path / "h")[0].minimal()
    assert hexapod.joints == ("flight",)
    assert hexapod.names == tuple(f"flight {one}" for one in ("vx", "vy", "vz", "wx", "wy", "wz"))
    assert hexapod.units == ("m", "m", "m", "rad", "rad", "rad")
    assert hexapod.effort_map(hexapod.chain.home).shape == (6, 18)
    assert not hexapod.is_flat
    flying = built(MECHANISMS["floating_fourbar"](rng).plan, tmp_path / "f")[0].minimal()
    assert flying.joints == ("flight", "a1")
    redundant = cutjoint.load("redundant")
    minimal = redundant.minimal()
    assert minimal.n == redundant.mobility().mobility < redundant.n
    assert set(minimal.joints) < {actuator.name for actuator in redundant.actuators}
    own = [k for k, actuator in enumerate(redundant.actuators) if actuator.name in minimal.joints]
    assert np.allclose(minimal.effort_map(redundant.home)[:, own], np.eye(minimal.n))
    again = pickle.loads(pickle.dumps(minimal))
    assert again.joints == minimal.joints


@pytest.mark.parametrize("kind", ["fixed", "revolute", "spherical", "prismatic", "universal"])
def test_two_free_bodies_that_a_cut_joins(kind: str) -> None:
    """The first flies with six velocities; the second has those that the cut leaves, which no whole joint tells unless
    there are none."""
    chain = ClosedChain(two_bodies(kind))
    if kind == "fixed":
        assert chain.minimal().joints == ("f1",)
        return
    with pytest.raises(ActuationError, match="nothing is left to name") as caught:
        chain.minimal()
    assert caught.value.mobility == 6 + {"revolute": 1, "prismatic": 1, "universal": 2, "spherical": 3}[kind]


def test_bad_names_are_told() -> None:
    crane = cutjoint.load("underactuated")
    with pytest.raises(ActuationError, match="each of these could be named: left, load, right") as caught:
        crane.minimal()
    assert (caught.value.mobility, caught.value.actuators) == (2, 1)
    assert {"left", "load", "right"} == set(caught.value.free)
    with pytest.raises(UnknownNameError, match="did you mean 'left'"):
        crane.minimal("lefft")
    with pytest.raises(InputError, match="named twice"):
        crane.minimal(["left", "left"])
    with pytest.raises(InputError, match=r"'cart' counts among the minimal coordinates .* anyway"):
        crane.minimal(["cart"])
    with pytest.raises(ActuationError, match="'right' of underactuated moves as cart, left make it move"):
        crane.minimal(["left", "right"])
    with pytest.raises(ActuationError, match=r"'left_elbow' .* moves as left_shoulder, right_shoulder make it move"):
        cutjoint.load("fivebar").minimal(["left_elbow"])
    minimal = crane.minimal("left")
    with pytest.raises(InputError, match=r"change must have shape \(2,\)"):
        minimal.moved(crane.home, [1.0])
    with pytest.raises(InputError, match=r"effort must have shape \(1,\)"):
        minimal.forward_dynamics(crane.home, np.zeros(2), np.zeros(2))
    with pytest.raises(InputError, match="this posture has"):
        minimal.terms(cutjoint.load("fourbar").home)
