"""A type of joint or cut that is new in its table is written and read back, or refused: never written wrongly."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from types import SimpleNamespace

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
from cutjoint.description.cuts import HINGE, LOCK, POINT, Equation, Kind, dot, slide
from cutjoint.description.formats import WRITERS, write
from cutjoint.description.formats.mjcf.types import MADE_OF, carrier_parts
from cutjoint.description.transforms import placement
from cutjoint.errors import InputError

AddRow = Callable[..., None]
IMPOSSIBLE = (POINT, dot(0, 1, "a"), dot(0, 2, "b"), dot(1, 2, "c"))


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
        cuts=(
            CutJoint("tie", cut, Frame("c", at), Frame("b", placement((0.0, 0.0, 1.0))), length=0.7 * cut.has_length),
        ),
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


def held(equations: tuple[Equation, ...]) -> np.ndarray:
    """What the equations hold of the twist (linear, angular) of frame B in frame A, where the two are alike."""
    one = np.eye(3)
    linear, angular = np.hstack([one, np.zeros((3, 3))]), np.hstack([np.zeros((3, 3)), one])
    rows = [np.zeros((0, 6))]
    for equation in equations:
        match equation.kind:
            case Kind.POINT:
                rows.append(linear)
            case Kind.LOCK:
                rows.append(angular)
            case Kind.HINGE:
                rows.append(angular[:2])
            case Kind.SLIDE:
                rows.append(linear[list(equation.axes)])
            case Kind.DOT:
                i, j = equation.axes
                rows.append(np.cross(one[i], one[j]) @ angular)
    return np.vstack([np.reshape(row, (-1, 6)) for row in rows])


def free(parts: list[tuple[str, np.ndarray | None]]) -> np.ndarray:
    """Twists, one a column, that joints of MuJoCo leave free."""
    columns = [np.zeros((6, 0))]
    for kind, axis in parts:
        columns.append(np.vstack([np.zeros((3, 3)), np.eye(3)]) if axis is None else np.zeros((6, 1)))
        if axis is not None:
            columns[-1][:3, 0] = axis * (kind == "slide")
            columns[-1][3:, 0] = axis * (kind != "slide")
    return np.hstack(columns)


PLACES = [(), (POINT,), *(tuple(slide(k) for k in axes) for n in (1, 2) for axes in combinations(range(3), n))]
TURNS = [(), (LOCK,), (HINGE,), *((dot(i, j, "t"),) for i in range(3) for j in range(3))]


@pytest.mark.parametrize("turn", TURNS, ids=lambda one: "-".join(f"{e.kind.name}{e.axes}" for e in one) or "none")
def test_carriers_in_mjcf_move_as_the_equations_allow_or_are_refused(turn: tuple[Equation, ...]) -> None:
    """Over every kind of place and turn: what two hinges about one axis would make of `dot(i, i)` is refused."""
    for place in PLACES:
        cut = SimpleNamespace(name="c", type=SimpleNamespace(value="new", equations=(*place, *turn)))
        if turn and turn[0].kind is Kind.DOT and len(set(turn[0].axes)) == 1:
            with pytest.raises(InputError, match="MJCF cannot say cut type 'new'"):
                carrier_parts(cut)  # type: ignore[arg-type]
            continue
        rows, moves = held((*place, *turn)), free(carrier_parts(cut))  # type: ignore[arg-type]
        assert np.abs(rows @ moves).max(initial=0.0) == 0.0
        assert np.linalg.matrix_rank(moves) == moves.shape[1] == 6 - (np.linalg.matrix_rank(rows) if len(rows) else 0)


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
