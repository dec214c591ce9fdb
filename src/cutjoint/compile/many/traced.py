"""One closed loop, plant and law and integrator, as programs: what many runs of it compute at every step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from cutjoint.compile.compiler import Compiled
from cutjoint.compile.expressions.graph import Expression, Graph, Number
from cutjoint.compile.expressions.program import Program
from cutjoint.compile.functions.tracing import accelerations
from cutjoint.compile.machine.kernel import Event, LoopParts, Sizes, Stages
from cutjoint.compile.many.hardware_numbers import fitted_with
from cutjoint.compile.many.sampled import Sampled
from cutjoint.compile.many.tracing import Tracing, continuous
from cutjoint.compile.sources.interface import Need
from cutjoint.compile.sources.law import TracedDesired
from cutjoint.compile.sources.traced_array import numbers
from cutjoint.control import Law
from cutjoint.errors import InputError
from cutjoint.mechanism import Mechanism
from cutjoint.simulation import ReducedPlant
from cutjoint.simulation.hardware import Hardware
from cutjoint.simulation.hardware.control import Control

STAGES: Mapping[str, Stages] = {
    "rk4": Stages((0.5, 0.5, 1.0), (1, 2, 2, 1), 6),
    "midpoint": Stages((0.5,), (0, 1), 1),
}
"""The methods of `cutjoint.simulation.integrators.FIXED_STEP`, as they are compiled."""


@dataclass(frozen=True, eq=False)
class TracedLoop:
    """A closed loop as programs.

    Attributes:
        plant, law: what it is made of.
        control: what is between law and joints: hardware, or under continuous control the limits of efforts.
        method: name of the integrator.
        gains: names of the law's gains that are arguments.
        varying: names of the hardware's numbers that are.
        behind: numbers of the state behind positions and velocities, which are 0 at first.
        desired: what is read of the reference.
        parts: the programs, and the sizes of what they read and write.
    """

    plant: Compiled
    law: Law
    control: Control
    method: str
    gains: tuple[str, ...]
    varying: tuple[str, ...]
    behind: int
    desired: TracedDesired
    parts: LoopParts

    @property
    def hardware(self) -> Hardware | None:
        """What is between law and joints, or None under continuous control."""
        return self.control if isinstance(self.control, Hardware) else None

    @property
    def rows_per_step(self) -> int:
        """Rows of the reference table that a step takes."""
        return 2 if self.hardware is None else 1


def traced_loop(
    plant: Compiled,
    law: Law,
    mechanism: Mechanism,
    gains: tuple[str, ...],
    control: Control,
    method: str,
    varying: tuple[str, ...] = (),
) -> TracedLoop:
    """Trace a closed loop; see `ClosedLoop` for arguments and errors."""
    for need in (Need.ACTUATED, Need.SMOOTH):
        if (lack := plant.source.lacks(need)) is not None:
            raise lack
    ReducedPlant(plant)  # raises: idle freedoms gain momentum, so these are not all coordinates of the motion
    if varying and not isinstance(control, Hardware):
        raise InputError(f"{varying[0]} is of hardware, and there is none; give hardware=")
    one = Tracing(plant, law, mechanism, gains, varying)
    hardware = Sampled(one, fitted_with(control, one.hardware, plant.n)) if isinstance(control, Hardware) else None
    moved = continuous(one, control) if hardware is None else hardware.actuation  # type: ignore[arg-type]
    a, factor = accelerations(one.traced, one.v, moved.effort)
    errors = [x - y for x, y in zip(numbers(one.desired.q), one.traced.actuated, strict=True)]
    rates = [*one.traced.position_rate(one.v), *a, *moved.rates]
    results = {"rate": rates, "watched": [*moved.effort, *errors], "strain": [factor.strain]}
    settle = one.settle(moved.behind)
    sizes = Sizes(
        state=len(rates),
        columns=len(one.desired.symbols),
        given=len(one.given),
        watched=2 * plant.n,
        settled=plant.source.positions if settle else 0,
    )
    stages = STAGES[method]
    if hardware is None:
        parts = LoopParts(one.program("rate", results, moved.behind), settle, stages, sizes)
    else:
        parts = _with_events(one, hardware, results, settle, stages, sizes)
    return TracedLoop(plant, law, control, method, gains, varying, len(moved.behind), one.desired, parts)


def _with_events(
    one: Tracing,
    hardware: Sampled,
    results: Mapping[str, Sequence[Number]],
    settle: Program | None,
    stages: Stages,
    sizes: Sizes,
) -> LoopParts:
    """The loop with its events; what nobody reads of the memory is left out."""
    symbols, behind, noise = hardware.symbols, hardware.actuation.behind, hardware.noise
    used = _read(one.graph, symbols, [x for values in results.values() for x in values])
    used |= _read(one.graph, symbols, hardware.shown)
    while True:
        wanted = [values[k] for values in hardware.events for k in used]
        if (more := used | _read(one.graph, symbols, wanted)) == used:
            break
        used = more
    live = sorted(used)
    memory = [symbols[k] for k in live]
    place = {k: index for index, k in enumerate(live)}
    number = {x.ref: k for k, x in enumerate(symbols)}
    shown = tuple(place[number[x.ref]] for x in hardware.shown)
    sizes = replace(sizes, memory=len(memory), noise=len(noise), shown=shown)

    def event(name: str, values: Mapping[int, Number], draws: bool) -> Event:
        program = one.program(name, {"values": list(values.values())}, behind, memory, noise)
        return Event(program, tuple(values), draws)

    events = []
    for k, values in enumerate(hardware.events):
        changed = {sizes.changing + place[i]: values[i] for i in live if values[i] is not symbols[i]}
        events.append(event(f"event {k}", changed, k == 0 and bool(noise)))
    first = len(hardware.begun) - len(symbols)
    begun = {sizes.state - len(behind) + i: x for i, x in enumerate(hardware.begun[:first])}
    begun |= {sizes.changing + place[i]: hardware.begun[first + i] for i in live}
    rate = one.program("rate", results, behind, memory)
    return LoopParts(rate, settle, stages, sizes, event("begin", begun, bool(noise)), tuple(events))


def _read(graph: Graph, symbols: Sequence[Expression], values: Sequence[Number]) -> set[int]:
    """Which symbols some values are made of."""
    nodes = set(graph.ancestors([graph.reference(x) for x in values]))
    return {k for k, x in enumerate(symbols) if abs(x.ref) in nodes}
