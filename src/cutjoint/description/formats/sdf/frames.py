"""Where everything in an SDF stands at zero, and which link every frame moves with."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

import numpy as np

from cutjoint.arrays import Array, readonly
from cutjoint.description.formats.sdf.scope import KINDS, MODEL, Item, Scope
from cutjoint.description.formats.sdf.values import WORLD, pose_of
from cutjoint.description.model import IDENTITY
from cutjoint.description.transforms import inverse
from cutjoint.description.xml import Element, only_child

Work = Callable[[], Array]
_OWN = ("", MODEL)


class Frames:
    """The placements (4, 4) in the world of all that has a name, each worked out once.

    `fixed` gives the placement of some scopes, in whose own frame things are then placed.
    """

    def __init__(self, fixed: Mapping[Item | Scope, Array] | None = None) -> None:
        self._fixed = bool(fixed)
        self._known: dict[Item | Scope, Array] = {}
        self._known.update(fixed or {})
        self._open: set[Item | Scope] = set()

    def put(self, item: Item, at: Array) -> None:
        """Give the placement of something that does not tell it itself."""
        self._known[item] = at

    def named(self, scope: Scope, name: str, what: str, line: int | None) -> Array:
        """The placement of whatever is called `name` in a scope; `what` names its use where there is no such thing."""
        if name in _OWN:
            return self.origin(scope)
        if name == WORLD:
            if self._fixed:
                scope.findings.error(f"{what} '{name}' below a placement_frame", "a frame of the model", "", line)
            return IDENTITY
        item = scope.look(name, KINDS, what, line)
        return IDENTITY if item is None else self.of(item)

    def origin(self, scope: Scope) -> Array:
        """The placement of a model's own frame."""
        if scope.above is None:
            return self._known.get(scope, IDENTITY)
        return self._once(scope, lambda: self._placed(scope, scope.above or scope))

    def of(self, item: Item) -> Array:
        """The placement of a link, joint, frame or model."""
        if item.model is not None:
            return self.origin(item.model)
        return self._once(item, lambda: self._stands(item))

    def _once(self, key: Item | Scope, work: Work) -> Array:
        if key in self._known:
            return self._known[key]
        if key in self._open:
            scope = key.scope if isinstance(key, Item) else key
            line = scope.element.sourceline if isinstance(key, Scope) else key.line
            found = f"the pose of '{key.name}' is relative to itself"
            scope.findings.error(found, "poses without a ring", "", line)
            return IDENTITY
        self._open.add(key)
        self._known[key] = work()
        self._open.discard(key)
        return self._known[key]

    def _stands(self, item: Item) -> Array:
        pose = only_child(item.element, "pose", item.scope.findings)
        what = f"{item.kind} '{item.name}'"
        relative = _relative(pose)
        base = relative
        if not relative and item.kind == "joint":
            base = item.child or WORLD
        elif not relative and item.kind == "frame":
            base = str(item.element.get("attached_to") or "").strip()
        own = IDENTITY if pose is None else pose_of(pose, what, item.scope.findings)
        # a joint's wrong child is told where its ends are read
        unknown = item.kind == "joint" and not relative and base != WORLD and item.scope.find(base) is None
        above = IDENTITY if unknown else self.named(item.scope, base, "unknown frame", item.line)
        return _times(above, own)

    def _placed(self, scope: Scope, above: Scope) -> Array:
        pose = scope.pose
        found = above.findings
        line = scope.element.sourceline if pose is None else pose.sourceline
        base = self.named(above, _relative(pose), "unknown frame", line)
        own = IDENTITY if pose is None else pose_of(pose, f"model '{scope.name}'", found)
        if scope.placement_frame in _OWN:
            return _times(base, own)
        inside = Frames({scope: IDENTITY}).named(scope, scope.placement_frame, "unknown placement_frame", line)
        return readonly(base @ own @ inverse(inside))


class Carriers:
    """Which link each frame moves with."""

    def __init__(self) -> None:
        self._open: set[Item] = set()

    def named(self, scope: Scope, name: str, what: str, line: int | None) -> str | None:
        """The full name of the link that a frame of a scope moves with, `world`, or None after noting why not."""
        if name == WORLD:
            return WORLD
        if name in _OWN:
            return self._own(scope, what, line)
        item = scope.look(name, KINDS, what, line)
        if item is None or item.kind == "link":
            return None if item is None else item.full
        if item in self._open:
            found = f"{item.kind} '{item.name}' is attached to itself"
            item.scope.findings.error(found, "a link at the end", "", item.line)
            return None
        self._open.add(item)
        try:
            return self._of(item, what, line)
        finally:
            self._open.discard(item)

    def _of(self, item: Item, what: str, line: int | None) -> str | None:
        if item.model is not None:
            return self._own(item.model, what, line)
        to = item.child if item.kind == "joint" else str(item.element.get("attached_to") or "").strip()
        return self.named(item.scope, to, f"{item.kind} '{item.name}' on the unknown frame", item.line)

    def _own(self, scope: Scope, what: str, line: int | None) -> str | None:
        """The canonical link of a model; the world of a world."""
        if not scope.is_model:
            return WORLD
        named = str(scope.element.get("canonical_link") or "").strip()
        if named:
            item = scope.look(named, ("link",), "unknown canonical_link", scope.element.sourceline)
            return None if item is None else WORLD if scope.static else item.full
        if scope.static:
            return WORLD
        first = scope.first_link()
        item = None if first is None else scope.find(first, ("link",))
        if item is None:
            scope.findings.error(f"{what} is a model without links", "at least one <link>", "", line)
            return None
        return item.full


def check_frames(scopes: Iterable[Scope], frames: Frames, carriers: Carriers) -> None:
    """Note what is wrong with frames, and with canonical links, whether or not something uses them."""
    for scope in scopes:
        for item in scope.items:
            if item.kind == "frame":
                frames.of(item)
                carriers.named(scope, item.name, "unknown frame", item.line)
        if str(scope.element.get("canonical_link") or "").strip():
            carriers.named(scope, MODEL, "unknown frame", scope.element.sourceline)


def _relative(pose: Element | None) -> str:
    return "" if pose is None else str(pose.get("relative_to") or pose.get("frame") or "").strip()


def _times(above: Array, own: Array) -> Array:
    """The product; the very same array where `own` is no motion."""
    return above if np.array_equal(own, IDENTITY) else readonly(above @ own)
