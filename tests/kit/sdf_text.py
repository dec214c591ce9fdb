"""Pieces of SDF for tests: links and joints along z of a plane, in as few words as they need."""

from __future__ import annotations


def link(name: str, pose: str = "0 0 0 0 0 0", more: str = "") -> str:
    """A thin rod from the link's origin along x, 1 m and 1 kg; `more` goes into the element."""
    inertia = "<inertia><ixx>0.001</ixx><iyy>0.084</iyy><izz>0.084</izz></inertia>"
    inertial = f"<inertial><pose>0.5 0 0 0 0 0</pose><mass>1</mass>{inertia}</inertial>"
    return f'<link name="{name}"><pose>{pose}</pose>{inertial}{more}</link>'


def joint(name: str, parent: str, child: str, kind: str = "revolute", axis: str = "", more: str = "") -> str:
    """A joint along z where it needs an axis; `axis` goes into the <axis>."""
    one = "" if kind in ("fixed", "ball") else f"<axis><xyz>0 0 1</xyz>{axis}</axis>"
    return f'<joint name="{name}" type="{kind}"><parent>{parent}</parent><child>{child}</child>{one}{more}</joint>'


def model(inside: str, name: str = "robot", version: str = "1.9") -> str:
    """A file with one model."""
    return f'<sdf version="{version}"><model name="{name}">{inside}</model></sdf>'


def world(inside: str, version: str = "1.9") -> str:
    """A file with a world."""
    return f'<sdf version="{version}"><world name="lab">{inside}</world></sdf>'


SQUARE = (
    link("a", "0 0 0 0 0 1.5707963267948966")
    + link("b", "0 1 0 0 0 0")
    + link("c", "1 0 0 0 0 1.5707963267948966")
    + joint("A", "world", "a")
    + joint("B", "a", "b")
    + joint("C", "world", "c")
)
"""Two cranks and a coupler of 1 m; what joins c to the end of b is left out."""
TIP = '<pose relative_to="b">1 0 0 0 0 0</pose>'
