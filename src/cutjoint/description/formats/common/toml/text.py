"""The keys of a loops.toml as text: all of them, or those that another format leaves over."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from cutjoint.description.formats.common.toml.couplings import coupling_lines
from cutjoint.description.formats.common.toml.physics import cut_lines
from cutjoint.description.formats.common.toml.scalars import key, number, numbers, text
from cutjoint.description.model import Coupling, CutJoint, Frame, Home, Link, RobotDescription, Variant
from cutjoint.description.transforms import rpy_from_rotation

JointKeys = Mapping[str, Mapping[str, object]]


def toml_text(
    robot: RobotDescription,
    *,
    urdf: str | None,
    cuts: Iterable[CutJoint],
    couplings: Iterable[Coupling],
    joints: JointKeys,
    links: Iterable[Link] = (),
    fixed: Mapping[str, str] | None = None,
) -> str:
    """The keys of a robot as TOML.

    Args:
        robot: the robot.
        urdf: name of the URDF beside the file; None where the text goes into another file.
        cuts: those that the other file cannot say.
        couplings: likewise.
        joints: [joint.NAME] tables, what the tree's format cannot say of a joint.
        links: those whose gravity compensation the other file cannot say.
        fixed: link -> name of the fixed joint above it, for formats whose fixed joints have no name.
    """
    lines = [] if urdf is None else ["schema = 1"]
    lines.append(f"name = {text(robot.name)}")
    lines += [f"title = {text(robot.title)}"] if robot.title else []
    lines += [] if urdf is None else [f"urdf = {text(urdf)}"]
    lines += [f"source = {text(robot.source)}"] if robot.source else []
    lines.append(f"gravity = {numbers(robot.gravity)}")
    lines.append(f"actuators = [{', '.join(map(text, robot.actuators))}]")
    if robot.tool is not None:
        lines += ["", "[tool]", f"frame = {_frame(robot.tool)}"]
        lines += [f"task = [{', '.join(map(text, robot.task))}]"] if robot.task else []
        lines += [f"axes = {text(robot.task_axes)}"] if robot.task_axes != "world" else []
    for name, keys in joints.items():
        lines += ["", f"[joint.{key(name)}]", *(f"{one} = {_value(value)}" for one, value in keys.items())]
    for link in (one for one in links if one.gravity_compensation):
        lines += ["", f"[link.{key(link.name)}]", f"gravity_compensation = {number(link.gravity_compensation)}"]
    for cut in cuts:
        lines += ["", "[[cut]]", f"name = {text(cut.name)}", f'type = "{cut.type.value}"']
        lines += ["frames = [", f"  {_frame(cut.a)},", f"  {_frame(cut.b)},", "]", *cut_lines(cut)]
    for coupling in couplings:
        lines += coupling_lines(coupling)
    for home in robot.homes:
        lines += home_lines(home)
    for variant in robot.variants:
        lines += _variant(variant)
    if fixed:
        lines += ["", "[fixed]", *(f"{key(link)} = {text(name)}" for link, name in fixed.items())]
    return "\n".join(lines) + "\n"


def _value(value: object) -> str:
    if isinstance(value, str):
        return text(value)
    if isinstance(value, float):
        return number(value)
    return numbers(np.asarray(value, dtype=float))


def _frame(frame: Frame) -> str:
    if np.array_equal(frame.placement, np.eye(4)):
        return text(frame.link)
    parts = [f"link = {text(frame.link)}", f"xyz = {numbers(frame.placement[:3, 3])}"]
    if not np.array_equal(frame.placement[:3, :3], np.eye(3)):
        parts.append(f"rpy = {numbers(rpy_from_rotation(frame.placement[:3, :3]))}")
    return f"{{ {', '.join(parts)} }}"


def home_lines(home: Home) -> list[str]:
    """The lines of a home posture, a blank one before them."""
    lines = ["", f"[home.{key(home.name)}]"]
    lines += [f"about = {text(home.about)}"] if home.about else []
    given = ", ".join(f"{key(name)} = {number(value)}" for name, value in home.actuated.items())
    lines.append(f"actuated = {{ {given} }}" if given else "actuated = {}")
    if home.passive:
        lines.append(f"[home.{key(home.name)}.passive]")
    for name, value in home.passive.items():
        lines.append(f"{key(name)} = {numbers(value) if isinstance(value, tuple) else number(value)}")
    return lines


def _variant(variant: Variant) -> list[str]:
    lines = ["", f"[variant.{key(variant.name)}]"]
    lines += [f"about = {text(variant.about)}"] if variant.about else []
    for link, inertial in variant.inertials.items():
        lines += [f"[variant.{key(variant.name)}.inertial.{key(link)}]", f"mass = {number(inertial.mass)}"]
        lines += [f"com = {numbers(inertial.com)}", f"inertia = {numbers(inertial.entries)}"]
    return lines
