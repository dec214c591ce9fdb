"""What a robot of a template must do, by plane and solid geometry alone: nothing of cutjoint's chain in it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np

Sizes = Mapping[str, float]
Array = np.ndarray


def meet(a: complex, b: complex, from_a: float, from_b: float, side: int) -> complex:
    """The point at these distances from two others, to the left (side 1) of the way from a to b."""
    way = b - a
    along = (abs(way) ** 2 + from_a**2 - from_b**2) / (2 * abs(way))
    return a + way / abs(way) * complex(along, side * math.sqrt(from_a**2 - along**2))


def planar(place: Array) -> complex:
    """A point of the world (3,) in the upright plane."""
    assert abs(place[1]) < 1e-9
    return complex(place[0], place[2])


def fourbar(size: Sizes, q: Mapping[str, float], tool: Array) -> float:
    """Distance of the tool from where the crank's angle puts it."""
    top = size["crank"] * np.exp(1j * q["crank"])
    knee = meet(top, size["ground"], size["coupler"], size["rocker"], 1)
    return abs(top + size["tracer"] * (knee - top) / size["coupler"] - planar(tool))


def fivebar(size: Sizes, q: Mapping[str, float], tool: Array) -> float:
    """How far the distal links are from their length."""
    at = planar(tool)
    worst = 0.0
    for side, joint in ((-1, "left_shoulder"), (1, "right_shoulder")):
        elbow = 0.5 * side * size["base"] + size["proximal"] * np.exp(1j * q[joint])
        worst = max(worst, abs(abs(at - elbow) - size["distal"]))
    return worst


def delta(size: Sizes, q: Mapping[str, float], tool: Array) -> float:
    """How far the rods are from their length."""
    worst = 0.0
    for i in range(3):
        out = np.array([math.cos(2 * math.pi * i / 3), math.sin(2 * math.pi * i / 3), 0.0])
        down, angle = np.array([0.0, 0.0, -1.0]), q[f"arm{i + 1}"]
        elbow = size["base"] * out + size["arm"] * (math.cos(angle) * out + math.sin(angle) * down)
        rod = tool + size["platform"] * out - elbow
        worst = max(worst, abs(float(np.linalg.norm(rod)) - size["rod"]))
    return worst


def stewart(size: Sizes, q: Mapping[str, float], tool: Array, rotation: Array) -> float:
    """How far the legs are from their slides' coordinates."""
    worst = 0.0
    for i in range(6):
        foot, top = (math.radians(120 * (i // 2) + one) for one in ((12, 48), (108, 72))[i % 2])
        at = tool + rotation @ [size["platform"] * math.cos(top), size["platform"] * math.sin(top), 0.0]
        leg = at - [size["base"] * math.cos(foot), size["base"] * math.sin(foot), 0.0]
        worst = max(worst, abs(float(np.linalg.norm(leg)) - q[f"leg{i + 1}_slide"]))
    return worst


def leg(size: Sizes, q: Mapping[str, float], tool: Array) -> float:
    """Distance of the foot from where Jansen's thirteen numbers put it."""
    u = size["crank"] / 15.0
    hip, pin = u * complex(-38.0, -7.8), 15.0 * u * np.exp(1j * q["crank"])
    upper, lower = meet(hip, pin, 41.5 * u, 50.0 * u, 1), meet(hip, pin, 39.3 * u, 61.9 * u, -1)
    out = meet(hip, upper, 40.1 * u, 55.8 * u, 1)
    heel = meet(out, lower, 39.4 * u, 36.7 * u, -1)
    return abs(meet(lower, heel, 49.0 * u, 65.7 * u, 1) - planar(tool))


def blank(size: Sizes, q: Mapping[str, float], tool: Array) -> float:
    """Distance of the piston from where the crank puts it."""
    top = 0.1 * np.exp(1j * q["crank"])
    return abs(top.real + math.sqrt(0.3**2 - top.imag**2) - planar(tool))


def stewart_legs(size: Sizes) -> bool:
    """Whether the pistons go into their cylinders at the shortest, and no leg stands flatter than its joint bends."""
    foot, top = (
        np.array([size[one] * math.cos(math.radians(angle)), size[one] * math.sin(math.radians(angle)), height])
        for one, angle, height in (("base", 12, 0.0), ("platform", 48, size["height"]))
    )
    leg = top - foot
    out = np.array([math.cos(math.radians(12)), math.sin(math.radians(12)), 0.0])
    length = float(np.linalg.norm(leg))
    tilt, swing = math.asin(leg @ out / length), math.atan2(leg @ np.cross(out, [0, 0, 1]), size["height"])
    return length - 0.5 * size["stroke"] >= 1.15 * size["stroke"] and max(abs(tilt), abs(swing)) <= math.radians(80)


CLOSES: Mapping[str, Callable[[Sizes], bool]] = {
    "fourbar": lambda s: (
        2 * max(s[one] for one in ("crank", "coupler", "rocker", "ground"))
        < sum(s[one] for one in ("crank", "coupler", "rocker", "ground"))
    ),
    "fivebar": lambda s: s["distal"] > 0.5 * s["base"] - s["proximal"],
    "delta": lambda s: (
        s["rod"] > s["base"] - s["platform"] + s["arm"] * math.cos(math.radians(105))
        and s["base"] - s["platform"] + s["arm"] > 0
    ),
    "stewart": stewart_legs,
    "leg": lambda s: True,
    "blank": lambda s: True,
}
"""Whether sizes can close with the elbows out, up to the arms' stops."""
