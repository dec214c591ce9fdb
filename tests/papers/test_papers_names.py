"""Published models name the numbers of their postures: the actuators, and the symbols of the paper."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from cutjoint.errors import InputError, UnknownNameError
from cutjoint.robots import PUBLISHED, published


@pytest.mark.parametrize("name", PUBLISHED)
def test_what_a_paper_stores_has_its_name(name: str) -> None:
    model, rng = published(name), np.random.default_rng(0)
    motors = [actuator.name for actuator in model.actuators]
    for _ in range(5):
        at = model.reach(model.tool(model.home).position + 0.01 * rng.uniform(-1.0, 1.0, 3))
        assert at.layout is model.home.layout
        assert [at[motor] for motor in motors] == at.q.tolist()
        assert at.names[: model.n] == tuple(motors)
        np.testing.assert_allclose([at[axis] for axis in "xyz"], model.tool(at).position, atol=1e-14)
        symbols = [stored.partition("[")[0] for stored in model.stored]
        assert [at[symbol] for symbol in symbols] == at.q_full.tolist()
        assert set(at) == {*motors, *symbols}
        words = {line.split()[0]: line.split()[2] for line in str(at).splitlines()[1:]}
        assert words["x"] == "m"
        assert all(unit == "rad" for symbol, unit in words.items() if symbol.startswith("theta"))
        assert repr(pickle.loads(pickle.dumps(at))) == repr(at)
        given = dict(list(at.actuated.items())[::-1])
        np.testing.assert_array_equal(model.close(given).q_full, model.close(at.q).q_full)
    with pytest.raises(UnknownNameError, match="did you mean"):
        model.home[motors[0] + "x"]
    with pytest.raises(UnknownNameError, match="unknown actuator"):
        model.close({**at.actuated, "other": 1.0})
    with pytest.raises(InputError, match=f"lacks {motors[1]}"):
        model.close({motors[0]: 0.1, motors[2]: 0.1})


@pytest.mark.parametrize("name", PUBLISHED)
@pytest.mark.parametrize("word", ["no", "", "ignored", None, True])
def test_what_is_said_of_limits_is_understood_though_there_are_none(name: str, word: object) -> None:
    model = published(name)
    point = model.tool(model.home).position
    for asked in (lambda: model.close(model.home.q, limits=word), lambda: model.reach(point, limits=word)):
        with pytest.raises(InputError, match='limits must be "respect" or "ignore"'):
            asked()
    np.testing.assert_array_equal(model.close(model.home.q, limits="ignore").q, model.home.q)
