"""Joint states as messages of ROS 2, plain values: `sensor_msgs/msg/JointState` of the joints with one coordinate, and
`tf2_msgs/msg/TFMessage` of those with several (REP 103, REP 105; ROS 2 interfaces sensor_msgs and tf2_msgs)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from cutjoint.handover.joint_states import CarriedChild, JointStates

JOINT_STATE, TRANSFORMS = "sensor_msgs/msg/JointState", "tf2_msgs/msg/TFMessage"
TOPICS = {"/joint_states": JOINT_STATE, "/tf": TRANSFORMS}
"""Topic -> type of its messages."""


class Message(NamedTuple):
    """A message on a topic: when [ns], and its fields by name."""

    topic: str
    time: int
    fields: dict[str, object]

    @property
    def type(self) -> str:
        """Of the topic."""
        return TOPICS[self.topic]


def topics_of(states: JointStates) -> tuple[str, ...]:
    """The topics that `messages` has something on."""
    return ("/joint_states",) * bool(states.names) + ("/tf",) * bool(states.carried)


def messages(states: JointStates) -> Iterator[Message]:
    """The messages of all samples, in the order of time."""
    for i, t in enumerate(states.time.tolist()):
        stamp = round(t * 1e9)
        header: dict[str, object] = {"stamp": {"sec": stamp // 10**9, "nanosec": stamp % 10**9}, "frame_id": ""}
        if states.names:
            rows = {name: getattr(states, name)[i].tolist() for name in ("position", "velocity", "effort")}
            yield Message("/joint_states", stamp, {"header": header, "name": list(states.names), **rows})
        if states.carried:
            held = [_transform(one, i, header) for one in states.carried]
            yield Message("/tf", stamp, {"transforms": held})


def _transform(one: CarriedChild, i: int, header: dict[str, object]) -> dict[str, object]:
    """A `geometry_msgs/msg/TransformStamped`."""
    place = dict(zip("xyz", one.position[i].tolist(), strict=True))
    turn = dict(zip("xyzw", one.orientation[i].tolist(), strict=True))
    return {
        "header": {**header, "frame_id": one.parent},
        "child_frame_id": one.child,
        "transform": {"translation": place, "rotation": turn},
    }
