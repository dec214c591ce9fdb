"""`<gazebo>` in a URDF: what of it closes loops, couples joints or acts on them.

Without a reference its content goes into the model: joints become cuts (`gazebo_joint`), plugins are looked at
(`plugins`), bodies that come with it are refused.  With one it goes to a joint, which may get a spring, or to a link.
Whatever else moves a robot otherwise than its URDF says is told; contact, sensors and looks are not.
"""

from __future__ import annotations

from dataclasses import replace

from cutjoint.description.formats.common.extras import OpenTree
from cutjoint.description.formats.sdf.values import text_of
from cutjoint.description.formats.urdf.gazebo_joint import read_gazebo_model
from cutjoint.description.formats.urdf.plugins import plug_in
from cutjoint.description.model import Joint
from cutjoint.description.numbers import LARGEST_PHYSICS, read_numbers
from cutjoint.description.xml import Element, check_known, children
from cutjoint.findings import Findings, nearest

_BODIES = frozenset({"model", "include", "link"})
_MOVING = {
    "turnGravityOff": ("1", "true", "yes"),
    "gravity": ("0", "false", "no"),
    "static": ("1", "true", "yes"),
    "kinematic": ("1", "true", "yes"),
}
"""Element -> the values with which it changes how a robot moves."""
_CHANGING = frozenset({"inertial", "axis", "axis2", "pose", "dampingFactor", "velocity_decay", "damping"})
_SPRING = frozenset({"springStiffness", "springReference"})
_LOOKS = frozenset(
    {"material", "visual", "collision", "sensor", "light", "projector", "audio_source", "audio_sink", "battery"}
    | {"particle_emitter", "mu1", "mu2", "mu", "fdir1", "kp", "kd", "minDepth", "maxVel", "maxContacts", "laserRetro"}
    | {"selfCollide", "self_collide", "stopCfm", "stopErp", "fudgeFactor", "provideFeedback", "canonicalBody"}
    | {
        "stopKp",
        "stopKd",
        "cfmDamping",
        "implicitSpringDamper",
        "disableFixedJointLumping",
        "preserveFixedJoint",
        "physics",
    }
    | {"allow_auto_disable", "enable_wind", "must_be_base_link", "frame", "friction", "contact", "surface", "gripper"}
)
_KNOWN = _BODIES | _MOVING.keys() | _CHANGING | _SPRING | _LOOKS


def read_gazebo(root: Element, tree: OpenTree, findings: Findings) -> None:
    """Add to `tree` what all `<gazebo>` elements say of loops, couplings and springs."""
    copied: list[Element] = []
    for gazebo in children(root, "gazebo"):
        check_known(gazebo, frozenset({"reference"}), frozenset({"joint", "plugin"}), _KNOWN, findings)
        reference = str(gazebo.get("reference") or "").strip()
        for element in children(gazebo):
            _changes(element, reference, findings)
            if element.tag == "plugin":
                plug_in(element, tree, findings)
            elif element.tag in ("joint", *_BODIES):
                copied += _part(element, reference, findings)
        if reference:
            _referred(gazebo, reference, tree, findings)
    if copied:
        read_gazebo_model(root, copied, tree, findings)


def _part(element: Element, reference: str, findings: Findings) -> list[Element]:
    """The element if it is a joint or link that Gazebo adds to the model; other bodies are quoted."""
    line = element.sourceline
    what = f"<{element.tag}> '{element.get('name') or element.get('uri') or ''}' in <gazebo>"
    if element.tag not in ("joint", "link"):
        expected = "bodies as <link> of the URDF"
        findings.doubt(f"{what}: a body that comes with it is not read", expected, "write it as URDF, or as SDF", line)
    elif reference:
        found = f"{what} with the reference '{reference}'"
        findings.error(found, "a <gazebo> without reference: Gazebo leaves out this one", "remove the reference", line)
    else:
        return [element]
    return []


def _changes(element: Element, reference: str, findings: Findings) -> None:
    """Tell of what would move the robot otherwise."""
    tag, text = str(element.tag), " ".join(text_of(element).split())
    value = str(element.get("value") or text).lower()
    zeros = tag in ("pose", "dampingFactor", "damping") and set(value.split()) <= {"0", "0.0", "0.", "-0"}
    if value in _MOVING.get(tag, ()) or (tag in _CHANGING and not zeros):
        where = f"<gazebo reference='{reference}'>" if reference else "<gazebo>"
        found = f"<{tag}>{f' {value}' if value else ''} in {where} is not used"
        findings.warn(found, "what URDF itself says of links and joints", "", element.sourceline)


def _referred(gazebo: Element, reference: str, tree: OpenTree, findings: Findings) -> None:
    """The spring that a `<gazebo>` gives a joint."""
    joints, links = {joint.name: joint for joint in tree.joints}, [link.name for link in tree.links]
    if reference not in joints and reference not in links:
        found = f"<gazebo> for the unknown link or joint '{reference}'"
        findings.warn(found, "a link or joint", nearest(reference, [*joints, *links]), gazebo.sourceline)
    values = {str(one.tag): one for one in children(gazebo) if one.tag in _SPRING}
    if not values:
        return
    if reference not in joints:
        found = f"a spring in <gazebo> for '{reference}', which is not a joint of the tree"
        findings.warn(found, "a joint", nearest(reference, joints), gazebo.sourceline)
        return
    numbers = {}
    for tag, one in values.items():
        what = f"{tag} of joint '{reference}'"
        text = str(one.get("value") or text_of(one))
        number = read_numbers(text, 1, what, findings, one.sourceline, LARGEST_PHYSICS)
        numbers[tag] = number[0] if number else 0.0
    stiffness = numbers.get("springStiffness", 0.0)
    if stiffness != 0.0:
        joint = joints[reference]
        tree.joints[tree.joints.index(joint)] = _sprung(
            joint, stiffness, numbers.get("springReference", 0.0), gazebo, findings
        )


def _sprung(joint: Joint, stiffness: float, rest: float, gazebo: Element, findings: Findings) -> Joint:
    """The joint with a spring, where it has none or the same."""
    own = joint.physics
    if own.stiffness not in (0.0, stiffness) or (own.stiffness != 0.0 and own.rest not in (None, rest)):
        found = f"joint '{joint.name}' with a spring in <dynamics> and another in <gazebo>"
        findings.error(found, "one spring", "keep one", gazebo.sourceline)
    return replace(joint, physics=replace(own, stiffness=stiffness, rest=rest))
