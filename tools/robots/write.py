"""Writes a robot as cutjoint writes it, with its notes, named colours, and angles as they were given."""

from __future__ import annotations

from pathlib import Path, PurePosixPath

from lxml import etree

from cutjoint.description import RobotDescription
from cutjoint.description.formats.common.exact import serialised, words
from cutjoint.description.formats.common.toml.text import toml_text
from cutjoint.description.formats.urdf.writer import robot_element
from robots.parts import COLOURS, GIVEN

MADE_BY = "Made by tools/make_robots.py; edit the robot's module in tools/robots/ and run it again."


def files(robot: RobotDescription, notes: tuple[str, ...]) -> dict[PurePosixPath, str]:
    """Path below urdf/ -> text, for the files of `robot`."""
    loops = [f"# {robot.title}: what closes the tree of robot.urdf, and how it is driven.", f"# {MADE_BY}"]
    loops.append(toml_text(robot, urdf="robot.urdf", cuts=robot.cuts, couplings=(), joints={}))
    folder = PurePosixPath(robot.name)
    return {folder / "robot.urdf": urdf(robot, notes), folder / "loops.toml": "\n".join(loops)}


def urdf(robot: RobotDescription, notes: tuple[str, ...]) -> str:
    """The open tree as URDF."""
    root = robot_element(robot, Path("robot.urdf"))
    for origin in root.iter("origin"):
        if origin.get("rpy") in GIVEN:
            origin.set("rpy", words(GIVEN[origin.get("rpy")]))
    names = {words(colour): name for name, colour in COLOURS.items()}
    used = set()
    for material in root.iter("material"):
        name = names[material[0].get("rgba")]
        used.add(name)
        material.set("name", name)
        del material[0]
    for name in [one for one in list(COLOURS)[::-1] if one in used]:
        material = etree.Element("material", name=name)
        etree.SubElement(material, "color", rgba=words(COLOURS[name]))
        root.insert(0, material)
    root.insert(0, etree.Comment("\n       ".join([f" {robot.title}: the open tree.", MADE_BY, *notes]) + " "))
    return serialised(root).decode("utf-8")
