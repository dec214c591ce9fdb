"""Messages as JSON, a line each, in the words of the rosbridge protocol 2: a bridge publishes them as they stand.

{"op": "advertise", "topic": "/joint_states", "type": "sensor_msgs/msg/JointState"}
{"op": "publish", "topic": "/joint_states", "msg": {"header": {...}, "name": [...], "position": [...], ...}}
"""

from __future__ import annotations

import json
from pathlib import Path

from cutjoint.files import write_whole
from cutjoint.handover.joint_states import JointStates
from cutjoint.handover.messages import TOPICS, messages, topics_of


def write_lines(states: JointStates, path: Path) -> None:
    """Write all messages, the topics first.

    Raises:
        InputError: the file cannot be written.
    """
    lines: list[dict[str, object]] = [
        {"op": "advertise", "topic": topic, "type": TOPICS[topic]} for topic in topics_of(states)
    ]
    lines += [{"op": "publish", "topic": one.topic, "msg": one.fields} for one in messages(states)]
    write_whole(path, "".join(f"{json.dumps(line, allow_nan=False)}\n" for line in lines))
