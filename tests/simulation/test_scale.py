"""A run of a robot of another size or mass is the same run: lengths by s, times by sqrt(s), masses by m."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from cutjoint.control import PD
from cutjoint.motion import Circle, Hold, Reference
from cutjoint.papers.cpm import CpmModel, Parameters
from cutjoint.papers.cpm.model import HOME_TOOL
from cutjoint.simulation import Adaptive, ReducedPlant, RungeKutta4, run


class Scaled(CpmModel):
    """The CPM with all lengths times s and all masses times m."""

    def __init__(self, s, m):
        p = Parameters()
        lengths = {name: s * getattr(p, name) for name in ("L", "L1", "L2", "D")}
        masses = {name: m * getattr(p, name) for name in ("m1", "m2", "m3", "m4")}
        super().__init__(replace(p, **lengths, **masses))
        self.s = s

    @property
    def home(self):
        return self._place(tuple(self.s * x for x in HOME_TOOL), self.signs)


METHODS = {"fixed": lambda unit: RungeKutta4(2e-3 * unit), "adaptive": lambda unit: Adaptive()}


@cache
def result(name, s, m):
    """Tool, effort and energy drift of a run, as a robot of size and mass 1 would have them."""
    unit = np.sqrt(s)
    model = Scaled(s, m)
    circle = Circle(s * np.array([0.425, 0.425, 0.3]), 0.175 * s, 2.0 * np.pi / unit)
    found = run(
        ReducedPlant(model),
        PD(8000.0 * m / s, 400.0 * m / unit),
        Reference(circle, model),
        integrator=METHODS[name](unit),
        duration=0.2 * unit,
        every=0.05 * unit,
    )
    return found.time / unit, found.tool / s, found.effort / m, found.energy_drift()


@pytest.mark.parametrize(("s", "m"), [(1e-4, 1.0), (1e4, 1.0), (1.0, 1e-6), (1.0, 1e6), (1e-4, 1e-6), (1e4, 1e6)])
@pytest.mark.parametrize("name", METHODS)
def test_a_run_is_the_same_at_every_size_and_mass(name, s, m):
    """A fixed step to rounding; adaptive steps to their tolerance, whose absolute part is in metres."""
    time, tool, effort, drift = result(name, s, m)
    _, wanted_tool, wanted_effort, wanted_drift = result(name, 1.0, 1.0)
    near = {"fixed": 1e-14, "adaptive": 1e-11}[name]
    assert np.allclose(time, [0.0, 0.05, 0.1, 0.15, 0.2], rtol=1e-12, atol=0.0)
    assert np.abs(tool - wanted_tool).max() < near
    assert np.abs(effort - wanted_effort).max() < 1e5 * near
    assert drift <= 100.0 * wanted_drift


@pytest.mark.parametrize("unit", [1e-13, 1e-6, 0.1])
@pytest.mark.parametrize("rate", [None, 5.0])
@pytest.mark.parametrize("method", [RungeKutta4, lambda h: Adaptive()])
def test_samples_lie_where_they_were_asked_for_on_every_clock(unit, rate, method):
    """What counts as one instant is relative to the run, which may take a tenth of a picosecond."""
    model = CpmModel()
    found = run(
        ReducedPlant(model),
        PD(8000.0, 400.0),
        Reference(Hold(HOME_TOOL, unit), model),
        integrator=method(0.05 * unit),
        every=0.25 * unit,
        rate=None if rate is None else rate / unit,
    )
    assert np.allclose(found.time / unit, [0.0, 0.25, 0.5, 0.75, 1.0], rtol=1e-12, atol=0.0)
