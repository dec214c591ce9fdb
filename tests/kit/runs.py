"""Results made of numbers that belong to no robot."""

from __future__ import annotations

import numpy as np

from cutjoint.simulation.result import Result, result_of


def made(
    m: int = 60, n: int = 3, kinds: str = "rt", about: dict[str, object] | None = None, **columns: object
) -> Result:
    """A result of m samples of n actuators, made of numbers that belong to no robot."""
    t = np.linspace(0.0, 2.0, m) if m > 1 else np.zeros(1)
    waves = np.array([np.sin((i + 1) * t) for i in range(n)]).reshape(n, m).T
    three = np.column_stack([np.cos(t), np.sin(t), 0.1 * t])
    zero = np.zeros(m)
    of_kind = {"r": "rotation", "t": "translation"}
    named = [[f"motor{i + 1}", of_kind[kinds[i % len(kinds)]]] for i in range(n)]
    own = {
        "time": t,
        "q": waves,
        "v": waves,
        "effort": 10.0 * waves,
        "q_full": np.zeros((m, 0)),
        "tool": three,
        "tool_velocity": three,
        "gap": np.zeros((m, 2)),
        **dict.fromkeys(("kinetic", "potential", "work"), zero),
    }
    return result_of(own | columns, {"robot": "made", "actuators": named} | (about or {}))
