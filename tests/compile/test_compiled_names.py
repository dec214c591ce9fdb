"""Postures of compiled robots have the names of their model's, and are closed by name alike."""

from __future__ import annotations

import numpy as np
import pytest

from cutjoint import compiled
from cutjoint.errors import InputError, UnknownNameError
from cutjoint.robots import load, published


@pytest.mark.parametrize("name", ["omega3", "stewart", "fivebar", "paper omega3"])
def test_names_survive_compiling(name: str) -> None:
    model = published(name[6:]) if name.startswith("paper ") else load(name)
    robot, rng = compiled(model), np.random.default_rng(0)
    for _ in range(4):
        at = robot.close(model.home.q + 0.01 * rng.normal(size=model.n))
        assert at.layout is model.home.layout
        same = model.close(at.q)
        assert at.names == same.names
        for one in at:
            np.testing.assert_allclose(at[one], same[one], atol=1e-12)
        np.testing.assert_array_equal(robot.close(dict(reversed(at.actuated.items()))).q_full, robot.close(at.q).q_full)
        assert str(robot.close(at.actuated)).splitlines()[0].startswith(f"posture of {model.name}, closed to ")
    first = robot.actuators[0].name
    with pytest.raises(InputError, match=f"lacks {first}"):
        robot.close({one: value for one, value in at.actuated.items() if one != first})
    with pytest.raises(UnknownNameError, match="unknown actuator"):
        robot.close({**at.actuated, "other": 1.0})
