"""Near singularities: the compiled robot says what the model says, a number or an error, and nothing in between."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from cutjoint.chain import ClosedChain
from cutjoint.compile import compiled
from cutjoint.compile.pivots import Plan
from cutjoint.compile.reduction import STRAIN_LIMIT
from cutjoint.description import load_description
from cutjoint.description.catalogue import path
from cutjoint.errors import ClosureError, CutjointError, InputError, LimbReachError, SingularError, UnreachableError
from cutjoint.mechanism import Posture


def outcome(call: Any) -> Any:
    """What a call gives: a value, or the class of its error."""
    try:
        return call()
    except CutjointError as error:
        return type(error)


def towards(model: Any, direction: np.ndarray, count: int) -> list[Posture]:
    """Postures ever nearer to where the model cannot go on in a direction of its actuators, found by halving steps."""
    found = [model.home]
    step = 0.2
    while len(found) < count and step > 1e-13:
        try:
            found.append(model.close(found[-1].q + step * direction, found[-1]))
        except CutjointError:
            step /= 3.0
    return found


@pytest.mark.parametrize(
    ("name", "direction"),
    [("fivebar", [0.4, -1.0]), ("fivebar", [1.0, -1.0]), ("cpm", [0.0, 1.0, 0.3]), ("cpm", [-1.0, -0.4, 0.2])],
)
def test_on_the_way_to_a_singularity(kit: Any, name: str, direction: list[float]) -> None:
    model, machine = kit.model(name), kit.machine(name)
    rng = np.random.default_rng(0)
    strains = []
    for at in towards(model, np.array(direction), 60):
        v, x = rng.normal(size=model.n), rng.normal(size=model.n)
        strains.append(machine.kernel("forward")(at.q_full, v, x, np.zeros(0))[-1])
        for call in ("forward_dynamics", "inverse_dynamics"):
            wanted = outcome(lambda call=call, at=at, v=v, x=x: getattr(model, call)(at, v, x))
            found = outcome(lambda call=call, at=at, v=v, x=x: getattr(machine, call)(at, v, x))
            if isinstance(wanted, type):
                assert found is wanted
            else:
                size = max(1.0, np.abs(wanted).max())
                # half of the digits are gone where the model itself is at its limit
                np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-6 * size)
    assert max(strains) > STRAIN_LIMIT, "the way must lead beyond what is compiled for"


def test_limbs_of_a_published_model_that_do_not_reach(kit: Any) -> None:
    machine = kit.machine("paper cpm")
    zero = np.zeros(3)
    with pytest.raises(LimbReachError):
        machine.close([5.0, 0.4, 0.3])
    with pytest.raises(LimbReachError) as caught:
        machine.batch.forward_dynamics([[0.4, 0.4, 0.3], [5.0, 0.4, 0.3]], zero, zero)
    assert "row 1" in "".join(caught.value.__notes__)
    with pytest.raises(InputError):
        machine.batch.reach([[0.4, 0.4, 0.3], [0.4, np.nan, 0.3]])
    with pytest.raises(InputError):
        machine.batch.inverse_dynamics([[0.4, np.nan, 0.3]], zero, zero)
    with pytest.raises(UnreachableError):
        kit.machine("paper omega3").batch.reach([[0.1, 0.0, 0.0], [9.0, 0.0, 0.0]])


def test_batches_raise_what_the_chain_raises(kit: Any) -> None:
    machine = kit.machine("fivebar")
    with pytest.raises(ClosureError) as caught:
        machine.batch.close(np.stack([machine.home.q, machine.home.q + np.array([1.0, -1.0])]))
    assert "row 1" in "".join(caught.value.__notes__)


def test_rows_beyond_the_limit_are_done_by_the_model(kit: Any) -> None:
    model, machine = kit.model("fivebar"), kit.machine("fivebar")
    way = towards(model, np.array([1.0, -1.0]), 60)
    strained = [at for at in way if not machine.kernel("terms")(at.q_full, [0, 0], np.zeros(0))[-1] <= STRAIN_LIMIT]
    good = [at for at in strained if not isinstance(outcome(lambda at=at: model.terms(at)), type)]
    assert good
    mass, _, gravity = machine.batch.terms(np.stack([good[0].q_full, model.home.q_full]))
    np.testing.assert_array_equal(mass[0], model.terms(good[0]).mass)
    np.testing.assert_array_equal(gravity[0], model.terms(good[0]).gravity)
    np.testing.assert_allclose(mass[1], model.terms(model.home).mass, rtol=1e-12)


def test_derivatives_too_near_to_a_singularity_are_refused(kit: Any) -> None:
    model, machine = kit.model("fivebar"), kit.machine("fivebar")
    at = towards(model, np.array([1.0, -1.0]), 60)[-1]
    with pytest.raises(SingularError):
        machine.forward_derivatives(at, np.zeros(2), np.zeros(2))


def test_a_bad_order_of_elimination_is_noticed_and_does_no_harm() -> None:
    """A pivot that is good at home and vanishes in the middle of the workspace, away from any singularity."""
    chain = ClosedChain(load_description(path("fivebar")))
    machine = compiled(chain, cached=False)
    plan: Plan = machine.source.plan
    jacobian = chain.constraint_jacobian(chain.home.q_full)
    others = [row for row in range(len(jacobian)) if np.abs(jacobian[row]).max() > 0.1]
    swapped = tuple(reversed([rate for _, rate in plan.pivots]))
    bad = replace(plan, pivots=tuple(zip(others, swapped, strict=True)))
    machine.source.__dict__["plan"] = bad
    rng = np.random.default_rng(0)
    strains = []
    for _ in range(300):
        q = chain.home.q + rng.uniform(-0.6, 0.6, 2)
        at = outcome(lambda q=q: chain.close(q))
        if isinstance(at, type):
            continue
        v, x = rng.normal(size=2), rng.normal(size=2)
        wanted = chain.forward_dynamics(at, v, x)
        found = machine.forward_dynamics(at, v, x)
        strains.append(machine.kernel("forward")(at.q_full, v, x, np.zeros(0))[-1])
        np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-9 * max(1.0, np.abs(wanted).max()))
    assert max(strains) > 20.0 * min(strains), "the order must be bad somewhere for this test to mean anything"
