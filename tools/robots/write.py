"""Writes a robot as URDF and loops.toml: readable, and the same bytes for the same robot every time."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import PurePosixPath

from robots.parts import COLOURS, Cut, Frame, Home, Inertial, Joint, Link, Robot, Shape, Variant

MADE_BY = "Made by tools/make_robots.py; edit the robot's module in tools/robots/ and run it again."


def files(robot: Robot) -> dict[PurePosixPath, str]:
    """Path below urdf/ -> text, for the files of `robot`."""
    folder = PurePosixPath(robot.name)
    return {folder / "robot.urdf": urdf(robot), folder / "loops.toml": loops(robot)}


def number(value: float) -> str:
    """The shortest text that reads back as `value`, up to the last two bits; noise around zero is zero."""
    if abs(value) < 1e-16:
        return "0"
    short = f"{value:.13g}"
    if abs(float(short) - value) > 4e-16 * abs(value):
        short = repr(float(value))
    return short


def numbers(values: Iterable[float], between: str = " ") -> str:
    """Several numbers on a line."""
    return between.join(number(value) for value in values)


def urdf(robot: Robot) -> str:
    """The open tree as URDF."""
    used = {shape.colour for link in robot.links for shape in link.visuals}
    lines = ['<?xml version="1.0" encoding="utf-8"?>', f"<!-- {robot.title}: the open tree.", f"     {MADE_BY}"]
    lines += [f"     {note}" for note in robot.notes]
    lines[-1] += " -->"
    lines.append(f'<robot name="{robot.name}">')
    for name, colour in COLOURS.items():
        if name in used:
            lines.append(f'  <material name="{name}"><color rgba="{numbers(colour)}"/></material>')
    for link in robot.links:
        lines += ["", *_link(link)]
        lines += [line for joint in robot.joints if joint.child == link.name for line in _joint(joint)]
    return "\n".join([*lines, "</robot>", ""])


def _link(link: Link) -> list[str]:
    if link.inertial is None and not link.visuals:
        return [f'  <link name="{link.name}"/>']
    lines = [f'  <link name="{link.name}">']
    if link.inertial is not None:
        body = link.inertial
        names = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
        inertia = " ".join(f'{name}="{number(value)}"' for name, value in zip(names, body.inertia, strict=True))
        lines += [
            "    <inertial>",
            f'      <origin xyz="{numbers(body.com)}" rpy="0 0 0"/>',
            f'      <mass value="{number(body.mass)}"/>',
            f"      <inertia {inertia}/>",
            "    </inertial>",
        ]
    for shape in link.visuals:
        lines += [
            "    <visual>",
            f'      <origin xyz="{numbers(shape.xyz)}" rpy="{numbers(shape.rpy)}"/>',
            f"      <geometry>{_geometry(shape)}</geometry>",
            f'      <material name="{shape.colour}"/>',
            "    </visual>",
        ]
    return [*lines, "  </link>"]


def _geometry(shape: Shape) -> str:
    if shape.kind == "box":
        return f'<box size="{numbers(shape.size)}"/>'
    if shape.kind == "cylinder":
        return f'<cylinder radius="{number(shape.size[0])}" length="{number(shape.size[1])}"/>'
    return f'<sphere radius="{number(shape.size[0])}"/>'


def _joint(joint: Joint) -> list[str]:
    lines = [
        f'  <joint name="{joint.name}" type="{joint.type}">',
        f'    <parent link="{joint.parent}"/>',
        f'    <child link="{joint.child}"/>',
        f'    <origin xyz="{numbers(joint.xyz)}" rpy="{numbers(joint.rpy)}"/>',
    ]
    if joint.type in ("revolute", "prismatic"):
        limit = (("lower", joint.lower), ("upper", joint.upper), ("effort", joint.effort), ("velocity", joint.velocity))
        lines += [
            f'    <axis xyz="{numbers(joint.axis)}"/>',
            "    <limit " + " ".join(f'{name}="{number(value)}"' for name, value in limit) + "/>",
        ]
    return [*lines, "  </joint>"]


def loops(robot: Robot) -> str:
    """Cuts, actuators, tool, homes and variants as loops.toml."""
    lines = [
        f"# {robot.title}: what closes the tree of robot.urdf, and how it is driven.",
        f"# {MADE_BY}",
        "schema = 1",
        f'name = "{robot.name}"',
        f'title = "{robot.title}"',
        'urdf = "robot.urdf"',
        f'source = "{robot.source}"',
        f"gravity = [{', '.join(_decimal(value) for value in robot.gravity)}]",
        f"actuators = [{', '.join(_quoted(name) for name in robot.actuators)}]",
        "",
        "[tool]",
        f'frame = "{robot.tool}"',
    ]
    for cut in robot.cuts:
        lines += ["", *_cut(cut)]
    for home in robot.homes:
        lines += ["", *_home(home)]
    for variant in robot.variants:
        lines += ["", *_variant(variant)]
    return "\n".join([*lines, ""])


def _quoted(text: str) -> str:
    return f'"{text}"'


def _decimal(value: float) -> str:
    """A number that TOML reads as a float."""
    text = number(value)
    return text if any(mark in text for mark in ".e") else f"{text}.0"


def _vector(values: Iterable[float]) -> str:
    return f"[{', '.join(_decimal(value) for value in values)}]"


def _frame(frame: Frame) -> str:
    if not any(frame.xyz) and not any(frame.rpy):
        return _quoted(frame.link)
    parts = [f"link = {_quoted(frame.link)}", f"xyz = {_vector(frame.xyz)}"]
    if any(frame.rpy):
        parts.append(f"rpy = {_vector(frame.rpy)}")
    return "{ " + ", ".join(parts) + " }"


def _cut(cut: Cut) -> list[str]:
    lines = ["[[cut]]", f"name = {_quoted(cut.name)}", f"type = {_quoted(cut.type)}"]
    one_line = f"frames = [{_frame(cut.a)}, {_frame(cut.b)}]"
    if len(one_line) <= 120:
        return [*lines, one_line]
    return [*lines, "frames = [", f"  {_frame(cut.a)},", f"  {_frame(cut.b)},", "]"]


def _home(home: Home) -> list[str]:
    lines = [f"[home.{home.name}]", f"about = {_quoted(home.about)}", f"[home.{home.name}.actuated]"]
    lines += [f"{name} = {_decimal(value)}" for name, value in home.actuated.items()]
    lines.append(f"[home.{home.name}.passive]")
    for name, value in home.passive.items():
        rounded = _vector(round(x, 4) for x in value) if isinstance(value, tuple) else _decimal(round(value, 4))
        lines.append(f"{name} = {rounded}")
    return lines


def _variant(variant: Variant) -> list[str]:
    lines = [f"[variant.{variant.name}]", f"about = {_quoted(variant.about)}"]
    for link, body in variant.inertials.items():
        lines += [f"[variant.{variant.name}.inertial.{link}]", *_inertial(body)]
    return lines


def _inertial(body: Inertial) -> list[str]:
    return [f"mass = {_decimal(body.mass)}", f"com = {_vector(body.com)}", f"inertia = {_vector(body.inertia)}"]
