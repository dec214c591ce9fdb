"""Slips of the keyboard in files of every format: two letters swapped, one lost, one doubled; none is lost in silence.

All of them, some 30 000, are tried by `tools/fuzz.py typos=ALL`.
"""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools"))

from attacks.judging import Wrong
from attacks.seeds import samples, seeds
from attacks.typos import Slip, act, silent, slips, spelt


@pytest.mark.parametrize("source", sorted(samples()))
def test_some_slips_are_told(source: str, tmp_path: Path) -> None:
    count, quiet = silent(seeds()[source], tmp_path, 30, 1499)
    assert count
    assert quiet == []


@pytest.mark.slow
@pytest.mark.parametrize("source", sorted(seeds()))
def test_many_slips_are_told(source: str, tmp_path: Path) -> None:
    count, quiet = silent(seeds()[source], tmp_path, 1, 29)
    assert count > 20
    assert quiet == []


def test_a_slip_of_which_nothing_is_said_is_seen(tmp_path: Path) -> None:
    text = "<robot name='r'><link name='a' {0}='1'/></robot>"
    for name, silence in (("x:tpye", True), ("nmae", False)):
        slip = Slip("", "name", name, text.format(name), False)
        try:
            verdict = act({"robot.urdf": text.replace("{0}='1'", "")}, "robot.urdf", slip, tmp_path)
        except Wrong:
            verdict = "silent"
        assert (verdict == "silent") is silence


def test_every_place_has_its_slips() -> None:
    assert {*spelt("axis")} == {"xais", "aixs", "axsi", "xis", "ais", "axs", "axi", "aaxis", "axxis", "axiis", "axiss"}
    text = '<robot name="r"><link name="ab"/><drake:joint type="ball" xmlns:drake="d"/></robot>'
    said = {(one.meant, one.said) for one in slips("robot.urdf", text)}
    assert {("name", "nmae"), ("{d}joint", "{d}jiont"), ("ball", "baall"), ("ab", "ba"), ("robot", "robo")} <= said
    keys = {(one.meant, one.said) for one in slips("loops.toml", 'schema = 1\n[[cut]]\ntype = "ball" # note\n')}
    assert {("schema", "shcema"), ("cut", "ctu"), ("ball", "bal")} <= keys
    assert not any(meant == "note" for meant, _ in keys)
