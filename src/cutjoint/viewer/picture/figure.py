"""A robot as a scene: its links, and what can be shown over them.

The scene's root turns the robot so that gravity points down on screen whatever the world frame of the description,
puts its middle into the point that the camera turns about, and scales it to radius 1, so that camera, lights and floor
suit a robot of any size.  Everything below the root is in the world frame of the description, in metres.

Colours are the description's own; a link without one gets the colour of its limb (`limbs`), from the palette of Okabe
and Ito (distinguishable for the colour-blind).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from meshcat import geometry as g

from cutjoint.arrays import Array
from cutjoint.chain import ClosedChain
from cutjoint.description.model import RobotDescription, Shape
from cutjoint.mechanism import Posture
from cutjoint.viewer.picture import shapes
from cutjoint.viewer.picture.limbs import limb_colours, limb_of
from cutjoint.viewer.picture.scene import Scene
from cutjoint.viewer.picture.shapes import Colour
from cutjoint.viewer.picture.sticks import is_bare, sticks

ROOT = "robot"
GREY: Colour = (0.62, 0.64, 0.67, 1.0)
AXES: tuple[Colour, ...] = ((0.8, 0.1, 0.1, 1.0), (0.1, 0.6, 0.1, 1.0), (0.1, 0.2, 0.8, 1.0))
COLLISION: Colour = (0.9, 0.2, 0.5, 0.35)
PURPLE: Colour = (0.42, 0.24, 0.6, 1.0)
GRAVITY: Colour = (0.15, 0.15, 0.18, 1.0)
WORKSPACE = 0x7A5195
GAP = 0xD81B60
FRAME = 0.12
STICK = 0.05
"""Radius of the sticks of a robot without shapes, in its characteristic length."""

FURTHEST = 3.0
"""How far from its middle at the start the picture follows a robot, in its radii; one that runs away leaves it."""
SMALLEST = 1e-9
"""Radius of a robot that is a point [m]."""

CAMERA: tuple[float, float, float] = (2.1, -2.5, 1.35)
FIELD_OF_VIEW = 34.0


class Figure:
    """The scene of one robot; `pose` moves it.  The picture has room for the postures `also`, which it may take, and
    for the points `beside` it, shape (count, 3) [m].

    Attributes:
        scene: what a tab is sent.
        radius: half the robot's extent [m].
        colours: of the limbs of actuators, as far as they are seen.
        toggles: what can be shown or hidden: title -> (paths, shown at the start).
    """

    def __init__(
        self, chain: ClosedChain, at: Posture, also: Sequence[Posture] = (), beside: Array | None = None
    ) -> None:
        self.chain = chain
        self.scene = Scene()
        self.toggles: dict[str, tuple[list[str], bool]] = {}
        description = chain.description
        placements = chain.link_placements(at)
        self._paths = {link.name: f"{ROOT}/links/{_safe(i, link.name)}" for i, link in enumerate(description.links)}
        self._visuals: Mapping[str, tuple[Shape, ...]] = {link.name: link.visuals for link in description.links}
        if is_bare(description):
            self._visuals = sticks(description, STICK * chain.length, placements)
        self.colours = limb_colours(description, self._visuals, shapes.has_own_colour)
        low, high = self._bounds(placements)
        self.radius = max(float(np.linalg.norm(high - low)) / 2, SMALLEST)
        boxes = np.array([(low, high), *(self._bounds(chain.link_placements(one)) for one in also)])
        if beside is not None and len(beside):
            boxes = np.concatenate([boxes, [(beside.min(axis=0), beside.max(axis=0))]])
        middle, most = (low + high) / 2, FURTHEST * self.radius
        low, high = (
            np.maximum(boxes[:, 0].min(axis=0), middle - most),
            np.minimum(boxes[:, 1].max(axis=0), middle + most),
        )
        self._stage(np.asarray(description.gravity), low, high)
        self._links(description)
        self._overlays(description)
        self.pose(at)

    def link_path(self, link: str) -> str:
        """Scene path of a link."""
        return self._paths[link]

    def colour_of(self, actuator: str) -> str:
        """Colour of an actuator's limb for a page, empty where nothing is seen in it."""
        return css(self.colours[actuator]) if actuator in self.colours else ""

    def labels(self) -> list[dict[str, str]]:
        """Names of the actuators and the tool, and the paths where they are shown."""
        joints = {joint.name: joint for joint in self.chain.description.joints}
        found = [
            {"text": a.name, "path": self.link_path(joints[a.name].child), "colour": self.colour_of(a.name)}
            for a in self.chain.actuators
        ]
        if self.chain.description.tool is not None:
            found.append({"text": "tool", "path": f"{ROOT}/tool", "colour": ""})
        return found

    def pose(self, at: Posture) -> None:
        """Show posture `at`, in one batch."""
        with self.scene.batch():
            for name, placement in self.chain.link_placements(at).items():
                self.scene.set_transform(self._paths[name], placement)
            for path, placement in self.overlay_placements(at).items():
                self.scene.set_transform(path, placement)

    def overlay_placements(self, at: Posture) -> dict[str, Array]:
        """Placements of what follows the posture but is no link: path -> (4, 4), scale included."""
        found: dict[str, Array] = {}
        for i, (name, a, b) in enumerate(self.chain.cut_placements(at)):
            path = f"{ROOT}/loops/{_safe(i, name)}"
            found[f"{path}/a"], found[f"{path}/b"] = np.asarray(a), np.asarray(b)
            found[f"{path}/gap"] = _between(np.asarray(a)[:3, 3], np.asarray(b)[:3, 3])
        tool = self.chain.description.tool
        if tool is not None:
            found[f"{ROOT}/tool"] = self.chain.link_placements(at)[tool.link] @ tool.placement
        centre = shapes.translation(self.chain.centre_of_mass(at))
        found[f"{ROOT}/mass"] = centre
        down = np.asarray(self.chain.description.gravity)
        if np.linalg.norm(down) > 0:
            found[f"{ROOT}/gravity"] = centre @ shapes.along(down)
        return found

    def show_box(self, title: str, low: Array, high: Array) -> None:
        """Draw the edges of a box in the world frame [m] under a toggle."""
        path = f"{ROOT}/workspace"
        corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
        edges = [(a, b) for a in range(8) for b in range(a) if np.abs(corners[a] - corners[b]).sum() == 1]
        points = (low + corners * (high - low))[np.array(edges).ravel()]
        with self.scene.batch():
            self.scene.set_object(path, shapes.lines(points, WORKSPACE, pairs=True))
            self.scene.set_property(path, "visible", self.toggles.get(title, ([], False))[1])
        self.toggles[title] = ([path], False)

    def _stage(self, gravity: Array, low: Array, high: Array) -> None:
        scene = self.scene
        with scene.batch():
            for path in ("Grid", "Axes", "Lights/FillLight"):
                scene.set_property(path, "visible", path.startswith("Lights"))
            camera = g.PerspectiveCamera(fov=FIELD_OF_VIEW, near=0.01, far=100)
            scene.set_object("Cameras/default/rotated", camera)
            x, y, z = CAMERA
            scene.set_property("Cameras/default/rotated/<object>", "position", [x, z, -y])
            turn = turn_down(gravity)
            scale = 1.0 / max(float(np.linalg.norm(high - low)) / 2, SMALLEST)
            root = np.eye(4)
            root[:3, :3] = scale * turn
            root[:3, 3] = -scale * turn @ (low + high) / 2
            scene.set_transform(ROOT, root)
            box = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]) * (high - low) + low
            bottom = float((box @ turn.T * scale + root[:3, 3])[:, 2].min())
            scene.set_object("floor", _grid(1.6, 16))
            scene.set_transform("floor", shapes.translation([0, 0, bottom - 0.02]))

    def _links(self, description: RobotDescription) -> None:
        frames, collisions = [], []
        owners = limb_of(description)
        for link in description.links:
            path = self._paths[link.name]
            limb = owners.get(link.name)
            default = GREY if limb is None else self.colours.get(limb, GREY)
            self._draw(f"{path}/visual", self._visuals.get(link.name, ()), default)
            if link.collisions:
                self._draw(f"{path}/collision", link.collisions, COLLISION, own=False)
                collisions.append(f"{path}/collision")
            self.scene.set_object(f"{path}/frame", g.triad(FRAME * self.radius))
            frames.append(f"{path}/frame")
        self.toggle("Link frames", frames, False)
        if collisions:
            self.toggle("Collision shapes", collisions, not any(self._visuals.values()))

    def _bounds(self, placements: Mapping[str, Array]) -> tuple[Array, Array]:
        """Corners of a box around the robot, shape (3,) each [m]."""
        points = [placement[:3, 3][None, :] for placement in placements.values()]
        for link in self.chain.description.links:
            at = placements[link.name]
            shown = self._visuals.get(link.name, ()) or link.collisions
            points += [np.asarray(shapes.corners(shape) @ at[:3, :3].T + at[:3, 3]) for shape in shown]
        cloud = np.concatenate(points)
        return cloud.min(axis=0), cloud.max(axis=0)

    def put(self, path: str, part: shapes.Part) -> None:
        """A part of a shape at `path`."""
        self.scene.set_object(path, part.thing)
        self.scene.set_transform(path, part.placement)

    def _draw(self, path: str, visuals: tuple[Shape, ...], default: Colour, own: bool = True) -> None:
        for i, shape in enumerate(visuals):
            colour = shape.colour if own and shape.colour is not None else default
            for j, part in enumerate(shapes.parts(shape, colour)):
                self.put(f"{path}/{i}_{j}", part)

    def _overlays(self, description: RobotDescription) -> None:
        size = FRAME * self.radius
        for i, cut in enumerate(description.cuts):
            path = f"{ROOT}/loops/{_safe(i, cut.name)}"
            self.scene.set_object(f"{path}/a", g.triad(1.3 * size))
            for axis, colour in enumerate(AXES):
                end = 0.8 * size * np.eye(3)[axis]
                stick = shapes.tube(np.array([0 * end, end]), 0.07 * size, shapes.material(colour))
                self.scene.set_object(f"{path}/b/{axis}", stick)
            self.scene.set_object(f"{path}/gap", shapes.lines(np.array([[0.0, 0, 0], [0, 0, 1.0]]), GAP))
        if description.cuts:
            self.toggle("Loop closures", [f"{ROOT}/loops"], False)
        if description.tool is not None:
            self.scene.set_transform(f"{ROOT}/tool", np.eye(4))
        ball = g.Mesh(g.Sphere(0.03 * self.radius), shapes.over(PURPLE))
        self.scene.set_object(f"{ROOT}/mass", ball)
        self.toggle("Centre of mass", [f"{ROOT}/mass"], False)
        if np.linalg.norm(description.gravity) > 0:
            for i, part in enumerate(shapes.arrow(0.45 * self.radius, 0.012 * self.radius, shapes.over(GRAVITY))):
                self.put(f"{ROOT}/gravity/{i}", part)
            self.toggle("Gravity", [f"{ROOT}/gravity"], False)

    def toggle(self, title: str, paths: list[str], shown: bool) -> None:
        """Let `paths` be shown and hidden under `title`."""
        self.toggles[title] = (paths, shown)
        for path in paths:
            self.scene.set_property(path, "visible", shown)


def turn_down(gravity: Array) -> Array:
    """The smallest rotation (3, 3) that takes `gravity` to -z; identity where there is no gravity."""
    size = float(np.linalg.norm(gravity))
    if size == 0.0:
        return np.eye(3)
    down, wanted = gravity / size, np.array([0.0, 0.0, -1.0])
    axis, cosine = np.cross(down, wanted), float(down @ wanted)
    if cosine < -1 + 1e-12:
        return np.diag([1.0, -1.0, -1.0])
    skew = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0.0]])
    return np.asarray(np.eye(3) + skew + skew @ skew / (1.0 + cosine))


def css(colour: Colour) -> str:
    """A colour for a page, #rrggbb, or #rrggbbaa where it is not opaque."""
    channels = colour[:3] if colour[3] >= 1.0 else colour
    return "#" + "".join(f"{round(255 * channel):02x}" for channel in channels)


def _between(start: Array, end: Array) -> Array:
    """Placement and length that turn a unit line along z into the line from `start` to `end`."""
    length = float(np.linalg.norm(end - start))
    placement = shapes.along(end - start) if length > 0 else np.eye(4)
    placement[:3, :3] *= max(length, 1e-12)
    placement[:3, 3] = start
    return placement


def _grid(half: float, cells: int) -> g.Object:
    ticks = np.linspace(-half, half, cells + 1)
    ends = [[[t, -half, 0], [t, half, 0], [-half, t, 0], [half, t, 0]] for t in ticks]
    return shapes.lines(np.array(ends).reshape(-1, 3), 0xD5D8DD, pairs=True)


def _safe(index: int, name: str) -> str:
    """A path element: unique by its number, readable by its name."""
    return f"{index}_" + "".join(c if c.isalnum() or c in "-_." else "_" for c in name)
