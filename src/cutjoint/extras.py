"""Optional packages: which extra of cutjoint brings what, and one error for all that is not installed."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from types import ModuleType

from cutjoint.errors import MissingPackageError

EXTRAS: Mapping[str, str] = {
    "meshcat": "viewer",
    "tornado": "viewer",
    "trimesh": "viewer",
    "umsgpack": "viewer",
    "matplotlib": "report",
    "llvmlite": "compile",
    "pyarrow": "parquet",
    "yaml": "formats",
    "example_robot_data": "formats",
    "xacro": "formats",
    "mujoco": "formats",
    "pxr": "usd",
    "rosbags": "ros",
}
"""Package, as it is imported -> the extra that brings it."""


def needed(module: str, what: str) -> ModuleType:
    """The module of an optional package; `what` begins the error's sentence, such as "a Parquet file".

    Raises:
        MissingPackageError: it is not installed.
    """
    try:
        return import_module(module)
    except ImportError as error:
        package = module.split(".")[0]
        raise MissingPackageError(what, package, EXTRAS[package]) from error
