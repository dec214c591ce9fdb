"""Arrows at the actuators that show their efforts: straight for forces, bent for torques.

Their full size stands for the largest effort of the motion.  It is a part of the robot's size, or less where actuators
are closer to each other than that, so that arrows of neighbours do not cover each other.
"""

from __future__ import annotations

import numpy as np

from cutjoint.arrays import Array
from cutjoint.chain import ClosedChain
from cutjoint.mechanism import Posture
from cutjoint.viewer.film.recording import Recording
from cutjoint.viewer.film.tracks import FilmTrack, pose_tracks
from cutjoint.viewer.picture import shapes
from cutjoint.viewer.picture.figure import ROOT, Figure
from cutjoint.viewer.picture.shapes import Colour

EFFORT: Colour = (0.83, 0.08, 0.08, 0.9)
LARGEST, SMALLEST = 0.4, 0.1
"""Full size of an arrow, in radii of the robot."""
APART = 0.8
"""Full size of an arrow, in the usual distance from one actuator to the next."""
TURN, HEAD, SHAFT, RING = 0.75, 0.225, 0.04, 0.035
"""Radius of a bent arrow, head, radius of the shaft and of the bent shaft, in the full size."""
SMALL = 1e-4
"""Part of its full size that an arrow always has: a scale of nothing cannot be undone."""
NOTHING = 1e-9
"""Part of the robot's weight (times its length, for torques) below which efforts are rounding."""


def full_size(figure: Figure, at: Posture) -> float:
    """Length of the longest arrow [m]."""
    chain = figure.chain
    placed = chain.link_placements(at)
    places = np.array([placed[chain.description.joint(one.name).child][:3, 3] for one in chain.actuators])
    nearest = []
    for i, place in enumerate(places):
        away = np.linalg.norm(np.delete(places, i, axis=0) - place, axis=1)
        nearest += [float(away[away > 1e-6 * figure.radius].min())] if (away > 1e-6 * figure.radius).any() else []
    largest = LARGEST * figure.radius
    return float(np.clip(APART * np.median(nearest), SMALLEST * figure.radius, largest)) if nearest else largest


def draw_arrows(figure: Figure, recording: Recording) -> str:
    """Put the arrows into the scene; returns what their full size stands for, empty where there is no effort."""
    size = full_size(figure, recording.postures[0])
    for i, actuator in enumerate(figure.chain.actuators):
        path = f"{ROOT}/effort/{i}"
        if actuator.kind == "translation":
            shaft, tip = shapes.arrow_parts(HEAD * size, SHAFT * size, shapes.over(EFFORT))
            figure.put(f"{path}/shaft/solid", shaft)
            figure.put(f"{path}/tip/solid", tip)
        else:
            for j, part in enumerate(shapes.turn_arrow(TURN * size, RING * size, shapes.over(EFFORT))):
                figure.put(f"{path}/turn/{j}", part)
    figure.toggle("Efforts", [f"{ROOT}/effort"], True)
    return ", ".join(f"{peak:.3g} {unit}" for unit, peak in largest_efforts(figure.chain, recording).items() if peak)


def largest_efforts(chain: ClosedChain, recording: Recording) -> dict[str, float]:
    """Largest effort of all actuators that have the unit, by unit; 0 where all are but rounding."""
    weight = float(sum(link.inertial.mass for link in chain.description.links if link.inertial is not None)) * 9.81
    largest: dict[str, float] = {}
    for actuator, effort in zip(chain.actuators, recording.effort.T, strict=True):
        unit = actuator.effort_unit
        rounding = NOTHING * weight * (1.0 if actuator.kind == "translation" else chain.length)
        peak = float(np.abs(effort).max())
        largest[unit] = max(largest.get(unit, 0.0), peak if peak > rounding else 0.0)
    return largest


def arrow_tracks(figure: Figure, recording: Recording, frames: Array) -> dict[str, list[FilmTrack]]:
    """How the arrows move and change: path -> tracks."""
    chain, size = figure.chain, full_size(figure, recording.postures[0])
    places = [chain.link_placements(at) for at in recording.postures]
    largest = largest_efforts(chain, recording)
    tracks: dict[str, list[FilmTrack]] = {}
    for i, actuator in enumerate(chain.actuators):
        joint, path = chain.description.joint(actuator.name), f"{ROOT}/effort/{i}"
        axis = shapes.along(np.asarray(joint.axis))
        matrices = np.array([place[joint.child] @ axis for place in places])
        figure.scene.set_transform(path, matrices[0])
        tracks[path] = pose_tracks(frames, matrices)
        peak = largest[actuator.effort_unit]
        share = recording.effort[:, i] / peak if peak else np.zeros(len(frames))
        sign, part = np.where(share < 0, -1.0, 1.0), np.maximum(np.abs(share), SMALL)
        if actuator.kind == "translation":
            tip = np.minimum(1.0, part / HEAD)
            body = np.maximum(part - HEAD, SMALL) * size
            none = np.zeros_like(part)
            tracks[f"{path}/shaft"] = [FilmTrack("scale", "vector3", frames, np.column_stack([tip, tip, sign * body]))]
            tracks[f"{path}/tip"] = [
                FilmTrack("position", "vector3", frames, np.column_stack([none, none, sign * body])),
                FilmTrack("scale", "vector3", frames, np.column_stack([tip, tip, sign * tip])),
            ]
        else:
            tracks[f"{path}/turn"] = [FilmTrack("scale", "vector3", frames, np.column_stack([part, sign * part, part]))]
    return tracks
