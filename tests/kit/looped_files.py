"""Files of planar linkages as people have them, a loop told in each of the ways that files know.

A linkage is the corners of its loop as it stands, in the x-y plane of the world: the first and the last are hinges of
the frame, each pair of neighbours is a bar.  The bars of the left half hang on the first corner one after the other,
those of the right half on the last, and both halves meet in a pin.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

Array = np.ndarray
FOUR = ((0.0, 0.0), (0.04, 0.09), (0.27, 0.19), (0.25, 0.0))
FIVE = ((-0.1, 0.0), (-0.17, 0.18), (0.0, 0.36), (0.18, 0.19), (0.1, 0.0))
WIDE = 0.02


@dataclass(frozen=True)
class Bar:
    """A bar of a linkage: its name, what it hangs on, where in that, and where it ends, from where it begins."""

    name: str
    parent: str
    at: Array
    end: Array

    @property
    def mass(self) -> float:
        """That of a rod of 2 kg/m."""
        return 2.0 * float(np.linalg.norm(self.end))

    @property
    def turned(self) -> float:
        """Its direction, from x towards y [rad]."""
        return float(np.arctan2(self.end[1], self.end[0]))

    @property
    def inertia(self) -> tuple[float, float]:
        """About its length, and across it, at its middle."""
        return self.mass * WIDE**2 / 6.0, self.mass * (float(self.end @ self.end) + WIDE**2) / 12.0


def bars(corners: tuple[tuple[float, float], ...]) -> list[Bar]:
    """The bars, those of the left half first."""
    points = np.array(corners)
    meeting = len(points) // 2
    made = []
    ways = (("left", list(range(meeting + 1))), ("right", list(range(len(points) - 1, meeting - 1, -1))))
    for side, way in ways:
        parent, last = "frame", np.zeros(2)
        for number, (start, end) in enumerate(pairwise(way), start=1):
            name = f"{side}_{number}"
            made.append(Bar(name, parent, points[start] - last, points[end] - points[start]))
            parent, last = name, points[start]
    return made


def _ends(made: list[Bar]) -> tuple[Bar, Bar]:
    """The bars that meet in the pin."""
    return [bar for bar in made if bar.name.startswith("left")][-1], made[-1]


def urdf(corners: tuple[tuple[float, float], ...], closing: Callable[[Bar, Bar], str]) -> str:
    """The linkage as URDF, its loop told by `closing`, which is given the two bars that meet."""
    made = bars(corners)
    inside = ['<link name="frame"/>', *_urdf(made), closing(*_ends(made))]
    return "\n".join(['<robot name="linkage">', *inside, "</robot>"])


def _urdf(made: list[Bar]) -> Iterator[str]:
    for bar in made:
        x, y = bar.end / 2.0
        along, across = bar.inertia
        middle = f'<origin xyz="{x} {y} 0" rpy="0 0 {bar.turned}"/>'
        yield (
            f'<link name="{bar.name}"><inertial>{middle}<mass value="{bar.mass}"/><inertia ixx="{along}" '
            f'iyy="{across}" izz="{across}" ixy="0" ixz="0" iyz="0"/></inertial><visual>{middle}<geometry>'
            f'<box size="{np.linalg.norm(bar.end)} {WIDE} {WIDE}"/></geometry></visual></link>'
        )
        yield (
            f'<joint name="hinge_{bar.name}" type="continuous"><parent link="{bar.parent}"/><child link="{bar.name}"/>'
            f'<origin xyz="{bar.at[0]} {bar.at[1]} 0"/><axis xyz="0 0 1"/></joint>'
        )


def frames(first: str, second: str, *further: tuple[str, str]) -> Callable[[Bar, Bar], str]:
    """The loop closes at links without mass of these names, one on either bar; `further` are such links beside them,
    along the axis of the hinge."""

    def closing(left: Bar, right: Bar) -> str:
        made = []
        for names, up in ((((first, second),), 0.0), (further, 0.1)):
            for pair in names:
                for name, bar in zip(pair, (left, right), strict=True):
                    made.append(
                        f'<link name="{name}"/><joint name="{name}_on_{bar.name}" type="fixed"><parent '
                        f'link="{bar.name}"/><child link="{name}"/>'
                        f'<origin xyz="{bar.end[0]} {bar.end[1]} {up}"/></joint>'
                    )
        return "\n".join(made)

    return closing


def two_parents(left: Bar, right: Bar) -> str:
    """The loop closes in a link that hangs on both bars: hinged to the left one, fixed to the right one."""
    return "\n".join(
        [
            '<link name="pin"/>',
            f'<joint name="fixes" type="fixed"><parent link="{right.name}"/><child link="pin"/>'
            f'<origin xyz="{right.end[0]} {right.end[1]} 0"/></joint>',
            f'<joint name="closes" type="continuous"><parent link="{left.name}"/><child link="pin"/>'
            f'<origin xyz="{left.end[0]} {left.end[1]} 0"/><axis xyz="0 0 1"/></joint>',
        ]
    )


def sdf(corners: tuple[tuple[float, float], ...]) -> str:
    """The linkage as SDF, where the last bar of the right half has a second parent."""
    made = bars(corners)
    places = {"frame": np.zeros(2)}
    lines = ['<sdf version="1.9"><model name="linkage">', '<link name="frame"/>']
    lines.append('<joint name="floor" type="fixed"><parent>world</parent><child>frame</child></joint>')
    for bar in made:
        places[bar.name] = places[bar.parent] + bar.at
        (x, y), (along, across), (mx, my) = places[bar.name], bar.inertia, bar.end / 2.0
        lines.append(
            f'<link name="{bar.name}"><pose>{x} {y} 0 0 0 0</pose><inertial><pose>{mx} {my} 0 0 0 {bar.turned}</pose>'
            f"<mass>{bar.mass}</mass><inertia><ixx>{along}</ixx><iyy>{across}</iyy><izz>{across}</izz><ixy>0</ixy>"
            "<ixz>0</ixz><iyz>0</iyz></inertia></inertial></link>"
        )
        lines.append(_sdf_hinge(f"hinge_{bar.name}", bar.parent, bar.name, "0 0"))
    left, right = _ends(made)
    lines.append(_sdf_hinge("closes", left.name, right.name, f"{right.end[0]} {right.end[1]}"))
    return "\n".join([*lines, "</model></sdf>"])


def _sdf_hinge(name: str, parent: str, child: str, at: str) -> str:
    return (
        f'<joint name="{name}" type="revolute"><parent>{parent}</parent><child>{child}</child><pose>{at} 0 0 0 0</pose>'
        "<axis><xyz>0 0 1</xyz></axis></joint>"
    )


FILES: dict[str, tuple[str, str]] = {
    "closed frames": ("robot.urdf", urdf(FOUR, frames("pin_closed_1", "pin_closed_2"))),
    "closing frames": (
        "robot.urdf",
        urdf(FIVE, frames("closing_tip_1", "closing_tip_2", ("closing_tip_1_z", "closing_tip_2_z"))),
    ),
    "loop frames": ("robot.urdf", urdf(FIVE, frames("tip_loop_a", "tip_loop_b"))),
    "ends in one place": ("robot.urdf", urdf(FOUR, frames("coupler_end", "rocker_end"))),
    "two parents": ("robot.urdf", urdf(FIVE, two_parents)),
    "SDF": ("robot.sdf", sdf(FOUR)),
}
"""How the loop is told -> name of the file, and its text."""
