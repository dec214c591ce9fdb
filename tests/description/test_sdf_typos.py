"""Slips of the pen in SDF files: every name with two letters exchanged is found, whatever element it is in."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from pathlib import Path

import pytest
from lxml import etree

from cutjoint.description import read_checked

SAMPLES = Path(__file__).parent / "samples"
FILES = ("everything.sdf", "fourbar.sdf")
OTHERS = ("plugin",)
"""Elements whose children are not SDF's."""


def exchanged(name: str) -> Iterator[str]:
    """`name` with two neighbouring letters exchanged."""
    for at in range(len(name) - 1):
        if name[at] != name[at + 1]:
            yield name[:at] + name[at + 1] + name[at] + name[at + 2 :]


def slips(tree: etree._Element) -> Iterator[tuple[int, str, str]]:
    """Each misspelt name: the number of its element, the attribute (empty for the element itself), and the name."""
    for number, element in enumerate(tree.iter(etree.Element)):
        if any(above.tag in OTHERS for above in element.iterancestors()) or "{" in element.tag:
            continue
        yield from ((number, "", wrong) for wrong in exchanged(element.tag))
        for name in element.attrib:
            yield from ((number, name, wrong) for wrong in exchanged(name))


def silent(file: str, folder: Path, start: int, step: int) -> tuple[int, list[str]]:
    """How many slips were tried, and those of which no problem tells."""
    tree = etree.fromstring((SAMPLES / file).read_bytes())
    path, quiet, tried = folder / "slip.sdf", [], list(slips(tree))[start::step]
    for number, attribute, wrong in tried:
        other = copy.deepcopy(tree)
        element = list(other.iter(etree.Element))[number]
        if attribute:
            element.attrib[wrong] = element.attrib.pop(attribute)
        else:
            element.tag = wrong
        path.write_bytes(etree.tostring(other))
        said = f"attribute '{wrong}'" if attribute else f"<{wrong}>"
        if not any(said in one.found for one in read_checked(path).problems):
            quiet.append(wrong)
    return len(tried), quiet


@pytest.mark.parametrize("file", FILES)
def test_some_slips_are_told(file: str, tmp_path: Path) -> None:
    count, quiet = silent(file, tmp_path, 3, 97)
    assert count
    assert quiet == []


@pytest.mark.slow
@pytest.mark.parametrize("start", range(8))
@pytest.mark.parametrize("file", FILES[:1])
def test_all_slips_are_told(file: str, start: int, tmp_path: Path) -> None:
    count, quiet = silent(file, tmp_path, start, 8)
    assert count > 100
    assert quiet == []


@pytest.mark.slow
def test_all_slips_of_a_small_file_are_told(tmp_path: Path) -> None:
    assert silent(FILES[1], tmp_path, 0, 1)[1] == []


def test_a_slip_in_what_moves_is_an_error_with_the_nearest_name(tmp_path: Path) -> None:
    text = (SAMPLES / "everything.sdf").read_text()
    slip = {"<lower>-2</lower>": "<lowre>-2</lowre>", "<damping>": "<dampign>", "</damping>": "</dampign>"}
    for old, new in slip.items():
        text = text.replace(old, new)
    path = tmp_path / "slip.sdf"
    path.write_text(text.replace('canonical_link="ground"', 'canonical_lnik="ground"'))
    problems = {one.found: one for one in read_checked(path).problems if one.severity == "error"}
    for found, near in (
        ("unknown element <lowre> in <limit>", "lower"),
        ("unknown element <dampign> in <dynamics>", "damping"),
        ("unknown attribute 'canonical_lnik' of <model>", "canonical_link"),
    ):
        assert problems[found].mend == f"did you mean '{near}'?"
