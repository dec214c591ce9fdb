"""Which of the internal stresses of loops is there: the least one, or the one that stated stiffnesses give.

What joints hold is H0 + H1 z with a column of H1 for each stress.  The least one has the least sum of squares, forces
times the characteristic length against moments, so z = -H1^+ H0.  Stated stiffnesses make the elastic energy the sum,
half of each component squared times its compliance, that is the least at the true z (Castigliano 1879, Menabrea 1858);
stresses that no compliant joint feels are the least ones after that.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cutjoint.arrays import Array
from cutjoint.chain.rank import Split


@dataclass(frozen=True, eq=False)
class HeldWrench:
    """What a joint, cut or coupling holds.

    Attributes:
        name: of it.
        values: without stresses, then what each of them adds, along its own axes, shape (c, 1 + k).
        weights: what makes the components comparable, shape (c,): the length of forces, 1 of moments.
    """

    name: str
    values: Array
    weights: Array


def chosen(held: Sequence[HeldWrench], compliances: Mapping[str, Array], loose: int) -> tuple[Array, Array]:
    """Part of each column, shape (1 + k,), and a basis of what is undecided, shape (1 + k, u).

    The last `loose` stresses are balanced up to the rounding of lengths alone; they get no part, and stay undecided.
    """
    columns = held[0].values.shape[1] if held else 1
    count = columns - loose
    start, open_ones = np.zeros(count), np.eye(count)[:, 1:]
    start[0] = 1.0
    soft = [one for one in held if compliances.get(one.name, np.zeros(1)).any()]
    if open_ones.shape[1] and soft:
        softness = [np.sqrt(compliances[one.name]) / one.weights for one in soft]
        softest = max(float(one.max()) for one in softness)
        elastic = [each[:, None] / softest * _even(one) for each, one in zip(softness, soft, strict=True)]
        start, open_ones = _least(np.concatenate(elastic)[:, :count], start, open_ones)
    undecided = open_ones
    if open_ones.shape[1]:
        start, _ = _least(
            np.concatenate([one.weights[:, None] * one.values[:, :count] for one in held]), start, open_ones
        )
    part, left = np.zeros(columns), np.zeros((columns, undecided.shape[1] + loose))
    part[:count], left[:count, : undecided.shape[1]] = start, undecided
    left[count:, undecided.shape[1] :] = np.eye(loose)
    return part, left


def _least(matrix: Array, start: Array, ways: Array) -> tuple[Array, Array]:
    """Start changed along `ways` such that matrix @ start is least, and the ways that do not change that."""
    split = Split.of(matrix @ ways)
    return start - ways @ split.solve(matrix @ start), ways @ split.null


def _even(one: HeldWrench) -> Array:
    """Components that are comparable, shape (c, 1 + k)."""
    return one.weights[:, None] * one.values
