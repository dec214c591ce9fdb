"""Messages as a rosbag2: a folder with an SQLite database and metadata, which `ros2 bag play` plays.

Written by the library rosbags, in version 8 of the format.
"""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from cutjoint.errors import InputError
from cutjoint.extras import needed
from cutjoint.files import check_place
from cutjoint.handover.joint_states import JointStates
from cutjoint.handover.messages import TOPICS, messages, topics_of

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

VERSION = 8
_FLOATS = "position", "velocity", "effort"
_INNER = {
    "header": "std_msgs/msg/Header",
    "stamp": "builtin_interfaces/msg/Time",
    "transform": "geometry_msgs/msg/Transform",
    "translation": "geometry_msgs/msg/Vector3",
    "rotation": "geometry_msgs/msg/Quaternion",
}
"""Fields that are messages -> their types."""


def write_bag(states: JointStates, path: Path) -> None:
    """Write all messages as a new folder, whole or not at all.

    Raises:
        InputError: something is there already, or it cannot be written.
        MissingPackageError: rosbags is not installed.
    """
    rosbag2, typesys = needed("rosbags.rosbag2", "a rosbag"), needed("rosbags.typesys", "a rosbag")
    types = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
    check_place(path)
    try:
        with tempfile.TemporaryDirectory(dir=path.parent, prefix=f".{path.name[:40]}.") as folder:
            fresh = Path(folder) / path.name
            with rosbag2.Writer(fresh, version=VERSION, storage_plugin=rosbag2.StoragePlugin.SQLITE3) as bag:
                ways = {topic: bag.add_connection(topic, TOPICS[topic], typestore=types) for topic in topics_of(states)}
                for one in messages(states):
                    bag.write(
                        ways[one.topic], one.time, types.serialize_cdr(_made(types, one.type, one.fields), one.type)
                    )
            fresh.rename(path)  # beside it, so at once; never into a folder that came meanwhile
    except OSError as error:
        raise InputError(f"cannot write {path}: {error.strerror or error}") from error


def _made(types: Typestore, name: str, fields: Mapping[str, object]) -> object:
    """The object of rosbags for a message of the type called `name`; of its fields those that are messages too are made
    so."""
    values = dict(fields)
    for field, value in fields.items():
        if isinstance(value, Mapping):
            values[field] = _made(types, _INNER[field], value)
        elif field == "transforms" and isinstance(value, list):
            values[field] = [_made(types, "geometry_msgs/msg/TransformStamped", one) for one in value]
        elif field in _FLOATS:
            values[field] = np.array(value, dtype=np.float64)
    return types.types[name](**values)
