"""What joints and cuts do by themselves, as a table and as plain data."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING

from cutjoint.commands.output import show
from cutjoint.tables import TextTable

if TYPE_CHECKING:
    from cutjoint.description import RobotDescription
    from cutjoint.description.model import Bushing, JointPhysics


def physics_data(robot: RobotDescription) -> list[dict[str, object]]:
    """A record for each joint and cut that does something by itself, in SI units."""
    from cutjoint.mechanism.physics import NO_PHYSICS

    records: list[dict[str, object]] = []
    for kind, items in (("joint", robot.joints), ("cut", robot.cuts)):
        for one in items:
            bushing = getattr(one, "bushing", None)
            if one.physics == NO_PHYSICS and bushing is None:
                continue
            record = {"name": one.name, "of": kind, **asdict(one.physics), "armature": one.physics.armature}
            records.append(record | ({} if bushing is None else {"bushing": asdict(bushing)}))
    return records


def show_physics(robot: RobotDescription) -> None:
    """A table of what acts in joints and cuts; nothing where all move freely."""
    from cutjoint.description.cuts import Freedom
    from cutjoint.mechanism.physics import NO_PHYSICS

    rows = [
        (joint.name, physics_words(joint.physics, any(joint.type.lengths), not joint.type.single))
        for joint in robot.joints
        if joint.physics != NO_PHYSICS
    ]
    for cut in robot.cuts:
        words = [] if cut.bushing is None else [_bushing_words(cut.bushing)]
        if cut.physics != NO_PHYSICS:
            words.append(physics_words(cut.physics, Freedom.SLIDE in cut.type.freedoms, len(cut.type.freedoms) > 1))
        if words:
            rows.append((f"{cut.name} (cut)", "; ".join(words)))
    if rows:
        show(TextTable("joint physics", ("joint", "what acts by itself"), rows))


def physics_words(physics: JointPhysics, slides: bool, several: bool) -> str:
    """What acts, in words; `slides` tells whether along a length, `several` whether along several coordinates."""
    length, force, speed = ("m", "N", "m/s") if slides else ("rad", "N m", "rad/s")
    words = []
    if physics.damping:
        mixed = f"{force} s/{length}" if not (slides and several) else "N s/m and N m s/rad"
        words.append(f"damping {physics.damping:.6g} {mixed}")
    if physics.friction:
        how = "holds what rests" if physics.sticks else f"fully from {physics.speed:.6g} {speed}"
        words.append(f"friction {physics.friction:.6g} {force} ({how})")
    if physics.stiffness:
        words.append(f"spring {physics.stiffness:.6g} {force}/{length}, at rest at {physics.rest or 0.0:.6g} {length}")
    if physics.rotor:
        geared = f", rotor {physics.rotor:.6g} behind a gear of {physics.gear:.6g}" if physics.gear != 1.0 else ""
        words.append(f"armature {physics.armature:.6g} {'kg' if slides else 'kg m2'}{geared}")
    elif physics.gear != 1.0:
        words.append(f"gear {physics.gear:.6g}, no rotor")
    if physics.stop_stiffness:
        damped = f" with {physics.stop_damping:.6g} {force} s/{length}" if physics.stop_damping else ""
        words.append(f"stops {physics.stop_stiffness:.6g} {force}/{length}{damped}")
    return ", ".join(words)


def _bushing_words(bushing: Bushing) -> str:
    words = f"bushing {bushing.stiffness:.6g} N/m, {bushing.damping:.6g} N s/m"
    turning = bushing.turning_stiffness or bushing.turning_damping
    if turning:
        words += f", {bushing.turning_stiffness:.6g} N m/rad, {bushing.turning_damping:.6g} N m s/rad"
    return words
