"""What a USD stage says, as plain values: made by `stage` in a child process, read by everything else here."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

Value = bool | int | float | str | tuple[float, ...]
"""An attribute; vectors and quaternions (w, x, y, z) as tuples."""


@dataclass(frozen=True)
class Prim:
    """A prim of the composed stage.

    Attributes:
        path: of it, such as /robot/arm.
        type: its type name, empty for none.
        typed: whether USD knows that type.
        apis: the schemas that are applied to it, known or not.
        defined: the names of the properties that its type and schemas define.
        authored: the names of the properties that the file gives.
        values: attribute -> value, defaults included; those that are no `Value` are left out.
        targets: relationship -> paths.
        world: placement (4, 4) in the world in units of the stage, column vectors, scale included; None for prims that
            stand nowhere.
        moving: names of attributes that change with time and say nothing besides.
        ops: operations that its order of transformations names and that do not exist.
        idle: transformations that it has and its order does not name.
        material: path of the physics material that is bound to it, or empty.
        strange: names of metadata that USD does not know.
        wrong: what its properties and metadata have as type or value that is none of those that are allowed: name, what
            is there, and the allowed ones (none where a type is unknown).
    """

    path: str
    type: str = ""
    typed: bool = True
    apis: tuple[str, ...] = ()
    defined: frozenset[str] = frozenset()
    authored: tuple[str, ...] = ()
    values: Mapping[str, Value] = field(default_factory=dict)
    targets: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    world: tuple[tuple[float, ...], ...] | None = None
    moving: tuple[str, ...] = ()
    ops: tuple[str, ...] = ()
    idle: tuple[str, ...] = ()
    material: str = ""
    strange: tuple[str, ...] = ()
    wrong: tuple[tuple[str, str, tuple[str, ...]], ...] = ()

    @property
    def name(self) -> str:
        """The last part of its path."""
        return self.path.rpartition("/")[2]

    def has(self, api: str) -> bool:
        """Whether a schema is applied to it, under whatever instance name."""
        return any(one == api or one.startswith(f"{api}:") for one in self.apis)

    def instances(self, api: str) -> tuple[str, ...]:
        """The instance names under which a schema is applied to it."""
        return tuple(one.partition(":")[2] for one in self.apis if one.startswith(f"{api}:"))

    def number(self, name: str, otherwise: float = 0.0) -> float:
        """An attribute as a number."""
        value = self.values.get(name, otherwise)
        return float(value) if isinstance(value, bool | int | float) else otherwise

    def flag(self, name: str, otherwise: bool) -> bool:
        """An attribute as a truth value."""
        return bool(self.values.get(name, otherwise))

    def word(self, name: str, otherwise: str = "") -> str:
        """An attribute as a word."""
        value = self.values.get(name, otherwise)
        return value if isinstance(value, str) else otherwise

    def vector(self, name: str, otherwise: tuple[float, ...] = ()) -> tuple[float, ...]:
        """An attribute as a vector."""
        value = self.values.get(name, otherwise)
        return value if isinstance(value, tuple) else otherwise


@dataclass(frozen=True)
class Facts:
    """A stage, or what is wrong with it.

    Attributes:
        errors: what keeps it from being composed; nothing else counts then.
        length, mass: metres and kilograms per unit of the stage.
        lengths: whether the file gives metersPerUnit.
        up: its axis that points up, Y or Z.
        name: of its default prim as the file gives it, whether there is such a prim or not; or empty.
        prims: in the order in which they are composed.
        strange: names of the stage's metadata that USD does not know.
        known: names of all types and schemas that USD knows.
    """

    errors: tuple[str, ...] = ()
    length: float = 1.0
    lengths: bool = True
    mass: float = 1.0
    up: str = "Z"
    name: str = ""
    prims: tuple[Prim, ...] = ()
    strange: tuple[str, ...] = ()
    known: frozenset[str] = frozenset()
