"""Numbers of a USD file: finite where they must be, and in a plausible range."""

from __future__ import annotations

import math

import numpy as np

from cutjoint.description.formats.usd.facts import Facts, Prim, Value
from cutjoint.description.numbers import LARGEST_INERTIA, LARGEST_MASS, LARGEST_PHYSICS
from cutjoint.findings import LARGEST_LENGTH, Findings

UNITS = 1e6
"""Metres or kilograms per unit, or units per metre or kilogram, beyond which nobody measures robots."""
_READ = ("physics:", "drive:", "limit:", "physxJoint", "physxMimicJoint:")
_LARGEST = {
    "physics:mass": LARGEST_MASS,
    "physics:density": LARGEST_MASS,
    "physics:diagonalInertia": LARGEST_INERTIA,
    "physics:centerOfMass": LARGEST_LENGTH,
    "physics:localPos0": LARGEST_LENGTH,
    "physics:localPos1": LARGEST_LENGTH,
    "size": LARGEST_LENGTH,
    "radius": LARGEST_LENGTH,
    "height": LARGEST_LENGTH,
}
_TURNS = ("physics:localRot0", "physics:localRot1", "physics:principalAxes")
_UNLIMITED = ("Limit", "maxForce", "low", "high", "breakForce", "breakTorque", "maxJointVelocity", "Distance",
              "gravityMagnitude", "centerOfMass")  # fmt: skip
"""What may be infinite, or as large as a number in single precision can be, to say that there is none."""
_POSITIVE = ("physics:mass", "physics:density", "size", "radius", "height")


def check_numbers(facts: Facts, findings: Findings) -> bool:
    """Whether the numbers that are read can be; notes what is wrong with the others."""
    before = len(findings.problems)
    for name, unit in (("metersPerUnit", facts.length), ("kilogramsPerUnit", facts.mass)):
        if not 1.0 / UNITS <= unit <= UNITS:
            findings.error(f"{name} is {unit:g}", f"a number from {1.0 / UNITS:g} to {UNITS:g}")
    if facts.up not in ("Y", "Z"):
        findings.error(f"upAxis is '{facts.up}'", "Y or Z")
    for prim in facts.prims:
        for name in prim.authored:
            value = prim.values.get(name)
            if value is not None and (name.startswith(_READ) or name in _LARGEST):
                _check(prim, name, value, findings)
        if prim.world is not None and not np.abs(np.array(prim.world)).max() * facts.length <= LARGEST_LENGTH:
            found = f"<{prim.path}> stands at {prim.world[0][3]:g}, {prim.world[1][3]:g}, {prim.world[2][3]:g}"
            findings.error(found, f"lengths up to {LARGEST_LENGTH:g} m, and scales", "check the units")
    return len(findings.problems) == before


def _check(prim: Prim, name: str, value: Value, findings: Findings) -> None:
    if isinstance(value, str | bool):
        return
    numbers = value if isinstance(value, tuple) else (float(value),)
    what = f"{name} of <{prim.path}> is {', '.join(f'{one:g}' for one in numbers)}"
    most = _LARGEST.get(name, LARGEST_PHYSICS)
    unlimited = name.endswith(_UNLIMITED)
    if any(math.isnan(one) or (math.isinf(one) and not unlimited) for one in numbers):
        findings.error(what, "finite numbers")
    elif name in _TURNS and not (max(map(abs, numbers)) == 0.0 or 1e-3 < math.hypot(*numbers) < 1e3):
        findings.error(what, "a quaternion of length 1")
    elif not unlimited and max(map(abs, numbers)) > most:
        findings.error(what, f"at most {most:g} in size", "check the units")
    elif name in _POSITIVE and numbers[0] < 0.0:
        findings.error(what, "a number >= 0")
