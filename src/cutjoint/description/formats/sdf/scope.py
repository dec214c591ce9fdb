"""What the names in an SDF mean: a scope for each `<world>` and `<model>`, with the links, joints, ... in it.

A model that is included with merge="true" keeps its own frame, but its names are those of the model around it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Self

from cutjoint.description.formats.sdf.values import WORLD, Version, text_of
from cutjoint.description.xml import Element, only_child
from cutjoint.findings import Findings, nearest

MODEL = "__model__"
"""What a model calls its own frame."""
KINDS = ("link", "joint", "frame", "model")
RESERVED: Version = (1, 7)
"""From here on joints are frames too, and none may be called as what SDF keeps for itself."""
APART = "::"
"""Between the name of a model and a name in it."""


@dataclass(eq=False)
class Scope:
    """A `<world>`, an `<sdf>` with a model, or a `<model>`.

    Attributes:
        element: of that name.
        name: of the model in the scope above, empty for the outermost.
        file, version, findings: where it was read, that file's version, and problems in that file.
        above: the scope around it.
        static: whether it, or a model around it, does not move.
        merged: whether its names are those of the scope above.
        pose: the `<pose>` element that places it: its own, or that of its `<include>`.
        placement_frame: the frame in it which the pose places; empty for its own.
        prefix: of the full names of what is in it, set where a robot is made of several models.
    """

    element: Element
    name: str
    file: Path
    version: Version
    findings: Findings
    above: Self | None = None
    static: bool = False
    merged: bool = False
    pose: Element | None = None
    placement_frame: str = ""
    prefix: str = ""
    items: list[Item] = field(default_factory=list)
    """Everything that stands in it, in the order of the file."""
    names: dict[tuple[str, str], Item] = field(default_factory=dict)
    """(kind, name) -> what it means here, merged models included."""

    @property
    def host(self) -> Scope:
        """The scope whose names it shares: itself unless it was merged."""
        return self.above.host if self.merged and self.above is not None else self

    @property
    def is_model(self) -> bool:
        """Whether it is a model, else the world."""
        return self.above is not None

    def add(self, item: Item) -> None:
        """Take in what stands here, under its name in this scope and those that it is merged into."""
        self.items.append(item)
        host, key = self.host, (item.kind, item.name)
        old = item.kind == "joint" and self.version < RESERVED  # no frame of that name yet
        if not old and (item.name == WORLD or (item.name.startswith("__") and item.name.endswith("__"))):
            found = f"{item.kind} '{item.name}'"
            self.findings.error(found, "another name: SDF keeps this one for itself", "", item.line)
        if key in host.names:
            found = f"a second {item.kind} '{item.name}' in one <{host.element.tag}>"
            self.findings.error(found, "a name of its own for each", "rename one", item.line)
        else:
            host.names[key] = item

    def find(self, name: str, kinds: tuple[str, ...] = KINDS) -> Item | None:
        """What `name` (also `model::name`, to any depth) means here, or None."""
        host = self.host
        for kind in kinds:
            if (kind, name) in host.names:
                return host.names[kind, name]
        first, _, rest = name.partition(APART)
        inside = host.names.get(("model", first))
        if inside is None or inside.model is None or not rest:
            return None
        return inside if rest == MODEL else inside.model.find(rest, kinds)

    def look(self, name: str, kinds: tuple[str, ...], what: str, line: int | None) -> Item | None:
        """The same, with an error that `what` is unknown and the nearest known name."""
        item = self.find(name, kinds)
        if item is None:
            known = [one for kind, one in self.host.names if kind in kinds] + list(self._deeper(kinds))
            expected = f"a {', '.join(kinds[:-1])} or {kinds[-1]}" if len(kinds) > 1 else f"a {kinds[0]}"
            self.findings.error(f"{what} '{name}'", expected, nearest(name, known), line)
        return item

    def _deeper(self, kinds: tuple[str, ...]) -> Iterator[str]:
        for (kind, name), item in self.host.names.items():
            if kind == "model" and item.model is not None:
                yield from (f"{name}{APART}{one}" for of, one in item.model.names if of in kinds)

    def full(self, name: str) -> str:
        """The name that a link or joint of this scope has in the whole robot."""
        host = self.host
        prefix = host.prefix or (host.above.full(host.name) if host.above is not None and host.above.is_model else "")
        return f"{prefix}{APART}{name}" if prefix else name

    def each(self, kind: str) -> Iterator[Item]:
        """All links, joints, ... in it and in the models in it."""
        yield from (item for item in self.items if item.kind == kind)
        for item in self.items:
            if item.model is not None:
                yield from item.model.each(kind)

    def models(self) -> Iterator[Scope]:
        """It and the models in it."""
        yield self
        for item in self.items:
            if item.model is not None:
                yield from item.model.models()

    def first_link(self) -> str | None:
        """The name of the canonical link where the file names none: the first link, or that of the first model."""
        for item in self.items:
            merged = item.model is not None and item.model.merged
            own = item.name if item.kind == "link" else item.model.first_link() if merged and item.model else None
            if own is not None:
                return own
        for item in self.items:
            inside = None if item.model is None else item.model.first_link()
            if inside is not None:
                return f"{item.name}{APART}{inside}"
        return None


@dataclass(frozen=True, eq=False)
class Item:
    """A link, joint, frame or model.

    `scope` is where it stands, and whose frame it is placed in unless it says otherwise; `model` the scope in a model.
    """

    kind: str
    name: str
    element: Element
    scope: Scope
    model: Scope | None = None

    @property
    def line(self) -> int | None:
        """In its file."""
        line: int | None = self.element.sourceline
        return line

    @property
    def full(self) -> str:
        """Its name in the whole robot."""
        return self.scope.full(self.name)

    @property
    def child(self) -> str:
        """The frame that a joint names as its child."""
        return text_of(only_child(self.element, "child", Findings()))
