"""Which values what varies has in which run: from the seed and the number of the run alone, so that any block of runs
can be drawn by anybody, in any order, in little memory.

Random numbers are Philox's (J. K. Salmon et al.: Parallel random numbers: as easy as 1, 2, 3. SC 2011), whose state is
a counter: that of a run is its number.  The strata of a Latin hypercube (M. D. McKay, R. J. Beckman, W. J. Conover.
Technometrics 21 (1979) 239-245) are shuffled by a permutation that is computed entry by entry: a Feistel network on the
bits of the number, walked until it lands within (J. Black, P. Rogaway: Ciphers with arbitrary finite domains.
CT-RSA 2002).  Sobol points are scipy's, scrambled (A. B. Owen, 1998).  The rows of "saltelli" are those of A. Saltelli
et al., Computer Physics Communications 181 (2010) 259-270, in the order of SALib: of two points A and B a run of A, one
a path of A with that entry of B, and a run of B.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array
from cutjoint.studies.spreads import Spread

ROUNDS = 6
"""Of the Feistel network."""
WORDS = 4
"""Numbers that Philox has for every count."""
Unsigned = npt.NDArray[np.uint64]


def drawn(method: str, spreads: Sequence[Spread], samples: int, seed: int, begin: int, end: int) -> Array:
    """The values of the runs from `begin` to before `end` of `samples`, shape (end - begin, paths)."""
    if not spreads:
        return np.zeros((end - begin, 0))
    if method == "grid":
        return _grid(spreads, begin, end)
    parts = UNIT[method](len(spreads), samples, seed, begin, end)
    return np.stack([spread.at(parts[:, k]) for k, spread in enumerate(spreads)], axis=1)


def random_parts(paths: int, samples: int, seed: int, begin: int, end: int) -> Array:
    """Independent numbers from 0 to below 1."""
    counts = -(-paths // WORDS)
    source = np.random.Generator(np.random.Philox(key=seed, counter=begin * counts))
    return source.random((end - begin, counts * WORDS))[:, :paths]


def hypercube_parts(paths: int, samples: int, seed: int, begin: int, end: int) -> Array:
    """Of `samples` strata of every path each run has another one, and lies anywhere in it."""
    within = random_parts(paths, samples, seed, begin, end)
    runs = np.arange(begin, end, dtype=np.uint64)
    strata = np.stack([shuffled(runs, samples, seed, k) for k in range(paths)], axis=1)
    return np.minimum((strata + within) / samples, np.nextafter(1.0, 0.0))


def sobol_parts(paths: int, samples: int, seed: int, begin: int, end: int) -> Array:
    """Points of one scrambled Sobol sequence."""
    from scipy.stats import qmc

    sequence = qmc.Sobol(paths, scramble=True, seed=seed)
    if begin:
        sequence.fast_forward(begin)
    count = end - begin
    # from the first point on scipy warns where it is asked for another number than a power of two
    asked = count if begin else 1 << max(0, count - 1).bit_length()
    return np.asarray(sequence.random(asked))[:count]


def saltelli_parts(paths: int, samples: int, seed: int, begin: int, end: int) -> Array:
    """Groups of paths + 2 rows, see above."""
    width = paths + 2
    first, last = begin // width, -(-end // width)
    points = sobol_parts(2 * paths, samples // width, seed, first, last)
    groups = np.repeat(points[:, None, :paths], width, axis=1)
    for k in range(paths):
        groups[:, k + 1, k] = points[:, paths + k]
    groups[:, paths + 1] = points[:, paths:]
    return groups.reshape(-1, paths)[begin - first * width : end - first * width]


UNIT: Mapping[str, Callable[[int, int, int, int, int], Array]] = {
    "random": random_parts,
    "latin-hypercube": hypercube_parts,
    "sobol": sobol_parts,
    "saltelli": saltelli_parts,
}
"""Method -> numbers from 0 to below 1 for (paths, samples, seed, begin, end), shape (end - begin, paths)."""


def shuffled(numbers: Unsigned, count: int, seed: int, stream: int) -> Unsigned:
    """Where a permutation of 0 to before `count` takes the numbers; another one for every seed and stream."""
    half = np.uint64(max(1, -(-max(count - 1, 1).bit_length() // 2)))
    mask = (np.uint64(1) << half) - np.uint64(1)
    keys = np.random.Generator(np.random.Philox(key=[seed, 1 + stream])).integers(0, 2**64, ROUNDS, dtype=np.uint64)
    found = numbers.copy()
    out = np.ones(len(found), dtype=bool)
    while out.any():  # a step of a permutation of more numbers, until it comes back among the first `count`
        left, right = found[out] >> half, found[out] & mask
        for key in keys:
            left, right = right, left ^ (_mixed(right ^ key) & mask)
        found[out] = (left << half) | right
        out = found >= count
    return found


def _mixed(x: Unsigned) -> Unsigned:
    """Bits that depend on all bits: the finaliser of SplitMix64 (G. L. Steele, D. Lea, C. H. Flood, OOPSLA 2014)."""
    x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return x ^ (x >> np.uint64(31))


def _grid(spreads: Sequence[Spread], begin: int, end: int) -> Array:
    """Every combination; the last path changes from run to run."""
    rest = np.arange(begin, end)
    columns = []
    for spread in reversed(spreads):
        rest, index = np.divmod(rest, spread.count)
        columns.append(spread.on_grid(index))
    return np.stack(columns[::-1], axis=1)
