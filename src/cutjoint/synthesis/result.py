"""What a synthesis comes to: the designs, those that none of the others beats, and the one that is taken."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cutjoint.arrays import Array, Frozen
from cutjoint.chain import ClosedChain
from cutjoint.description import RobotDescription
from cutjoint.errors import InputError
from cutjoint.reprs import line
from cutjoint.synthesis.judging import Design, DesignProblem, closed
from cutjoint.synthesis.variables import chosen
from cutjoint.tables import TextTable


@dataclass(frozen=True, eq=False)
class Synthesis(Frozen):
    """Designs of a robot.

    Attributes:
        problem: what was chosen, and what was wanted.
        designs: all that were judged; the first is the robot as it is.
        told: what was odd, in sentences.
    """

    problem: DesignProblem
    designs: tuple[Design, ...]
    told: tuple[str, ...] = ()

    __repr__ = line("problem", "designs")

    @property
    def old(self) -> Design:
        """The robot as it is."""
        return self.designs[0]

    @cached_property
    def front(self) -> tuple[int, ...]:
        """Designs that do and that no other one beats in every goal, by number; sorted by the first goal."""
        doing = [k for k, one in enumerate(self.designs) if not one.why]
        if not doing or not self.problem.goals:
            return tuple(doing)
        costs = self._costs(doing)
        kept = [k for k, own in zip(doing, costs, strict=True) if not _beaten(own, costs)]
        return tuple(sorted(kept, key=lambda k: float(costs[doing.index(k)][0])))

    @cached_property
    def best(self) -> int:
        """The design of the front that is nearest to the best of every goal, by number.  Goals are measured in parts
        of what they span on the front.

        Raises:
            InputError: no design does.
        """
        if not self.front:
            reasons = "; ".join(f"{count} times: {why}" for why, count in self.reasons()[:3])
            raise InputError(f"none of {len(self.designs)} designs does what is wanted. {reasons}")
        if not self.problem.goals:
            return self.front[0]
        costs = self._costs(self.front)
        span = np.ptp(costs, axis=0)
        span[span == 0.0] = 1.0
        return self.front[int(np.argmin(np.linalg.norm((costs - costs.min(axis=0)) / span, axis=1)))]

    def reasons(self) -> list[tuple[str, int]]:
        """Why designs do not do, in short, and how many; the most frequent first."""
        counts: dict[str, int] = {}
        for one in self.designs:
            if one.why:
                short = (
                    one.why.partition(":")[0] if "Error:" in one.why else one.why.partition(" ")[0] + " out of bounds"
                )
                counts[short] = counts.get(short, 0) + 1
        return sorted(counts.items(), key=lambda pair: -pair[1])

    def _costs(self, numbers: Sequence[int]) -> Array:
        signs = [-1.0 if one.goal == "most" else 1.0 for one in self.problem.goals]
        names = [one.name for one in self.problem.goals]
        return np.array([[s * self.designs[k].found[n] for s, n in zip(signs, names, strict=True)] for k in numbers])

    def robot(self, number: int | None = None) -> ClosedChain:
        """A design as a robot; default the best one.

        Raises:
            InputError: there is no such design, or none does.
            ClosureError: it does not close.
        """
        return closed(self.problem, self._design(number).values)

    def description(self, number: int | None = None) -> RobotDescription:
        """A design as a description; default the best one; errors as of `robot`."""
        return chosen(self.problem.robot, self.problem.variables, self._design(number).values)

    def _design(self, number: int | None) -> Design:
        number = self.best if number is None else number
        if not 0 <= number < len(self.designs):
            raise InputError(f"there are designs 0 to {len(self.designs) - 1}, found {number}")
        return self.designs[number]

    def against_old(self, number: int | None = None) -> TextTable:
        """Old against new: variables and quantities."""
        new, old = self._design(number), self.old
        rows = [
            (one.name, f"{a:.6g}", f"{b:.6g}", one.unit or "ratio", "")
            for one, a, b in zip(self.problem.variables, old.values, new.values, strict=True)
        ]
        for want in self.problem.wants:
            before, after = old.found.get(want.name), new.found.get(want.name)
            change = f"{100.0 * (after / before - 1.0):+.1f} %" if before and after is not None else ""
            rows.append((want.name, _number(before), _number(after), self.units[want.name], change))
        return TextTable(
            f"{self.problem.robot.name}: as it is, and design {self.best if number is None else number}",
            ("", "as it is", "new", "unit", "change"),
            rows,
            right=("as it is", "new", "change"),
        )

    def as_json(self, taken: int | None) -> dict[str, object]:
        """All of it as plain values; `taken` is the number of the design that is taken."""
        names = [one.name for one in self.problem.variables]
        return {
            "robot": self.problem.robot.name,
            "taken": taken,
            "front": list(self.front),
            "told": list(self.told),
            "units": {**{one.name: one.unit or "1" for one in self.problem.variables}, **self.units},
            "designs": [
                {"values": dict(zip(names, one.values.tolist(), strict=True)), "found": dict(one.found), "why": one.why}
                for one in self.designs
            ],
        }

    @cached_property
    def units(self) -> dict[str, str]:
        """Want by name -> SI unit."""
        chain = ClosedChain(self.problem.robot, self.problem.home)
        axes = sum(name in chain.task.names for name in "xyz")
        return {one.name: one.unit(chain, axes) for one in self.problem.wants}

    def front_table(self) -> TextTable:
        """The designs that none beats, a row each."""
        goals = [*self.problem.goals, *(one for one in self.problem.wants if one.goal is None)]
        heads = [f"{one.name}{self.units[one.name] and f' [{self.units[one.name]}]'}" for one in goals]
        names = [one.name for one in self.problem.variables]
        rows = [
            (
                f"{k}{' *' if k == self.best else ''}",
                *(f"{self.designs[k].found[one.name]:.4g}" for one in goals),
                *(f"{x:.4g}" for x in self.designs[k].values),
            )
            for k in self.front
        ]
        return TextTable("Designs that none beats (* taken)", ("design", *heads, *names), rows, right=(*heads, *names))


def _beaten(own: Array, costs: Array) -> bool:
    """Whether another design is at least as good in every goal, and better in one."""
    return bool(((costs <= own).all(axis=1) & (costs < own).any(axis=1)).any())


def _number(value: float | None) -> str:
    return "none" if value is None else f"{value:.6g}"
