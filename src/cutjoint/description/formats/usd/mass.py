"""What a body weighs, by the rules of https://openusd.org/release/api/class_usd_physics_mass_a_p_i.html.

A mass of the body overrides what its colliders weigh together; a density of a collider that of the body, and both that
of a material; without any it is 1000 kg/m3.  What the file gives of centre, moments and their axes replaces what is
computed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cutjoint.arrays import Array
from cutjoint.description.formats.usd.facts import Facts, Prim
from cutjoint.description.model import Inertial, Shape
from cutjoint.description.transforms import rotation_from_quaternion
from cutjoint.findings import Findings

WATER = 1000.0
"""kg/m3."""
API = "PhysicsMassAPI"


@dataclass(frozen=True, eq=False)
class Collider:
    """A collider of a body: its prim, its scale (3,) and its shape in the body's frame; None for others than solids."""

    prim: Prim
    scale: Array
    shape: Shape | None


@dataclass(frozen=True, eq=False)
class _Given:
    """What a MassAPI gives, in SI units along the axes of its prim; None for what it leaves out."""

    mass: float | None
    density: float | None
    com: Array | None
    moments: Array | None
    axes: Array | None


def _given(prim: Prim, scale: Array, facts: Facts) -> _Given:
    if not prim.has(API):
        return _Given(None, None, None, None, None)
    mass, density = prim.number("physics:mass"), prim.number("physics:density")
    com = np.array(prim.vector("physics:centerOfMass", (math.nan,) * 3))
    moments = np.array(prim.vector("physics:diagonalInertia", (0.0,) * 3))
    axes = prim.vector("physics:principalAxes", (0.0,) * 4)
    return _Given(
        mass * facts.mass if mass != 0.0 else None,
        density * facts.mass / facts.length**3 if density != 0.0 else None,
        com * scale * facts.length if np.isfinite(com).all() else None,
        moments * facts.mass * facts.length**2 if moments.any() else None,
        rotation_from_quaternion(axes) if any(axes) else None,
    )


def inertial_of(
    body: Prim, scale: Array, colliders: Sequence[Collider], facts: Facts, findings: Findings
) -> Inertial | None:
    """Mass, centre and inertia of a body in its own frame.

    None where it has neither mass nor colliders, or after noting what cannot be computed.
    """
    given = _given(body, scale, facts)
    told = given.mass is not None and given.moments is not None
    if told and (given.com is not None or not colliders):
        return _own(given)
    if not colliders:
        if given.mass is not None or given.moments is not None:
            found = f"body <{body.path}> has {'a mass' if given.mass is not None else 'moments of inertia'} only"
            findings.error(found, "physics:mass and physics:diagonalInertia, or colliders to compute them of")
        else:
            found = f"body <{body.path}> has neither mass nor colliders: it is taken as massless"
            findings.warn(found, "physics:mass and physics:diagonalInertia")
        return None
    unknown = [one.prim for one in colliders if one.shape is None]
    if unknown:
        found = f"the mass of body <{body.path}> depends on <{unknown[0].path}>, of type {unknown[0].type}"
        expected = "physics:mass, physics:diagonalInertia and physics:centerOfMass of the body, or colliders that are"
        findings.error(found, f"{expected} cubes, spheres, cylinders and capsules")
        return None
    together = _sum([_collider(one, given.density, facts) for one in colliders])
    if given.mass is not None:
        share = given.mass / together.mass if together.mass > 0.0 else 0.0
        together = Inertial(given.mass, together.com, share * together.inertia)
    if given.com is not None:
        together = _moved(together, given.com)
    if given.moments is not None:
        return _own(_Given(together.mass, None, together.com, given.moments, given.axes))
    if given.axes is not None and not np.allclose(given.axes, np.eye(3)):
        found = f"physics:principalAxes of body <{body.path}> without physics:diagonalInertia is not used"
        findings.warn(found, "both, or none to compute them of the colliders")
    return together


def _own(given: _Given) -> Inertial:
    axes = np.eye(3) if given.axes is None else given.axes
    moments = np.zeros(3) if given.moments is None else given.moments
    com = np.zeros(3) if given.com is None else given.com
    return Inertial.of(given.mass or 0.0, com, [float(one) for one in moments], axes)


def _collider(one: Collider, density: float | None, facts: Facts) -> Inertial:
    """What a collider weighs, in the frame of its body."""
    assert one.shape is not None
    given = _given(one.prim, one.scale, facts)
    volume, moments = solid(one.shape)
    material = next((prim for prim in facts.prims if prim.path == one.prim.material), None)
    of_material = material.number("physics:density") * facts.mass / facts.length**3 if material else 0.0
    mass = given.mass if given.mass is not None else volume * (given.density or density or of_material or WATER)
    place = one.shape.placement
    inertia = np.diag(moments) * (mass / volume if volume > 0.0 else 0.0)
    turn = place[:3, :3]
    own = Inertial(mass, place[:3, 3], turn @ inertia @ turn.T)
    # What the file gives is along the axes of the prim, which those of the shape are turned against.
    axes = turn @ along(one.prim).T
    if given.com is not None:
        own = _moved(own, place[:3, 3] + axes @ given.com)
    if given.moments is not None:
        turned = axes if given.axes is None else axes @ given.axes
        own = Inertial(mass, own.com, turned @ np.diag(given.moments) @ turned.T)
    return own


def along(prim: Prim) -> Array:
    """The turn (3, 3) of a solid along z against its prim, whose `axis` it has."""
    if prim.type not in ("Cylinder", "Capsule"):
        return np.eye(3)
    turns = {"X": [[0, 0, 1], [1, 0, 0], [0, 1, 0]], "Y": [[0, 1, 0], [0, 0, 1], [1, 0, 0]]}
    return np.array(turns.get(prim.word("axis", "Z"), np.eye(3)), dtype=float)


def solid(shape: Shape) -> tuple[float, Array]:
    """Volume [m3], and moments (3,) of it [m5] about its middle."""
    if shape.kind == "box":
        x, y, z = shape.size
        return x * y * z, x * y * z / 12.0 * np.array([y * y + z * z, x * x + z * z, x * x + y * y])
    if shape.kind == "sphere":
        (r,) = shape.size
        volume = 4.0 / 3.0 * math.pi * r**3
        return volume, np.full(3, 0.4 * volume * r * r)
    r, h = shape.size
    barrel = math.pi * r * r * h
    across, about = barrel * (3.0 * r * r + h * h) / 12.0, 0.5 * barrel * r * r
    if shape.kind == "capsule":
        caps = 4.0 / 3.0 * math.pi * r**3
        across += caps * (0.4 * r * r + 0.25 * h * h + 0.375 * r * h)
        about += 0.4 * caps * r * r
        barrel += caps
    return barrel, np.array([across, across, about])


def _moved(one: Inertial, com: Array) -> Inertial:
    """With its centre elsewhere, and its inertia about that: what UsdPhysics makes of a centre that is given."""
    arm = com - one.com
    return Inertial(one.mass, com, one.inertia + one.mass * (float(arm @ arm) * np.eye(3) - np.outer(arm, arm)))


def _sum(parts: Sequence[Inertial]) -> Inertial:
    mass = sum(one.mass for one in parts)
    com = sum((one.mass * one.com for one in parts), np.zeros(3)) / mass if mass > 0.0 else parts[0].com
    return Inertial(mass, com, sum((_moved(one, com).inertia for one in parts), np.zeros((3, 3))))
