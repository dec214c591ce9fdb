"""docs/reproduction.md and the README's section about it, figure by figure against what is computed.

All runs of the reproduction are made once; every table of the document is compared cell by cell, and every sentence
with a figure is written anew from the runs and looked for.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from cutjoint.experiments import cpm, cpm_claims, cpm_law_claims, omega3, study
from cutjoint.experiments.cpm_claims import TITLES
from cutjoint.experiments.tables import Verdict
from cutjoint.papers.cpm.published import CIRCLE, SETTLING_TIME
from cutjoint.papers.omega3.published import ERROR_BOUND
from cutjoint.papers.publication import PrintedNumber
from cutjoint.pool import run_all
from cutjoint.tuning.known import GAINS

ROOT = Path(__file__).resolve().parents[2]
NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e-?\d+)?")
LESS = re.compile(r"< (?=\d)")
WORDS = ("no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve")
TABLE_3 = {
    "inferred code, solver steps": "inferred",
    "(39), solver steps": "steps",
    "(39), uniform 1 ms": "equation",
    "Pinocchio, lumped": "lumped",
    "Pinocchio, distributed": "distributed",
}
SETUPS = {
    "equation (42), continuous control": "paper",
    "the same, started 60 mm off the path": "home",
    "Pinocchio, lumped rods, 1 kHz": "lumped",
    "Pinocchio, distributed rods, 1 kHz": "distributed",
    "the same, payload 20 % too heavy": "heavy",
}


def section(file: str, heading: str) -> str:
    """What stands under a heading, up to the next one of its rank or above."""
    text = (ROOT / file).read_text(encoding="utf-8")
    rank = len(re.search(rf"^(#+) {re.escape(heading)}$", text, re.MULTILINE)[1])
    after = re.split(rf"^#{{{rank}}} {re.escape(heading)}$", text, flags=re.MULTILINE)[1]
    return re.split(rf"^#{{1,{rank}}} ", after, flags=re.MULTILINE)[0]


def rows(text: str) -> list[dict[str, str]]:
    """The rows of the one Markdown table in a text."""
    lines = [line.strip()[2:-2].split(" | ") for line in text.splitlines() if line.startswith("| ")]
    return [dict(zip(lines[0], line, strict=True)) for line in lines[1:]]


def prose(text: str) -> str:
    """A text in one line, without emphasis."""
    return " ".join(text.replace("**", "").replace("*everywhere*", "everywhere").split())


def same(shown: str, computed: str) -> None:
    """The same words, and every number the same in the digits that are shown; `< x` stands for any number below x."""
    bounds = [shown[: one.start()].count(" ") for one in LESS.finditer(shown)]
    assert NUMBER.sub("#", LESS.sub("", shown)) == NUMBER.sub("#", computed)
    below = [LESS.search(shown[max(0, one.start() - 2) : one.end()]) is not None for one in NUMBER.finditer(shown)]
    assert sum(below) == len(bounds)
    for wanted, found, bounded in zip(NUMBER.findall(shown), NUMBER.findall(computed), below, strict=True):
        if bounded:
            assert abs(float(found)) < float(wanted), (shown, computed)
        else:
            # The report's own last digit may round the other way.
            got, asked = PrintedNumber(found).resolution, PrintedNumber(wanted).resolution
            spare = 0.5 * got * (got < asked)
            assert abs(float(found) - float(wanted)) <= 0.5 * asked + spare, (shown, computed)


def test_a_wrong_figure_would_be_noticed():
    same("PD 0.785 mm, < 1e-9 m", "PD 0.7851 mm, 2e-12 m")
    for wrong in ("PD 0.786 mm, < 1e-9 m", "PD 0.785 mm, < 1e-12 m", "PD 0.785 m, < 1e-9 m", "PD 0.785 mm, 1e-9 m"):
        with pytest.raises(AssertionError):
            same(wrong, "PD 0.7851 mm, 2e-12 m")


@pytest.fixture(scope="module")
def everything():
    return run_all(study.tasks(["cpm", "omega3"]))


@pytest.fixture(scope="module")
def found(everything):
    return {key: value for (robot, key), value in everything.items() if robot == "cpm"}


@pytest.fixture(scope="module")
def found_omega3(everything):
    return {key: value for (robot, key), value in everything.items() if robot == "omega3"}


@pytest.mark.slow
def test_table_3(found):
    seen = 0
    for row in rows(section("docs/reproduction.md", "Table 3")):
        name = next(name for name, title in TITLES.items() if title == row["controller"])
        printed = (cpm.ROWS[name].position_error, cpm.ROWS[name].velocity_error)
        assert row["printed"] == ", ".join(map(str, printed))
        for heading, column in TABLE_3.items():
            position, velocity = (PrintedNumber(text) for text in row[heading].split(", "))
            error = found["run", name, column].rmse()
            assert position.agrees(error.position), (name, column)
            assert velocity.agrees(error.velocity), (name, column)
            seen += 1
    assert seen == 20


@pytest.mark.slow
def test_table_3_of_the_errata(found):
    titles = {TITLES[name] if name != "feedforward" else "feedforward": name for name in cpm.ROWS}
    for row in rows(section("docs/errata.md", "Table 3")):
        name = titles.pop(row["controller"])
        for heading in ("inferred code, solver steps", "(39), solver steps", "(39), uniform 1 ms"):
            error = found["run", name, TABLE_3[heading]].rmse()
            for text, value in zip(row[heading].split(", "), error, strict=True):
                assert PrintedNumber(text).agrees(value), (name, heading)
    assert not titles
    error = found["rule", "feedforward", "inferred"].error_of_guess
    assert f"K_P = 7053 leaves {1e3 * error:.6f} mm with the inferred code" in prose(
        section("docs/errata.md", "Table 3")
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("heading", "module"),
    [("Claims about table 3", cpm_claims), ("Claims about the control laws", cpm_law_claims)],
)
def test_claims(found, heading, module):
    shown, computed = rows(section("docs/reproduction.md", heading)), module.claims(found)
    for row, claim in zip(shown, computed, strict=True):
        assert (row["where"], row["claim"], row["verdict"]) == (claim.where, claim.text, str(claim.verdict))
        same(row["found"], claim.found)


def agreeing(found, column):
    """Which printed errors a column gives in every digit."""
    return {
        (name, index)
        for name, row in cpm.ROWS.items()
        for index, printed in enumerate((row.position_error, row.velocity_error))
        if printed.agrees(found["run", name, column].rmse()[index])
    }


@pytest.mark.slow
def test_sentences_about_table_3(found):
    text = prose(section("docs/reproduction.md", "Table 3"))
    inferred, steps, even = (agreeing(found, column) for column in ("inferred", "steps", "equation"))
    assert f"it gives the printed digits of {WORDS[len(inferred)]} of the eight errors" in text
    assert steps == {("computed-torque", 0), ("computed-torque", 1)}
    assert steps < inferred
    assert f"equation (39) gives the printed digits of {WORDS[len(steps)]} of these {WORDS[len(inferred)]}" in text
    assert inferred - steps == {("feedforward", 0), ("feedforward", 1), ("pd", 0)}
    assert f"the other {WORDS[len(inferred - steps)]}, both of PD + feedforward and the position error of PD" in text
    assert not even, "the averaging is needed for every one of them"
    speed = float(np.linalg.norm(found["run", "pd", "equation"].velocity_error[0]))
    assert f"the robot rests and the path moves at {speed:.4f} m/s" in text
    times = [found["run", name, "steps"].time for name in cpm.ROWS]
    close = [np.searchsorted(t, 0.01) / len(t) / (0.01 / CIRCLE.duration) for t in times]
    assert f"in the first 10 ms the solver's steps lie {min(close):.1f} to {max(close):.1f} times as close" in text
    # Uniform rods cost less than the choice of samples does.
    for name in cpm.ROWS:
        errors = {column: np.array(found["run", name, column].rmse()) for column in TABLE_3.values()}
        assert (abs(errors["distributed"] - errors["equation"]) < abs(errors["steps"] - errors["equation"])).all()
        np.testing.assert_allclose(errors["lumped"], errors["equation"], rtol=1e-6)


@pytest.mark.slow
def test_sentences_about_the_claims(found):
    text = prose(section("docs/reproduction.md", "Claims about table 3"))
    row, late = cpm.ROWS["feedforward"], found["run", "feedforward", "inferred"]
    error = found["rule", "feedforward", "inferred"].error_of_guess
    assert f"code at K_P = {row.k_p:g} leaves {1e3 * error:.6f} mm with PD + feedforward" in text
    assert f"more than the {1e3 * row.bound:g} mm of section 5.4.3" in text
    first = late.time[np.searchsorted(late.time, SETTLING_TIME)] - SETTLING_TIME
    assert f"after 0.3 s, {1e3 * first:.1f} ms later, the error is" in text
    assert f"the error is {1e3 * late.worst_axis_error(SETTLING_TIME):.6f} mm" in text
    load = {name: found["load", name].deviation for name in cpm.ROWS}
    text = prose(section("docs/reproduction.md", "Claims about the control laws"))
    assert f"make {TITLES[min(load, key=load.get)]} the stiffest of the four" in text
    assert f"and {TITLES[max(load, key=load.get)]} the softest" in text
    assert f"plus {100 * (cpm_law_claims.cpm_laws.REASONABLE - 1):.0f} %: at 100 Hz a higher rate" in text


@pytest.mark.slow
def test_the_cost_of_lumping(found, found_omega3):
    text = prose(section("docs/reproduction.md", "The cost of lumping"))
    cost = found["cost"]
    worst = int(np.argmax(cost.error))
    assert f"at most {cost.error[worst]:.2f} N along the circle (limb {worst + 1})" in text
    assert f"which is {100 * cost.error[worst] / cost.peak.max():.1f} % of the largest force" in text
    assert f"and {cost.percent[worst]:.1f} % of that limb's" in text
    text = prose(section("docs/reproduction.md", "Omega-3"))
    cost = found_omega3["cost"]
    assert f"Lumping the rods costs up to {cost.error.max():.4f} N m, " in text
    assert f"{cost.percent.min():.1f} to {cost.percent.max():.1f} % of an arm's peak torque" in text
    arms = {one.about: float((one.change / found_omega3["arms"][0].peak).max()) for one in found_omega3["arms"]}
    ring, axis, elbow = (
        f"{100 * arms[about]:.0f} %"
        for about in ("half-ring of radius L_A", "all its mass at the motor axis", "all its mass at the elbow")
    )
    assert f"half-disc {ring}, all its mass at the axis {axis}, at the elbow {elbow} of the peak" in text


@pytest.mark.slow
def test_the_omega3_s_runs(found_omega3):
    text = section("docs/reproduction.md", "Omega-3")
    headings = {"computed torque": "computed-torque", "PD + feedforward": "feedforward"}
    errors = []
    for row, setup in zip(rows(text), omega3.SETUPS, strict=True):
        assert SETUPS[row["plant"]] == setup
        for heading, name in headings.items():
            error = found_omega3["run", name, setup].worst_error(SETTLING_TIME)
            assert row[heading].endswith(" mm")
            assert PrintedNumber(row[heading][:-3]).agrees(1e3 * error)
            errors.append(error)
    assert "The claim holds everywhere" in prose(text)
    assert max(errors) < ERROR_BOUND
    torque, forward = GAINS["omega3"]["computed-torque"], GAINS["omega3"]["feedforward"]
    assert f"computed torque, K_P = {torque['kp']:g} 1/s², K_D = {torque['kd']:g} 1/s," in prose(text)
    assert f"PD + feedforward, K_P = {forward['kp']:g} N m/rad, K_D = {forward['kd']:g} N m s/rad." in prose(text)


@pytest.mark.slow
def test_the_readme(found, found_omega3):
    text = prose(section("README.md", "What the papers' experiments came to"))
    inferred, steps = agreeing(found, "inferred"), agreeing(found, "steps")
    gains = sum(found["rule", name, "inferred"].gain == cpm.ROWS[name].k_p for name in cpm_claims.RULED)
    assert not any(found["rule", name, "equation"].gain == cpm.ROWS[name].k_p for name in cpm_claims.RULED)
    assert f"{WORDS[len(inferred)]} of eight errors come out to every printed digit" in text
    assert f"the {WORDS[len(steps)]} of computed torque" in text
    tuned = f"{WORDS[gains]} of {WORDS[len(cpm_claims.RULED)]} tuned gains"
    assert f"the other {WORDS[len(inferred - steps)]}, and {tuned}, only with a model that differs" in text
    laws = cpm_law_claims.claims(found)
    holding = sum(one.verdict is Verdict.HOLDS for one in laws)
    assert len(laws) == 16
    assert f"{WORDS[holding]} claims of sixteen hold" in text
    assert "the error does fall below 3 mm within 0.3 s" in text
    assert all(
        found_omega3["run", name, setup].worst_error(SETTLING_TIME) < ERROR_BOUND
        for name in omega3.LAWS
        for setup in omega3.SETUPS
    )
    assert ERROR_BOUND == 3e-3
