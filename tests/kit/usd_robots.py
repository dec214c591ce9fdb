"""Random robots with loops as USD text, and the same robots as descriptions, made side by side of the same numbers.

USD keeps frames and masses in single precision, so all of them are drawn as such numbers; what follows from them is
computed in double precision.  In USD a body's own frame is anywhere, and a joint has a frame on each of its bodies; in
the description a link's frame is that of the joint which carries it.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from cutjoint.description import (
    Coupling,
    CutJoint,
    CutType,
    Frame,
    Inertial,
    Joint,
    JointType,
    Limits,
    Link,
    RobotDescription,
)

Array = np.ndarray
Rng = np.random.Generator
TYPES = {"revolute": "Revolute", "prismatic": "Prismatic", "spherical": "Spherical", "fixed": "Fixed"}
AXES = dict(zip("XYZ", np.eye(3), strict=True))


def single(values: Array | float) -> Array:
    """Rounded to single precision."""
    return np.float64(np.float32(values))


@dataclass
class Place:
    """A frame in single precision: position (3,) and quaternion (w, x, y, z)."""

    position: Array
    quaternion: Array

    @property
    def matrix(self) -> Array:
        w, x, y, z = self.quaternion / np.linalg.norm(self.quaternion)
        s = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        matrix = np.eye(4)
        matrix[:3, :3] += 2.0 * w * s + 2.0 * s @ s
        matrix[:3, 3] = self.position
        return matrix


def place_of(matrix: Array) -> Place:
    """The frame nearest to a matrix."""
    values, vectors = np.linalg.eigh(_symmetric(matrix[:3, :3]))
    x, y, z, w = vectors[:, np.argmax(values)]
    return Place(single(matrix[:3, 3]), single(np.array([w, x, y, z])))


def _symmetric(r: Array) -> Array:
    """The matrix whose largest eigenvector is the quaternion (x, y, z, w) of a rotation (Bar-Itzhack)."""
    return (
        np.array(
            [
                [r[0, 0] - r[1, 1] - r[2, 2], r[1, 0] + r[0, 1], r[2, 0] + r[0, 2], r[2, 1] - r[1, 2]],
                [r[1, 0] + r[0, 1], r[1, 1] - r[0, 0] - r[2, 2], r[2, 1] + r[1, 2], r[0, 2] - r[2, 0]],
                [r[2, 0] + r[0, 2], r[2, 1] + r[1, 2], r[2, 2] - r[0, 0] - r[1, 1], r[1, 0] - r[0, 1]],
                [r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1], r[0, 0] + r[1, 1] + r[2, 2]],
            ]
        )
        / 3.0
    )


NOWHERE = Place(np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]))


def somewhere(rng: Rng, planar: bool = False) -> Place:
    """A random frame; of planar robots a shift in their plane alone."""
    if planar:
        return Place(single(np.append(rng.uniform(-0.4, 0.4, 2), 0.0)), NOWHERE.quaternion)
    return Place(single(rng.uniform(-0.4, 0.4, 3)), single(rng.normal(size=4)))


@dataclass
class UsdJoint:
    """A joint of either kind; `length` of a distance, `limits` in degrees or units."""

    name: str
    kind: str
    parent: str
    child: str
    a: Place
    b: Place
    axis: str = "Z"
    length: float = 0.0
    limits: tuple[float, float] | None = None
    cut: bool = False
    value: float = 0.0
    """Where it stands, in radians or metres, along the axis of the tree."""
    flipped: bool = False
    """Whether the file names the child first, so that its coordinates are those of the inverse motion."""


@dataclass
class UsdRobot:
    """A robot: bodies, joints of the tree in its order, cuts; the world is the body without a name."""

    name: str
    rng: Rng
    length: float = 1.0
    mass: float = 1.0
    masses: dict[str, tuple[float, Array, Array, Array]] = field(default_factory=dict)
    joints: list[UsdJoint] = field(default_factory=list)
    gears: list[tuple[str, str, float, float]] = field(default_factory=list)
    mounting: dict[str, Array] = field(default_factory=lambda: {"": np.eye(4)})
    """Where each body stands in the file."""
    frames: dict[str, Array] = field(default_factory=lambda: {"": np.eye(4)})
    """The frame of the description's link in the frame of the body."""

    def joint(self, name: str, kind: str, parent: str, child: str, a: Place, b: Place, axis: str = "Z") -> UsdJoint:
        """A joint of the tree with the body that it carries, at random coordinates in the pose of the file."""
        rng = self.rng
        axes = single(rng.normal(size=4))
        moments = single(rng.uniform(0.5, 1.0, 3) * 2e-2)
        self.masses[child] = (float(single(rng.uniform(0.3, 1.0))), single(rng.uniform(-0.1, 0.1, 3)), moments, axes)
        made = UsdJoint(name, kind, parent, child, a, b, axis)
        self.joints.append(made)
        self.frames[child] = b.matrix
        motion = np.eye(4)
        made.value = rng.uniform(-1.0, 1.0) if kind == "revolute" else rng.uniform(-0.3, 0.3)
        if kind == "revolute":
            motion = _turn(AXES[axis], made.value)
        elif kind == "prismatic":
            motion[:3, 3] = made.value * AXES[axis]
        elif kind == "spherical":
            motion = place_of(somewhere(rng).matrix).matrix
            motion[:3, 3] = 0.0
        self.mounting[child] = self.mounting[parent] @ a.matrix @ motion @ np.linalg.inv(b.matrix)
        return made

    def cut(self, name: str, kind: str, parent: str, child: str, a: Place, axis: str = "Z") -> UsdJoint:
        """A joint that closes a loop where the bodies stand, to single precision."""
        at = self.mounting[parent] @ a.matrix
        length = 0.0
        if kind == "distance":
            b = somewhere(self.rng)
            length = float(single(np.linalg.norm(at[:3, 3] - (self.mounting[child] @ b.matrix)[:3, 3])))
        else:
            b = place_of(np.linalg.inv(self.mounting[child]) @ at)
            if not np.any(a.quaternion[1:]):
                b.quaternion = NOWHERE.quaternion
                b.position[2] = 0.0
        made = UsdJoint(name, kind, parent, child, a, b, axis, length, cut=True)
        self.joints.append(made)
        return made

    @property
    def usda(self) -> str:
        """The text of a stage; values are in its own units."""
        rows = [
            "#usda 1.0",
            f'(\n    defaultPrim = "{self.name}"\n    metersPerUnit = {self.length!r}',
            f'    kilogramsPerUnit = {self.mass!r}\n    upAxis = "Z"\n)',
            f'def Xform "{self.name}" (\n    prepend apiSchemas = ["PhysicsArticulationRootAPI"]\n)\n{{',
        ]
        for name, (mass, com, moments, axes) in self.masses.items():
            matrix = self.mounting[name].copy()
            matrix[:3, 3] /= self.length
            given = ", ".join(_tuple(column) for column in matrix.T)
            rows += [
                f'    def Xform "{name}" (\n'
                '        prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"]\n    )\n    {',
                f"        float physics:mass = {mass / self.mass!r}",
                f"        point3f physics:centerOfMass = {_tuple(com / self.length)}",
                f"        float3 physics:diagonalInertia = {_tuple(moments / self.mass / self.length**2)}",
                f"        quatf physics:principalAxes = {_tuple(axes)}",
                f"        matrix4d xformOp:transform = ( {given} )",
                '        uniform token[] xformOpOrder = ["xformOp:transform"]\n    }',
            ]
        rows += [self._text(joint) for joint in self.joints]
        return "\n".join([*rows, "}", ""])

    def _text(self, joint: UsdJoint) -> str:
        kind = "Distance" if joint.kind == "distance" else TYPES[joint.kind]
        gears = [one for one in self.gears if one[0] == joint.name]
        head = f'    def Physics{kind}Joint "{joint.name}"'
        if gears:
            head += ' (\n        prepend apiSchemas = ["PhysxMimicJointAPI:rotX"]\n    )'
        rows = [head, "    {"]
        ends = [(joint.parent, joint.a), (joint.child, joint.b)]
        for number, (body, place) in enumerate(ends[::-1] if joint.flipped else ends):
            if body:
                rows.append(f"        rel physics:body{number} = </{self.name}/{body}>")
            rows.append(f"        point3f physics:localPos{number} = {_tuple(place.position / self.length)}")
            rows.append(f"        quatf physics:localRot{number} = {_tuple(place.quaternion)}")
        if joint.kind in ("revolute", "prismatic"):
            rows.append(f'        uniform token physics:axis = "{joint.axis}"')
        if joint.limits is not None:
            rows.append(f"        float physics:lowerLimit = {joint.limits[0]!r}")
            rows.append(f"        float physics:upperLimit = {joint.limits[1]!r}")
        if joint.kind == "distance":
            rows.append(f"        float physics:minDistance = {joint.length / self.length!r}")
            rows.append(f"        float physics:maxDistance = {joint.length / self.length!r}")
        if joint.cut:
            rows.append("        bool physics:excludeFromArticulation = 1")
        for _, leader, gearing, offset in gears:
            rows.append(f"        float physxMimicJoint:rotX:gearing = {gearing!r}")
            rows.append(f"        float physxMimicJoint:rotX:offset = {offset!r}")
            rows.append(f"        rel physxMimicJoint:rotX:referenceJoint = </{self.name}/{leader}>")
        return "\n".join([*rows, "    }"])

    @property
    def description(self) -> RobotDescription:
        """The same robot, its links in the frames of their joints."""
        links, joints, cuts = [Link("world")], [], []
        for name, (mass, com, moments, axes) in self.masses.items():
            back = np.linalg.inv(self.frames[name])
            turned = back[:3, :3] @ Place(np.zeros(3), axes).matrix[:3, :3]
            inertia = turned @ np.diag(moments) @ turned.T
            centre = back[:3, :3] @ com + back[:3, 3]
            links.append(Link(name, Inertial(mass, centre, 0.5 * (inertia + inertia.T))))
        for one in self.joints:
            parent, child = one.parent or "world", one.child or "world"
            at = np.linalg.inv(self.frames[one.parent]) @ one.a.matrix
            if one.cut:
                align = np.eye(4)
                align[:3, :3] = {"X": _columns("YZX"), "Y": _columns("ZXY"), "Z": np.eye(3)}[one.axis]
                there = np.linalg.inv(self.frames[one.child]) @ one.b.matrix
                kind = CutType(one.kind)
                cuts.append(
                    CutJoint(one.name, kind, Frame(parent, at @ align), Frame(child, there @ align), length=one.length)
                )
                continue
            kind = JointType.CONTINUOUS if one.kind == "revolute" and one.limits is None else JointType(one.kind)
            limits = Limits()
            if one.limits is not None:
                unit = np.pi / 180.0 if one.kind == "revolute" else self.length
                limits = Limits(one.limits[0] * unit, one.limits[1] * unit)
            axis = -AXES[one.axis] if one.flipped else AXES[one.axis]
            joints.append(Joint(one.name, kind, parent, child, at, axis, limits=limits))
        couplings = [self._coupling(*gear) for gear in self.gears]
        return RobotDescription(self.name, tuple(links), tuple(joints), tuple(cuts), tuple(couplings))

    def in_file(self, joint: UsdJoint) -> float:
        """Where a joint stands, in degrees or units, as its file counts it."""
        unit = np.pi / 180.0 if joint.kind == "revolute" else self.length
        return (-joint.value if joint.flipped else joint.value) / unit

    def _coupling(self, joint: str, leader: str, gearing: float, offset: float) -> Coupling:
        units = {one.name: np.pi / 180.0 if one.kind == "revolute" else self.length for one in self.joints}
        return Coupling.geared(
            f"{joint}_mimic", joint, leader, -gearing * units[joint] / units[leader], -offset * units[joint]
        )


def _columns(letters: str) -> Array:
    """The rotation whose columns are these axes."""
    return np.column_stack([AXES[letter] for letter in letters])


def _tuple(values: Array) -> str:
    return f"({', '.join(repr(float(one)) for one in values)})"


def _turn(axis: Array, angle: float) -> Array:
    return Place(np.zeros(3), np.append(np.cos(0.5 * angle), np.sin(0.5 * angle) * axis)).matrix


def planar(rng: Rng, bars: int, **units: float) -> UsdRobot:
    """A planar linkage with one loop of `bars` links, the base among them; a hinge or a slider a joint."""
    robot = UsdRobot(f"bars{bars}", rng, **units)
    left = int(rng.integers(1, bars - 1))
    for side, count in (("l", left), ("r", bars - 1 - left)):
        parent = ""
        for number in range(count):
            name = f"{side}{number}"
            robot.joint(f"{name}_turn", "revolute", parent, name, somewhere(rng, True), somewhere(rng, True))
            parent = name
    robot.cut("tip", "revolute", f"l{left - 1}", f"r{bars - 2 - left}", somewhere(rng, True))
    return robot


def spatial(rng: Rng, **units: float) -> UsdRobot:
    """Two chains of all types of joints, a ball, a weld or a rod between their ends, perhaps a gear and limits."""
    robot = UsdRobot("spatial", rng, **units)
    singles: list[UsdJoint] = []
    for side in "lr":
        parent, turns = "", 0
        while turns < 4:
            kind = str(rng.choice(list(TYPES), p=[0.55, 0.2, 0.15, 0.1]))
            name = f"{side}{len(robot.joints)}"
            made = robot.joint(
                f"{name}_joint", kind, parent, name, somewhere(rng), somewhere(rng), str(rng.choice(list("XYZ")))
            )
            if rng.random() < 0.3 and kind in ("revolute", "prismatic"):
                made.limits = (-170.0, 175.0) if kind == "revolute" else (-8.0, 8.0)
            if kind in ("revolute", "prismatic"):
                singles.append(made)
            made.flipped = rng.random() < 0.25
            parent, turns = name, turns + {"spherical": 3, "fixed": 0}.get(kind, 1)
    ends = [[one for one in robot.masses if one.startswith(side)][-1] for side in "lr"]
    kind = str(rng.choice(["spherical", "distance", "fixed"], p=[0.5, 0.3, 0.2]))
    robot.cut("closing", kind, *(ends if rng.random() < 0.5 else ends[::-1]), somewhere(rng))
    if len(singles) > 1 and rng.random() < 0.5:
        first, second = (singles[number] for number in rng.choice(len(singles), 2, replace=False))
        gearing = float(single(rng.uniform(0.5, 2.0)))
        own, other = (robot.in_file(one) for one in (first, second))
        robot.gears.append((first.name, second.name, gearing, float(single(-own - gearing * other))))
    return robot


def stewart(rng: Rng) -> UsdRobot:
    """A Stewart platform in miniature: ball, slider, ball a leg, the first ball of each in the tree."""
    robot = UsdRobot("stewart", rng)
    robot.masses["plate"] = (1.0, single(np.array([0.0, 0.0, 0.01])), single(np.array([0.01, 0.01, 0.02])),
                             NOWHERE.quaternion)  # fmt: skip
    robot.mounting["plate"] = Place(np.array([0.0, 0.0, 0.5]), NOWHERE.quaternion).matrix
    robot.frames["plate"] = np.eye(4)
    for number in range(6):
        angle = np.pi / 3.0 * number + 0.2 * (-1) ** number
        foot = single(0.4 * np.array([np.cos(angle), np.sin(angle), 0.0]))
        head = single(0.25 * np.array([np.cos(1.1 * angle), np.sin(1.1 * angle), 0.0]))
        low, high = f"low{number}", f"high{number}"
        robot.joint(f"ball{number}", "spherical", "", low, Place(foot, NOWHERE.quaternion), NOWHERE)
        way = robot.mounting["plate"][:3, 3] + head - foot
        axis = way / np.linalg.norm(way)
        robot.mounting[low] = np.eye(4)
        robot.mounting[low][:3, :3] = np.linalg.svd(np.outer(axis, axis))[0][:, [1, 2, 0]]
        robot.mounting[low][:3, 2] = axis
        if np.linalg.det(robot.mounting[low][:3, :3]) < 0.0:
            robot.mounting[low][:3, 0] *= -1.0
        robot.mounting[low][:3, 3] = foot
        robot.joint(f"slider{number}", "prismatic", low, high, NOWHERE, NOWHERE)
        robot.mounting[high] = robot.mounting[low].copy()
        robot.mounting[high][:3, 3] += way
    for number in range(6):
        if number == 0:
            at = single((np.linalg.inv(robot.mounting["plate"]) @ robot.mounting["high0"])[:3, 3])
            place, weights = robot.mounting["plate"], robot.masses["plate"]
            robot.joint("top0", "spherical", "high0", "plate", NOWHERE, Place(at, NOWHERE.quaternion))
            robot.mounting["plate"], robot.masses["plate"] = place, weights
            continue
        head = np.linalg.inv(robot.mounting["plate"]) @ robot.mounting[f"high{number}"]
        made = robot.cut(f"top{number}", "spherical", f"high{number}", "plate", NOWHERE)
        made.b.position = single(head[:3, 3])
    return robot
