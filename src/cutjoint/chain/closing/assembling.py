"""Closing from any configuration: damped least squares (Levenberg-Marquardt), then Newton; no branch is promised."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain
from math import inf

import numpy as np

from cutjoint.arrays import Array
from cutjoint.chain.closing.drivers import Driver
from cutjoint.chain.closing.equations import System
from cutjoint.chain.closing.newton import settle
from cutjoint.chain.kinematics import Kinematics, Placed
from cutjoint.errors import ClosureError

ROUNDED = 1e-6
"""Sum of squared errors below which the loops of a robot are as good as closed where some rows cannot be."""
RESTARTS = 8
"""Starts around a configuration that are tried where none is found from itself."""


def assemble(kinematics: Kinematics, q: Array, driver: Driver | None) -> Placed | None:
    """A closed configuration from any start `q`, shape (nq,), or None; damped least squares, then Newton."""
    near, cost = nearest(kinematics.whole, q, driver)
    return settle(kinematics, near, driver, inf) if cost < (ROUNDED if kinematics.closure.left_out else 1e-12) else None


def assembled(kinematics: Kinematics, q: Array, driver: Driver | None) -> Placed:
    """A closed configuration from `q`, shape (nq,), or from around it at growing distance: a straight limb pulled along
    itself does not know which way to bend.

    Raises:
        ClosureError: none was found.
    """
    for start in chain([q], around(kinematics, q, np.geomspace(0.05, 1.5, RESTARTS))):
        found = assemble(kinematics, start, driver)
        if found is not None:
            return found
    distance, angle, cut = kinematics.at(nearest(kinematics.whole, q, driver)[0]).gap
    raise ClosureError(
        f"{kinematics.name}: no closed posture found from this configuration or around it; it comes to rest with "
        f"gaps of up to {distance:.3g} m and {angle:.3g} rad, the worst at "
        f"{kinematics.closure.told(cut)}. Give a start nearer to a closed posture, or mend that one",
        gap=(distance, angle),
        cut=cut,
    )


def around(kinematics: Kinematics, q: Array, reaches: Array) -> Iterator[Array]:
    """Configurations around `q`, shape (nq,), at most as far as each of `reaches`; always the same ones."""
    k, random = kinematics, np.random.default_rng(0)
    return (k.after(q, random.uniform(-reach, reach, k.model.nv)) for reach in reaches.tolist())


def nearest(kinematics: Kinematics, q: Array, driver: Driver | None, iterations: int = 100) -> tuple[Array, float]:
    """Where damped least squares comes to rest from `q`, shape (nq,), and the sum of squared scaled errors."""
    k, damping = kinematics, 1e-3
    system = System(k, driver)
    here = system.at(k.at(q))
    cost = float(here.error @ here.error)
    for _ in range(iterations):
        if cost < 1e-12:
            break
        matrix = here.matrix
        normal, gradient = matrix.T @ matrix, matrix.T @ here.error
        while damping < 1e8:
            motion = -np.linalg.solve(normal + damping * np.eye(len(normal)), gradient)
            motion *= min(1.0, 1.0 / float(np.abs(motion).max(initial=1e-12)))
            trial = k.after(q, motion)
            there = system.at(k.at(trial))
            trial_cost = float(there.error @ there.error)
            if trial_cost < cost:
                break
            damping *= 4.0
        else:
            break
        if trial_cost > cost * (1.0 - 1e-4) and damping < 1e-3:
            break
        q, here, cost = trial, there, trial_cost
        damping = max(damping * 0.2, 1e-12)
    return q, cost
