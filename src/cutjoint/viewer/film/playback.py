"""A recording as a scene with meshcat's own animation: the robot, the tool's paths and the actuators' efforts.

Every moving path of the scene gets tracks of position, quaternion and scale, sampled at the recording's frames.  The
page, not meshcat's player, runs the clock: that one falls back to the first frame at the end.
"""

from __future__ import annotations

import numpy as np
from meshcat.animation import Animation, AnimationClip
from meshcat.path import Path

from cutjoint.arrays import Array
from cutjoint.chain import ClosedChain
from cutjoint.viewer.film.arrows import EFFORT, arrow_tracks, draw_arrows
from cutjoint.viewer.film.curves import as_data
from cutjoint.viewer.film.document import Document
from cutjoint.viewer.film.recording import Recording
from cutjoint.viewer.film.tracks import FilmTrack, pose_tracks
from cutjoint.viewer.picture import shapes
from cutjoint.viewer.picture.figure import ROOT, Figure, css
from cutjoint.viewer.picture.places import Places, legend_of, show_places
from cutjoint.viewer.picture.shapes import Colour

DESIRED: Colour = (0.35, 0.36, 0.4, 0.45)
ACTUAL: Colour = (0.55, 0.1, 0.7, 1.0)
TRAIL_POINTS = 600
SAMPLES = 12
"""Postures of the motion that the picture has room for."""
MANY_NAMES = 12
"""Names of more actuators hide the robot, so they are off at first."""

KEPT = "\u00a0"
"""A space at which no line breaks."""
NAMED = 2
"""Actuators of one colour that the legend names; of more it names the first."""


def playback(chain: ClosedChain, recording: Recording, title: str = "", places: Places | None = None) -> Document:
    """The recording as a page that plays it, with `places` beside the robot."""
    also = recording.postures[:: max(1, len(recording.postures) // SAMPLES)]
    figure = Figure(chain, recording.postures[0], also, None if places is None else places.all_points)
    if places is not None:
        show_places(figure, places)
    legend = _limbs(figure) + ([] if places is None else legend_of(places))
    data: dict[str, object] = {
        "title": title or chain.description.title or chain.name,
        "about": list(recording.about),
        "duration": recording.duration,
        "legend": legend,
        "labels": figure.labels(),
        "time": _rounded(recording.time),
        "effort": [],
        "error": None,
        "trail": None,
        "names": chain.n <= MANY_NAMES,
        "curves": as_data(recording.curves),
    }
    if recording.duration > 0:
        longest = draw_arrows(figure, recording)
        data |= _trails(figure, recording, legend)
        data["effort"] = [
            {
                "name": a.name,
                "unit": a.effort_unit,
                "colour": figure.colour_of(a.name),
                "values": _rounded(recording.effort[:, i]),
            }
            for i, a in enumerate(chain.actuators)
        ]
        if longest:
            legend.append(
                {"text": f"effort, full size = {longest.replace(' ', KEPT)}", "colour": css(EFFORT), "over": True}
            )
        _animate(figure, recording)
    data["toggles"] = [{"title": t, "paths": p, "shown": s} for t, (p, s) in figure.toggles.items()]
    return Document(figure.scene, data)


def _limbs(figure: Figure) -> list[dict[str, str | bool]]:
    """What the colours of limbs mean: a row a colour, with the actuators that share it."""
    sharing: dict[str, list[str]] = {}
    for name, colour in figure.colours.items():
        sharing.setdefault(css(colour), []).append(name)
    return [
        {
            "text": ", ".join(names) if len(names) <= NAMED else f"{names[0]} and {len(names) - 1} others",
            "colour": colour,
        }
        for colour, names in sharing.items()
    ]


def _trails(figure: Figure, recording: Recording, legend: list[dict[str, str | bool]]) -> dict[str, object]:
    """The tool's paths, named in the legend; what the page has to know of them."""
    found: dict[str, object] = {}
    every = max(1, len(recording.time) // TRAIL_POINTS)
    size = 0.0045 * figure.radius
    if recording.desired is not None:
        wanted = shapes.tube(recording.desired[::every], 2.4 * size, shapes.over(DESIRED))
        figure.scene.set_object(f"{ROOT}/desired", wanted)
        figure.toggle("Desired path", [f"{ROOT}/desired"], True)
        legend.append({"text": "desired path of the tool", "colour": css(DESIRED), "over": True})
        found["error"] = _rounded(np.linalg.norm(recording.desired - recording.tool, axis=1))
    if np.ptp(recording.tool, axis=0).max() > 0:
        path = recording.tool[::every]
        figure.scene.set_object(f"{ROOT}/actual", shapes.tube(path, size, shapes.over(ACTUAL)))
        figure.toggle("Tool path", [f"{ROOT}/actual"], True)
        legend.append({"text": "path of the tool so far", "colour": css(ACTUAL), "over": True})
        found["trail"] = {
            "path": f"{ROOT}/actual/<object>",
            "times": _rounded(recording.time[::every]),
            "indices": 30,
        }
    return found


def _animate(figure: Figure, recording: Recording) -> None:
    chain = figure.chain
    poses: dict[str, list[Array]] = {}
    for at in recording.postures:
        placed = {figure.link_path(n): p for n, p in chain.link_placements(at).items()}
        placed |= {p: m for p, m in figure.overlay_placements(at).items() if not p.endswith("/gap")}
        for path, matrix in placed.items():
            poses.setdefault(path, []).append(matrix)
    frames = np.arange(len(recording.time), dtype=float)
    tracks: dict[str, list[FilmTrack]] = {}
    for path, matrices in poses.items():
        tracks[path] = pose_tracks(frames, np.array(matrices))
    tracks |= arrow_tracks(figure, recording, frames)
    animation = Animation(default_framerate=recording.frames_per_second)
    for path, found in tracks.items():
        if found:
            clip = AnimationClip(fps=recording.frames_per_second)
            clip.tracks = dict(enumerate(found))
            animation.clips[Path(tuple(path.split("/")))] = clip
    figure.scene.set_animation(animation)


def _rounded(values: Array) -> list[float]:
    """Six significant digits: enough to show, and short in a file."""
    return [float(f"{value:.6g}") for value in values]
