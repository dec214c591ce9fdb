"""Tables of motors: units are converted, and whatever is wrong is told with file, line and column."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cutjoint.errors import InputError
from cutjoint.sizing import motors_from_file

HEADINGS = "name,rated_torque [N m],peak_torque [N m],max_speed [rpm],rotor_inertia [kg cm2]"


def table(folder: Path, text: str) -> Path:
    file = folder / "motors.csv"
    file.write_text(text, encoding="utf-8")
    return file


def test_the_same_motors_in_any_units(tmp_path: Path) -> None:
    rows = {
        HEADINGS: "a,1.5,4.5,3000,0.8",
        "Name;rated_torque [mNm];peak_torque [N·m];max_speed [1/min];rotor_inertia [g cm²]": "a;1500;4.5;3000;800",
        "peak_torque[Ncm]\tname\tmax_speed [rev/s]\trotor_inertia [kg*m^2]\trated_torque [kN m]": (
            "450\ta\t50\t8e-5\t0.0015"
        ),
    }
    for headings, row in rows.items():
        (found,) = motors_from_file(table(tmp_path, f"# a comment\n\n{headings}\r\n{row}\n"))
        numbers = (found.rated, found.peak, found.max_speed, found.rotor)
        assert np.allclose(numbers, (1.5, 4.5, 100.0 * np.pi, 8e-5), rtol=1e-12)
        assert (found.name, found.kind) == ("a", "rotation")


def test_motors_that_slide_and_columns_that_may_be_empty(tmp_path: Path) -> None:
    text = (
        "name,rated_force [N],peak_force [kN],max_speed [m/min],mover_mass [g],force_constant [N/A],resistance [Ohm],"
        "thermal_resistance [K/W],max_temperature [°C],brake_force [N]\n"
        "l1,50,0.2,120,800,30,2,0.5,130,\nl2,5,0.02,60,0,,,,,7\n"
    )
    one, other = motors_from_file(table(tmp_path, text))
    assert (one.kind, one.peak, one.max_speed, one.rotor, one.brake) == ("translation", 200.0, 2.0, 0.8, None)
    assert (one.constant, one.max_temperature, other.brake, other.rotor, other.constant) == (
        30.0,
        130.0,
        7.0,
        0.0,
        None,
    )


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (HEADINGS.replace("[rpm]", "[N m]") + "\na,1,2,3,4", r":1, column 4 .*'N m', which is a unit of torque"),
        (HEADINGS.replace("[rpm]", "[m/s]") + "\na,1,2,3,4", r"a unit of speed; expected a unit of speed of rotation"),
        (HEADINGS.replace("[kg cm2]", "[kg]") + "\na,1,2,3,4", r"column 5 .*'kg', which is a unit of mass"),
        (HEADINGS.replace("[rpm]", "[furlong]") + "\na,1,2,3,4", r"'furlong', which is not known"),
        (HEADINGS.replace(" [rpm]", "") + "\na,1,2,3,4", r"column 4 'max_speed': the heading tells no unit"),
        (HEADINGS.replace("peak_torque", "peak_torqe") + "\na,1,2,3,4", r"'peak_torqe.*did you mean 'peak_torque'"),
        (HEADINGS.replace(",rotor_inertia [kg cm2]", "") + "\na,1,2,3", r":1: column rotor_inertia is missing"),
        (HEADINGS + ",max_speed [rpm]\na,1,2,3,4,5", r"column 6 .*is there twice"),
        (HEADINGS + ",peak_force [N]\na,1,2,3,4,5", r"of a motor that turns, and peak_force, of one that slides"),
        (HEADINGS + "\na,1,2,3", r":2: found 4 cells; expected 5"),
        (HEADINGS + "\na,1,2,3,4\na,1,2,3,4", r":3, column 1 'name': motor 'a' is there twice, first on line 2"),
        (HEADINGS + "\na,1,-2,3,4", r":2, column 3 'peak_torque \[N m\]': found '-2'; expected a number > 0"),
        (HEADINGS + "\na,1,nan,3,4", r"found 'nan'"),
        (HEADINGS.replace(",", ";") + "\na;1;2,5;3;4", r"found '2,5'; expected a number > 0, with a point: 2\.5"),
        (HEADINGS + "\na,1,1_0,3,4", r"found '1_0'"),
        (HEADINGS + "\na,1,,3,4", r"found an empty cell"),
        (HEADINGS + "\n,1,2,3,4", r"column 1 'name': found no name"),
        (HEADINGS + "\na,3,2,3,4", r":2: motor 'a' has a peak effort of 2, below its rated 3"),
        (HEADINGS + ",rated_speed [rpm]\na,1,2,3000,4,3001", r"rated_speed of .*beyond its largest speed"),
        (HEADINGS, r"headings and no motor"),
        ("# nothing\n", r"no line but blank ones"),
        ("", r"no line but blank ones|empty"),
    ],
)  # fmt: skip
def test_whatever_is_wrong_is_told_in_its_place(text: str, told: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=told):
        motors_from_file(table(tmp_path, text))


def test_what_is_no_text_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "motors.csv"
    for content in (b"\xff\xfe\x00", b"name,\x00rated\n"):
        file.write_bytes(content)
        with pytest.raises(InputError, match=r"motors\.csv"):
            motors_from_file(file)
    with pytest.raises(InputError, match=r"none\.csv"):
        motors_from_file(tmp_path / "none.csv")


def test_more_motors_than_anyone_compares_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("cutjoint.sizing.motor_table.MOST_MOTORS", 3)
    rows = "\n".join(f"m{k},1,2,3,4" for k in range(4))
    assert len(motors_from_file(table(tmp_path, HEADINGS + "\n" + rows[: rows.rindex("\n")]))) == 3
    with pytest.raises(InputError, match=r":5: found more than 3 motors"):
        motors_from_file(table(tmp_path, HEADINGS + "\n" + rows))
