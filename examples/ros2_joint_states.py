# /// script
# requires-python = ">=3.11"
# dependencies = ["rosbags>=0.10"]
# ///
"""A simulation as joint states of ROS 2, with the passive joints, written as a rosbag2 and read back.

`cutjoint states RUN.npz -o FOLDER` does the same.  A platform that flies has no place among numbers: it is on /tf.

cutjoint itself comes from a checkout: pip install '.[compile,ros]'
"""

import tempfile
from pathlib import Path

import numpy as np
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore

import cutjoint
from cutjoint.handover import joint_states, write
from cutjoint.simulation import run


def read(folder):
    """Topic -> messages of a bag."""
    types, found = get_typestore(Stores.ROS2_JAZZY), {}
    with Reader(folder) as bag:
        for connection, _, raw in bag.messages():
            found.setdefault(connection.topic, []).append(types.deserialize_cdr(raw, connection.msgtype))
    return found


def main():
    """A Stewart platform under a constant push of its motors."""
    chain = cutjoint.load("stewart")
    result = run(chain, lambda t: chain.terms(chain.home).gravity + np.array([5.0, 0, 0, 5.0, 0, 0]), duration=0.2)
    with tempfile.TemporaryDirectory() as folder:
        found = read(write(joint_states(result, chain), Path(folder) / "run"))

    joints, last = found["/joint_states"], found["/joint_states"][-1]
    places = dict(zip(last.name, last.position, strict=True))
    speeds = dict(zip(last.name, last.velocity, strict=True))
    flown = found["/tf"][-1].transforms[0]
    placed = chain.link_placements(result.q_full[-1])[flown.child_frame_id][:3, 3]
    apart = np.abs([getattr(flown.transform.translation, axis) for axis in "xyz"] - placed).max()
    print(f"{len(joints)} messages of {len(places)} joints; {flown.child_frame_id} is on /tf, {apart:.1e} m off")
    assert len(joints) == len(found["/tf"]) == len(result)
    assert apart < 1e-12
    for k, one in enumerate(chain.actuators):
        assert places[one.name] == result.q[-1, k]
        assert abs(speeds[one.name] - result.v[-1, k]) < 1e-9
    assert set(places) - {one.name for one in chain.actuators}, "passive joints should be there"


if __name__ == "__main__":
    main()
