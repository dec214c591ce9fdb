"""What joints do by themselves: dampers, dry friction, springs, rotors behind gears, stops that yield, and bushings.

All of it is force against a motion, along the coordinates of a joint or between the two frames of a cut:

    force = -damping v - friction sign(v) - stiffness (q - rest) - stop

    sign(v)     1 from `friction_speed` on, below it the odd quintic in v that joins 1 with two continuous derivatives;
                with a friction speed of 0 it jumps, and what rests is held by up to the friction (stiction)
    stop        stop_stiffness x + stop_damping x', x how far a joint is beyond its limits; it never pulls
    rotor       a motor's rotor turns `gear` times as fast as the joint; seen from the joint it weighs gear^2 rotor,
                in the joint's own coordinates (what it does as a gyroscope is left out, as it is everywhere)

[N] and [m] for what slides, [N m] and [rad] for what turns.
"""

from __future__ import annotations

from dataclasses import dataclass

from cutjoint.reprs import line

LARGEST_PAYLOAD = 1e9
"""kg.  Nothing that moves carries more."""
FRICTION_SPEED = 0.01
"""Speed [m/s] or [rad/s] from which dry friction acts fully, where nobody says: small against the speeds of a robot,
and large enough for steps of a millisecond."""


@dataclass(frozen=True)
class JointPhysics:
    """What a joint, or the free motion of a cut joint, does by itself.

    Of a joint with several coordinates every one is meant; a ball turns about the axis that it turns about.

    Attributes:
        damping: viscous, [N s/m] or [N m s/rad].
        friction: dry (Coulomb), [N] or [N m].
        friction_speed: from which it acts fully [m/s] or [rad/s]; None for `FRICTION_SPEED`, 0 for stiction.
        stiffness: of a spring, [N/m] or [N m/rad].
        rest: where the spring is at rest, [m] or [rad]; None where nobody said.
        rotor: inertia of the motor's rotor, [kg m2], or [kg] of a motor that slides.
        gear: how many times as fast as the joint the rotor moves; turns a metre [rad/m] of a spindle.
        stop_stiffness: of the stops at the joint's limits, [N/m] or [N m/rad]; 0 where nothing is said of them.
        stop_damping: of them, [N s/m] or [N m s/rad].
    """

    damping: float = 0.0
    friction: float = 0.0
    friction_speed: float | None = None
    stiffness: float = 0.0
    rest: float | None = None
    rotor: float = 0.0
    gear: float = 1.0
    stop_stiffness: float = 0.0
    stop_damping: float = 0.0

    __repr__ = line(
        damping="N s/m or N m s/rad",
        friction="N or N m",
        friction_speed="m/s or rad/s",
        stiffness="N/m or N m/rad",
        rest="m or rad",
        rotor="kg or kg m2",
        stop_stiffness="N/m or N m/rad",
        stop_damping="N s/m or N m s/rad",
    )

    @property
    def armature(self) -> float:
        """What the rotor weighs at the joint, [kg m2] or [kg]: gear^2 rotor."""
        return self.gear * self.gear * self.rotor

    @property
    def acts(self) -> bool:
        """Whether it does anything but weigh."""
        return bool(self.damping or self.friction or self.stiffness or self.stop_stiffness)

    @property
    def sticks(self) -> bool:
        """Whether its friction holds what rests."""
        return self.friction > 0.0 and self.friction_speed == 0.0

    @property
    def speed(self) -> float:
        """From which friction acts fully, [m/s] or [rad/s]."""
        return FRICTION_SPEED if self.friction_speed is None else self.friction_speed


NO_PHYSICS = JointPhysics()
"""A joint that moves freely."""


@dataclass(frozen=True)
class Bushing:
    """A spring and damper in place of what a cut joint would hold rigidly.

    The springs act on each equation of the cut's type (`cutjoint.description.cuts`): the stiffnesses on those that are
    lengths, the turning ones on those that are angles.

    Attributes:
        stiffness: [N/m].
        damping: [N s/m].
        turning_stiffness: [N m/rad].
        turning_damping: [N m s/rad].
    """

    stiffness: float
    damping: float = 0.0
    turning_stiffness: float = 0.0
    turning_damping: float = 0.0

    __repr__ = line(stiffness="N/m", damping="N s/m", turning_stiffness="N m/rad", turning_damping="N m s/rad")
