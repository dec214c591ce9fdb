"""Motors and gears against what the actuators must do: how much of each motor is used at which ratio.

Behind a gear that makes it turn g times as fast as its actuator, a motor of the inertia J must give

    tau = g J a + b eta^-s / g

with b the effort of the actuator without rotors, a its acceleration, eta the efficiency of the gear, and s = -1 where
the motion drives the motor (b v < 0), else 1.  So its mean square at every ratio follows from three integrals,

    rms^2 = g^2 J^2 <a^2> + 2 J <a b eta^-s> + <b^2 eta^-2s> / g^2

and is least where g^4 = <b^2 eta^-2s> / (J^2 <a^2>); of a load that is an inertia alone g = sqrt(J_load / J), the ratio
that makes both inertias equal.  What counts is the worst of three uses, each a part of what the motor can give: the
largest effort beside the curve of the largest effort, the root mean square beside what the motor stands for ever at its
root mean square speed, and the largest speed beside its own.  The best ratio is the one of the least worst use.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cutjoint.arrays import Array
from cutjoint.mechanism import Actuator
from cutjoint.reprs import line
from cutjoint.sizing.cycle import LoadCycle
from cutjoint.sizing.gearing import Gearing
from cutjoint.sizing.motor import ServoMotor

RATIOS, NARROWINGS = 81, 40
"""Ratios that are tried, and steps of the golden section between the best of them."""
SPAN = 1e4
"""Largest over least ratio that is tried."""
GOLDEN = 0.5 * (5.0**0.5 - 1.0)


@dataclass(frozen=True)
class MotorFit:
    """A motor behind a gear at an actuator, all trajectories taken together.

    Attributes:
        actuator, motor: which.
        ratio: of the gear: how many times as fast as the actuator, or as the screw, the motor moves.
        is_chosen: whether the ratio is one of those that may be chosen, not any.
        best_ratio: any ratio, of the least worst use.
        least_heat: any ratio, of the least root mean square effort.
        effort: the largest of the motor, [N m] or [N].
        rms_effort: its root mean square.
        speed: the largest of the motor, [rad/s] or [m/s].
        rms_speed: its root mean square.
        peak_use: the largest effort beside what the motor can give at its speed.
        heat_use: the root mean square beside what it stands for ever.
        speed_use: the largest speed beside its own.
        inertia_ratio: inertia of the actuator at the motor, beside that of the motor and gear; infinite without one.
        reflected: what motor and gear weigh at the actuator, [kg m2] or [kg].
        temperature: of the winding in the long run [degC]; None where the table does not tell enough.
        brake_use: what a brake must hold beside what it holds; None without a brake.
        worst_at: the trajectory of the worst use.
    """

    actuator: Actuator
    motor: ServoMotor
    ratio: float
    is_chosen: bool
    best_ratio: float
    least_heat: float
    effort: float
    rms_effort: float
    speed: float
    rms_speed: float
    peak_use: float
    heat_use: float
    speed_use: float
    inertia_ratio: float
    reflected: float
    temperature: float | None
    brake_use: float | None
    worst_at: str

    __repr__ = line(
        "actuator", "motor", "ratio", "effort", "rms_effort", "speed", "use", effort="N or N m", rms_effort="N or N m",
        speed="m/s or rad/s",
    )  # fmt: skip

    @property
    def use(self) -> float:
        """The worst of the uses of effort, heat and speed; the motor can give it where it is at most 1."""
        return max(self.peak_use, self.heat_use, self.speed_use)

    @property
    def margin(self) -> float:
        """Part of the motor that is left, below 0 where it is too small."""
        return 1.0 - self.use

    @property
    def is_too_hot(self) -> bool:
        """Whether the winding gets hotter than it may."""
        limit = self.motor.max_temperature
        return self.temperature is not None and limit is not None and self.temperature > limit

    @property
    def fits(self) -> bool:
        """Whether the motor does it, its winding stays cold enough, and its brake, where it has one, holds."""
        return self.use <= 1.0 and not self.is_too_hot and (self.brake_use is None or self.brake_use <= 1.0)

    @property
    def why_not(self) -> str:
        """What is too much, in words; empty where it fits."""
        wrong = [
            ("peak effort", self.peak_use > 1.0),
            ("rms effort", self.heat_use > 1.0),
            ("speed", self.speed_use > 1.0),
            ("temperature", self.is_too_hot),
            ("brake", self.brake_use is not None and self.brake_use > 1.0),
        ]
        return ", ".join(name for name, is_wrong in wrong if is_wrong)


def matched(
    cycles: Sequence[LoadCycle], actuators: Sequence[Actuator], motors: Sequence[ServoMotor], gearing: Gearing
) -> tuple[MotorFit, ...]:
    """Every motor at every actuator it can drive: by actuator, those that fit first, the least powerful of them first;
    then the others, the least overloaded first."""
    found = []
    for i, actuator in enumerate(actuators):
        own = [
            _Match(cycles, i, actuator, motor, gearing, base).fit()
            for motor in motors
            if (base := gearing.base(actuator, motor)) is not None
        ]
        found += sorted(own, key=lambda one: (not one.fits, one.motor.rated_power if one.fits else one.use))
    return tuple(found)


class _Match:
    """One motor at one actuator."""

    def __init__(
        self,
        cycles: Sequence[LoadCycle],
        i: int,
        actuator: Actuator,
        motor: ServoMotor,
        gearing: Gearing,
        base: float,
    ) -> None:
        self._i, self._actuator, self._motor, self._gearing, self._base = i, actuator, motor, gearing, base
        self._cycles = cycles
        self._inertia = motor.rotor + gearing.inertia
        self._fastest = max(float(np.abs(one.v[:, i]).max()) for one in cycles)
        eta = gearing.efficiency
        self._courses = [
            (one.v[:, i], one.a[:, i], np.where(one.bare[:, i] * one.v[:, i] < 0.0, eta, 1.0 / eta) * one.bare[:, i])
            for one in cycles
        ]
        self._means = [self._mean(one) for one in cycles]

    def _mean(self, cycle: LoadCycle) -> tuple[float, float, float, float]:
        """<a^2>, <a b eta^-s>, <b^2 eta^-2s> and <v^2>."""
        i, eta, found = self._i, self._gearing.efficiency, cycle.integrals
        ba = (found.ba[i] - found.ba_returned[i]) / eta + found.ba_returned[i] * eta
        bb = (found.bb[i] - found.bb_returned[i]) / eta**2 + found.bb_returned[i] * eta**2
        aa, ba, bb, vv = (float(one) / cycle.duration for one in (found.aa[i], ba, bb, found.vv[i]))
        return aa, ba, bb, vv

    def _rms(self, ratio: float, k: int) -> float:
        """Root mean square effort of the motor along a trajectory; `ratio` counts the screw too."""
        aa, ba, bb, _ = self._means[k]
        square = (ratio * self._inertia) ** 2 * aa + 2.0 * self._inertia * ba + bb / ratio**2
        return float(np.sqrt(max(square, 0.0)))

    def _uses(self, ratio: float, k: int) -> tuple[float, float, float]:
        """Uses of effort, heat and speed along a trajectory."""
        v, a, b = self._courses[k]
        motor = self._motor
        effort = np.abs(ratio * self._inertia * a + b / ratio)
        peak = float((effort / motor.largest(ratio * v)).max())
        at = np.array(ratio * np.sqrt(self._means[k][3]))
        heat = self._rms(ratio, k) / float(motor.lasting(at))
        return peak, heat, ratio * float(np.abs(v).max()) / motor.max_speed

    def _worst(self, ratio: float) -> float:
        return max(max(self._uses(ratio, k)) for k in range(len(self._cycles)))

    def _best(self) -> float:
        """The ratio of the least worst use, the screw counted."""
        top = SPAN * self._base
        if self._fastest > 0.0:
            top = min(top, 2.0 * self._motor.max_speed / self._fastest)
        tried = np.geomspace(top / SPAN, top, RATIOS)
        uses = [self._worst(float(one)) for one in tried]
        k = int(np.argmin(uses))
        low, high = np.log(tried[max(k - 1, 0)]), np.log(tried[min(k + 1, RATIOS - 1)])
        for _ in range(NARROWINGS):
            left, right = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
            if self._worst(float(np.exp(left))) <= self._worst(float(np.exp(right))):
                high = right
            else:
                low = left
        return float(np.exp(0.5 * (low + high)))

    def _coolest(self) -> float:
        """The ratio of the least root mean square effort over the trajectory that heats most at the best ratio."""
        k = max(range(len(self._cycles)), key=lambda k: self._means[k][2])
        aa, _, bb, _ = self._means[k]
        if not (aa > 0.0 and self._inertia > 0.0):
            return float("inf")
        return float((bb / (self._inertia**2 * aa)) ** 0.25)

    def fit(self) -> MotorFit:
        """At the best ratio, or at the best of those that may be chosen."""
        best, chosen = self._best(), self._gearing.ratios
        ratio = min((one * self._base for one in chosen), key=self._worst) if chosen else best
        uses = [self._uses(ratio, k) for k in range(len(self._cycles))]
        worst = int(np.argmax([max(one) for one in uses]))
        peaks = [float(np.abs(ratio * self._inertia * a + b / ratio).max()) for _, a, b in self._courses]
        rms = max(self._rms(ratio, k) for k in range(len(self._cycles)))
        mass = max(float(one.mass[self._i]) for one in self._cycles)
        held = self._gearing.brake_factor * max(float(one.holding[self._i]) for one in self._cycles) / ratio
        reflected = self._inertia * ratio**2
        return MotorFit(
            self._actuator,
            self._motor,
            ratio / self._base,
            bool(chosen),
            best / self._base,
            self._coolest() / self._base,
            max(peaks),
            rms,
            ratio * self._fastest,
            ratio * float(np.sqrt(max(one[3] for one in self._means))),
            *_worst_of(uses),
            mass / reflected if reflected > 0.0 else float("inf"),
            reflected,
            self._motor.temperature(rms, self._gearing.ambient),
            None if self._motor.brake is None else held / self._motor.brake,
            self._cycles[worst].name,
        )


def _worst_of(uses: Sequence[tuple[float, float, float]]) -> tuple[float, float, float]:
    """Of every use the largest."""
    peak, heat, speed = (max(parts) for parts in zip(*uses, strict=True))
    return peak, heat, speed


def choices(fit: MotorFit, cycles: Sequence[LoadCycle], gearing: Gearing, i: int) -> tuple[Array, Array]:
    """Speeds and efforts of the motor of a fit all along the trajectories, shape (m,) each: [rad/s], [N m] or [m/s],
    [N]."""
    base = gearing.base(fit.actuator, fit.motor)
    assert base is not None
    ratio, eta = fit.ratio * base, gearing.efficiency
    inertia = fit.motor.rotor + gearing.inertia
    v, a, b = (np.concatenate([getattr(one, name)[:, i] for one in cycles]) for name in ("v", "a", "bare"))
    b = np.where(b * v < 0.0, eta, 1.0 / eta) * b
    return ratio * v, ratio * inertia * a + b / ratio
