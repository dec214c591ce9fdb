"""Laws from outside the package: taken up by name, with their gains, and refused at the door where they do not fit."""

from __future__ import annotations

from collections.abc import Iterator
from importlib.metadata import EntryPoint
from pathlib import Path

import numpy as np
import pytest

from cutjoint import plugins
from cutjoint.control import ComputedTorque, Law, LawOfFunction, law
from cutjoint.control.catalogue import law_row
from cutjoint.errors import CutjointError, InputError, UnknownNameError
from cutjoint.motion import Hold, Reference
from cutjoint.papers.cpm import CpmModel
from cutjoint.simulation import ReducedPlant, run

MODEL = CpmModel()
SOURCE = '''
from typing import Annotated

import numpy as np

from cutjoint.control import PD
from cutjoint.control.law import Gain, GainHelp


class SlidingMode:
    """Called like a function."""

    def __init__(self, model, eta, slope=30.0, width=0.1):
        self.model, self.eta, self.slope, self.width = model, eta, slope, width

    def __call__(self, t, desired, q, v):
        e, e_dot = desired.q - q, desired.v - v
        at = self.model.close(q, desired.posture)
        wanted = desired.a + self.slope * e_dot + self.eta * np.tanh((e_dot + self.slope * e) / self.width)
        return self.model.inverse_dynamics(at, v, wanted)


class Damped(PD):
    """A law as those of the package."""

    name = "damped"

    def __init__(self, kp, kd, drag: Annotated[float, GainHelp("against the speed", "N s/m")]):
        super().__init__(kp, kd)
        self.drag = Gain("drag", drag)

    def effort(self, desired, q, v, memory):
        return self.feedback(desired, q, v) - self.drag(v)


def spring(t, desired, q, v):
    return 1000.0 * (desired.q - q) - 50.0 * v


made = Damped(1.0, 2.0, 3.0)


class NoRate:
    name, gains = "no rate", {}

    def memory(self, n):
        return 0

    def effort(self, desired, q, v, memory):
        return q


class Whole(NoRate):
    size, answer, rate, gains = 0, None, np.zeros(0), {}

    def memory(self, n):
        return self.size

    def effort(self, desired, q, v, memory):
        return q if self.answer is None else self.answer

    def memory_rate(self, desired, q, v, asked, given):
        return self.rate


class BadSize(Whole):
    size = 1.5


class BadGains(Whole):
    gains = {"k": "stiff"}


class NoGains(Whole):
    gains = 3


class BadRate(Whole):
    size = 2


class Short(Whole):
    answer = [1.0]


class NaN(Whole):
    answer = np.full(3, np.nan)


class Words(Whole):
    answer = "strong"


class Raises:
    def __init__(self, k):
        raise RuntimeError("no luck")


class Typed:
    def __init__(self, k: "NoSuchType"):
        pass


def two(a, b):
    return a


number = 3


def late(t, desired, q, v):
    return [1.0] if t > 0.01 else 0.0 * q
'''


@pytest.fixture(scope="module")
def laws(tmp_path_factory: pytest.TempPathFactory) -> str:
    file: Path = tmp_path_factory.mktemp("laws") / "my_laws.py"
    file.write_text(SOURCE)
    return str(file)


def reference() -> Reference:
    return Reference(Hold([0.5, 0.4, 0.3], 0.05), MODEL)


def test_a_class_that_is_called_controls(laws: str) -> None:
    made = law(f"{laws}:SlidingMode", MODEL, {"eta": 20.0, "slope": 40.0})
    assert isinstance(made, Law)
    assert isinstance(made, LawOfFunction)
    assert (made.name, made.gains) == ("SlidingMode", {"eta": [[20.0]], "slope": [[40.0]]})
    start = MODEL.reach([0.501, 0.4, 0.3])
    found = run(ReducedPlant(MODEL), made, reference(), start=start)
    assert found.worst_error(after=0.05) < 0.5 * found.worst_error()
    assert found.about["gains"] == made.gains


def test_a_class_like_those_of_the_package_and_an_object_and_a_function(laws: str) -> None:
    damped = law(f"{laws}:Damped", MODEL, {"kp": 1.0, "kd": [1.0, 2.0, 3.0], "drag": 4.0})
    assert damped.gains == {"kp": [[1.0]], "kd": [[1.0, 2.0, 3.0]], "drag": [[4.0]]}
    assert law_row(f"{laws}:Damped").gains["drag"].about == "against the speed"
    assert law(f"{laws}:made", MODEL, {}).gains["drag"] == [[3.0]]
    spring = law(f"{laws}:spring", MODEL, {})
    now = reference().at(0.0)
    q, v = now.q + 0.001, now.v + 0.1
    assert np.allclose(spring.effort(now, q, v, np.zeros(0)), -1.0 - 5.0)
    assert spring.name == "spring"


def test_gains_are_the_parameters_of_its_constructor(laws: str) -> None:
    row = law_row(f"{laws}:SlidingMode")
    assert (list(row.gains), row.needed) == (["eta", "slope", "width"], ["eta"])
    assert list(law_row("pid").gains) == law_row("pid").needed == ["kp", "ki", "kd"]
    for gains in ({}, {"slope": 1.0}, {"eta": 1.0, "model": 1.0}, {"eta": 1.0, "kp": 1.0}):
        with pytest.raises(InputError, match="takes the gains eta, slope, width; found"):
            law(f"{laws}:SlidingMode", MODEL, gains)


@pytest.mark.parametrize(
    ("name", "gains", "about"),
    [
        ("NoRate", {}, r"has an effort but no memory_rate; a law is a function \(t, desired, q, v\) -> efforts"),
        ("BadSize", {}, r"memory\(3\) must give the number of the law's own states, it gave 1.5"),
        ("BadGains", {}, "gains must be a dict of names and numbers, it is {'k': 'stiff'}"),
        ("NoGains", {}, "gains must be a dict of names and numbers, it is 3"),
        ("Raises", {"k": 1.0}, r"Raises raised RuntimeError: no luck at .*my_laws.py:\d+: raise RuntimeError"),
        ("Typed", {"k": 1.0}, "parameters of .*Typed cannot be read: NameError: name 'NoSuchType'"),
        ("two", {}, r"two\(a, b\) is no control law: a law is a function \(t, desired, q, v\)"),
        ("number", {}, "is 3, which is neither called nor has an effort; a law is"),
        ("Damped", {"kp": -1.0, "kd": 1.0, "drag": 1.0}, "gain kp must be >= 0"),
        ("Damped", {"kp": [1.0, 2.0], "kd": 1.0, "drag": 1.0}, "gain kp has shape"),
    ],
)
def test_what_is_no_law_is_refused_when_it_is_made(laws: str, name: str, gains: dict[str, float], about: str) -> None:
    with pytest.raises(InputError, match=about):
        law(f"{laws}:{name}", MODEL, gains)


@pytest.mark.parametrize(
    ("name", "about"),
    [
        ("Short", r"asks for efforts of shape \(1,\); the robot has 3 actuators"),
        ("NaN", "asks for an effort that is not finite"),
        ("Words", "must return efforts, one an actuator; it returned the text 'strong'"),
        ("BadRate", r"has a memory of shape \(2,\) and its rate is of shape \(0,\)"),
    ],
)
def test_what_answers_wrongly_is_refused_before_anything_moves(laws: str, name: str, about: str) -> None:
    told: list[float] = []
    with pytest.raises(InputError, match=about):
        run(ReducedPlant(MODEL), law(f"{laws}:{name}", MODEL, {}), reference(), progress=told.append)
    assert told == []


def test_what_answers_wrongly_later_stops_the_run(laws: str) -> None:
    with pytest.raises(CutjointError, match=r"stopped at t = 0.0\d+ s.*efforts of shape \(1,\)"):
        run(ReducedPlant(MODEL), law(f"{laws}:late", MODEL, {}), reference())


def test_names_that_are_none_are_told_with_all_there_are(laws: str) -> None:
    with pytest.raises(UnknownNameError, match="unknown controller 'pdd'; did you mean 'pd'"):
        law("pdd", MODEL, {})
    with pytest.raises(UnknownNameError, match="did you mean 'SlidingMode'"):
        law(f"{laws}:SlidingMod", MODEL, {})
    with pytest.raises(InputError, match=r"nothing goes behind .*SlidingMode; give gains by name"):
        law(f"{laws}:SlidingMode:1,2", MODEL, {})


@pytest.fixture
def offering(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    offers = {"cutjoint.controllers": [EntryPoint("ours", "cutjoint.control:ComputedTorque", "cutjoint.controllers")]}
    monkeypatch.setattr(plugins, "entry_points", lambda group: offers.get(group, []))
    plugins.installed.cache_clear()
    yield
    plugins.installed.cache_clear()


@pytest.mark.usefixtures("offering")
def test_an_installed_law_goes_by_its_name() -> None:
    made = law("ours", MODEL, {"kp": 100.0, "kd": 20.0})
    assert isinstance(made, ComputedTorque)
    assert made.model is MODEL
    with pytest.raises(UnknownNameError, match="did you mean 'ours'"):
        law("our", MODEL, {})
