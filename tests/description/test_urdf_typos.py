"""A slip in any name of any element or attribute of a URDF, in every dialect, is told: never is one lost in silence."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from lxml import etree

from cutjoint.description import read_checked

SAMPLES = Path(__file__).parent / "samples"
COUPLED = """<robot name="r" xmlns:drake="http://drake.mit.edu">
  <link name="o"/><link name="a"/><link name="b"/><link name="c"/><link name="d"/>
  <joint name="oa" type="continuous" independent="true"><parent link="o"/><child link="a"/><axis xyz="0 1 0"/></joint>
  <joint name="ob" type="continuous" independent="false"><parent link="o"/><child link="b"/><axis xyz="0 1 0"/></joint>
  <joint name="ac" type="continuous" independent="true"><parent link="a"/><child link="c"/><axis xyz="0 1 0"/></joint>
  <joint name="od" type="continuous"><parent link="o"/><child link="d"/><axis xyz="0 1 0"/>
    <drake:mimic joint="oa" multiplier="2" offset="0.1"/></joint>
  <coupling name="belt"><predecessor link="c"/><successor link="b"/><ratio value="8"/></coupling>
  <drake:tendon_constraint>
    <drake:tendon_constraint_joint name="oa" a="1"/><drake:tendon_constraint_joint name="ac" a="-1"/>
    <drake:tendon_constraint_offset value="0"/><drake:tendon_constraint_lower_limit value="0"/>
    <drake:tendon_constraint_upper_limit value="0"/>
  </drake:tendon_constraint>
</robot>"""
SEEDS = {
    "dialects": (SAMPLES / "dialects.urdf").read_text(encoding="utf-8"),
    "plus": (SAMPLES / "fourbar_plus.urdf").read_text(encoding="utf-8"),
    "coupled": COUPLED,
}
FREE = ("plugin", "param", "hardwareInterface")
"""Elements whose content belongs to others."""


def slips(name: str) -> list[str]:
    """The name with its middle letters swapped, one of them too few, too many, and another one; prefixes stay."""
    start = max(name.rfind("}"), name.rfind(":")) + 1
    head, word = name[:start], name[start:]
    if len(word) < 2:
        return [head + "q"]
    at = next((one for one in range(len(word) // 2, len(word)) if word[one] != word[one - 1]), len(word) - 1)
    tails = (word[at] + word[at - 1], word[at - 1], word[at - 1] + word[at] * 2, word[at - 1] + "q")
    return [head + word[: at - 1] + tail + word[at + 1 :] for tail in tails if tail != word[at - 1 : at + 1]]


def misspelt(text: str) -> Iterator[tuple[str, bytes]]:
    """Every slip in every name of a file, told and as a file."""
    root = etree.fromstring(text.encode(), etree.XMLParser(remove_comments=True))
    for element in root.iter(etree.Element):
        tag = str(element.tag)
        for slip in slips(tag):
            if slip.rsplit("}", 1)[-1].isidentifier():
                element.tag = slip
                yield f"<{slip}> for <{tag}>, line {element.sourceline}", etree.tostring(root)
        element.tag = tag
        for key, value in list(element.attrib.items()):
            for slip in slips(str(key)):
                if slip not in element.attrib and slip.isidentifier():
                    del element.attrib[key]
                    element.attrib[slip] = value
                    yield f"{slip}= for {key}= of <{tag}>, line {element.sourceline}", etree.tostring(root)
                    del element.attrib[slip]
                    element.attrib[key] = value


def silent(text: str, folder: Path, rng: np.random.Generator | None = None) -> list[str]:
    """The slips of which nothing is said."""
    path = folder / "robot.urdf"
    path.write_text(text, encoding="utf-8")
    before = {problem.found for problem in read_checked(path).problems}
    every = list(misspelt(text))
    if rng is not None:
        every = [every[index] for index in rng.choice(len(every), 20, replace=False)]
    found = []
    for told, data in every:
        path.write_bytes(data)
        if not {problem.found for problem in read_checked(path).problems} - before:
            found.append(told)
    return found


@pytest.mark.parametrize("seed", SEEDS)
def test_a_slip_in_a_name_is_told(seed: str, tmp_path: Path) -> None:
    assert silent(SEEDS[seed], tmp_path, np.random.default_rng(0)) == []


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS)
def test_every_slip_in_every_name_is_told(seed: str, tmp_path: Path) -> None:
    assert silent(SEEDS[seed], tmp_path) == []
