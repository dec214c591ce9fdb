"""The smallest robots: one velocity coordinate, or none; no actuators, no cuts, no tool, no links beyond the base."""

from __future__ import annotations

from pathlib import Path

HINGE = '<joint name="{name}" type="continuous"><parent link="{a}"/><child link="{b}"/><axis xyz="0 1 0"/>{at}</joint>'
BODY = (
    '<link name="{name}"><inertial><origin xyz="0 0 -0.5"/><mass value="2"/>'
    '<inertia ixx="0.1" iyy="0.1" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>'
)
SLIDE = (
    '<joint name="slide" type="prismatic"><parent link="base"/><child link="block"/><axis xyz="0 0 1"/>'
    '<limit lower="-1" upper="1" effort="10" velocity="1"/></joint>'
)
TOOL = '[tool]\nframe = { link = "%s", xyz = [0.0, 0.0, -1.0] }\n'
DOOR = (
    '[[cut]]\nname = "upper"\ntype = "revolute"\n'
    'frames = [{ link = "base", xyz = [0.0, 1.0, 0.0], rpy = [-1.5707963267948966, 0.0, 0.0] }, '
    '{ link = "rod", xyz = [0.0, 1.0, 0.0], rpy = [-1.5707963267948966, 0.0, 0.0] }]\n'
)


def _hinge(a: str = "base", b: str = "rod", name: str = "hinge") -> str:
    return HINGE.format(name=name, a=a, b=b, at="")


PENDULUM = BODY.format(name="rod") + _hinge()
ROBOTS: dict[str, tuple[str, str, str]] = {
    "pendulum": (PENDULUM, 'actuators = ["hinge"]', TOOL % "rod"),
    "pendulum without a tool": (PENDULUM, 'actuators = ["hinge"]', ""),
    "pendulum that swings free": (PENDULUM, "actuators = []", TOOL % "rod"),
    "pendulum without mass": ('<link name="rod"/>' + _hinge(), 'actuators = ["hinge"]', TOOL % "rod"),
    "slider": (BODY.format(name="block") + SLIDE, 'actuators = ["slide"]', TOOL % "block"),
    "door": (PENDULUM, 'actuators = ["hinge"]', TOOL % "rod" + DOOR),
    "door that swings free": (PENDULUM, "actuators = []", DOOR),
    "locked door": (PENDULUM, "actuators = []", TOOL % "rod" + DOOR.replace('"revolute"', '"fixed"')),
    "driven locked door": (PENDULUM, 'actuators = ["hinge"]', TOOL % "rod" + DOOR.replace('"revolute"', '"fixed"')),
    "two welded links": (
        BODY.format(name="rod") + '<joint name="weld" type="fixed"><parent link="base"/><child link="rod"/></joint>',
        "actuators = []",
        TOOL % "rod",
    ),
    "base alone": ("", "actuators = []", ""),
    "base with a tool": ("", "actuators = []", TOOL % "base"),
}
"""Name -> links and joints beside `base`, actuators, tool and cuts."""


def write(name: str, folder: Path) -> Path:
    """robot.urdf and loops.toml of one of them in `folder`."""
    tree, actuators, rest = ROBOTS[name]
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "robot.urdf").write_text(f'<robot name="small"><link name="base"/>{tree}</robot>', encoding="utf-8")
    text = f'schema = 1\nname = "small"\nurdf = "robot.urdf"\n{actuators}\n{rest}'
    (folder / "loops.toml").write_text(text, encoding="utf-8")
    return folder
