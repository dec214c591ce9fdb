"""Elements of a URDF that are for other programs: `<transmission>`, `<ros2_control>`, `<mujoco>`, `<sensor>`.

What of them is used is read elsewhere (`transmission`).  Here their names are checked, and what would couple joints or
move the robot otherwise is told.
"""

from __future__ import annotations

from collections.abc import Mapping

from cutjoint.description.formats.common.extras import OpenTree
from cutjoint.description.formats.urdf.plugins import couple
from cutjoint.description.xml import Element, check_known, children, short
from cutjoint.findings import Findings, Harmless, listing

_NONE: frozenset[str] = frozenset()
_NAME = frozenset({"name"})
_NAMES = frozenset({"name", "type", "role"})
_GEAR = frozenset({"mechanicalReduction", "mechanical_reduction"})
_MOTOR = _GEAR | {"hardwareInterface", "hardware_interface", "motorTorqueConstant", "offset", "pulsesPerRevolution"}
_DRAKE = frozenset({"drake:gear_ratio", "drake:rotor_inertia", "drake:controller_gains"})
_WRIST = frozenset({"leftActuator", "rightActuator", "flexJoint", "rollJoint"})
_GRIPPER = frozenset({"gap_joint", "passive_joint", "use_simulated_gripper_joint", "simulated_actuated_joint"})
_TRANSMISSION: Mapping[str, tuple[frozenset[str], frozenset[str]]] = {
    "transmission": (
        _NAMES,
        _GEAR | _WRIST | _GRIPPER | {"type", "plugin", "joint", "actuator", "compensator", "param", "robotNamespace"}
        | {"motorTorqueConstant", "pulsesPerRevolution", "rotorInertia", "rotor_inertia", "hardwareInterface"},
    ),
    "joint": (_NAMES, _MOTOR | {"state_interface", "command_interface", "param"}),
    "actuator": (_NAMES, _MOTOR | _DRAKE | {"rotorInertia", "rotor_inertia", "param"}),
}  # fmt: skip
_LIMITED = frozenset({"name", "data_type", "size"}), frozenset({"param", "limits"})
_CONTROL: Mapping[str, tuple[frozenset[str], frozenset[str]]] = {
    "ros2_control": (
        _NAMES | {"rw_rate", "is_async", "thread_priority", "affinity"},
        frozenset({"hardware", "joint", "sensor", "gpio", "transmission"}),
    ),
    "hardware": (_NONE, frozenset({"plugin", "param", "group", "properties"})),
    "joint": (
        _NAMES | {"mimic", "multiplier", "offset", "enable_limits"},
        frozenset({"command_interface", "state_interface", "param", "limits", "properties"}),
    ),
    "sensor": (_NAMES, frozenset({"state_interface", "param", "properties"})),
    "gpio": (_NAME, frozenset({"command_interface", "state_interface", "param", "properties"})),
    "command_interface": _LIMITED,
    "state_interface": (_LIMITED[0], frozenset({"param", "limits", "initial_value"})),
    "limits": (frozenset({"enable"}), _NONE),
    "param": (_NAME, _NONE),
}
_MUJOCO = frozenset({"compiler", "option", "size", "statistic", "visual", "asset", "default", "extension"})
_SENSOR = frozenset({"parent", "origin", "camera", "ray", "imu", "force_torque", "contact", "topic", "update_rate"})


def check_others(root: Element, tree: OpenTree, findings: Findings) -> None:
    """Note unknown names in the elements for other programs, and what they do to joints; joints that a `<ros2_control>`
    lets mimic others are coupled."""
    harmless = Harmless(findings)
    for element in children(root, "transmission"):
        _checked(element, _TRANSMISSION, findings)
        _coupled(element, findings)
    for control in children(root, "ros2_control"):
        _checked(control, _CONTROL, findings)
        for element in children(control, "joint"):
            _mimics(element, tree, findings)
        for element in children(control, "transmission"):
            _checked(element, _TRANSMISSION, findings)
            _coupled(element, findings)
    for element in children(root, "mujoco"):
        _mujoco(element, findings)
    for element in children(root, "sensor"):
        attributes = frozenset({"name", "type", "update_rate", "group", "isaac_sim_config"})
        check_known(element, attributes, _SENSOR, _NONE, harmless)
    for element in children(root, "fixed_frame"):
        check_known(element, _NAME, frozenset({"parent", "origin"}), _NONE, harmless)


def _checked(element: Element, table: Mapping[str, tuple[frozenset[str], frozenset[str]]], findings: Findings) -> None:
    """Note unknown names in an element and those inside it that the table has."""
    attributes, tags = table[str(element.tag)]
    check_known(element, attributes, tags, _NONE, findings)
    for child in children(element):
        if str(child.tag) in table and child.tag != "transmission":
            _checked(child, table, findings)


def _mimics(element: Element, tree: OpenTree, findings: Findings) -> None:
    """The parameters `mimic` and `multiplier` of a joint in `<ros2_control>`."""
    values = {str(one.get("name") or ""): str(one.text or "").strip() for one in children(element, "param")}
    if values.get("mimic"):
        said = (str(element.get("name") or "").strip(), values["mimic"], values.get("multiplier") or "1", "0")
        couple(said, "a mimic of <ros2_control>", tree, element.sourceline, findings)


def _coupled(element: Element, findings: Findings) -> None:
    """Tell of transmissions of several joints."""
    what, line = f"<transmission> '{element.get('name') or ''}'", element.sourceline
    passive = [str(one.get("name")) for tag in ("gap_joint", "passive_joint") for one in children(element, tag)]
    if passive:
        found = f"{what} couples {listing(passive)} to its motor, and is not read"
        findings.doubt(found, "couplings as <mimic>", "give each of these joints a <mimic>, and remove them", line)
    for gains in element.iter("{*}controller_gains"):
        found = f"<{short(str(gains.tag))}> in {what} is not used"
        findings.warn(found, "a control law of the simulation", "", gains.sourceline)


def _mujoco(element: Element, findings: Findings) -> None:
    """MuJoCo's own part of a URDF: its compiler's settings and options."""
    check_known(element, _NONE, _MUJOCO, _NONE, findings)
    for tag in ("equality", "tendon", "actuator", "contact"):
        for one in children(element, tag):
            found = f"<{tag}> in the <mujoco> of a URDF, where MuJoCo does not read it"
            findings.doubt(found, "an MJCF file", "read that instead", one.sourceline)
    for one in children(element, "option"):
        acting = [key for key in ("gravity", "wind", "density", "viscosity") if one.get(key) is not None]
        if acting:
            found = f"{listing(acting)} of <option> in <mujoco> are not used"
            findings.warn(found, "what URDF itself says", "give gravity in a loops.toml", one.sourceline)
