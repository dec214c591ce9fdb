"""What joints and cuts do by themselves: possible numbers, springs that rest somewhere, and only what is computed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from numbers import Real

from cutjoint.description.checks.tree import check_limits
from cutjoint.description.cuts import Freedom
from cutjoint.description.formats.common.physics import KEYS
from cutjoint.description.model import Bushing, CutJoint, Joint, JointPhysics, JointType, Place, RobotDescription
from cutjoint.errors import DescriptionError
from cutjoint.findings import Findings, listing
from cutjoint.mechanism.physics import NO_PHYSICS

_SIGNED = ("rest", "gear")
_UNSAID = ("rest", "friction_speed")
_MOTOR = ("rotor", "gear", "stop_stiffness", "stop_damping")
_SINGLE = ("friction", "stiffness", "rotor", "stop_stiffness")
"""What has no meaning for joints that slide and turn: their velocities are along axes that turn with them."""


def check_physics(robot: RobotDescription, findings: Findings) -> None:
    """Note what is wrong with the physics of joints and cuts."""
    for joint in robot.joints:
        if joint.physics != NO_PHYSICS:
            what = f"joint '{joint.name}'"
            if _numbers(_values(joint.physics), what, joint.place, findings):
                _joint(joint, what, findings)
    for cut in robot.cuts:
        what = f"cut '{cut.name}'"
        if cut.physics != NO_PHYSICS and _numbers(_values(cut.physics), what, cut.place, findings):
            _cut(cut, what, findings)
        if cut.bushing is not None:
            if cut.physics != NO_PHYSICS:
                found = f"{_given(cut.physics)} of {what} beside a bushing"
                mend = "make the cut rigid, or let a joint of the tree move there"
                findings.error(found, "one of the two: what yields has no motion of its own to damp", mend, cut.place)
            _bushing(cut, cut.bushing, what, findings)


def require_possible(robot: RobotDescription) -> None:
    """Refuse physics and limits that cannot be: for descriptions that were made or changed without a file.

    Raises:
        DescriptionError: there are such; it lists all of them.
    """
    findings = Findings(str(robot.path or ""))
    for joint in robot.joints:
        lower, upper = joint.limits.lower, joint.limits.upper
        if lower is not None and upper is not None and not lower <= upper:
            check_limits(joint, findings)
    check_physics(robot, findings)
    if findings.failed:
        raise DescriptionError([one for one in findings.problems if one.severity == "error"])


def _values(physics: JointPhysics) -> dict[str, float]:
    """What is given, by name."""
    values = {key: getattr(physics, key) for key in KEYS}
    return {key: value for key, value in values.items() if value is not None or key not in _UNSAID}


def _numbers(values: Mapping[str, float], what: str, place: Place, findings: Findings) -> bool:
    """Note those that cannot be; returns whether all of them are numbers at all."""
    for key, value in values.items():
        if isinstance(value, bool) or not isinstance(value, Real):
            findings.error(f"{key} of {what} is {value!r}", "a number", "", place)
        elif not math.isfinite(value):
            findings.error(f"{key} of {what} is {value:g}", "a finite number", "", place)
        elif value < 0.0 and key not in _SIGNED:
            findings.error(f"{key} of {what} is {value:g}", "a number >= 0", "", place)
        elif value == 0.0 and key == "gear":
            findings.error(f"gear of {what} is 0", "how many times as fast the rotor moves", "1 without a gear", place)
    return all(isinstance(value, Real) for value in values.values())


def _joint(joint: Joint, what: str, findings: Findings) -> None:
    physics, kind, place = joint.physics, joint.type, joint.place
    if not kind.moves:
        expected = "a joint that moves"
        findings.warn(f"{_given(physics)} of the {kind.value} {what} without effect", expected, "remove them", place)
        return
    if not kind.single and any(kind.lengths):
        wrong = [key for key in _SINGLE if getattr(physics, key) != 0.0]
        if wrong:
            found = f"{' and '.join(wrong)} of the {kind.value} {what}"
            findings.error(found, "damping only", "make it of joints with one coordinate each", place)
        return
    _spring(physics, kind is JointType.SPHERICAL, f"of {what}", f"[joint.{joint.name}]", place, findings)
    if kind is JointType.SPHERICAL:
        _stiction(physics, f"the ball {what}", place, findings)
    _stops(joint, what, findings)


def _spring(physics: JointPhysics, ball: bool, of: str, table: str, place: Place, findings: Findings) -> None:
    """A spring and its rest; one of a ball pulls towards no turn."""
    if physics.stiffness != 0.0 and physics.rest is None and not ball:
        found, mend = f"the spring {of} has no rest position", f"add rest = ... to {table}"
        findings.error(found, "where the spring is at rest, [m] or [rad]", mend, place)
    elif physics.stiffness == 0.0 and physics.rest is not None:
        mend = f"add stiffness = ... to {table}"
        findings.warn(f"rest {of} without a spring", "a stiffness above 0", mend, place)
    elif physics.rest and ball:
        found = f"rest {of} is {physics.rest:g}"
        findings.error(found, "0: the spring of a ball is at rest where it is not turned", "turn the frames", place)


def _stiction(physics: JointPhysics, what: str, place: Place, findings: Findings) -> None:
    """What cannot stick must slide."""
    if physics.sticks:
        found = f"friction of {what} with friction_speed 0 (stiction)"
        findings.error(found, "a friction_speed above 0: only angles and travels of joints stick", "0.01", place)


def _stops(joint: Joint, what: str, findings: Findings) -> None:
    physics, limits = joint.physics, joint.limits
    if physics.stop_stiffness != 0.0 and not limits.bounded:
        found = f"stop_stiffness of {what}, which has no limits"
        findings.warn(found, "limits, at which the stops are", "give it limits, or remove the stops", joint.place)
    if physics.stop_damping != 0.0 and physics.stop_stiffness == 0.0:
        found = f"stop_damping of {what} without stop_stiffness"
        findings.warn(found, "both: only stops that yield damp", "add stop_stiffness", joint.place)


def _cut(cut: CutJoint, what: str, findings: Findings) -> None:
    physics = cut.physics
    own = [key for key in _MOTOR if getattr(physics, key) != getattr(NO_PHYSICS, key)]
    if own:
        mend = "close the loop at another joint, and keep this one in the tree"
        findings.error(f"{' and '.join(own)} of {what}", "damping, friction and a spring only", mend, cut.place)
    if not cut.type.freedoms:
        expected = "a cut that leaves a motion free"
        found = f"{_given(physics)} of the {cut.type.value} {what} without effect"
        findings.warn(found, expected, "remove them", cut.place)
    else:
        _spring(physics, Freedom.BALL in cut.type.freedoms, f"of {what}", "its [[cut]]", cut.place, findings)
        _stiction(physics, what, cut.place, findings)


def _given(physics: JointPhysics) -> str:
    return listing(key for key, value in _values(physics).items() if value != getattr(NO_PHYSICS, key))


def _bushing(cut: CutJoint, bushing: Bushing, what: str, findings: Findings) -> None:
    values = {key: getattr(bushing, key) for key in bushing.__dataclass_fields__}
    if not _numbers(values, f"the bushing of {what}", cut.place, findings):
        return
    if bushing.stiffness == 0.0:
        found = f"stiffness of the bushing of {what} is 0"
        findings.error(found, "a number > 0", "remove the cut where nothing holds it", cut.place)
    turning = bushing.turning_stiffness != 0.0 or bushing.turning_damping != 0.0
    held = [one for one in cut.type.equations if not one.is_length]
    if held and bushing.turning_stiffness == 0.0:
        found = f"the bushing of {what} lets it turn freely, which a {cut.type.value} cut does not"
        mend = "add turning_stiffness, or make it a spherical cut"
        findings.warn(found, "a turning_stiffness above 0", mend, cut.place)
    elif turning and not held:
        found = f"turning_stiffness or turning_damping of the bushing of the {cut.type.value} {what} without effect"
        findings.warn(found, "a cut that holds angles", "remove them", cut.place)
