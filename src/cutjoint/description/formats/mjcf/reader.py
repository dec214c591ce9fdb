"""MJCF, MuJoCo's format (https://mujoco.readthedocs.io/en/stable/XMLreference.html), with `<equality>` as cut joints.

MuJoCo itself parses and compiles the file, in a child process; what it compiled is translated.  So defaults, frames,
replicas, inertia out of geoms and meshes, and what is an error are MuJoCo's own.  `connect` is a spherical cut, `weld`
a fixed one, what ties joints or fixed tendons couplings; what `<actuator>` acts on are the actuators, keyframes homes.
A free joint hangs on the world.  What a file of cutjoint's own writer knows beyond MJCF stands in
`<custom><text name="cutjoint" data="..."/>`, as in a loops.toml.
"""

from __future__ import annotations

import re
from dataclasses import replace
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from cutjoint.arrays import readonly
from cutjoint.description.formats.common.child import ChildFailed, in_child
from cutjoint.description.formats.common.extras import Extras, actuated_by_default, described
from cutjoint.description.formats.common.toml.keys import read_extras
from cutjoint.description.formats.mjcf.actuator import actuated_joints, driven, read_motors
from cutjoint.description.formats.mjcf.body import Bodies
from cutjoint.description.formats.mjcf.compiled import Model, Refused, Request
from cutjoint.description.formats.mjcf.equality import read_equalities
from cutjoint.description.formats.mjcf.geom import check_meshes
from cutjoint.description.formats.mjcf.home import read_homes
from cutjoint.description.formats.mjcf.looks import MOST, left_out
from cutjoint.description.formats.mjcf.schema import parse_schema, unknown_names
from cutjoint.description.formats.mjcf.source import MjcfText, read_source
from cutjoint.description.formats.mjcf.tendon import read_tendons, restore_tendons
from cutjoint.description.model import Place, RobotDescription
from cutjoint.description.numbers import number_problem, parse_number
from cutjoint.extras import how_to_get, is_installed
from cutjoint.findings import Findings, Harmless, check_range, clip, listing, nearest

WORKER = "cutjoint.description.formats.mjcf.worker:compile_model"
OLDEST = (3, 3, 7)
"""The first version of MuJoCo that has all of `mujoco.MjSpec` that is used."""
SECONDS, MEGABYTES = 20.0, 2048
"""What MuJoCo may take; a robot with its collision meshes takes a second or two."""

_FLUID = ("density", "viscosity", "wind")
_SWITCHES = ("passive", "spring", "damper", "frictionloss", "gravity", "limit", "equality")


def read(path: Path, findings: Findings) -> RobotDescription | None:
    """An MJCF file."""
    source = read_source(path, findings)
    if source is None:
        return None
    custom = next(((one, at) for one, at in source.all("text") if one.get("name") == "cutjoint"), None)
    extras = None if custom is None else read_extras(str(custom[0].get("data") or ""), findings, custom[1].line)
    model = _compiled(source, extras is not None, findings)
    if model is None:
        return None
    if source.plugins:
        unknown_names(source, parse_schema(model.schema), findings)
    check_meshes(model.meshes, source, findings)
    _unused(source, findings)
    bodies = Bodies(model, source, extras is not None, findings)
    check_range(model.gravity, "gravity", findings, None)
    if extras is not None and list(extras.gravity) != list(model.gravity):
        found = f"<option gravity> {listing(map(str, model.gravity))} is not used"
        findings.warn(found, f"that of the text 'cutjoint', {listing(map(str, extras.gravity))}", "change both")
    extras = extras or Extras(gravity=readonly(model.gravity))
    known = {cut.name for cut in extras.cuts} | {coupling.name for coupling in extras.couplings}
    cuts, followers = read_equalities(bodies, known, actuated_joints(bodies), findings)
    restore_tendons(bodies, followers, findings)
    motors = read_motors(bodies, followers, findings)
    cuts += read_tendons(bodies, followers, known | {cut.name for cut in cuts}, findings)
    extras = replace(extras, couplings=(*extras.couplings, *followers.couplings.values()))
    named = {frame.link for cut in [*cuts, *extras.cuts] for frame in (cut.a, cut.b)}
    named |= set() if extras.tool is None else {extras.tool.link}
    named |= {joint.parent for joint in bodies.tree.joints if joint.child in extras.fixed}
    bodies.drop_empty_world(named)
    bodies.name_fixed_joints(extras.fixed)
    bodies.tree.joints = driven(bodies.tree.joints, motors)
    every = [*cuts, *extras.cuts]
    if extras.actuators is None:
        driving = tuple(dict.fromkeys(motor.joint for motor in motors))
        if not every and not any(len(one) for one, _ in source.all("actuator")):
            driving = actuated_by_default(bodies.tree.joints, extras.couplings)
        extras = replace(extras, actuators=driving)
    if not extras.homes:
        extras = replace(extras, homes=read_homes(bodies, extras.actuators or (), findings))
    return described(bodies.tree, every, extras, path, findings)


def _compiled(source: MjcfText, own: bool, findings: Findings) -> Model | None:
    """What MuJoCo makes of the text, or None after noting why there is nothing.

    Flaws of mere looks, for which it refuses a file, are doubted and left out.
    """
    if not _installed(findings):
        return None
    for _ in range(MOST):
        request = Request(source.text, source.models, tuple(source.folders), own)
        try:
            answer = in_child(WORKER, request, SECONDS, MEGABYTES)
        except ChildFailed as failure:
            findings.error(f"MuJoCo {failure.reason} on this file", "a file that MuJoCo compiles", "")
            return None
        if not isinstance(answer, Refused):
            break
        message, line = _words(answer.text)
        known = not unknown_names(source, parse_schema(answer.schema), Findings())
        if line is None or not known or not left_out(line, message, source):
            break
        _refused(message, line, source, Harmless(findings))
    if isinstance(answer, Model):
        if len(answer.bodies) > 1:
            return answer
        place = next((at for _, at in source.all("worldbody")), None)
        findings.error("no body under <worldbody>", "<worldbody><body>...", "", place or source.root.sourceline)
    elif isinstance(answer, Refused):
        check_meshes(answer.meshes, source, findings)
        if answer.text and not unknown_names(source, parse_schema(answer.schema), findings):
            _refused(*_words(answer.text), source, findings)
    return None


def _installed(findings: Findings) -> bool:
    """Whether MuJoCo is there and new enough, without loading it into this process; else that is noted."""
    mend = how_to_get("mujoco")
    try:
        found = version("mujoco") if is_installed("mujoco") else ""
    except PackageNotFoundError:
        found = ""
    if not found:
        findings.error("MJCF is read through MuJoCo, which is not installed", "", mend)
        return False
    if tuple(int(part) for part in re.findall(r"\d+", found)[:3]) < OLDEST:
        findings.error(f"MuJoCo {found} is too old to read MJCF", f"{'.'.join(map(str, OLDEST))} or newer", mend)
        return False
    return True


def _words(text: str) -> tuple[str, int | None]:
    """What MuJoCo complains of, and the line of its text."""
    message, _, rest = text.partition("\nElement ")
    found = re.search(r"line (\d+)", rest)
    return re.sub(r"^((XML )?Error: |Schema violation: )+", "", message), int(found[1]) if found else None


def _refused(message: str, line: int | None, source: MjcfText, findings: Findings) -> None:
    """Note an error of MuJoCo at the place that it names."""
    place, element = source.place(line), source.element(line)
    quoted = re.findall(r"'([^']*)'", message)
    given = {} if element is None else {str(key): str(value) for key, value in element.attrib.items()}
    mend = ""
    for value in (given[key] for key in quoted if key in given and "format" in message):
        problem, mend = number_problem(value)
        message = f"{message}: {problem}"
    for key, value in given.items():
        if value in quoted:
            mend = mend or nearest(value, _names(key, source) - {value})
    what = "" if element is None else f"<{element.tag}>: "
    expected = "a file that MuJoCo compiles"
    findings.error(f"{what}{clip(message, 300)}", expected, mend, place or Place(findings.file))


def _names(attribute: str, source: MjcfText) -> set[str]:
    """All names that an attribute such as `joint2` or `class` may hold."""
    kind = attribute.rstrip("0123456789")
    tags = {"class": ("default",), "childclass": ("default",), "joint": ("joint", "freejoint")}
    tags["tendon"] = ("fixed", "spatial")
    found = (one.get("name") or one.get("class") for tag in tags.get(kind, (kind,)) for one, _ in source.all(tag))
    return {str(name) for name in found if name}


def _unused(source: MjcfText, findings: Findings) -> None:
    """Note forces of MuJoCo that are not computed here: of a fluid, and switches."""
    for option, place in source.all("option"):
        used = [key for key in _FLUID if any(parse_number(word) != 0.0 for word in str(option.get(key, "")).split())]
        if used:
            found = f"{', '.join(used)} of <option> not used"
            findings.warn(found, "forces of joints, cuts and gravity", "", place)
    for flag, place in source.all("flag"):
        off = [key for key in _SWITCHES if flag.get(key) == "disable"]
        if off:
            found = f"{', '.join(off)} switched off by <flag>, which is not heeded"
            findings.warn(found, "what acts in the model itself", "", place)
