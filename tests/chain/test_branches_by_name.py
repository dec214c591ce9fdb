"""Branches by name: a home of the description, given as `near`, picks the assembly and the working mode."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from cutjoint.chain import ClosedChain
from cutjoint.description.model import Home
from cutjoint.errors import UnknownNameError


def with_modes(kit: Any, name: str) -> tuple[ClosedChain, dict[str, np.ndarray]]:
    """A robot whose assembly modes are homes with names, and the configurations of these."""
    chain = kit.robot(name)
    modes = {f"mode {number}": mode.q_full for number, mode in enumerate(chain.assembly_modes())}
    values = {}
    for called, q in modes.items():
        at = chain.posture(q)
        passive = {
            joint.name: tuple(np.atleast_1d(at[joint.name]).tolist())
            for joint in chain.description.joints
            if joint.type.moves and joint.name not in chain.description.actuators
        }
        passive = {joint: value[0] if len(value) == 1 else value for joint, value in passive.items()}
        actuated = {one: float(at[one]) for one in chain.description.actuators}
        values[called] = Home(called, actuated, passive)
    homes = (*chain.description.homes, *values.values())
    return ClosedChain(replace(chain.description, homes=homes)), modes


@pytest.mark.parametrize("name", ["fivebar", "fourbar"])
def test_a_home_by_its_name_picks_the_assembly_mode(name: str, kit: Any) -> None:
    chain, modes = with_modes(kit, name)
    assert len(modes) > 1
    compiled = chain.compile()
    for called, q in modes.items():
        at = chain.close(chain.home.q, called)
        np.testing.assert_allclose(at.q_full, q, atol=1e-10)
        further = chain.close(chain.home.q + 1e-3, called)
        np.testing.assert_allclose(further.q_full, chain.close(chain.home.q + 1e-3, at).q_full, atol=1e-10)
        np.testing.assert_allclose(compiled.close(chain.home.q + 1e-3, called).q_full, further.q_full, atol=1e-10)
        point = chain.tool(further).position
        np.testing.assert_allclose(chain.reach(point, called).q_full, further.q_full, atol=1e-9)
        np.testing.assert_allclose(compiled.reach(point, called).q_full, further.q_full, atol=1e-9)


def test_a_home_that_is_none_is_told(kit: Any) -> None:
    chain = kit.robot("fivebar")
    for robot in (chain, chain.compile()):
        with pytest.raises(UnknownNameError, match="home posture 'defualt'; did you mean 'default'"):
            robot.close(chain.home.q, "defualt")
        with pytest.raises(UnknownNameError):
            robot.reach(chain.tool(chain.home).position, "upside down")
