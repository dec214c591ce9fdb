"""A recording as a scene with meshcat's own animation: the robot, the tool's paths and the actuators' efforts.

Every moving path of the scene gets tracks of position, quaternion and scale, sampled at the recording's frames and
sent as float32 arrays (meshcat's own Python writes a table of keys per number, five times the size).  The page, not
meshcat's player, runs the clock: that one falls back to the first frame at the end.
"""

from __future__ import annotations

import numpy as np
import umsgpack
from meshcat.animation import Animation, AnimationClip
from meshcat.path import Path
from meshcat.transformations import quaternion_from_matrix

from cutjoint.arrays import Array
from cutjoint.chain import ClosedChain
from cutjoint.viewer.film.document import Document
from cutjoint.viewer.film.recording import Recording
from cutjoint.viewer.picture import shapes
from cutjoint.viewer.picture.figure import ROOT, Figure, css
from cutjoint.viewer.picture.shapes import Colour

DESIRED: Colour = (0.35, 0.36, 0.4, 0.35)
ACTUAL: Colour = (0.55, 0.1, 0.7, 1.0)
EFFORT: Colour = (0.83, 0.08, 0.08, 0.9)
ARROW = 0.4
TURN = 0.3
TINY = 1e-4
TRAIL_POINTS = 600


class _Track:
    """Values of one property at the frames, in the compact form that three.js takes too."""

    def __init__(self, name: str, kind: str, frames: Array, values: Array) -> None:
        self._name, self._kind, self._frames, self._values = name, kind, frames, values

    def lower(self) -> dict[str, object]:
        return {
            "name": f".{self._name}",
            "type": self._kind,
            "times": umsgpack.Ext(0x17, self._frames.astype("<f4").tobytes()),
            "values": umsgpack.Ext(0x17, self._values.astype("<f4").tobytes()),
        }


def playback(chain: ClosedChain, recording: Recording, title: str = "") -> Document:
    """The recording as a page that plays it."""
    figure = Figure(chain, recording.postures[0])
    legend = [{"text": name, "colour": css(colour)} for name, colour in figure.colours.items()]
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
    }
    if recording.duration > 0:
        longest = _efforts(chain, figure, recording)
        data |= _trails(figure, recording, legend)
        data["effort"] = [
            {"name": a.name, "unit": a.effort_unit, "values": _rounded(recording.effort[:, i])}
            for i, a in enumerate(chain.actuators)
        ]
        legend.append({"text": f"effort, full size = {longest}", "colour": css(EFFORT)})
        _animate(figure, recording)
    data["toggles"] = [{"title": t, "paths": p, "shown": s} for t, (p, s) in figure.toggles.items()]
    return Document(figure.scene, data)


def _trails(figure: Figure, recording: Recording, legend: list[dict[str, str]]) -> dict[str, object]:
    """The tool's paths, named in the legend; what the page has to know of them."""
    found: dict[str, object] = {}
    every = max(1, len(recording.time) // TRAIL_POINTS)
    size = 0.0045 * figure.radius
    if recording.desired is not None:
        wanted = shapes.tube(recording.desired[::every], 2.4 * size, shapes.over(DESIRED))
        figure.scene.set_object(f"{ROOT}/desired", wanted)
        figure.toggle("Desired path", [f"{ROOT}/desired"], True)
        legend.append({"text": "desired path of the tool", "colour": css(DESIRED)})
        found["error"] = _rounded(np.linalg.norm(recording.desired - recording.tool, axis=1))
    if np.ptp(recording.tool, axis=0).max() > 0:
        path = recording.tool[::every]
        figure.scene.set_object(f"{ROOT}/actual", shapes.tube(path, size, shapes.over(ACTUAL)))
        figure.toggle("Tool path", [f"{ROOT}/actual"], True)
        legend.append({"text": "path of the tool so far", "colour": css(ACTUAL)})
        found["trail"] = {
            "path": f"{ROOT}/actual/<object>",
            "times": _rounded(recording.time[::every]),
            "indices": 30,
        }
    return found


def _efforts(chain: ClosedChain, figure: Figure, recording: Recording) -> str:
    """Arrows at the actuators: straight for forces, bent for torques; returns what their full size means."""
    for i, actuator in enumerate(chain.actuators):
        path, radius = f"{ROOT}/effort/{i}", figure.radius
        if actuator.kind == "translation":
            head = 0.09 * radius
            shaft, tip = shapes.arrow_parts(head, 0.016 * radius, shapes.over(EFFORT))
            figure.put(f"{path}/shaft/solid", shaft)
            figure.put(f"{path}/tip/solid", tip)
        else:
            for j, part in enumerate(shapes.turn_arrow(TURN * radius, 0.014 * radius, shapes.over(EFFORT))):
                figure.put(f"{path}/turn/{j}", part)
    figure.toggle("Efforts of the actuators", [f"{ROOT}/effort"], True)
    return ", ".join(f"{peak:.3g} {unit}" for unit, peak in _largest(chain, recording).items())


def _largest(chain: ClosedChain, recording: Recording) -> dict[str, float]:
    """Largest effort of all actuators that have the unit, by unit."""
    largest: dict[str, float] = {}
    for actuator, effort in zip(chain.actuators, recording.effort.T, strict=True):
        largest[actuator.effort_unit] = max(largest.get(actuator.effort_unit, 0.0), float(np.abs(effort).max()))
    return largest


def _animate(figure: Figure, recording: Recording) -> None:
    chain = figure.chain
    poses: dict[str, list[Array]] = {}
    for at in recording.postures:
        placed = {figure.link_path(n): p for n, p in chain.link_placements(at).items()}
        placed |= {p: m for p, m in figure.overlay_placements(at).items() if not p.endswith("/gap")}
        for path, matrix in placed.items():
            poses.setdefault(path, []).append(matrix)
    frames = np.arange(len(recording.time), dtype=float)
    tracks: dict[str, list[_Track]] = {}
    for path, matrices in poses.items():
        tracks[path] = _pose_tracks(frames, np.array(matrices))
    tracks |= _effort_tracks(figure, recording, frames)
    animation = Animation(default_framerate=recording.frames_per_second)
    for path, found in tracks.items():
        if found:
            clip = AnimationClip(fps=recording.frames_per_second)
            clip.tracks = dict(enumerate(found))
            animation.clips[Path(tuple(path.split("/")))] = clip
    figure.scene.set_animation(animation)


def _pose_tracks(frames: Array, matrices: Array) -> list[_Track]:
    """Tracks of position and quaternion; none where the path does not move."""
    if np.abs(matrices - matrices[0]).max() == 0.0:
        return []
    turns = np.array([quaternion_from_matrix(matrix)[[1, 2, 3, 0]] for matrix in matrices])
    signs = np.cumprod(np.where(np.einsum("ij,ij->i", turns[1:], turns[:-1]) < 0, -1.0, 1.0))
    turns[1:] *= signs[:, None]  # neighbouring frames on the same side, so that what lies between is short
    return [
        _Track("position", "vector3", frames, matrices[:, :3, 3]),
        _Track("quaternion", "quaternion", frames, turns),
    ]


def _effort_tracks(figure: Figure, recording: Recording, frames: Array) -> dict[str, list[_Track]]:
    chain, radius = figure.chain, figure.radius
    joints = {joint.name: joint for joint in chain.description.joints}
    places = [chain.link_placements(at) for at in recording.postures]
    largest = _largest(chain, recording)
    tracks: dict[str, list[_Track]] = {}
    for i, actuator in enumerate(chain.actuators):
        joint, path = joints[actuator.name], f"{ROOT}/effort/{i}"
        axis = shapes.along(np.asarray(joint.axis))
        matrices = np.array([place[joint.child] @ axis for place in places])
        figure.scene.set_transform(path, matrices[0])
        tracks[path] = _pose_tracks(frames, matrices)
        share = recording.effort[:, i] / max(largest[actuator.effort_unit], 1e-300)
        sign, size = np.where(share < 0, -1.0, 1.0), np.maximum(np.abs(share), TINY)
        one = np.ones_like(size)
        if actuator.kind == "translation":
            length, head = ARROW * radius * size, 0.09 * radius
            tip = np.minimum(1.0, length / head)
            body = np.maximum(length - head, TINY * radius)
            tracks[f"{path}/shaft"] = [_Track("scale", "vector3", frames, np.column_stack([tip, tip, sign * body]))]
            tracks[f"{path}/tip"] = [
                _Track("position", "vector3", frames, np.column_stack([0 * one, 0 * one, sign * body])),
                _Track("scale", "vector3", frames, np.column_stack([tip, tip, sign * tip])),
            ]
        else:
            tracks[f"{path}/turn"] = [_Track("scale", "vector3", frames, np.column_stack([size, sign * size, size]))]
    return tracks


def _rounded(values: Array) -> list[float]:
    """Six significant digits: enough to show, and short in a file."""
    return [float(f"{value:.6g}") for value in values]
