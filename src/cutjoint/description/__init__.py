"""Robots on disk and as values: readers, checks, and the catalogue of robots that ship with cutjoint."""

from cutjoint.description.check import check, check_description, load_description, read_checked
from cutjoint.description.formats import write
from cutjoint.description.model import (
    Bushing,
    Coupling,
    CutJoint,
    CutType,
    Frame,
    Home,
    Inertial,
    Joint,
    JointPhysics,
    JointType,
    Limits,
    Link,
    Place,
    RobotDescription,
    Shape,
    Variant,
)
from cutjoint.description.paths import paths
from cutjoint.description.stretching import mounted, stretched
from cutjoint.description.values import value, with_values

__all__ = [
    "Bushing",
    "Coupling",
    "CutJoint",
    "CutType",
    "Frame",
    "Home",
    "Inertial",
    "Joint",
    "JointPhysics",
    "JointType",
    "Limits",
    "Link",
    "Place",
    "RobotDescription",
    "Shape",
    "Variant",
    "check",
    "check_description",
    "load_description",
    "mounted",
    "paths",
    "read_checked",
    "stretched",
    "value",
    "with_values",
    "write",
]
