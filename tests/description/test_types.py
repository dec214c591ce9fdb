"""A type of joint or cut that is new in its table is written and read back, or refused: never written wrongly."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from enum import StrEnum
from pathlib import Path

import numpy as np
import pytest
from kit.described import FILES, differences

from cutjoint.description import (
    CutJoint,
    CutType,
    Frame,
    Home,
    Inertial,
    Joint,
    JointType,
    Link,
    RobotDescription,
    check,
    load_description,
)
from cutjoint.description.cuts import HINGE, POINT, dot, slide
from cutjoint.description.formats import WRITERS, write
from cutjoint.description.formats.mjcf.types import MADE_OF
from cutjoint.description.transforms import placement
from cutjoint.errors import InputError

AddRow = Callable[..., None]
IMPOSSIBLE = (POINT, dot(0, 1, "a"), dot(0, 2, "b"), dot(1, 2, "c"))


@pytest.fixture
def add_row(monkeypatch: pytest.MonkeyPatch) -> AddRow:
    """Adds a member to a table of types for the time of a test."""

    def add(table: type[StrEnum], name: str, *row: object) -> None:
        member = table.__new_member__(table, name, *row)
        member._name_ = name.upper()
        monkeypatch.setitem(table._value2member_map_, name, member)
        monkeypatch.setitem(table._member_map_, name.upper(), member)
        monkeypatch.setattr(table, "_member_names_", [*table._member_names_, name.upper()])

    return add


def robot(kind: JointType, cut: CutType = CutType.SPHERICAL) -> RobotDescription:
    """Two bodies on a base, the first by a joint of `kind`, joined by a cut."""
    body = Inertial(1.0, inertia=np.eye(3))
    at = placement((0.1, 0.2, 0.3), (0.1, -0.2, 0.4))
    first = Joint("first", kind, "base", "a", at)
    if not kind.axes:
        first = replace(first, axis=np.array([1.0, 0.0, 0.0]))
    passive = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6)[: kind.dof]
    homes = {"first": passive[0] if kind.dof == 1 else passive} if passive else {}
    return RobotDescription(
        name="two",
        links=(Link("base"), Link("a", body), Link("b", body), Link("c", body)),
        joints=(
            first,
            Joint("second", JointType.REVOLUTE, "base", "b", at),
            Joint("third", JointType.CONTINUOUS, "a", "c", at),
        ),
        cuts=(CutJoint("tie", cut, Frame("c", at), Frame("b", placement((0.0, 0.0, 1.0)))),),
        homes=(Home("default", passive=homes),),
    )


def comes_back(one: RobotDescription, form: str, folder: Path) -> bool:
    """Whether it is read back as it was written."""
    assert [problem for problem in check(one) if problem.severity == "error"] == []
    return differences(one, load_description(write(one, folder / FILES[form], to=form)[0])) == []


def comes_back_or_is_refused(one: RobotDescription, form: str, folder: Path) -> bool:
    """Whether it is read back, but for MJCF, which must refuse it and write nothing."""
    if form != "mjcf":
        return comes_back(one, form, folder)
    with pytest.raises(InputError, match=r"MJCF cannot say .* type '.*' of .* '.*'; write loops\.toml \(--to loops\)"):
        write(one, folder / FILES[form], to=form)
    return not any(folder.iterdir())


@pytest.mark.parametrize("form", WRITERS)
@pytest.mark.parametrize("kind", JointType)
def test_every_joint_type_comes_back(kind: JointType, form: str, tmp_path: Path) -> None:
    assert comes_back(robot(kind), form, tmp_path)


@pytest.mark.parametrize("form", WRITERS)
@pytest.mark.parametrize("cut", CutType)
def test_every_cut_type_comes_back(cut: CutType, form: str, tmp_path: Path) -> None:
    assert comes_back(robot(JointType.FLOATING, cut), form, tmp_path)


@pytest.mark.parametrize("form", WRITERS)
def test_a_new_joint_type_comes_back_or_is_refused(form: str, add_row: AddRow, tmp_path: Path) -> None:
    add_row(JointType, "translation", "x[m] y[m] z[m]")
    assert comes_back_or_is_refused(robot(JointType("translation")), form, tmp_path)


def test_mjcf_says_a_new_joint_type_with_one_row(
    add_row: AddRow, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    add_row(JointType, "translation", "x[m] y[m] z[m]")
    with pytest.raises(InputError, match="cannot say joint type 'translation' of joint 'first'"):
        write(robot(JointType("translation")), tmp_path / "robot.xml", to="mjcf")
    monkeypatch.setitem(MADE_OF, JointType("translation"), ("slide", "slide", "slide"))
    assert comes_back(robot(JointType("translation")), "mjcf", tmp_path)


@pytest.mark.parametrize("form", WRITERS)
@pytest.mark.parametrize(
    "equations",
    [(slide(0), slide(1), HINGE), (slide(2),), (POINT, dot(2, 0, "t"))],
    ids=["cylindrical", "plane", "dot"],
)
def test_a_new_cut_type_comes_back(form: str, equations: tuple[object, ...], add_row: AddRow, tmp_path: Path) -> None:
    add_row(CutType, "other", equations, "", "test")
    assert comes_back(robot(JointType.FLOATING, CutType("other")), form, tmp_path)


@pytest.mark.parametrize("form", WRITERS)
def test_equations_that_mjcf_cannot_say_are_refused(form: str, add_row: AddRow, tmp_path: Path) -> None:
    add_row(CutType, "other", IMPOSSIBLE, "", "test")
    assert comes_back_or_is_refused(robot(JointType.FLOATING, CutType("other")), form, tmp_path)


def test_a_cylindrical_cut_is_a_slide_and_a_hinge_in_mujoco(add_row: AddRow, tmp_path: Path) -> None:
    mujoco = pytest.importorskip("mujoco")
    add_row(CutType, "cylindrical", (slide(0), slide(1), HINGE), "z", "slides along and turns about z")
    file = write(robot(JointType.FLOATING, CutType("cylindrical")), tmp_path / "robot.xml", to="mjcf")[0]
    model = mujoco.MjModel.from_xml_path(str(file))
    kinds = [model.joint(f"cutjoint:tie{end}").type[0] for end in ("", "/2")]
    assert kinds == [mujoco.mjtJoint.mjJNT_SLIDE, mujoco.mjtJoint.mjJNT_HINGE]
    assert all(np.array_equal(model.joint(f"cutjoint:tie{end}").axis, [0.0, 0.0, 1.0]) for end in ("", "/2"))


def test_homes_are_told_the_coordinates_of_a_type(add_row: AddRow) -> None:
    add_row(JointType, "translation", "x[m] y[m] z[m]")
    one = robot(JointType("translation"))
    wrong = replace(one, homes=(Home("default", passive={"first": 1.0}),))
    assert [problem.expected for problem in check(wrong)] == ["3: x, y, z"]


def test_the_page_on_descriptions_lists_every_type() -> None:
    page = (Path(__file__).resolve().parents[2] / "docs/description.md").read_text(encoding="utf-8")
    for kind in JointType:
        names = ", ".join(one.name for one in kind.coordinates) or "none"
        assert f"| `{kind}` | {names} | {', '.join(['`axis`', '`axis2`'][: kind.axes])}" in page
    for cut in CutType:
        assert f"| `{cut}` | {cut.rows} | " in page
