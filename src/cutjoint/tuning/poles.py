"""Gains by pole placement: a bandwidth w and a damping ratio z, for the linear loop at the worst posture and payload.

Computed torque with the plant's own model makes the error's equation e'' + kd e' + kp e = 0, so kp = w^2, kd = 2 z w is
exact.  For laws whose gains are efforts, with D_i the inertia of actuator i,

    kp_i = (s w)^2 D_i,  kd_i = 2 z s w D_i

With D no less than the mass matrix M at any posture (the largest eigenvalue of D^-1 M is 1; D is 2 % more, which is
room for springs and weights) a mode of eigenvalue m obeys m x'' + 2 z s w x' + (s w)^2 x = 0: its damping z / sqrt(m)
is z or more.  What slows a light mode down, and what the robot does by itself, is met by s, the least for which every
pole of the linear loop has

    damping ratio >= z   and   decay >= min(z, 1) w

PID has a third pole at b w, b = 0.2: kp = (1 + 2 z b) w^2 D, kd = (2 z + b) w D, ki = b w^3 D with w as s w above, and
is held to a decay of b w.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from cutjoint.arrays import Array, positive
from cutjoint.doors import door
from cutjoint.errors import InputError
from cutjoint.reprs import line
from cutjoint.tuning.case import TuningCase
from cutjoint.tuning.rule import FoundGains

INTEGRAL = 0.2
"""b: where the pole of an integral is, as a part of the bandwidth."""
LEAST, MOST, TRIED = 0.25, 64.0, 60
SLACK = 1e-6
ROOM = 1.02


@door
@dataclass(frozen=True)
class PolePlacement:
    """What poles should be like.

    Attributes:
        bandwidth: w [rad/s].
        damping: z, least damping ratio of a pole.

    Raises:
        InputError: one of them is not positive.
    """

    bandwidth: float = 20.0
    damping: float = 1.0

    __repr__ = line(bandwidth="rad/s")

    def __post_init__(self) -> None:
        object.__setattr__(self, "bandwidth", positive("bandwidth", self.bandwidth, "rad/s"))
        object.__setattr__(self, "damping", positive("damping", self.damping))

    @property
    def words(self) -> str:
        """How it is told."""
        return f"poles, {self.bandwidth:g} rad/s, damping {self.damping:g}"


def by_poles(case: TuningCase, spec: PolePlacement) -> FoundGains:
    """Gains that place the poles.

    Raises:
        InputError: the law has other gains than kp, kd and ki, or no gains of this form do it.
    """
    names = set(case.row.gains)
    if not {"kp", "kd"} <= names <= {"kp", "ki", "kd"}:
        raise InputError(
            f"poles are placed for laws with the gains kp, kd and ki; {case.name} takes {', '.join(case.row.gains)}. "
            "Tune it by search"
        )
    w, z = spec.bandwidth, spec.damping
    if case.row.gains["kp"].unit == "1/s2":
        gains = {"kp": np.array(w * w), "kd": np.array(2.0 * z * w)}
        return FoundGains(gains, (), tuple(_exact(case, gains, spec)))
    size = _inertia(case)
    wanted = min(z, 1.0, INTEGRAL if "ki" in names else 1.0) * w

    def meets(scale: float) -> bool:
        loops = case.linear(_gains(size, scale * w, z, names), ideal=True)
        return all(
            one.damping >= min(z, 1.0) * (1.0 - SLACK) - SLACK and one.decay >= wanted * (1.0 - SLACK) for one in loops
        )

    scales = np.geomspace(LEAST, MOST, TRIED).tolist()
    first = next((k for k, scale in enumerate(scales) if meets(scale)), None)
    if first is None:
        raise InputError(
            f"no gains of this form give every pole a damping of {z:g} and a decay of {wanted:g} 1/s at all postures; "
            "ask for less, or tune by search"
        )
    low, high = scales[max(first - 1, 0)], scales[first]
    for _ in range(20 if first else 0):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if meets(middle) else (middle, high)
    told = [f"the gains are those of {high * w:.4g} rad/s and the largest inertia of every actuator on the way"]
    return FoundGains(_gains(size, high * w, z, names), (), tuple(told))


def _gains(size: Array, w: float, z: float, names: set[str]) -> Mapping[str, Array]:
    if "ki" not in names:
        return {"kp": w * w * size, "kd": 2.0 * z * w * size}
    b = INTEGRAL
    return {"kp": (1.0 + 2.0 * z * b) * w * w * size, "ki": b * w**3 * size, "kd": (2.0 * z + b) * w * size}


def _inertia(case: TuningCase) -> Array:
    """D: the largest inertia of every actuator, all by the factor that makes D no less than M; shape (n,)."""
    masses = [plant.mass for _, plants in case.plants for plant in plants]
    size = np.max([np.diag(one) for one in masses], axis=0)
    if not (size > 0.0).all():
        raise InputError("an actuator feels no inertia, so nothing can be placed; give the links masses")
    root = 1.0 / np.sqrt(size)
    largest = max(float(np.linalg.eigvalsh(root[:, None] * one * root[None, :])[-1]) for one in masses)
    return np.asarray(ROOM * size * max(largest, 1.0))


def _exact(case: TuningCase, gains: Mapping[str, Array], spec: PolePlacement) -> list[str]:
    """What becomes of exact gains where model and plant differ."""
    decay = min(one.decay for one in case.linear(gains, ideal=True))
    z, w = spec.damping, spec.bandwidth
    wanted = z * w if z <= 1.0 else w * (z - np.sqrt(z * z - 1.0))
    if abs(decay - wanted) <= 1e-3 * wanted:
        return ["kp = w^2 and kd = 2 z w are exact for this law, whose model is the robot's"]
    return [
        f"kp = w^2 and kd = 2 z w would be exact if the law's model were the robot; as it is, the slowest pole decays "
        f"at {decay:.4g} 1/s instead of {wanted:.4g} 1/s"
    ]
