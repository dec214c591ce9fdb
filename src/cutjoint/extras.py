"""Optional packages: which extra of cutjoint brings what, and one error for all that is not installed."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from importlib.util import find_spec
from types import ModuleType

from cutjoint.errors import MissingPackageError

EXTRAS: Mapping[str, str] = {
    "meshcat": "viewer",
    "tornado": "viewer",
    "trimesh": "viewer",
    "umsgpack": "viewer",
    "zmq": "viewer",
    "matplotlib": "report",
    "llvmlite": "compile",
    "pyarrow": "parquet",
    "yaml": "formats",
    "example_robot_data": "formats",
    "xacro": "formats",
    "mujoco": "formats",
    "pxr": "usd",
    "rosbags": "ros",
    "skimage": "surface",
    "ruckig": "retime",
    "control": "tune",
    "distributed": "study",
    "SALib": "study",
    "optuna": "optimise",
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
        raise missing(module, what) from error


def missing(module: str | None, what: str) -> MissingPackageError:
    """The error for an optional package, or a module in it, that could not be imported for `what`.

    Raises:
        ImportError: it is no optional package, so that nothing can be said about it.
    """
    package = (module or "").split(".")[0]
    if package not in EXTRAS:
        raise ImportError(f"{what} needs {module}, which cannot be imported")
    return MissingPackageError(what, package, EXTRAS[package])


def is_installed(package: str) -> bool:
    """Whether an optional package can be imported, without importing it."""
    return find_spec(package) is not None


def how_to_get(package: str) -> str:
    """How an optional package is installed."""
    return f"pip install 'cutjoint[{EXTRAS[package]}]'"
