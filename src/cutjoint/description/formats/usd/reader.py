"""USD stages with the physics of UsdPhysics (https://openusd.org/release/api/usd_physics_page_front.html), read through
Pixar's own library in a child process: `usd-core`, the extra `usd`.

Rigid bodies are links, the world is the root link.  Joints of the articulation make the tree; a joint with
`physics:excludeFromArticulation`, or one that meets a body which others carry already, is a cut.  Drives name the
actuators; the pose of the file is the home.
"""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np

from cutjoint.arrays import Array, readonly
from cutjoint.description.formats.common.child import ChildFailed, in_child
from cutjoint.description.formats.common.extras import Extras, described
from cutjoint.description.formats.usd.bodies import read_bodies
from cutjoint.description.formats.usd.facts import Facts
from cutjoint.description.formats.usd.foreign import check_foreign, couplings_of
from cutjoint.description.formats.usd.joints import UNLIMITED, read_joints
from cutjoint.description.formats.usd.ranges import check_numbers
from cutjoint.description.formats.usd.tree import home_of, spanned
from cutjoint.description.formats.usd.typos import check_names
from cutjoint.description.model import RobotDescription
from cutjoint.errors import FileError
from cutjoint.extras import how_to_get, is_installed
from cutjoint.files import check_file
from cutjoint.findings import Findings, clip, nearest

LARGEST = 512 * 2**20
"""Bytes: meshes and pictures are in the file."""
SECONDS = 60.0
MEGABYTES = 4096
EARTH = 9.81
_LINE = re.compile(r":(\d+):\d+: ")


def read(path: Path, findings: Findings) -> RobotDescription | None:
    """A USD file: .usd, .usda, .usdc or .usdz."""
    facts = _facts(path, findings)
    if facts is None:
        return None
    if not facts.lengths:
        found = f"the stage does not give metersPerUnit: it is taken as USD's default, {facts.length:g}"
        findings.warn(found, "metersPerUnit = 1, or whatever its lengths are in")
    paths = [prim.path for prim in facts.prims]
    if facts.name and f"/{facts.name.strip('/')}" not in paths:
        found, roots = f"defaultPrim is '{clip(facts.name)}'", [path[1:] for path in paths if path.count("/") == 1]
        findings.doubt(found, "a prim of the stage", nearest(facts.name, roots))
    check_names(facts, findings)
    check_foreign(facts, findings)
    if not check_numbers(facts, findings):
        return None
    bodies = read_bodies(facts, findings)
    if len(bodies.by_path) == 1:
        expected = "prims with PhysicsRigidBodyAPI"
        findings.error(
            "a stage without rigid bodies that move", expected, "it may hold shapes only: load the robot's file"
        )
        return None
    edges = read_joints(facts, bodies, findings)
    tree, cuts, pose = spanned(facts.name.rpartition("/")[2] or path.stem, bodies, edges, findings)
    tree.couplings.extend(couplings_of(edges, tree.joints, facts, findings))
    kept = {joint.name for joint in tree.joints}
    driven = tuple(edge.joint.name for edge in edges if edge.driven and edge.joint.name in kept)
    tree.actuators = driven
    robot = described(tree, cuts, Extras(driven or None, gravity=_gravity(facts, findings)), path, findings)
    return replace(robot, homes=home_of(pose, robot.actuators))


def _facts(path: Path, findings: Findings) -> Facts | None:
    """What the stage says, or None after noting why it cannot be read."""
    if not is_installed("pxr"):
        findings.error("a USD file", "the package usd-core, which reads it", how_to_get("pxr"))
        return None
    try:
        check_file(path, LARGEST)
        facts = in_child("cutjoint.description.formats.usd.stage:read", str(path.absolute()), SECONDS, MEGABYTES)
    except FileError as error:
        findings.error(str(error), "a USD file")
        return None
    except ChildFailed as error:
        findings.error(f"the USD library {error.reason}", "a USD file that it can read", "the file may be damaged")
        return None
    assert isinstance(facts, Facts)
    for text in facts.errors:
        at = _LINE.search(text)
        findings.error(f"USD says: {clip(text, 300)}", "a stage that can be composed", "", int(at[1]) if at else None)
    return None if facts.errors else facts


def _gravity(facts: Facts, findings: Findings) -> Array:
    """Gravity of the stage's scenes [m/s2]; USD's own, down and that of the Earth, where none is given."""
    up = np.eye(3)["XYZ".index(facts.up)]
    found = []
    for prim in facts.prims:
        if prim.type == "PhysicsScene":
            direction = np.array(prim.vector("physics:gravityDirection", (0.0, 0.0, 0.0)))
            size = float(np.linalg.norm(direction))
            magnitude = prim.number("physics:gravityMagnitude", -np.inf)
            strength = EARTH if magnitude < 0.0 or abs(magnitude) > UNLIMITED else magnitude * facts.length
            found.append(strength * (-up if size == 0.0 else direction / size))
    if any(not np.array_equal(one, found[0]) for one in found):
        findings.error(f"{len(found)} physics scenes with different gravity", "one gravity", "remove the others")
    gravity = found[0] if found else -EARTH * up
    return readonly(gravity + 0.0)
