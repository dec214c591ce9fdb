"""The claims of Elkady et al. 2008 about table 3, judged by equation (39) and by the inferred code.

What the paper says of the control laws themselves is in `cutjoint.experiments.cpm_law_claims`.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from cutjoint.experiments import cpm
from cutjoint.experiments.tables import Claim, Verdict
from cutjoint.papers.cpm.published import CIRCLE, FORCE_LIMIT, SETTLING_TIME
from cutjoint.pool import Key, Outcome
from cutjoint.simulation import Result
from cutjoint.tuning.smallest import SmallestGain

Found = Mapping[Key, Outcome]
TITLES = {
    "pd": "PD",
    "pd-gravity": "PD + gravity",
    "feedforward": "PD + feedforward",
    "computed-torque": "computed torque",
}
RULED = tuple(name for name, row in cpm.ROWS.items() if row.bound is not None)


def run_of(found: Found, name: str, column: str) -> Result:
    """One run of table 3."""
    result = found["run", name, column]
    assert isinstance(result, Result)
    return result


def rule_of(found: Found, name: str, column: str) -> SmallestGain:
    """One end of the gain rule."""
    rule = found["rule", name, column]
    assert isinstance(rule, SmallestGain)
    return rule


def claims(found: Found) -> list[Claim]:
    """The paper's claims with their verdicts."""
    listed = []
    for name in RULED:
        row, bound = cpm.ROWS[name], cpm.bound(name)
        rule = [rule_of(found, name, column) for column in ("equation", "inferred")]
        # The printed gain is the first one that the rule tries: both rows judge by the same error.
        errors = [one.error_of_guess for one in rule]
        holds = [error < bound for error in errors]
        listed.append(
            Claim(
                "5.4",
                f"{TITLES[name]}: error along every axis below {1e3 * bound:g} mm after {SETTLING_TIME:g} s",
                f"(39): {1e3 * errors[0]:.6g} mm; inferred code: {1e3 * errors[1]:.6g} mm",
                Verdict.of(*holds),
            )
        )
        listed.append(
            Claim(
                "5.3, table 3",
                f"{TITLES[name]}: K_P = {row.k_p:g} is the smallest integer that does so",
                f"(39): {rule[0].gain}; inferred code: {rule[1].gain}",
                Verdict.of(*(one.gain == round(row.k_p) for one in rule)),
            )
        )
    for name, row in cpm.ROWS.items():
        runs = [run_of(found, name, column) for column in ("equation", "inferred")]
        peaks = [float(one.peak_effort().max()) for one in runs]
        first = all(np.abs(one.effort[0]).max() == peak for one, peak in zip(runs, peaks, strict=True))
        listed.append(
            Claim(
                "5.3, 5.4",
                f"{TITLES[name]}: no actuator force above {FORCE_LIMIT:g} N",
                f"(39): {peaks[0]:.2f} N; inferred code: {peaks[1]:.2f} N{', at t = 0' if first else ''}",
                Verdict.of(*(peak <= FORCE_LIMIT for peak in peaks)),
            )
        )
        largest = [cpm.largest_k_d(column, name, FORCE_LIMIT) for column in ("equation", "inferred")]
        listed.append(
            Claim(
                "5.4.4, table 3",
                f"{TITLES[name]}: K_D = {row.k_d:g} is the largest integer within that limit",
                f"(39): {largest[0]}; inferred code: {largest[1]}",
                Verdict.of(*(one == round(row.k_d) for one in largest)),
            )
        )
    listed.append(order(found))
    speed = CIRCLE.radius * CIRCLE.omega
    listed.append(
        Claim(
            "5.3",
            "the path is planned without sudden changes of velocity",
            f"it starts with a step of {speed:.4f} m/s for a robot at rest",
            Verdict.of(speed == 0.0),
        )
    )
    return listed


def order(found: Found) -> Claim:
    """Whether the position error falls from law to law, computed torque last."""
    errors = {
        column: [run_of(found, name, column).rmse().position for name in cpm.ROWS]
        for column in ("equation", "inferred")
    }
    shown = {column: ", ".join(f"{1e3 * one:.4g}" for one in row) for column, row in errors.items()}
    return Claim(
        "6",
        "position error: PD > PD + gravity > PD + feedforward > computed torque",
        f"(39): {shown['equation']} mm; inferred code: {shown['inferred']} mm",
        Verdict.of(*(row == sorted(set(row), reverse=True) for row in errors.values())),
    )
