from __future__ import annotations

import base64
import hashlib
import html
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from kit.pages import data_of, scene_of, tracks_of

from cutjoint.chain import ClosedChain
from cutjoint.errors import InputError, ViewerError
from cutjoint.robots import PUBLISHED, load
from cutjoint.simulation import Result, run
from cutjoint.simulation.result import result_of
from cutjoint.viewer import Document, play, show
from cutjoint.viewer.film.recording import FEWEST, FRAMES, frame_times, from_result, from_trajectory
from cutjoint.viewer.film.tracks import pose_tracks

LAG = np.array([0.0, 0.001, 0.0])


def made_up(chain: ClosedChain, full: bool) -> Result:
    """A made-up run of 0.4 s that starts at 2 s: all actuators move a little, the tool lags by a millimetre."""
    time = np.sort(np.concatenate([np.linspace(2.0, 2.4, 9), [2.001, 2.0015]]))
    share = (time - 2.0) / 0.4
    q = chain.home.q + 0.05 * share[:, None] * np.array([1.0, -1.0, 0.5])
    postures = [chain.close(one, chain.home) for one in q]
    tool = np.array([chain.tool(at).position for at in postures])
    zeros, flat = np.zeros_like(q), np.zeros(len(time))
    columns = dict(  # noqa: C408
        time=time,
        q=q,
        v=zeros,
        desired_q=q,
        desired_v=zeros,
        tool=tool,
        tool_velocity=zeros,
        desired_tool=tool + LAG,
        desired_tool_velocity=zeros,
        effort=10.0 * (share[:, None] - 0.5) * np.array([1.0, 2.0, -3.0]),
        gap=np.zeros((len(time), 2)),
        kinetic=flat,
        potential=flat,
        work=flat,
        q_full=np.array([at.q_full for at in postures]) if full else q,
    )
    return result_of(columns, {"robot": chain.name, "plant": "made up", "rate": None})


@pytest.mark.parametrize("full", [True, False])
def test_a_result_becomes_closed_postures_at_even_times(chain: ClosedChain, full: bool) -> None:
    result = made_up(chain, full)
    recording = from_result(chain, result)
    np.testing.assert_allclose(np.diff(recording.time), recording.duration / (len(recording.time) - 1))
    assert recording.time[0] == 0.0
    assert recording.duration == pytest.approx(0.4)
    assert len(recording.time) == FEWEST + 1
    for at in recording.postures:
        assert max(at.gap) <= 1e-9
    np.testing.assert_allclose(recording.postures[-1].q, result.q[-1], atol=1e-12)
    np.testing.assert_allclose(recording.postures[0].q, result.q[0], atol=1e-12)
    assert recording.desired is not None
    np.testing.assert_allclose(recording.desired - recording.tool, np.tile(LAG, (len(recording.time), 1)), atol=1e-12)
    assert "plant: made up" in recording.about


def test_a_run_is_shown_in_its_own_configurations_whatever_branch_it_fell_to() -> None:
    """A free five-bar passes a singularity: closing its actuated coordinates again would show the other branch."""
    robot = load("fivebar")
    result = run(robot, duration=0.4, every=0.01, joint_limits="ignore")
    last = from_result(robot, result).postures[-1]
    np.testing.assert_allclose(last.q_full, result.q_full[-1], atol=1e-12)
    np.testing.assert_allclose(robot.tool(last).position, result.tool[-1], atol=1e-9)


def test_another_robot_of_the_same_width_is_refused(chain: ClosedChain) -> None:
    result = made_up(chain, full=False)
    names = [[f"other{k}", one.kind] for k, one in enumerate(chain.actuators)]
    with pytest.raises(InputError, match="other0"):
        from_result(chain, replace(result, about={**result.about, "actuators": names}))
    with pytest.raises(InputError, match="m away from where the result has it"):
        from_result(chain, replace(result, tool=result.tool + 1e-3))
    full = made_up(chain, full=True)
    with pytest.raises(InputError, match="are none of"):
        from_result(chain, replace(full, q_full=full.q_full + 0.1))


def test_a_long_run_has_a_bounded_number_of_frames() -> None:
    times = frame_times(3600.0)
    assert len(times) == FRAMES + 1
    assert times[-1] == 3600.0
    assert len(frame_times(1e-4)) == FEWEST + 1
    assert np.diff(frame_times(4.0)) == pytest.approx(1 / 30)


def test_a_trajectory_is_followed_exactly_with_its_inverse_dynamics(chain: ClosedChain) -> None:
    trajectory = PUBLISHED[chain.description.name].trajectory()
    recording = from_trajectory(chain, trajectory)
    assert recording.desired is None
    for t, at, tool in zip(recording.time[::20], recording.postures[::20], recording.tool[::20], strict=True):
        np.testing.assert_allclose(tool, trajectory.at(float(t)).position, atol=1e-9)
        assert max(at.gap) <= 1e-9
    assert np.abs(recording.effort).max() > 0


def test_another_robots_result_is_refused(chain: ClosedChain) -> None:
    result = made_up(chain, full=False)
    two = {name: getattr(result, name)[:, :2] for name in ("q", "v", "desired_q", "desired_v", "effort")}
    with pytest.raises(InputError, match="2 actuators"):
        from_result(chain, result_of({**result.columns, **two}, result.about))


def test_the_animation_ends_where_the_run_ends_and_turns_the_short_way(chain: ClosedChain) -> None:
    result = made_up(chain, full=True)
    document = play(chain, result)
    last = chain.link_placements(chain.close(result.q[-1], chain.home).q_full)
    first = chain.link_placements(chain.close(result.q[0], chain.home).q_full)
    seen = set()
    for path, name, values in tracks_of(document.html):
        assert np.isfinite(values).all()
        if name == ".quaternion":
            assert (np.einsum("ij,ij->i", values[1:], values[:-1]) > 0).all()
            np.testing.assert_allclose(np.linalg.norm(values, axis=1), 1.0, atol=1e-6)
        for link in chain.description.links:
            if path.startswith("/robot/links/") and path.endswith(f"_{link.name}") and name == ".position":
                np.testing.assert_allclose(values[-1], last[link.name][:3, 3], atol=1e-6)
                np.testing.assert_allclose(values[0], first[link.name][:3, 3], atol=1e-6)
                seen.add(link.name)
    moving = {name for name in last if np.abs(last[name] - first[name]).max() > 0}
    assert seen == moving
    assert len(moving) >= 8


def test_a_link_that_turns_twice_never_takes_the_long_way() -> None:
    angles, axis = np.linspace(0.0, 4 * np.pi, 60), np.array([1.0, 2.0, -2.0]) / 3.0
    skew = np.cross(np.eye(3), axis).T
    matrices = np.tile(np.eye(4), (60, 1, 1))
    matrices[:, :3, :3] += np.sin(angles)[:, None, None] * skew + (1 - np.cos(angles))[:, None, None] * (skew @ skew)
    _, turns = (track.lower() for track in pose_tracks(np.arange(60.0), matrices))
    values = np.frombuffer(turns["values"].data, "<f4").reshape(-1, 4)
    np.testing.assert_allclose(np.einsum("ij,ij->i", values[1:], values[:-1]), np.cos(2 * np.pi / 59), atol=1e-5)
    np.testing.assert_allclose(np.abs(values[:, 3]), np.abs(np.cos(angles / 2)), atol=1e-5)


def test_arrows_show_the_efforts(chain: ClosedChain) -> None:
    result = made_up(chain, full=True)
    sizes: dict[int, np.ndarray[Any, Any]] = {}
    for path, name, values in tracks_of(play(chain, result).html):
        found = re.fullmatch(r"/robot/effort/(\d)/(shaft|turn)", path)
        if found and name == ".scale":
            sizes[int(found[1])] = values[:, 2 if found[2] == "shaft" else 1]
    for i, effort in enumerate(result.effort[[0, -1]].T):
        assert np.sign(sizes[i][[0, -1]]).tolist() == np.sign(effort).tolist()
    assert np.abs(sizes[2]).max() > 1.4 * np.abs(sizes[1]).max() > 1.4 * np.abs(sizes[0]).max()


def test_the_page_makes_no_request_and_runs_its_own_scripts_only(chain: ClosedChain) -> None:
    page = play(chain, PUBLISHED[chain.description.name].trajectory()).html
    policy = html.unescape(re.search(r'Content-Security-Policy" content="([^"]*)"', page)[1])  # type: ignore[index]
    assert policy.startswith("default-src 'none'")
    assert "eval" not in policy
    assert "unsafe-inline" not in policy.partition("script-src")[2].partition(";")[0]
    scripts = re.findall(r"<script>(.*?)</script>", page, re.DOTALL)
    digests = [base64.b64encode(hashlib.sha256(script.encode()).digest()).decode() for script in scripts]
    assert len(digests) == 5
    assert all(f"'sha256-{digest}'" in policy for digest in digests)
    without_scripts = re.sub(r"<script.*?</script>", "", page, flags=re.DOTALL)
    assert not re.search(r"""(src|href)\s*=|url\(|@import""", without_scripts)
    assert 0.9e6 < len(page.encode()) < 1.6e6


def test_names_of_a_robot_cannot_break_out_of_the_page(chain: ClosedChain) -> None:
    evil = "</script><script>alert(1)</script><img src=x onerror=alert(2)>"
    page = play(chain, made_up(chain, full=True), title=evil).html
    assert "<script>alert" not in page
    assert "<img" not in page
    assert data_of(page)["title"] == evil


def test_a_still_page_shows_the_posture_it_was_given(chain: ClosedChain) -> None:
    at = chain.close(chain.home.q + 0.03, chain.home)
    page = show(chain, at).html
    assert data_of(page)["duration"] == 0.0
    placed = {c["path"]: np.array(c["matrix"]).reshape(4, 4).T for c in scene_of(page) if c["type"] == "set_transform"}
    for i, link in enumerate(chain.description.links):
        expected = chain.link_placements(at)[link.name]
        np.testing.assert_allclose(placed[f"/robot/links/{i}_{link.name}"], expected, atol=1e-12)


def test_a_notebook_gets_the_page_in_a_sandboxed_frame(chain: ClosedChain) -> None:
    frame = show(chain)._repr_html_()
    found = re.fullmatch(r'<iframe srcdoc="([^"]*)" style="[^"]*" sandbox="allow-scripts"></iframe>', frame)
    assert found
    assert html.unescape(found[1]).startswith("<!DOCTYPE html>")


@pytest.fixture
def document(cpm: ClosedChain) -> Document:
    return show(cpm)


def test_a_file_is_written_whole_and_its_size_is_told(document: Document, tmp_path: Path) -> None:
    target = tmp_path / "a.html"
    target.write_text("old")
    assert document.save(target) == target.stat().st_size
    assert target.read_text().startswith("<!DOCTYPE html>")
    assert list(tmp_path.iterdir()) == [target]


@pytest.mark.parametrize("name", ["missing/a.html", ""])
def test_a_file_that_cannot_be_written_leaves_nothing(document: Document, tmp_path: Path, name: str) -> None:
    with pytest.raises(ViewerError, match="cannot write"):
        document.save(tmp_path / name)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("bad", [{"width": 3}, {"height": 100_000}, {"time": -1.0}, {"time": float("nan")}])
def test_a_picture_of_impossible_size_or_time_is_refused(
    document: Document, tmp_path: Path, bad: dict[str, Any]
) -> None:
    with pytest.raises(InputError):
        document.picture(tmp_path / "a.png", **bad)
    assert list(tmp_path.iterdir()) == []
