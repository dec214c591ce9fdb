"""The page about runs: whole, closed in itself, truthful about what is missing, and right on every screen."""

from __future__ import annotations

import re

import numpy as np
import pytest
from kit.runs import made

import cutjoint
from cutjoint.errors import InputError
from cutjoint.report import run_report
from cutjoint.report.named_runs import check_robot, robot_of
from cutjoint.robots import load
from cutjoint.simulation import run

SECTIONS = ("Can it be believed?", "How it was made", "What came of it", "Curves", "Animation")


def test_a_page_of_a_run_of_no_robot_says_what_is_missing(tmp_path):
    page = made(about={"robot": "nowhere", "gains": {"kp": [[3.5]]}, "law": "</script><b>"}).report(tmp_path / "a.html")
    text = (tmp_path / "a.html").read_text()
    assert all(f">{name}</h2>" in text for name in SECTIONS)
    assert "kp 3.5" in text
    assert "&#x27;nowhere&#x27;, which is no robot here" in text
    assert "There is no animation" in text
    assert "<b>" not in text.replace("<b>run</b>", "")
    assert not re.search(r'(?:src|href)="(?!#)', text)
    assert page.verdicts["run"].grade == "good"


def test_runs_stand_beside_each_other_with_a_verdict_each():
    drifting = made(kinetic=np.linspace(0.0, 1.0, 60))
    page = run_report({"good": made(), "bad <run>": drifting})
    assert [one.grade for one in page.verdicts.values()] == ["good", "bad"]
    assert page.html.count('class="overall ') == 2
    assert "bad &lt;run&gt;" in page.html
    assert "bad <run>" not in page.html.split("<script")[0]
    assert "good; bad" not in page.html


@pytest.mark.parametrize("name", ["run.pdf", "missing/run.html", "."])
def test_places_where_no_page_can_be_written_are_refused_before_the_work(tmp_path, name):
    with pytest.raises(InputError, match=r"written as|does not exist|is a folder"):
        made().report(tmp_path / name)


def test_a_robot_of_the_same_name_with_other_actuators_is_refused():
    with pytest.raises(InputError, match="made with"):
        robot_of(made(about={"robot": "fourbar"}))
    with pytest.raises(InputError, match="does not tell its robot"):
        robot_of(made(about={"robot": ""}))
    with pytest.raises(InputError, match="made with"):
        run_report(made(), robot=load("fourbar"))


@pytest.fixture(scope="module")
def swing():
    chain = load("fourbar")
    return run(chain, duration=0.1, every=0.01), chain


@pytest.mark.slow
def test_a_run_of_a_robot_has_reactions_limits_and_an_animation(swing, tmp_path):
    result, chain = swing
    page = result.report()
    assert "largest reactions" in page.html
    assert "<iframe" in page.html
    check_robot(result, chain)
    # the reactions' table has the peaks of the reactions themselves
    found = cutjoint.simulation.reactions_of(result, chain)
    for one in found.peaks:
        assert f'<td>{one.name}</td><td class="n">{one.force:.4g}</td>' in page.html


@pytest.mark.slow
def test_a_run_with_a_payload_that_the_robot_has_not_gets_no_reactions(swing):
    _, chain = swing
    heavy = run(chain.with_payload(1.0), duration=0.1, every=0.01)
    page = run_report(heavy, robot=chain)
    assert "largest reactions" not in page.html
    assert "a run with a payload" in page.html
    assert "masses, lengths" in heavy.report().html  # the robot of that name has no payload
    given = run_report(heavy, robot=chain.with_payload(1.0))
    assert "largest reactions" in given.html
