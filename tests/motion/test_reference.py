"""A trajectory through a mechanism: actuator rates are derivatives of the inverse kinematics."""

import gc
import weakref

import numpy as np
import pytest

from cutjoint.errors import InputError, UnreachableError
from cutjoint.motion import Circle, Hold, Lissajous, PointToPoint, Reference
from cutjoint.motion import reference as motion
from cutjoint.papers.cpm import CpmModel
from cutjoint.papers.omega3 import Omega3Model

CASES = {
    "cpm": (CpmModel, Circle([0.425, 0.425, 0.3], 0.175, 0.5 * np.pi)),
    "omega3": (Omega3Model, Lissajous([0.1, 0, 0], [0, 0.06, 0.06], [0, np.pi, 2 * np.pi], [0, 0, -np.pi / 2], 2.0)),
}


@pytest.fixture(params=CASES)
def reference(request):
    model, trajectory = CASES[request.param]
    return Reference(trajectory, model())


@pytest.mark.parametrize("t", [0.0, 0.31, 1.234, 1.9])
def test_rates_are_derivatives_of_the_inverse_kinematics(reference, t):
    h = 1e-5
    before, now, after = (reference.at(t + s) for s in (-h, 0.0, h))
    assert np.allclose((after.q - before.q) / (2 * h), now.v, atol=1e-6, rtol=1e-6)
    assert np.allclose((after.v - before.v) / (2 * h), now.a, atol=1e-5, rtol=1e-6)


@pytest.mark.parametrize("t", [0.0, 0.777, 7.3])
def test_tool_is_where_the_trajectory_says(reference, t):
    now = reference.at(t)
    tool = reference.mechanism.tool(now.posture, now.v)
    assert np.allclose(tool.position, now.tool.position, atol=1e-12)
    assert np.allclose(tool.jacobian @ now.v, now.tool.velocity, atol=1e-12)
    assert np.allclose(tool.jacobian @ now.a + tool.drift, now.tool.acceleration, atol=1e-10)


def test_it_has_no_memory(reference):
    times = [0.1, 1.7, 0.4, 1.2]
    forwards = [reference.at(t).q for t in times]
    backwards = [reference.at(t).q for t in reversed(times)]
    assert all(np.array_equal(a, b) for a, b in zip(forwards, reversed(backwards), strict=True))


def test_it_remembers_the_last_instants_and_no_more(reference, monkeypatch):
    """What it remembers is handed out again; what fell out is made anew, with the same bits."""
    monkeypatch.setattr(motion, "MEMORY", 50)
    times = [float(t) for t in np.linspace(0.0, 1.9, 120)]
    first = [reference.at(t) for t in times]
    assert [reference.at(t) is one for t, one in zip(times[-50:], first[-50:], strict=True)] == [True] * 50
    again = [reference.at(t) for t in times[:70]]
    assert not any(one is other for one, other in zip(again, first, strict=False))
    assert all(np.array_equal(one.a, other.a) for one, other in zip(again, first, strict=False))


def test_a_run_of_any_length_takes_a_bounded_memory(reference, monkeypatch):
    monkeypatch.setattr(motion, "MEMORY", 50)
    kept = [weakref.ref(reference.at(float(t))) for t in np.linspace(0.0, 1.9, 400)]
    gc.collect()
    assert sum(one() is not None for one in kept) == 50


def test_leaving_the_workspace_is_found_before_anything_moves():
    way = PointToPoint([0.6, 0.425, 0.3], [1.4, 0.425, 0.3], 2.0)
    with pytest.raises(UnreachableError, match=r"leaves the workspace of .* at t = 0\.7\d+ s, tool at \(") as caught:
        Reference(way, CpmModel())
    # Limb 3 ends its reach of 0.873 m at x = 0.784 m; the first anchor after that is named.
    assert 0.78 < caught.value.target[0] < 0.8
    Reference(way, CpmModel(), duration=0.5)


@pytest.mark.parametrize("duration", [0.0, -1.0, np.nan, np.inf, "long"])
def test_duration_must_be_positive(duration):
    with pytest.raises(InputError, match="duration"):
        Reference(Hold([0.6, 0.425, 0.3]), CpmModel(), duration)


def test_desired_posture_of_another_model_is_closed_by_it():
    one, other = CpmModel(), CpmModel()
    now = Reference(Hold([0.6, 0.425, 0.3]), one).at(0.0)
    assert now.posture_of(one) is now.posture
    assert now.posture_of(other) is not now.posture
    assert np.array_equal(now.posture_of(other).q_full, now.posture.q_full)
