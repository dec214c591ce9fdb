"""Where joint states are written: a file of JSON lines or a rosbag, by the ending of the name."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from cutjoint.errors import InputError, shown
from cutjoint.extras import needed
from cutjoint.files import check_place, path_name
from cutjoint.handover.bag import write_bag
from cutjoint.handover.joint_states import JointStates
from cutjoint.handover.lines import write_lines

WRITERS: Mapping[str, tuple[Callable[[JointStates, Path], None], str]] = {
    ".jsonl": (write_lines, "JSON lines in the words of rosbridge"),
    "": (write_bag, "the folder of a rosbag2"),
}
"""Ending -> how to write it, and what it is."""


def check_target(path: str | Path) -> Path:
    """`path` as a place for joint states; worth asking before anything long.

    Raises:
        InputError: another ending, no such folder, or a rosbag where something is already.
        MissingPackageError: a rosbag, and rosbags is not installed.
    """
    target = Path(path_name(path))
    if target.suffix not in WRITERS:
        known = "; ".join(f"'{ending or 'no ending'}' {what}" for ending, (_, what) in WRITERS.items())
        raise InputError(f"joint states are not written as '{shown(target.suffix)}'; known: {known}")
    if not target.suffix:
        needed("rosbags", "a rosbag")
        if target.exists():
            raise InputError(f"{shown(str(path))} is there already, and a rosbag is a new folder: name another one")
    return check_place(target)


def write(states: JointStates, path: str | Path) -> Path:
    """Write joint states as messages of ROS 2, as JSON lines (.jsonl) or as a rosbag2 (a name without ending).

    Raises:
        InputError, MissingPackageError: as `check_target`, or it cannot be written.
    """
    target = check_target(path)
    WRITERS[target.suffix][0](states, target)
    return target
