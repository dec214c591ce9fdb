"""Files with thousands of faults, lists in lists, and meshes that take for ever: told in a few words, in time."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from cutjoint.description import meshes, read_checked
from cutjoint.errors import DescriptionError, InputError
from cutjoint.findings import MOST, Findings

ROBOT = "<robot name='r'><link name='a'/>{}</robot>"
MANY = 6000


def test_problems_are_each_told_once_and_very_many_errors_end_the_reading() -> None:
    findings = Findings("file")
    for number in range(5 * MOST):
        findings.warn(f"odd {number}")
        findings.warn("odd 0")
    assert len(findings.problems) == 3 * MOST + 1
    assert not findings.failed
    findings.doubt("too much to list")
    assert findings.failed, "that something is left out of the list does not pass it"
    for number in range(MOST - 1):
        findings.error(f"wrong {number}")
    with pytest.raises(DescriptionError) as raised:
        findings.error("the last")
    assert f"{MOST} errors" in raised.value.problems[-1].found


@pytest.mark.parametrize(
    ("name", "text", "read"),
    [
        ("same.urdf", ROBOT.format("<foo/>\n" * MANY), True),
        ("wrong.urdf", ROBOT.format("".join(f"<joint name='j{k}'/>\n" for k in range(MANY))), False),
        ("deep.yaml", "closed_loop: " + "{" * MANY, False),
        ("wide.yaml", "closed_loop: [" + "[a, b]," * MANY + "]", False),
        ("frames.sdf", "<sdf version='1.9'><model name='m'><link name='l'/>"
         + "".join(f"<frame name='f{k}' attached_to='f{k + 1}'/>" for k in range(3000))
         + "<frame name='f3000' attached_to='l'/></model></sdf>", False),
    ],
)  # fmt: skip
def test_thousands_of_faults_are_told_in_time(name: str, text: str, read: bool, tmp_path: Path) -> None:
    (tmp_path / name).write_text(text, encoding="utf-8")
    began = time.process_time()
    reading = read_checked(tmp_path / name)
    assert time.process_time() - began < 5.0
    assert (reading.description is not None) is read
    assert reading.problems
    assert len(reading.problems) <= 4 * MOST


def test_a_mesh_that_takes_for_ever_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(meshes, "SECONDS", 0.5)
    file = tmp_path / "parts.obj"
    file.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\n" + "".join(f"usemtl m{k}\nf 1 2 3\n" for k in range(40_000)))
    with pytest.raises(InputError, match=r"took longer than 0\.5 s"):
        meshes.read_meshes(file)


@pytest.mark.slow
def test_a_mesh_of_any_size_is_read_alike(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "part.obj"
    file.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    (here,) = meshes.read_meshes(file)
    monkeypatch.setattr(meshes, "AT_ONCE", 0)
    (there,) = meshes.read_meshes(file)
    assert there.vertices.tolist() == here.vertices.tolist()
    assert there.faces.tolist() == here.faces.tolist()
    file.write_text("v 0 0 0\nv 1 0 0\nv 0 1 1e9\nf 1 2 3\n")
    with pytest.raises(InputError, match="cannot be read: it holds corners"):
        meshes.read_meshes(file)
