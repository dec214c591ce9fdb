"""The Cartesian Parallel Manipulator with rotary motors (section 1.1 of its paper): `cpm`, its first hinges driven.

The same bodies, joints and cuts.  The sliders are passive, and there is a home in each of the eight working modes.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import product

from cutjoint.description import Home, RobotDescription
from robots import cpm
from robots.parts import posture

SIGNS = (1, 1, 1)  # far from a type-2 singularity at the start of the circle and all along it; `cpm` has (+, -, +)
TORQUE = cpm.EFFORT * cpm.L1  # N m, not in the paper: the force limit of section 5.3 at the end of the first rod
NOTES = (*cpm.NOTES, "The motors turn the first hinge of each limb (section 1.1); the sliders are passive.")


def robot() -> RobotDescription:
    """The robot with both inertia variants of `cpm`."""
    linear = cpm.robot()
    effort = {"slide": 0.0, "shoulder": TORQUE}
    return replace(
        linear,
        name="cpm_rotary",
        title="Cartesian Parallel Manipulator, rotary motors",
        joints=tuple(
            replace(
                joint,
                limits=replace(joint.limits, effort=effort.get(joint.name.partition("_")[2], joint.limits.effort)),
            )
            for joint in linear.joints
        ),
        actuators=tuple(f"limb{i}_shoulder" for i in (1, 2, 3)),
        homes=tuple(_home(signs) for signs in product((1, -1), repeat=3)),
    )


def _home(signs: tuple[int, ...]) -> Home:
    """The start of the paper's circle in a working mode; `p` and `m` in its name are the elbow signs + and -."""
    values = cpm.joints_at(cpm.START, signs)
    motors = {name: value for name, value in values.items() if name.endswith("_shoulder")}
    passive: dict[str, float | tuple[float, ...]] = {k: value for k, value in values.items() if k not in motors}
    marks = ", ".join("+" if sign > 0 else "-" for sign in signs)
    name = "default" if signs == SIGNS else "".join("p" if sign > 0 else "m" for sign in signs)
    return posture(name, f"start of the paper's circle, elbow signs ({marks})", motors, passive)
