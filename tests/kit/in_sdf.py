"""Random mechanisms, and the same in the many words of SDF: frames, models in models, includes, chains of poses.

A mechanism is bodies and joints as they stand in the world at zero.  `as_description` makes a tree with cuts of it by
hand; `Sdf` writes it as text, with everything said in a randomly chosen way.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from cutjoint.description import JointType
from cutjoint.description.model import (
    Coupling,
    CutJoint,
    CutType,
    Frame,
    Inertial,
    Joint,
    JointPhysics,
    Link,
    RobotDescription,
)

Array = np.ndarray
Rng = np.random.Generator
WORDS = {
    JointType.REVOLUTE: ("revolute", "continuous"),
    JointType.PRISMATIC: ("prismatic",),
    JointType.UNIVERSAL: ("universal", "revolute2"),
    JointType.SPHERICAL: ("ball",),
    JointType.FIXED: ("fixed",),
}


def somewhere(rng: Rng) -> Array:
    """A random placement (4, 4) within a metre."""
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.random(random_state=rng).as_matrix()
    matrix[:3, 3] = rng.uniform(-0.6, 0.6, 3)
    return matrix


def unit(rng: Rng) -> Array:
    """A random direction (3,)."""
    vector = rng.normal(size=3)
    return vector / np.linalg.norm(vector)


@dataclass
class Body:
    """Mass [kg], centre (3,) [m] and inertia (3, 3) about it, along the axes of the world."""

    name: str
    mass: float
    centre: Array
    inertia: Array

    def seen(self, frame: Array) -> Inertial:
        """The same along a frame (4, 4)."""
        turn = frame[:3, :3].T
        inertia = turn @ self.inertia @ turn.T
        return Inertial(self.mass, turn @ (self.centre - frame[:3, 3]), 0.5 * (inertia + inertia.T))


@dataclass
class Pair:
    """A joint between two bodies (or the world), its frame (4, 4) in the world, and its axes (3,) in that frame."""

    name: str
    kind: JointType
    parent: str
    child: str
    frame: Array
    axis: Array
    axis2: Array
    damping: float = 0.0


@dataclass
class Mechanism:
    """Bodies, the joints of a tree from the world, those that close loops, mimics (joint, driver, ratio, offset)."""

    bodies: list[Body]
    tree: list[Pair]
    closing: list[Pair]
    mimics: list[tuple[str, str, float, float]] = field(default_factory=list)
    gravity: Array = field(default_factory=lambda: np.array([0.0, 0.0, -9.81]))


def random_mechanism(rng: Rng, count: int = 6) -> Mechanism:
    """Some bodies on random joints, one or two loops, and maybe a coupling."""
    bodies, tree = [], []
    for number in range(count):
        moments = rng.uniform(0.01, 0.02, 3)
        axes = Rotation.random(random_state=rng).as_matrix()
        bodies.append(
            Body(f"b{number}", rng.uniform(0.5, 2.0), rng.uniform(-1, 1, 3), axes @ np.diag(moments) @ axes.T)
        )
        parent = "world" if number == 0 else f"b{rng.integers(number)}"
        tree.append(_pair(rng, f"j{number}", parent, f"b{number}", (0.5, 0.2, 0.15, 0.15, 0.0)))
    closing = []
    for number in range(rng.integers(1, 3)):
        two = rng.choice(count, 2, replace=False)
        closing.append(_pair(rng, f"c{number}", f"b{two[0]}", f"b{two[1]}", (0.1, 0.0, 0.2, 0.6, 0.1)))
    single = [one.name for one in tree if one.kind in (JointType.REVOLUTE, JointType.PRISMATIC)]
    mimics = []
    if len(single) > 3 and rng.random() < 0.5:
        joint, driver = rng.choice(single, 2, replace=False)
        mimics.append((str(joint), str(driver), float(rng.uniform(-2, 2)), 0.0))
    return Mechanism(bodies, tree, closing, mimics, rng.uniform(-10, 10, 3))


def _pair(rng: Rng, name: str, parent: str, child: str, odds: tuple[float, ...]) -> Pair:
    kind = list(WORDS)[rng.choice(len(WORDS), p=odds)]
    axis = unit(rng)
    axis2 = np.cross(axis, unit(rng))
    damping = float(rng.choice([0.0, 0.3])) if kind not in (JointType.FIXED, JointType.SPHERICAL) else 0.0
    return Pair(name, kind, parent, child, somewhere(rng), axis, axis2 / np.linalg.norm(axis2), damping)


def as_description(made: Mechanism) -> RobotDescription:
    """The mechanism as a tree and cuts: every link has the frame of the joint that carries it."""
    at = {"world": np.eye(4)} | {one.child: one.frame for one in made.tree}
    links = [Link("world"), *(Link(body.name, body.seen(at[body.name])) for body in made.bodies)]
    joints = []
    for one in made.tree:
        here = np.linalg.inv(at[one.parent]) @ one.frame
        joint = Joint(one.name, one.kind, one.parent, one.child, here, one.axis, one.axis2)
        joints.append(_damped(joint, one))
    cuts = []
    for one in made.closing:
        turn = np.eye(4)
        if one.kind is JointType.UNIVERSAL:
            turn[:3, :3] = np.column_stack([one.axis, one.axis2, np.cross(one.axis, one.axis2)])
        elif one.kind in (JointType.REVOLUTE, JointType.PRISMATIC):
            side = np.cross(one.axis, np.eye(3)[np.argmin(np.abs(one.axis))])
            side /= np.linalg.norm(side)
            turn[:3, :3] = np.column_stack([side, np.cross(one.axis, side), one.axis])
        frames = [Frame(name, np.linalg.inv(at[name]) @ one.frame @ turn) for name in (one.parent, one.child)]
        physics = JointPhysics(damping=one.damping)
        cuts.append(CutJoint(one.name, CutType(str(one.kind.cut)), *frames, physics=physics))
    couplings = [Coupling.geared(f"{j}_mimic", j, driver, ratio, off) for j, driver, ratio, off in made.mimics]
    return RobotDescription("made", tuple(links), tuple(joints), tuple(cuts), tuple(couplings), gravity=made.gravity)


def _damped(joint: Joint, pair: Pair) -> Joint:
    return replace(joint, physics=JointPhysics(damping=pair.damping)) if pair.damping else joint


@dataclass
class Model:
    """A model as it is written: its frame (4, 4) in the world, and where all that is named in it stands."""

    name: str
    frame: Array
    above: Model | None = None
    places: dict[str, Array] = field(default_factory=dict)
    """Names that poses may be relative to, those of inner models among them."""
    lines: list[str] = field(default_factory=list)
    bodies: list[str] = field(default_factory=list)
    inner: list[Model] = field(default_factory=list)
    merged: bool = False

    def path(self) -> list[Model]:
        """From the outermost model to this one."""
        return [*(self.above.path() if self.above else []), self]


class Sdf:
    """A mechanism in SDF.  `names` tells what its joints are called there; `old` keeps to versions without frames."""

    def __init__(self, made: Mechanism, rng: Rng, folder: Path, old: bool = False) -> None:
        self.made, self.rng, self.folder, self.old = made, rng, folder, old
        self.names: dict[str, str] = {}
        self.links = {body.name: somewhere(rng) for body in made.bodies}
        self.files, self.included = 0, set[int]()
        self.version = str(rng.choice(["1.4", "1.5", "1.6"] if old else ["1.7", "1.9", "1.10", "1.12"]))

    def write(self) -> Path:
        """The file to read; included models are beside it."""
        top = Model("robot", somewhere(self.rng))
        self._nest(top, [body.name for body in self.made.bodies], 0)
        for pair in (*self.made.tree, *self.made.closing):
            self._joint(top, pair)
        gravity = " ".join(map(repr, map(float, self.made.gravity)))
        ground = '<model name="ground"><static>1</static><link name="plane"/></model>'
        text = self._text(top, self._pose(top.frame, {}, ""))
        path = self.folder / "robot.sdf"
        path.write_text(
            f'<sdf version="{self.version}"><world name="w"><gravity>{gravity}</gravity>{ground}{text}</world></sdf>\n'
        )
        return path

    # -- models ------------------------------------------------------------------------------------------------------

    def _nest(self, model: Model, bodies: list[str], depth: int) -> None:
        """Write the links, some of them into inner models."""
        inner: list[str] = []
        if not self.old and depth < 2 and len(bodies) > 2 and self.rng.random() < 0.7:
            inner = list(self.rng.choice(bodies, 2 if depth else 3, replace=False))
        for name in bodies:
            if name not in inner:
                self._link(model, name)
        if inner:
            below = Model(f"m{depth}", somewhere(self.rng), model)
            below.merged = self.rng.random() < 0.25
            model.inner.append(below)
            self._nest(below, inner, depth + 1)
            prefix = "" if below.merged else f"{below.name}::"
            model.places |= {} if below.merged else {below.name: below.frame}
            model.places |= {f"{prefix}{name}": at for name, at in below.places.items()}

    def _link(self, model: Model, name: str) -> None:
        at = self.links[name]
        body = next(one for one in self.made.bodies if one.name == name)
        own = somewhere(self.rng)
        seen = body.seen(at)
        inertia = own[:3, :3].T @ seen.inertia @ own[:3, :3]
        own[:3, 3] = seen.com
        numbers = {"ixx": (0, 0), "iyy": (1, 1), "izz": (2, 2), "ixy": (0, 1), "ixz": (0, 2), "iyz": (1, 2)}
        entries = "".join(f"<{key}>{float(inertia[where])!r}</{key}>" for key, where in numbers.items())
        pose = self._pose(own, None, "")
        model.lines.append(
            f'<link name="{name}">{self._pose(at, model.places, "", model)}'
            f"<inertial>{pose}<mass>{body.mass!r}</mass><inertia>{entries}</inertia></inertial></link>"
        )
        model.places[name] = at
        model.bodies.append(name)
        for number in range(0 if self.old else self.rng.integers(0, 3)):
            frame, place = f"{name}f{number}", somewhere(self.rng)
            to = name if number == 0 else str(self.rng.choice([name, f"{name}f{number - 1}"]))
            pose = self._pose(place, model.places, to, model)
            model.lines.append(f'<frame name="{frame}" attached_to="{to}">{pose}</frame>')
            model.places[frame] = place

    def _text(self, model: Model, pose: str) -> str:
        said = "".join(model.lines)
        for one in model.inner:
            inside = [*one.places] if one.merged else [one.name, *(f"{one.name}::{name}" for name in one.places)]
            base = {name: at for name, at in model.places.items() if name not in inside}
            said += self._inner(one, base, model)
        attributes = "".join(f' {key}="{value}"' for key, value in self._canonical(model).items())
        return f'<model name="{model.name}"{attributes}>{pose}{said}</model>'

    def _canonical(self, model: Model) -> dict[str, str]:
        if model.bodies and self.rng.random() < 0.5:
            return {"canonical_link": model.bodies[0]}
        return {}

    def _inner(self, one: Model, base: dict[str, Array], above: Model) -> str:
        """An inner model, written in place or included, with a pose of its own frame or of a frame in it."""
        frame, placed = "", one.frame
        if one.places and self.rng.random() < 0.5:
            frame = str(self.rng.choice(list(one.places)))
            placed = one.places[frame]
        pose = self._pose(placed, base, "", above)
        if not (one.merged or self.rng.random() < 0.4):
            said = self._text(one, pose)
            return said.replace("<model ", f'<model placement_frame="{frame}" ', 1) if frame else said
        self.files += 1
        part = f"part{self.files}"
        folder = self.folder / part
        folder.mkdir()
        self.included.add(id(one))
        text = self._text(one, self._pose(somewhere(self.rng), None, ""))
        text = text.replace(f'name="{one.name}"', 'name="other"', 1)
        (folder / "here.sdf").write_text(f'<sdf version="{self.version}">{text}</sdf>')
        (folder / "model.config").write_text(
            '<model><sdf version="1.4">no.sdf</sdf><sdf version="1.9">here.sdf</sdf></model>'
        )
        given = f"<placement_frame>{frame}</placement_frame>" if frame else ""
        merge = ' merge="true"' if one.merged else ""
        near = "../" if any(id(model) in self.included for model in above.path()) else ""
        uri = self.rng.choice([f"{near}{part}", f"model://{part}", f"{near}{part}/here.sdf"])
        return f"<include{merge}><uri>{uri}</uri><name>{one.name}</name>{pose}{given}</include>"

    # -- joints ------------------------------------------------------------------------------------------------------

    def _joint(self, top: Model, pair: Pair) -> None:
        """Write a joint into the innermost model that has both its ends."""
        ways = [self._way(top, name) for name in (pair.parent, pair.child)]
        model = top
        known = [way for way in ways if way is not None]
        shared = min(map(len, known)) if len(known) == 2 else 1
        coupled = any(pair.name in mimic[:2] for mimic in self.made.mimics)
        for depth in range(1, 1 if coupled else shared):
            if known[0][depth] is known[1][depth]:
                model = known[0][depth]
        backwards = pair.kind in (JointType.REVOLUTE, JointType.PRISMATIC) and self.rng.random() < 0.3
        backwards = backwards and "world" not in (pair.parent, pair.child)
        ends = [self._end(model, name) for name in (pair.parent, pair.child)]
        axis, axis2 = (-pair.axis if backwards else pair.axis), pair.axis2
        frame = pair.frame.copy()
        if pair.kind is not JointType.SPHERICAL:
            turn = Rotation.random(random_state=self.rng).as_matrix()
            frame[:3, :3] = frame[:3, :3] @ turn
            axis, axis2 = turn.T @ axis, turn.T @ axis2
        if pair.kind is JointType.REVOLUTE:
            frame[:3, 3] += frame[:3, :3] @ axis * self.rng.uniform(-1, 1)
        ends = ends[::-1] if backwards else ends
        word = "revolute" if self.old and pair.kind is JointType.REVOLUTE else self.rng.choice(WORDS[pair.kind])
        said = [self._axis(tag, one, frame, model, pair.damping) for tag, one in (("axis", axis), ("axis2", axis2))]
        count = pair.kind.axes
        mimic = "".join(
            f'<mimic joint="{driver}"><multiplier>{ratio!r}</multiplier><offset>{off!r}</offset></mimic>'
            for joint, driver, ratio, off in self.made.mimics
            if joint == pair.name
        )
        base = ends[1]
        pose = self._pose(frame, model.places, base, model)
        axes = "".join(said[:count]).replace("</axis>", f"{mimic}</axis>")
        hosts = model.path()
        while hosts[-1].merged:
            hosts.pop()
        self.names[pair.name] = "::".join([*(one.name for one in hosts[1:] if not one.merged), pair.name])
        if pair in self.made.closing:
            axes += "<physics><simbody><must_be_loop_joint>true</must_be_loop_joint></simbody></physics>"
        ends_said = f"<parent>{ends[0]}</parent><child>{ends[1]}</child>"
        model.lines.append(f'<joint name="{pair.name}" type="{word}">{pose}{ends_said}{axes}</joint>')

    def _way(self, model: Model, name: str) -> list[Model] | None:
        """The models around a link, outermost first; None for the world."""
        if name in model.bodies:
            return model.path()
        return next((way for one in model.inner if (way := self._way(one, name)) is not None), None)

    def _end(self, model: Model, name: str) -> str:
        """A link, or a frame that moves with it."""
        if name == "world":
            return name
        deeper = (self._way(model, name) or [])[len(model.path()) :]
        prefix = "::".join(one.name for one in deeper if not one.merged)
        prefix = prefix + "::" if prefix else ""
        frames = [one for one in model.places if one.startswith(f"{prefix}{name}f")]
        return str(self.rng.choice([f"{prefix}{name}", *frames]))

    def _axis(self, tag: str, axis: Array, frame: Array, model: Model, damping: float) -> str:
        name = str(self.rng.choice(["", "__model__", *([] if self.old else model.places)]))
        name = "__model__" if self.version == "1.4" else name
        if name:
            other = model.frame if name == "__model__" else model.places[name]
            axis = other[:3, :3].T @ frame[:3, :3] @ axis
        said = f' expressed_in="{name}"' if name and not self.old else ""
        dynamics = f"<dynamics><damping>{damping!r}</damping></dynamics>" if damping else ""
        if self.old and self.version != "1.4" and (name or self.rng.random() < 0.5):
            flag = self.rng.choice(["true", "1"] if name else ["false", "0"])
            dynamics += f"<use_parent_model_frame>{flag}</use_parent_model_frame>"
        return f"<{tag}><xyz{said}>{' '.join(map(repr, map(float, axis)))}</xyz>{dynamics}</{tag}>"

    # -- poses -------------------------------------------------------------------------------------------------------

    def _pose(self, at: Array, places: dict[str, Array] | None, default: str, model: Model | None = None) -> str:
        """A pose of what stands at `at` in the world, relative to some name or to the default (a name, or the model).

        Without places it is a pose in a frame that is not named.
        """
        said, base = "", np.eye(4)
        if places is not None:
            base = places[default] if default in places else np.eye(4) if model is None or default else model.frame
            if default and default not in places:
                said, base = ' relative_to="__model__"', (model.frame if model else np.eye(4))
            if model is not None and not self.old and self.rng.random() < 0.6:
                name = str(self.rng.choice(["__model__", *places]))
                base = model.frame if name == "__model__" else places[name]
                said = f' relative_to="{name}"'
        pose = np.linalg.inv(base) @ at
        turn = Rotation.from_matrix(pose[:3, :3])
        form = self.rng.integers(1 if self.old else 3)
        if form == 0:
            numbers = turn.as_euler("xyz")
        elif form == 1:
            numbers, said = np.rad2deg(turn.as_euler("xyz")), said + ' degrees="true"'
        else:
            numbers, said = turn.as_quat(), said + ' rotation_format="quat_xyzw"'
        return f"<pose{said}>{' '.join(map(repr, map(float, [*pose[:3, 3], *numbers])))}</pose>"
