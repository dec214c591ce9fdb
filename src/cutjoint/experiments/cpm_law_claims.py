"""What Elkady et al. 2008 say of their four control laws, with a verdict from a run each (sections 4.2 to 4.6, 5.4.4).

The runs are in `cutjoint.experiments.cpm_laws`.  Equation (39) judges: the inferred code is about the figures of
table 3 and no mechanism.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from cutjoint.compile import CompiledPaper
from cutjoint.compile.expressions.graph import Graph
from cutjoint.compile.expressions.operations import Op
from cutjoint.compile.many.tracing import measured_state
from cutjoint.compile.sources.interface import TracedState
from cutjoint.compile.sources.law import TracedDesired, clipped, trace_law
from cutjoint.compile.sources.paper import PaperModel
from cutjoint.control import Law
from cutjoint.experiments import cpm, cpm_laws
from cutjoint.experiments.cpm_claims import TITLES, Found, run_of
from cutjoint.experiments.cpm_laws import Damping, Held, Response, UpdateRate
from cutjoint.experiments.tables import Claim, Verdict
from cutjoint.mechanism import Mechanism
from cutjoint.papers.cpm import CpmModel
from cutjoint.pool import Key, Task
from cutjoint.simulation import Result

ZERO = 1e-9
"""A tracking error below this is the integrator's [m]; the smallest bound of the paper is ten thousand times it."""

SAME = 1e-6
"""Two courses of an error that differ by less than this part of its largest value are the same."""

ROUNDING = 1e-12
"""An energy that rises by less than this part of itself does not rise."""

FEW = 10
"""Computations are few where computed torque needs more than this many times as many."""

K_D = cpm.ROWS["computed-torque"].k_d
K_P = cpm.ROWS["computed-torque"].k_p


def tasks() -> dict[Key, Task]:
    """The runs, the longest first."""
    wanted: dict[Key, Task] = {
        "rate": (cpm_laws.update_rate, ()),
        "damping": (cpm_laws.damping, ()),
        "wrong": (cpm_laws.wrong_model, ()),
        "linear": (cpm_laws.linearised, ()),
    }
    for name in ("pd", "pd-gravity"):
        wanted["held", name] = (cpm_laws.held, (name,))
    for name in cpm.ROWS:
        wanted["load", name] = (cpm_laws.load_response, (name,))
    for k_d in (0.5 * K_D, K_D, 2.0 * K_D):
        wanted["critical", k_d] = (cpm_laws.critical_error, (k_d,))
    for name, feedback in (("pd-gravity", True), ("feedforward", True), ("feedforward", False)):
        wanted["tracking", name, feedback] = (cpm_laws.tracking_error, (name, feedback))
    return wanted


def claims(found: Found) -> list[Claim]:
    """The paper's claims with their verdicts, from what `tasks` and table 3's runs gave."""
    load: dict[str, Response] = {name: found["load", name] for name in cpm.ROWS}
    return [
        disturbed(load),
        computations(),
        high_rate(found["rate"]),
        *overwork({name: run_of(found, name, "equation") for name in cpm.ROWS}),
        constant_reference(found["held", "pd-gravity"], found["held", "pd"]),
        imperfect(found["tracking", "pd-gravity", True]),
        exact_feedforward(found["tracking", "feedforward", True], found["tracking", "feedforward", False]),
        *changed_mass(load["feedforward"], load["computed-torque"]),
        linear(found["linear"]),
        accurate_model(*found["wrong"]),
        critical(found["damping"]),
        *decays(found),
        largest_k_d({k_d: found["critical", k_d] for k_d in (0.5 * K_D, K_D, 2.0 * K_D)}),
    ]


def listed(values: Mapping[str, str], unit: str = "") -> str:
    """The four laws with a figure each."""
    return ", ".join(f"{TITLES[name]} {value}" for name, value in values.items()) + (f" {unit}" if unit else "")


def disturbed(load: Mapping[str, Response]) -> Claim:
    """Section 4.2: low rejection of disturbances and parameter variations."""
    worst = max(load, key=lambda name: load[name].deviation)
    shown = listed({name: f"{1e3 * one.deviation:.3f}" for name, one in load.items()}, "mm")
    return Claim(
        "4.2",
        "control of each joint by itself resists disturbances and changed parameters worse than with a model",
        f"{cpm_laws.LOAD:g} kg picked up moves the tool by: {shown}",
        Verdict.of(worst == "pd"),
    )


def computations() -> Claim:
    """Sections 4.3 and 4.5: what has to be computed while the robot moves."""
    model = cpm.model("equation")
    assert isinstance(model, CpmModel)
    count = {name: operations(cpm.controller(name, "equation"), model) for name in cpm.ROWS}
    return Claim(
        "4.3, 4.5",
        "PD needs very few computations; feedforward terms can be computed before, so its burden is small too",
        "arithmetic operations an update: " + listed({name: str(one) for name, one in count.items()}),
        Verdict.of(
            all(FEW * one < count["computed-torque"] for name, one in count.items() if name != "computed-torque")
        ),
    )


def high_rate(rate: UpdateRate) -> Claim:
    """Section 4.3: PD needs a high update rate."""
    lowest = listed({name: str(one) for name, one in rate.lowest.items()}, "Hz")
    return Claim(
        "4.3",
        "PD needs a high update rate for a reasonable accuracy",
        f"error after 0.3 s: {1e3 * rate.slow:.4f} mm at {cpm_laws.LOW_RATE:g} Hz, {1e3 * rate.continuous:.4f} mm "
        f"under continuous control; lowest rates for that accuracy: {lowest}",
        Verdict.of(rate.slow > cpm_laws.REASONABLE * rate.continuous),
    )


def overwork(runs: Mapping[str, Result]) -> list[Claim]:
    """Section 4.3: the motors overwork under PD."""
    work = {name: cpm_laws.work(one) for name, one in runs.items()}
    peak = {name: float(one.peak_effort().max()) for name, one in runs.items()}
    return [
        Claim(
            "4.3",
            "under PD the motors work more than under the other laws",
            "mean power in table 3: " + listed({name: f"{one:.4f}" for name, one in work.items()}, "W"),
            Verdict.of(max(work, key=lambda name: work[name]) == "pd"),
        ),
        Claim(
            "4.3",
            "under PD the motors give larger forces than under the other laws",
            "largest force in table 3: " + listed({name: f"{one:.2f}" for name, one in peak.items()}, "N"),
            Verdict.of(max(peak, key=lambda name: peak[name]) == "pd"),
        ),
    ]


def constant_reference(gravity: Held, plain: Held) -> Claim:
    """Section 4.4: asymptotic stability."""
    return Claim(
        "4.4",
        "PD + gravity is asymptotically stable at a constant reference, from wherever it starts",
        f"from {1e3 * cpm_laws.AWAY * 3**0.5:.0f} mm away on eight sides, {gravity.left:.1e} m are left after "
        f"{gravity.duration:g} s and its Lyapunov function never rises; PD alone stays {1e3 * plain.left:.3f} mm off",
        Verdict.of(gravity.left < ZERO and gravity.rise < ROUNDING),
    )


def imperfect(error: float) -> Claim:
    """Section 4.4: no perfect tracking of a reference that moves."""
    return Claim(
        "4.4",
        "PD + gravity does not track a moving reference perfectly",
        f"started on the circle at its speed: error up to {1e3 * error:.4f} mm",
        Verdict.of(error > ZERO),
    )


def exact_feedforward(closed: float, open_: float) -> Claim:
    """Section 4.5: zero error from exact feedforward."""
    return Claim(
        "4.5",
        "with an exact model and no error at first the feedforward force alone keeps the error zero",
        f"once around the circle: {open_:.0e} m without feedback, {closed:.0e} m with it",
        Verdict.of(max(closed, open_) < ZERO),
    )


def changed_mass(feedforward: Response, torque: Response) -> list[Claim]:
    """Section 4.5: the response to a load."""
    kilo = f"{cpm_laws.LOAD:g} kg picked up half way around"
    return [
        Claim(
            "4.5",
            "PD + feedforward responds to a load that is picked up more slowly than computed torque",
            f"{kilo}: nine tenths of the change after {feedforward.rise_time:.3f} s against {torque.rise_time:.3f} s",
            Verdict.of(feedforward.rise_time > torque.rise_time),
        ),
        Claim(
            "4.5",
            "PD + feedforward is less sensitive to changed masses than computed torque",
            f"{kilo}: the tool moves by {1e3 * feedforward.deviation:.3f} mm against {1e3 * torque.deviation:.3f} mm",
            Verdict.of(feedforward.deviation < torque.deviation),
        ),
    ]


def linear(deviation: float) -> Claim:
    """Section 4.6: equation (44)."""
    return Claim(
        "4.6, (44)",
        "computed torque makes the error of every axis linear; with positive gains it dies exponentially",
        f"{1e3 * float(np.abs(cpm_laws.DISPLACED).max()):g} mm off, other gains along every axis: within "
        f"{deviation:.0e} of the first error of the solution of (44)",
        Verdict.of(deviation < SAME),
    )


def accurate_model(exact: float, wrong: float) -> Claim:
    """Section 4.6: the need for a reasonably accurate model."""
    bound = cpm.bound("feedforward")
    return Claim(
        "4.6",
        "computed torque needs a reasonably accurate model",
        f"error after 0.3 s: {1e3 * exact:.0e} mm with the exact model, {1e3 * wrong:.4f} mm with masses "
        f"{100 * cpm_laws.OFF:g} % too large",
        Verdict.of(exact < bound < wrong),
    )


def critical(found: Mapping[float, Damping]) -> Claim:
    """Section 4.6: equation (46)."""
    calm = {ratio: one.settling_time for ratio, one in found.items() if one.overshoot == 0.0}
    fastest = min(calm, key=lambda ratio: calm[ratio])
    below = max(ratio for ratio in found if ratio < 1.0)
    above = min(ratio for ratio in found if ratio > 1.0)
    return Claim(
        "4.6, (46)",
        "critical damping gives the fastest error that does not oscillate",
        f"to 1 %: {found[1.0].settling_time:.3f} s, at damping ratio {above:g} {found[above].settling_time:.3f} s; at "
        f"{below:g} the error overshoots by {100 * found[below].overshoot:.2f} %",
        Verdict.of(fastest == 1.0 and min(calm) == 1.0),
    )


def decays(found: Found) -> list[Claim]:
    """Sections 4.6 and 5.4.4: how fast the error of table 3's run decays."""
    equation, chain = (cpm_laws.decay(run_of(found, "computed-torque", column)) for column in ("equation", "lumped"))
    return [
        Claim(
            "5.4.4, (50)",
            "computed torque: the error is e_dot(0) t exp(-K_D t / 2)",
            f"of {1e3 * equation.largest:.4f} mm at most, (39) is within {equation.deviation:.0e} m of it, Pinocchio's "
            f"closed chain within {chain.deviation:.0e} m",
            Verdict.of(max(one.deviation / one.largest for one in (equation, chain)) < SAME),
        ),
        Claim(
            "4.6, (47)",
            "the error decays with K_P / 2",
            f"it decays with {equation.rate:.2f} 1/s; K_P / 2 = {0.5 * K_P:g}, K_D / 2 = {0.5 * K_D:g}",
            Verdict.of(abs(equation.rate - 0.5 * K_P) < 0.01 * equation.rate),
        ),
    ]


def largest_k_d(errors: Mapping[float, float]) -> Claim:
    """Section 5.4.4: K_D as large as the force allows."""
    shown = ", ".join(f"{1e3 * error:.4f} mm with {k_d:g}" for k_d, error in errors.items())
    return Claim(
        "5.4.4",
        "computed torque, critically damped: the larger K_D, the smaller the error",
        f"root mean square of the first 0.5 s: {shown}",
        Verdict.of(bool((np.diff([errors[k_d] for k_d in sorted(errors)]) < 0.0).all())),
    )


def operations(law: Law, model: PaperModel) -> int:
    """Arithmetic operations between measured state and effort of `law` on a robot that is `model`, a root as one.

    The law is run on symbols, as the compiler does.  What depends on the desired motion alone is not counted: it can be
    computed before the robot moves.
    """
    plant = CompiledPaper(model)
    n = plant.n
    graph = Graph()
    state = graph.symbols(plant.source.positions + n)
    measured, v = state[:-n], state[-n:]
    traced = plant.source.state(graph, measured, [])
    desired = TracedDesired(graph, n, model)

    def seen_by(one: Mechanism) -> TracedState | None:
        return measured_state(one, plant, traced, graph, traced.actuated)

    answer = trace_law(law, desired, traced.actuated, v, [], {}, clipped(None), seen_by)
    needed = graph.ancestors([graph.reference(one) for one in answer.given])
    return sum(graph.op[node] not in (Op.CONST, Op.INPUT) for node in needed)
