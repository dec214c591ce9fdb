"""Random states and a fine difference quotient for the laws of the published models."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest

from cutjoint.arrays import Array
from cutjoint.papers import cpm, omega3
from cutjoint.papers.cpm import equations as cpm_equations
from cutjoint.papers.omega3 import equations as omega3_equations


def five_point(f: Callable[[float], Array], h: float = 5e-5) -> Array:
    """Derivative of f at 0 by the five-point stencil: an error of h^4, so about ten digits."""
    one = np.asarray(f(h)) - np.asarray(f(-h))
    two = np.asarray(f(2 * h)) - np.asarray(f(-2 * h))
    return (8.0 * one - two) / (12.0 * h)


@pytest.fixture
def slope() -> Callable[..., Array]:
    """`slope(f)`: derivative of f(s) at s = 0, f any function of a number that gives an array."""
    return five_point


@pytest.fixture
def rng() -> np.random.Generator:
    """Random numbers, the same in every run."""
    return np.random.default_rng(20080401)


def _cpm_tools(rng: np.random.Generator, p: cpm.Parameters, count: int) -> Array:
    """Tool positions (count, 3) that all limbs reach, well away from their limits."""
    found: list[Array] = []
    while len(found) < count:
        tool = rng.uniform((0.15, 0.15, 0.05), (0.75, 0.75, 0.6))
        ends = cpm_equations.limb_ends(p, tuple(tool))
        if all(0.2 < np.hypot(u, w) < 0.82 for u, w in ends):
            found.append(tool)
    return np.array(found)


@dataclass(frozen=True)
class SizedCpm:
    """A CPM of other size and masses, a working mode of it and a tool position [m] that its limbs span with ease."""

    p: cpm.Parameters
    signs: tuple[int, int, int]
    tool: Array
    scale: float


def random_cpm(rng: np.random.Generator) -> SizedCpm:
    """A random CPM between a tenth and ten times the paper's size."""
    while True:
        scale = 10.0 ** rng.uniform(-1, 1)
        lengths = scale * rng.uniform((0.05, 0.35, 0.35, 0.8), (0.2, 0.6, 0.6, 1.2))
        p = cpm.Parameters(*lengths, *rng.uniform(0.1, 3.0, 4), rng.uniform(1.0, 20.0))
        tool = scale * rng.uniform(0.1, 0.8, 3)
        ends = np.hypot(*np.transpose(cpm_equations.limb_ends(p, tuple(tool))))
        low, high = p.reach
        if (ends > low + 0.15 * (high - low)).all() and (ends < high - 0.15 * (high - low)).all():
            one, two, three = (int(s) for s in rng.choice([-1, 1], 3))
            return SizedCpm(p, (one, two, three), tool, scale)


@pytest.fixture
def sized_cpm(rng: np.random.Generator) -> Callable[[], SizedCpm]:
    """Makes another random CPM at every call."""
    return lambda: random_cpm(rng)


@pytest.fixture
def cpm_states(rng: np.random.Generator) -> SimpleNamespace:
    """A thousand random states of the CPM at once, in random branches: arrays of shape (3, 1000)."""
    p = cpm.Parameters()
    tool = _cpm_tools(rng, p, 1000).T
    signs = rng.choice([-1.0, 1.0], size=tool.shape)
    assert np.isfinite(cpm_equations.limb_angles(p, tuple(tool), tuple(signs), np)).all()
    v, a = rng.uniform(-1, 1, tool.shape), rng.uniform(-5, 5, tool.shape)
    return SimpleNamespace(p=p, tool=tool, signs=signs, v=v, a=a)


@pytest.fixture
def omega3_states(rng: np.random.Generator) -> SimpleNamespace:
    """A thousand random states of the Omega-3 at once, elbows out: arrays of shape (3, 1000)."""
    p = omega3.Parameters()
    tool = rng.uniform((0.095, -0.05, -0.05), (0.14, 0.05, 0.05), size=(1000, 3)).T
    signs = -np.ones(tool.shape)
    assert np.isfinite(omega3_equations.arm_angles(p, tuple(tool), tuple(signs), np)).all()
    v, a = rng.uniform(-3, 3, tool.shape), rng.uniform(-20, 20, tool.shape)
    return SimpleNamespace(p=p, tool=tool, signs=signs, v=v, a=a)


def _cases() -> dict[str, tuple[object, float]]:
    return {
        "cpm": (cpm.CpmModel(), 0.08),
        "cpm+++": (cpm.CpmModel(signs=(1, 1, 1)), 0.08),
        "cpm---": (cpm.CpmModel(signs=(-1, -1, -1)), 0.08),
        "cpm loaded": (cpm.CpmModel().with_payload(0.7), 0.08),
        "cpm_rotary": (cpm.CpmRotaryModel(), 0.15),
        "cpm_rotary+-+": (cpm.CpmRotaryModel(signs=(1, -1, 1)), 0.03),
        "cpm_rotary---": (cpm.CpmRotaryModel(signs=(-1, -1, -1)), 0.15),
        "cpm_rotary loaded": (cpm.CpmRotaryModel().with_payload(0.7), 0.15),
        "omega3": (omega3.Omega3Model(), 0.25),
        "omega3 elbows in": (omega3.Omega3Model(signs=(1, 1, 1)), 0.15),
        "omega3 loaded": (omega3.Omega3Model().with_payload(0.05), 0.25),
    }


@pytest.fixture(params=list(_cases()))
def case(request: pytest.FixtureRequest, rng: np.random.Generator) -> SimpleNamespace:
    """A model with twelve random states near home on its branch: `model`, `states` = [(posture, v, a), ...]."""
    model, spread = _cases()[request.param]
    states = []
    for _ in range(12):
        at = model.close(model.home.q + rng.uniform(-spread, spread, 3))
        states.append((at, rng.uniform(-1, 1, 3), rng.uniform(-5, 5, 3)))
    return SimpleNamespace(model=model, states=states)
