"""Public methods of every kind of robot with arguments that are none: no error but cutjoint's own, and no hang."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from functools import cache, partial
from pathlib import Path

import numpy as np
import numpy.typing as npt

from attacks.judging import Attack, Wrong
from cutjoint.errors import CutjointError
from cutjoint.mechanism import Posture
from cutjoint.robots import load, published

ROBOTS = ("fourbar", "cpm", "stewart", "underactuated", "redundant")
KINDS = ("chain", "minimal", "compiled", "published")
SKIPPED = {
    *("compile", "rebuilt", "kernel", "batch", "working_modes", "assembly_modes", "minimal", "full_load_effort"),
    *("arrays", "columns", "coefficients", "state_at", "forward_derivatives", "inverse_derivatives"),
    *("gamma_dot", "on_branch", "angle_rates", "inverse_kinematics"),
}
"""What makes another robot, looks or compiles for long, or takes values of classes of its own; `with_` methods too."""
Random = np.random.Generator


def attacks(seed: int, count: int, folder: Path) -> Iterator[Attack]:
    """`count` calls."""
    for number in range(count):
        yield Attack(f"methods {seed}:{number}", partial(_act, seed, number))


def _act(seed: int, number: int) -> str:
    rng = np.random.default_rng([seed, number])
    kind = KINDS[number % len(KINDS)]
    name = ROBOTS[number // len(KINDS) % len(ROBOTS)]
    robot = _robot(name, kind)
    if robot is None:
        return "no such model"
    names = _methods(robot)
    method = names[int(rng.integers(len(names)))]
    call = getattr(robot, method)
    given = [_argument(rng, one.name, robot) for one in inspect.signature(call).parameters.values() if _wanted(one)]
    shown = f"{name} ({kind}).{method}({', '.join(_short(one) for one in given)})"
    try:
        found = call(*given)
    except CutjointError:
        return "refused"
    except Exception as error:
        raise Wrong(f"{shown}: {type(error).__name__}: {str(error)[:300]}") from error
    if isinstance(found, np.ndarray) and found.dtype.kind == "f" and not np.isfinite(found).all():
        raise Wrong(f"{shown} gives numbers that are not finite: {found.tolist()}")
    return "done"


@cache
def _robot(name: str, kind: str) -> object | None:
    chain = load(name)
    try:
        if kind == "published":
            return published(name)
        return chain if kind == "chain" else chain.minimal() if kind == "minimal" else chain.compile()
    except CutjointError:
        return None


def _methods(robot: object) -> list[str]:
    kind = type(robot)
    return [
        name
        for name in dir(kind)
        if not name.startswith(("_", "with_")) and name not in SKIPPED and inspect.isfunction(getattr(kind, name))
    ]


def _wanted(parameter: inspect.Parameter) -> bool:
    return parameter.kind in (parameter.POSITIONAL_ONLY, parameter.POSITIONAL_OR_KEYWORD) and (
        parameter.default is parameter.empty
    )


def _argument(rng: Random, name: str, robot: object) -> object:
    """Mostly an array of about the right size, with numbers that may be anything."""
    home = getattr(getattr(robot, "chain", robot), "home", None)
    if name in ("at", "near", "to", "posture") and isinstance(home, Posture):
        return home if rng.integers(5) else load(ROBOTS[int(rng.integers(len(ROBOTS)))]).home
    sizes = [getattr(robot, one) for one in ("n", "nv", "nq") if isinstance(getattr(robot, one, None), int)]
    size = int(rng.choice([*sizes, *sizes, *sizes, 0, 1, 3, 6, 7, 12, 1000]))
    array: npt.NDArray[np.float64] = rng.standard_normal(size)
    what = int(rng.integers(14))
    if what < 5 and size:
        array[int(rng.integers(size))] = rng.choice([np.nan, np.inf, 1e308, -1e308, 1e200, 1e-320])
    others: dict[int, object] = {
        5: array[:, None],
        6: array.tolist(),
        7: array.astype(complex),
        8: array.astype(str),
        9: np.clip(array, -1e9, 1e9).astype(np.float32),
        10: None,
        11: 1e308,
        12: [10**400] * size,
        13: np.zeros((4, 4)),
    }
    return others.get(what, array)


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) < 150 else f"{text[:150]}..."
