"""Compiled functions against the model they were made from, at a few states, before anybody uses them.

This is what makes a stored program trustworthy beyond its digest, and a fresh one beyond the tracer: a function that
does not reproduce the model is refused.  What is compared, in which units and how closely, stands in the function's row
(`cutjoint.compile.functions.table`).
"""

from __future__ import annotations

import threading
from collections.abc import Sequence

import numpy as np

from cutjoint.arrays import Array
from cutjoint.compile.equations.elimination import STRAIN_LIMIT
from cutjoint.compile.functions.chain_sample import ChainSample
from cutjoint.compile.functions.library import CompiledFunction
from cutjoint.compile.functions.sample import RobotSample, RobotUnits, nearest_turn
from cutjoint.compile.once import once
from cutjoint.compile.sources.chain import ChainSource
from cutjoint.compile.sources.interface import Need
from cutjoint.compile.sources.paper import PaperSource
from cutjoint.errors import CompileError, CutjointError, DynamicsError, SingularError
from cutjoint.mechanism import Mechanism, Posture

BESIDE = 0.02
"""How far from home the second state is, in the robot's units."""
WELL_POSED = 1e-3
"""Smallest singular value of the loops, against the largest, where they are compared."""


class Checker:
    """The check that `Library` asks for: says what is wrong with a function, or nothing.

    Args:
        source: what is traced.
        model: the same robot, not compiled, with the inertial parameters at `parameters`.
        parameters: values of those that are arguments.
    """

    def __init__(self, source: ChainSource | PaperSource, model: Mechanism, parameters: Array) -> None:
        self.source, self.model, self.parameters = source, model, parameters
        self._lock = threading.RLock()

    def __reduce__(self) -> tuple[object, ...]:
        return Checker, (self.source, self.model, self.parameters)

    @once
    def units(self) -> RobotUnits:
        """The robot's own units."""
        source = self.source
        if isinstance(source, PaperSource):
            length, gravity = source.model.length, source.model.parameters.g
        else:
            length, gravity = source.chain.length, float(np.linalg.norm(source.model.gravity.linear))
        return units_of_rates(tuple(one.kind == "rotation" for one in self.model.actuators), length, gravity)

    @once
    def postures(self) -> list[Posture]:
        """Home and a posture beside it, where one can be closed; where home is singular, two near it that are not."""
        source, home, unit = self.source, self.model.home, self.units.coordinate
        if isinstance(source, ChainSource) and not well_posed(source):
            return [source.chain.posture(q) for q in source.cloud[:2]]
        for sign in (1.0, -1.0):
            try:
                return [home, self.model.close(home.q + sign * BESIDE * unit * (1.0 + np.abs(home.q / unit)))]
            except CutjointError:
                continue
        return [home]

    @once
    def other(self) -> tuple[ChainSource, Posture, Array] | None:
        """The chain built anew at other values of its parameters, a posture of it, and the values."""
        source = self.source
        if not (isinstance(source, ChainSource) and source.parameters):
            return None
        for row in source.wide_cloud[::-1]:
            q, values = row[: source.positions], row[source.positions :]
            try:
                description = source.arguments.rebuilt(dict(zip(source.parameters, values.tolist(), strict=True)))
                built = ChainSource(source.chain.rebuilt(description), source.parameters)
                return built, built.chain.posture(q), np.asarray(values)
            except CutjointError:
                continue
        return None

    def __call__(self, function: CompiledFunction) -> str:
        chance, source = np.random.default_rng(len(function.row.name)), self.source
        samples: list[tuple[RobotSample, Array]] = []
        for at in self.postures:
            if isinstance(source, ChainSource):
                samples.append((ChainSample(source, self.units, at, chance), self.parameters))
            else:
                samples.append((RobotSample(self.model, self.units, at, chance), self.parameters))
        led = "goal" in function.row.arguments
        if self.other is not None and isinstance(source, ChainSource):
            built, at, values = self.other
            if not led or source.keeps_task(values):
                samples.append((ChainSample(built, self.units, at, chance, source), values))
            if Need.PARAMETERS in function.row.needs:
                samples = samples[-1:]
        return judged(function, samples)


def units_of_rates(turning: tuple[bool, ...], length: float, gravity: float) -> RobotUnits:
    """Units of a robot of a length [m] under gravity [m/s2], of which coordinates are angles or not."""
    rate = float(np.sqrt(gravity / length)) if gravity > 0.0 else 1.0
    return RobotUnits(np.where(turning, 1.0, length), turning, length, rate)


def judged(function: CompiledFunction, samples: Sequence[tuple[RobotSample, Array]]) -> str:
    """What is wrong with a function at states with their parameters, in words, or nothing.

    Raises:
        CompileError: the robot itself has no answer there.
    """
    for sample, parameters in samples:
        try:
            wrong = disagreement(function, sample, parameters)
        except DynamicsError as error:
            name = function.row.name
            raise CompileError(f"'{name}' of {sample.model.name} cannot be compiled: near home {error}") from error
        except (np.linalg.LinAlgError, SingularError):
            wrong = "the robot has a motion that moves no mass, or is singular near home"
        if wrong:
            return wrong
    return ""


def well_posed(source: ChainSource) -> bool:
    """Whether the loops of a chain are far from singular at home."""
    source.need_all_rows()
    if source.idle is None:
        return False
    dependent = np.delete(source.scaled_jacobian(source.chain.home.q_full), list(source.actuated_rates), axis=1)
    values = np.linalg.svd(dependent, compute_uv=False)
    rank = dependent.shape[1] - source.idle
    return rank == 0 or bool(rank <= values.size and values[rank - 1] > WELL_POSED * values[0])


def disagreement(function: CompiledFunction, sample: RobotSample, parameters: Array) -> str:
    """What a function gives at one state against what it must give there: what is wrong, in words, or nothing."""
    arguments = [parameters if name == "parameters" else getattr(sample, name) for name in function.row.arguments]
    y, known = function.kernel(*arguments), function.row.known(sample)
    if not y[-1] <= STRAIN_LIMIT:
        return f"strain {y[-1]} near home"
    found = function.parts(y)
    for part in function.row.parts:
        if part.name not in known:
            continue
        unit = np.ones(())
        for axis in part.units.split(","):
            unit = np.multiply.outer(unit, sample.axes[axis])
        given, wanted = found[part.name], known[part.name]
        if part.periodic:
            given = nearest_turn(given, wanted, sample.units.turning)
        size = max(float(np.abs(wanted / unit).max(initial=0.0)), part.size(sample))
        worst = float(np.abs((given - wanted) / unit).max(initial=0.0))
        if not worst <= part.tolerance * size:
            return f"'{part.name}' is off by {worst:.2g} in {size:.2g}, in the robot's own units"
    return ""
