"""SDF (http://sdformat.org/spec), versions 1.4 to 1.12: links may have several parents; joints left over close loops.

One robot, of one model or of several that joints tie together, in a world or alone; models may be nested and included.
Without `<static>` and without a joint to `world` the base floats.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from cutjoint.arrays import readonly
from cutjoint.description.formats.common.extras import Extras, described
from cutjoint.description.formats.common.graph import PlacedLink, span
from cutjoint.description.formats.sdf.choice import Picked, chosen
from cutjoint.description.formats.sdf.coupling import read_gearbox, read_mimics
from cutjoint.description.formats.sdf.frames import Carriers, Frames, check_frames
from cutjoint.description.formats.sdf.include import open_sdf, outermost
from cutjoint.description.formats.sdf.joint import read_joints, world_end
from cutjoint.description.formats.sdf.link import read_body
from cutjoint.description.formats.sdf.plugin import read_plugins
from cutjoint.description.formats.sdf.scope import Item, Scope
from cutjoint.description.formats.sdf.values import WORLD
from cutjoint.description.formats.sdf.world import gravity_of, note_foreign, note_world
from cutjoint.description.model import IDENTITY, Coupling, Joint, JointType, Link, RobotDescription
from cutjoint.findings import Findings


def read(path: Path, findings: Findings) -> RobotDescription | None:
    """An SDF file with one robot."""
    root = open_sdf(path, findings)
    outer = None if root is None else outermost(root, path, findings)
    choice = None if outer is None else chosen(outer)
    if outer is None or choice is None:
        return None
    note_world(outer)
    frames, carriers = Frames(), Carriers()
    links = [item for model in choice.models for item in model.each("link")]
    if not links:
        findings.error("a model without links", "at least one <link>", "", choice.models[0].element.sourceline)
        return None
    placed = [read_body(item, frames) for item in links]
    mimics = [*read_mimics(choice.joints)]
    two = {one for mimic in mimics for one in (mimic.follower, mimic.leader)}
    edges = read_joints(choice.joints, two, frames, carriers)
    scopes = [scope for top in (outer, *choice.models) for scope in _scopes(top)]
    note_foreign(scopes)
    check_frames(scopes, frames, carriers)
    acting = read_plugins(scopes)
    couplings = [mimic.coupling for mimic in mimics] + acting.couplings + edges.couplings
    for item in edges.gearboxes:
        gearbox = read_gearbox(item, edges.joints, frames, carriers)
        couplings += [] if gearbox is None else [gearbox]
    placed += edges.links
    at = {body.link.name: body.world for body in placed}
    for parent, child, name, place in acting.held:
        edges.joints.append(Joint(name, JointType.FIXED, parent, child, at[child], place=place))
        edges.last.append(name)
    joints, root_link = _held(edges.joints, links, placed, choice)
    if root_link == WORLD:
        placed.insert(0, PlacedLink(Link(WORLD), IDENTITY))
    keep = {one for coupling in couplings for one in (coupling.joint, *coupling.drivers)} | {*acting.driven}
    tree, cuts = span(choice.name or path.stem, placed, joints, root_link, findings, keep, edges.last)
    _note_cut({cut.name for cut in cuts}, couplings, acting.driven, findings)
    tree.couplings.extend(couplings)
    extras = Extras(actuators=tuple(acting.driven) or None, gravity=readonly(gravity_of(outer)))
    return described(tree, cuts, extras, path, findings)


def _scopes(top: Scope) -> Sequence[Scope]:
    """The outermost scope alone, or a model with the models in it."""
    return [*top.models()] if top.is_model else [top]


def _held(joints: list[Joint], links: list[Item], placed: list[PlacedLink], choice: Picked) -> tuple[list[Joint], str]:
    """The joints, with those that hold static links and let the base float, and the root of the tree."""
    first = choice.models[0]
    if choice.base_only:
        moving = [one for one in joints if one.type.moves]
        if moving:
            found = f"static model '{first.name}' with joints that move, which Gazebo holds too"
            mend = "read as a robot on a fixed base; write a fixed joint to the world instead"
            first.findings.warn(found, "a model that is not static", mend, first.element.sourceline)
        if not any(world_end(one) for one in joints) and len(_parts(placed, joints)) == 1:
            return joints, placed[0].link.name
        return [*joints, *_roots(placed, joints, JointType.FIXED)], WORLD
    static = {item.full for item in links if item.scope.static}
    kept = []
    for one in joints:
        if {one.parent, one.child} <= static | {WORLD}:
            found = f"joint '{one.name}' between links of static models is not used"
            first.findings.warn(found, "a link that moves", "", one.place)
        else:
            kept.append(one)
    at = {body.link.name: body for body in placed}
    for name in sorted(static, key=list(at).index):
        body = at[name]
        kept.append(Joint(f"{name}_static", JointType.FIXED, WORLD, name, body.world, place=body.link.place))
    return [*kept, *_roots(placed, kept, JointType.FLOATING)], WORLD


def _parts(placed: list[PlacedLink], joints: list[Joint]) -> list[list[str]]:
    """The links in groups that joints connect, that of the world first where one hangs on it, in the file's order."""
    near: dict[str, set[str]] = {}
    for joint in joints:
        near.setdefault(joint.parent, set()).add(joint.child)
        near.setdefault(joint.child, set()).add(joint.parent)
    left = dict.fromkeys([*([WORLD] if WORLD in near else []), *(body.link.name for body in placed)])
    parts = []
    while left:
        stack, part = [next(iter(left))], []
        while stack:
            name = stack.pop()
            if name in left:
                del left[name]
                part.append(name)
                stack += near.get(name, set())
        parts.append(part)
    return parts


def _roots(placed: list[PlacedLink], joints: list[Joint], kind: JointType) -> list[Joint]:
    """A joint from the world to each part that none ties to it: to its first link, one that is no child if there is."""
    at = {body.link.name: body for body in placed}
    order = {name: number for number, name in enumerate(at)}
    below = {joint.child for joint in joints}
    extra: list[Joint] = []
    for part in _parts(placed, joints):
        if WORLD not in part:
            body = at[min(part, key=lambda name: (name in below, order[name]))]
            name = "root_joint" if not extra else f"{body.link.name}_root_joint"
            extra.append(Joint(name, kind, WORLD, body.link.name, body.world, place=body.link.place))
    return extra


def _note_cut(cuts: set[str], couplings: Sequence[Coupling], driven: Sequence[str], findings: Findings) -> None:
    """Note couplings and controllers of joints that close loops, which have no coordinate."""
    mend = "let another joint of the loop close it: <must_be_loop_joint>, or <parent> and <child> exchanged"
    for coupling in couplings:
        for name in sorted(cuts & {coupling.joint, *coupling.drivers}):
            found = f"coupling '{coupling.name}' of joint '{name}', which closes a loop"
            findings.error(found, "joints of the tree", mend, coupling.place)
    for name in cuts & set(driven):
        findings.error(f"a controller of joint '{name}', which closes a loop", "a joint of the tree", mend)
