"""What joints carry, as values: forces and moments at any point, along any axes, and what of them is unique."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from cutjoint import tolerances
from cutjoint.arrays import Array, Frozen, as_vector
from cutjoint.errors import InputError, UnknownNameError
from cutjoint.reprs import clipped, line, one_line, quoted
from cutjoint.tables import TextTable

COMPONENTS = ("fx", "fy", "fz", "mx", "my", "mz")
"""What the components of a reaction are called, forces [N] first, then moments [N m]."""


@dataclass(frozen=True, eq=False)
class Reaction(Frozen):
    """What a joint's parent exerts on its child, or body A of a cut on body B: all that passes there, the efforts of
    motors, springs, dampers and friction included.

    Attributes:
        name: of the joint or cut.
        force: shape (3,) [N].
        moment: about `point`, shape (3,) [N m].
        point: where they act, in the world, shape (3,) [m]; at first the origin of the child's frame, or of frame b.
        axes: along which they are given, as columns in the world, shape (3, 3); at first those of the world.
        own_axes: those of the child's frame, or of frame b, as columns in the world, shape (3, 3).
        stresses: what internal stresses that nothing decides do to force and moment, shape (6, k), dimensionless.
        length: what their moments are measured by against their forces [m].
    """

    name: str
    force: Array
    moment: Array
    point: Array
    axes: Array
    own_axes: Array
    stresses: Array
    length: float

    @property
    def wrench(self) -> Array:
        """Force and moment, shape (6,)."""
        return np.concatenate([self.force, self.moment])

    @property
    def unique(self) -> tuple[bool, ...]:
        """Of the six components, forces first, which are the only ones possible; the others are one choice of many."""
        sizes = np.abs(self.stresses).max(axis=1, initial=0.0)
        return tuple(bool(size < tolerances.STRESSED.value) for size in sizes)

    def at(self, point: npt.ArrayLike) -> Reaction:
        """The same about another point of the world, shape (3,) [m].

        Raises:
            InputError: not a point.
        """
        there = as_vector("point", point, 3, "m")
        arm = self.axes.T @ (self.point - there)
        length = max(self.length, float(np.linalg.norm(arm)))
        stresses = self.stresses.copy()
        stresses[3:] = (stresses[3:] * self.length + np.cross(arm, stresses[:3].T).T) / length
        moment = self.moment + np.cross(arm, self.force)
        return replace(self, moment=moment, point=there, stresses=stresses, length=length)

    def in_axes(self, axes: npt.ArrayLike) -> Reaction:
        """The same along other axes: columns in the world, shape (3, 3), such as `own_axes`.

        Raises:
            InputError: not a rotation.
        """
        wanted = np.asarray(axes, dtype=np.float64)
        if wanted.shape != (3, 3) or not np.abs(wanted.T @ wanted - np.eye(3)).max() < 1e-9:
            raise InputError(f"axes must be the columns of a rotation (3, 3) in the world, found {axes!r}")
        turn = wanted.T @ self.axes
        stresses = np.concatenate([turn @ self.stresses[:3], turn @ self.stresses[3:]])
        return replace(self, force=turn @ self.force, moment=turn @ self.moment, axes=wanted, stresses=stresses)

    def __repr__(self) -> str:
        sizes = [f"{value:.3g}{'' if alone else '?'}" for _, value, alone in self._components()]
        force, moment = f"force=({', '.join(sizes[:3])}) N", f"moment=({', '.join(sizes[3:])}) N m"
        return one_line("Reaction", [quoted(self.name, 20), force, moment])

    def _components(self) -> Iterator[tuple[str, float, bool]]:
        return zip(COMPONENTS, self.wrench.tolist(), self.unique, strict=True)


@dataclass(frozen=True)
class GearForce:
    """What a coupling does to its joint, [N] or [N m], and whether that is the only one possible."""

    force: float
    unique: bool

    __repr__ = line(force="N or N m")


@dataclass(frozen=True, eq=False, repr=False)
class Reactions(Frozen):
    """Reactions of a whole robot in one motion; `reactions["crank"]` is that of a joint or cut.

    Attributes:
        joints: reactions of all joints of the description, fixed ones too.
        cuts: of all cuts, bushings included.
        couplings: coupling -> force on its joint; its driver feels it times the ratio, the other way.
        redundancy: how many internal stresses the loops can hold in themselves: 0 where equilibrium tells everything.
        undecided: how many of them neither equilibrium nor stated stiffnesses decide; of those the least are taken.
        effort: of all joints, of the actuators as a rule, shape (nv,), [N] or [N m].
    """

    joints: Mapping[str, Reaction]
    cuts: Mapping[str, Reaction]
    couplings: Mapping[str, GearForce]
    redundancy: int
    undecided: int
    effort: Array

    def __getitem__(self, name: str) -> Reaction:
        """Of the joint or cut called `name`.

        Raises:
            UnknownNameError: there is none.
            InputError: a joint and a cut are called so.
        """
        found = [kind[name] for kind in (self.joints, self.cuts) if name in kind]
        if not found:
            raise UnknownNameError("joint or cut", str(name), [*self.joints, *self.cuts])
        if len(found) > 1:
            raise InputError(f"a joint and a cut are called '{name}'; ask .joints or .cuts")
        return found[0]

    def __iter__(self) -> Iterator[Reaction]:
        """All of joints, then of cuts."""
        yield from self.joints.values()
        yield from self.cuts.values()

    def __repr__(self) -> str:
        marked = [f"  {self.undecided} undecided: components with ? are the least of many"] if self.undecided else []
        head = f"reactions of {len(self.joints)} joints and {len(self.cuts)} cuts, {self.redundancy} times redundant"
        return "\n".join([head, *marked, *(f"  {one!r}" for one in self)])

    def _repr_html_(self) -> str:
        return self.table()._repr_html_()

    def table(self) -> TextTable:
        """Forces and moments, a row a joint or cut."""
        units = [f"{name} [{'N' if name.startswith('f') else 'N m'}]" for name in COMPONENTS]
        rows = [
            (clipped(one.name), *(f"{value:.6g}{'' if alone else '?'}" for _, value, alone in one._components()))
            for one in self
        ]
        note = "? one of many that are possible, the least" if self.undecided else ""
        title = f"reactions, {self.redundancy} times redundant"
        return TextTable(title, ("joint or cut", *units), rows, units, note)
