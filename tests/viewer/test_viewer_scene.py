from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import umsgpack
from meshcat import geometry as g

from cutjoint.errors import InputError
from cutjoint.viewer.picture.scene import Scene

BOX = g.Mesh(g.Box([1.0, 1.0, 1.0]))


def types(messages: list[bytes]) -> list[tuple[str, str]]:
    return [(m["type"], m.get("path", "")) for m in map(umsgpack.unpackb, messages)]


def test_a_late_tab_gets_the_scene_as_it_is_now() -> None:
    scene = Scene()
    scene.set_object("a/b", BOX)
    for x in range(5):
        scene.set_transform("a/b", np.diag([1.0, 1.0, 1.0, 1.0]) + np.eye(4, k=3) * x)
        scene.set_property("a/b", "visible", x % 2 == 0)
    scene.set_object("gone/below", BOX)
    scene.set_transform("gone", np.eye(4))
    scene.delete("gone")
    replay = list(scene.messages())
    assert types(replay) == [("set_object", "/a/b"), ("set_property", "/a/b"), ("set_transform", "/a/b")]
    assert umsgpack.unpackb(replay[2])["matrix"][12] == 4.0
    assert umsgpack.unpackb(replay[1])["value"] is True


def test_a_new_object_drops_the_properties_of_the_old_one_as_meshcat_does() -> None:
    scene = Scene()
    scene.set_object("a", BOX)
    scene.set_property("a", "visible", False)
    scene.set_object("a", BOX)
    assert types(list(scene.messages())) == [("set_object", "/a")]


def test_deleting_a_path_keeps_its_namesakes() -> None:
    scene = Scene()
    for path in ("arm", "arm2", "arm/hand"):
        scene.set_transform(path, np.eye(4))
    scene.delete("arm")
    assert scene.paths() == ("arm2",)


def test_a_batch_is_one_message_and_nests() -> None:
    scene, heard = Scene(), []
    scene.listener = heard.append
    with scene.batch():
        scene.set_transform("a", np.eye(4))
        with scene.batch():
            scene.set_transform("b", np.eye(4))
        assert not heard
    scene.set_transform("c", np.eye(4))
    assert [types(batch) for batch in heard] == [
        [("set_transform", "/a"), ("set_transform", "/b")],
        [("set_transform", "/c")],
    ]


@pytest.mark.parametrize("matrix", [np.full((4, 4), np.nan), np.eye(3), np.diag([1, 1, 1, np.inf])])
def test_a_placement_that_cannot_be_drawn_is_refused(matrix: Any) -> None:
    scene = Scene()
    with pytest.raises(InputError, match="finite"):
        scene.set_transform("a", matrix)
    assert scene.paths() == ()


def test_a_property_that_meshcat_would_misname_is_refused() -> None:
    with pytest.raises(InputError, match="lower"):
        Scene().set_property("a", "renderOrder", 1)
