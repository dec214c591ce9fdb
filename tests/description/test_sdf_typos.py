"""Slips of the pen in SDF files are errors that name what was meant (every slip is told: `tests/attacks/`)."""

from __future__ import annotations

from pathlib import Path

from cutjoint.description import read_checked

SAMPLES = Path(__file__).parent / "samples"


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
