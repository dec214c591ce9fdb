"""MJCF, MuJoCo's format (https://mujoco.readthedocs.io/en/stable/XMLreference.html), with `<equality>` as cut joints.

`connect` is a spherical cut, `weld` a fixed one, `joint` with a linear polynomial a coupling; the joints of
`<actuator>` are the actuators, keyframes the homes.  A free joint hangs on the world.  What a file of cutjoint's own
writer knows beyond MJCF stands in `<custom><text name="cutjoint" data="..."/>`, as in a loops.toml.
Not supported and reported: `<include>`, inertia out of meshes, tendons in equalities, `<composite>` and the like.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from cutjoint.arrays import Array, readonly
from cutjoint.description.files import read_mesh
from cutjoint.description.findings import Findings, nearest
from cutjoint.description.formats.common.extras import Extras, described
from cutjoint.description.formats.common.toml.keys import read_extras
from cutjoint.description.formats.mjcf.actuator import driven, read_motors
from cutjoint.description.formats.mjcf.body import Bodies, Compiler
from cutjoint.description.formats.mjcf.equality import read_equalities
from cutjoint.description.formats.mjcf.geom import Mesh
from cutjoint.description.formats.mjcf.pose import AngleUnits, Defaults
from cutjoint.description.formats.mjcf.types import MADE_OF, NUMBERS
from cutjoint.description.model import Home, JointType, RobotDescription
from cutjoint.description.numbers import parse_number, read_numbers
from cutjoint.description.transforms import rotation_from_quaternion, rpy_from_rotation
from cutjoint.description.xml import Element, children, read_xml

REFUSED = ("include", "deformable", "extension", "replicate", "frame", "attach", "composite", "flexcomp")
SECTIONS = frozenset(
    {"compiler", "option", "size", "visual", "statistic", "default", "custom", "asset", "worldbody", "contact"}
    | {"equality", "tendon", "actuator", "sensor", "keyframe", *REFUSED}
)

_TENDON: tuple[str, ...] = ("stiffness", "damping", "frictionloss", "armature")
_FLUID = ("density", "viscosity")
_BODY = ("gravcomp",)
_SWITCHES = ("passive", "spring", "damper", "frictionloss", "gravity", "limit", "equality")


def read(path: Path, findings: Findings) -> RobotDescription | None:
    """An MJCF file."""
    root = read_xml(path, findings, "MJCF")
    if root is None:
        return None
    if root.tag != "mujoco":
        findings.error(f"the root element is <{root.tag}>", "<mujoco>", "is this another format?", root.sourceline)
        return None
    _refuse(root, findings)
    compiler = _compiler(root, findings)
    bodies = Bodies(root, compiler, _meshes(root, compiler.meshes, path, findings), path, findings)
    extras = _custom(root, findings) or Extras(gravity=readonly(_gravity(root, findings)))
    cuts, couplings = read_equalities(root, bodies, {cut.name for cut in extras.cuts}, findings)
    bodies.tree.couplings.extend(couplings)
    named = {frame.link for cut in [*cuts, *extras.cuts] for frame in (cut.a, cut.b)}
    named |= set() if extras.tool is None else {extras.tool.link}
    bodies.drop_empty_world(named)
    bodies.name_fixed_joints(extras.fixed)
    _unused(root, bodies.defaults, findings)
    motors = read_motors(root, bodies, findings)
    bodies.tree.actuators = tuple(dict.fromkeys(motor.joint for motor in motors))
    bodies.tree.joints = driven(bodies.tree.joints, motors)
    if not extras.homes:
        extras = replace(extras, homes=read_homes(root, bodies, findings))
    return described(bodies.tree, [*cuts, *extras.cuts], extras, path, findings)


def _refuse(root: Element, findings: Findings) -> None:
    for element in children(root):
        if element.tag not in SECTIONS:
            found, expected = f"unknown section <{element.tag}>", f"one of {', '.join(sorted(SECTIONS))}"
            findings.error(found, expected, nearest(str(element.tag), SECTIONS), element.sourceline)
    for tag in REFUSED:
        for element in root.iter(tag):
            remedy = "save the compiled model first: mujoco.mj_saveLastXML"
            findings.error(f"<{tag}> is not supported", "a flat MJCF", remedy, element.sourceline)


def _unused(root: Element, defaults: Defaults, findings: Findings) -> None:
    """Note forces of MuJoCo that are not computed here: of tendons, of a fluid, against gravity, and switches."""
    tendons = [element for section in children(root, "tendon") for element in children(section)]
    given = [(element, f"<{element.tag}>", defaults.attributes(element, ""), _TENDON) for element in tendons]
    given += [(element, "<option>", element.attrib, _FLUID) for element in children(root, "option")]
    given += [(one, f"body '{one.get('name', '')}'", one.attrib, _BODY) for one in root.iter("body")]
    for element, what, get, keys in given:
        used = [key for key in keys if any(parse_number(word) != 0.0 for word in str(get.get(key, "0")).split())]
        if used:
            found = f"{', '.join(used)} of {what} not used"
            findings.warn(found, "forces of joints, cuts and gravity", "", element.sourceline)
    for option in children(root, "option"):
        for flag in children(option, "flag"):
            off = [key for key in _SWITCHES if flag.get(key) == "disable"]
            if off:
                found = f"{', '.join(off)} switched off by <flag>, which is not heeded"
                findings.warn(found, "what acts in the model itself", "", flag.sourceline)


def _compiler(root: Element, findings: Findings) -> Compiler:
    degrees, order, geoms, meshes = True, "xyz", "auto", ""
    for element in children(root, "compiler"):
        angle = str(element.get("angle") or ("degree" if degrees else "radian"))
        if angle not in ("degree", "radian"):
            findings.error(f"angle is '{angle}'", "degree or radian", "", element.sourceline)
        degrees = angle != "radian"
        order = str(element.get("eulerseq") or order)
        if len(order) != 3 or any(letter not in "xyzXYZ" for letter in order):
            findings.error(f"eulerseq is '{order}'", "three of x, y, z, X, Y, Z", "", element.sourceline)
            order = "xyz"
        if element.get("coordinate", "local") != "local":
            remedy = "convert it with an old MuJoCo"
            findings.error("global coordinates", "local coordinates", remedy, element.sourceline)
        geoms = str(element.get("inertiafromgeom") or geoms)
        meshes = str(element.get("meshdir") or element.get("assetdir") or meshes)
    return Compiler(AngleUnits(degrees, order), geoms, meshes)


def _gravity(root: Element, findings: Findings) -> tuple[float, ...]:
    gravity: tuple[float, ...] = (0.0, 0.0, -9.81)
    for element in children(root, "option"):
        if element.get("gravity") is not None:
            gravity = read_numbers(element.get("gravity"), 3, "gravity", findings, element.sourceline) or gravity
    return gravity


def _meshes(root: Element, folder: str, path: Path, findings: Findings) -> dict[str, Mesh | None]:
    meshes: dict[str, Mesh | None] = {}
    for asset in children(root, "asset"):
        for element in children(asset, "mesh"):
            file = str(element.get("file") or "")
            name = str(element.get("name") or Path(file).stem)
            text = element.get("scale", "1 1 1")
            scale = read_numbers(text, 3, f"scale of mesh '{name}'", findings, element.sourceline)
            inside = str(Path(folder) / file)
            found = read_mesh(inside if file else "", f"mesh '{file}'", "", path, findings, element.sourceline)
            meshes[name] = None if found is None or scale is None else Mesh(found, scale)
    return meshes


def _custom(root: Element, findings: Findings) -> Extras | None:
    for custom in children(root, "custom"):
        for text in children(custom, "text"):
            if text.get("name") == "cutjoint":
                return read_extras(str(text.get("data") or ""), findings, text.sourceline)
    return None


def read_homes(root: Element, bodies: Bodies, findings: Findings) -> tuple[Home, ...]:
    """Each `<key>` with a qpos as a home.

    A qpos of a free joint is the body's placement in the world; that of the joint is relative to its place at zero.
    """
    joints = [joint for joint in bodies.tree.joints if joint.type.moves]
    actuated = set(bodies.tree.actuators)
    sizes = [sum(NUMBERS[kind] for kind in MADE_OF[joint.type]) for joint in joints]
    homes = []
    for section in children(root, "keyframe"):
        for number, key in enumerate(children(section, "key")):
            if key.get("qpos") is None:
                continue
            name = str(key.get("name") or f"key_{number + 1}")
            values = read_numbers(key.get("qpos"), sum(sizes), f"qpos of key '{name}'", findings, key.sourceline)
            if values is None:
                continue
            given: dict[str, float] = {}
            passive: dict[str, float | tuple[float, ...]] = {}
            start = 0
            for joint, size in zip(joints, sizes, strict=True):
                part = values[start : start + size]
                start += size
                if joint.type is JointType.FLOATING:
                    local = joint.placement[:3, :3].T @ _rotation(part[3:])
                    at = joint.placement[:3, :3].T @ (part[:3] - joint.placement[:3, 3])
                    passive[joint.name] = (*map(float, at), *rpy_from_rotation(local))
                elif "ball" in MADE_OF[joint.type]:
                    passive[joint.name] = (*part[:-4], *rpy_from_rotation(_rotation(part[-4:])))
                elif size > 1:
                    passive[joint.name] = part
                else:
                    value = part[0] - bodies.references.get(joint.name, 0.0)
                    (given if joint.name in actuated else passive)[joint.name] = value
            homes.append(Home(name, given, passive))
    return tuple(homes)


def _rotation(quaternion: tuple[float, ...]) -> Array:
    """Of zeros, which MuJoCo reads as no rotation, too."""
    return rotation_from_quaternion(quaternion if any(quaternion) else (1.0, 0.0, 0.0, 0.0))
