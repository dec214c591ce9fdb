"""The Omega-3's part of the reproduction: runs, figures 4 and 5, the claim, the cost of its hypotheses."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from cutjoint.experiments import omega3
from cutjoint.experiments.tables import Verdict, cost_table, errata_table
from cutjoint.papers.omega3.errata import ERRATA
from cutjoint.papers.omega3.published import ERROR_BOUND, SETTLING_TIME
from cutjoint.pool import Key, Outcome, Task
from cutjoint.report import Panel, Section, ToolPath, figure
from cutjoint.report.page import Picture
from cutjoint.robots import hypothesis_cost_of
from cutjoint.simulation import Result
from cutjoint.tables import TextTable
from cutjoint.tuning.known import GAINS

TITLES = {"computed-torque": "computed torque", "feedforward": "PD + feedforward"}
ARMS = ("arm 1", "arm 2", "arm 3")
Found = Mapping[Key, Outcome]


def tasks() -> dict[Key, Task]:
    """Everything that has to be run."""
    wanted: dict[Key, Task] = {
        ("run", name, setup): (omega3.curve_run, (name, setup)) for name in omega3.LAWS for setup in omega3.SETUPS
    }
    wanted["cost"] = (hypothesis_cost_of, ("omega3",))
    wanted["arms"] = (omega3.arm_assumptions, ())
    return wanted


def paper_section(found: Found) -> Section:
    """Both controllers along the curve, and the claim."""
    return Section(
        "Omega-3",
        (
            "Adetu, Moore and Roberts follow the figure of eight (43) with PD feedback and their dynamic model. "
            "They print neither gains nor the initial state nor where the model enters, so both usual forms are "
            "run, with gains of this project: computed torque with K_P = {kp:g} 1/s2, K_D = {kd:g} 1/s, and PD + "
            "feedforward with K_P = {fp:g} N m/rad and K_D = {fd:g} N m s/rad. The robot starts at rest.".format(
                **dict(zip(("kp", "kd"), GAINS["omega3"]["computed-torque"].values(), strict=True)),
                **dict(zip(("fp", "fd"), GAINS["omega3"]["feedforward"].values(), strict=True)),
            ),
            "It claims (section V) a position error below 3 mm after about 0.3 s.",
            *(runs_table(found, name) for name in omega3.LAWS),
        ),
        level=2,
    )


def cost_section(found: Found) -> Section:
    """What the paper's hypotheses cost."""
    return Section(
        "What the hypotheses cost",
        (
            "Rods: the paper puts half of each pair's mass at either end. Arm: the paper gives neither the inertia "
            "nor the centre of mass of the semi-circular arm, which matters more.",
            cost_table("Omega-3, lumped against uniform rods, along the curve", found["cost"]),
            arm_table(found),
        ),
    )


def run_of(found: Found, name: str, setup: str) -> Result:
    """One run of the curve."""
    result = found["run", name, setup]
    assert isinstance(result, Result)
    return result


def gains_of(name: str) -> str:
    """The gains as text."""
    gains = GAINS["omega3"][name]
    return f"K_P = {gains['kp']:g}, K_D = {gains['kd']:g}"


def runs_table(found: Found, name: str) -> TextTable:
    """Errors and torques of all runs with one controller, and the claim."""
    columns = (
        "plant",
        "largest error [mm]",
        "after 0.3 s [mm]",
        "rms over time [mm]",
        "peak torque [N m]",
        "loop gap [m]",
        "energy balance",
        "below 3 mm after 0.3 s",
    )
    rows = [
        (
            setup.about,
            f"{1e3 * result.worst_error():.3f}",
            f"{1e3 * result.worst_error(SETTLING_TIME):.3f}",
            f"{1e3 * result.rmse_over_time().position:.3f}",
            f"{result.peak_effort().max():.3f}",
            f"{result.loop_gap()[0]:.1e}",
            f"{result.energy_drift():.1e}",
            Verdict.of(result.worst_error(SETTLING_TIME) < ERROR_BOUND).cell,
        )
        for key, setup in omega3.SETUPS.items()
        for result in [run_of(found, name, key)]
    ]
    return TextTable(
        f"{TITLES[name]}, {gains_of(name)}: one turn of the curve (43) from rest",
        columns,
        rows,
        right=columns[1:-1],
        note="The controller always believes equation (42). Energy balance: energy that came from nowhere, relative to "
        "what was turned over; RK4 with 1 ms. Under continuous control it is the integrator's error in the feedback's "
        "first milliseconds."
        if name == omega3.LAWS[-1]
        else "",
    )


def arm_table(found: Found) -> TextTable:
    """What the unknown arm may change."""
    columns = (
        "shape of the arm",
        "centre of mass [mm]",
        "inertia about the axis [kg m2]",
        "peak torque [N m]",
        "change",
    )
    rows = [
        (
            one.about,
            f"{1e3 * one.com:.2f}",
            f"{one.inertia:.3e}",
            " / ".join(f"{value:.4f}" for value in one.peak),
            f"{100.0 * float(np.max(one.change / found['arms'][0].peak)):.1f} % of the peak",
        )
        for one in found["arms"]
    ]
    return TextTable(
        "Torque along the curve under other shapes of the semi-circular arm, equal mass and length",
        columns,
        rows,
        right=columns[1:],
        note="The inertia is without the rods' share, which adds half a pair's mass times L_A^2.",
    )


def figures(found: Found) -> list[str | Picture]:
    """Figures 4 and 5."""
    first = run_of(found, "computed-torque", "paper")
    shown: list[str | Picture] = [
        Picture(
            figure(
                ToolPath("Desired path (figure 4a)", "yz", first.desired_tool),
                Panel("Desired joint positions (figure 4b)", first.time, first.desired_q, "rad", "angle", ARMS),
                Panel("Desired joint velocities (figure 4c)", first.time, first.desired_v, "rad/s", "velocity", ARMS),
            ),
            "Figure 4. The curve (43) in the y-z plane and its inverse kinematics, elbows out.",
        )
    ]
    for name in omega3.LAWS:
        for setup in ("paper", "heavy"):
            result = run_of(found, name, setup)
            error = np.linalg.norm(result.error, axis=1)[:, None]
            shown.append(
                Picture(
                    figure(
                        ToolPath("Paths (figure 5)", "yz", result.desired_tool, result.tool),
                        Panel(
                            "Position error (figure 5)",
                            result.time,
                            error,
                            "m",
                            "length of the error",
                            ("error",),
                            ERROR_BOUND,
                            SETTLING_TIME,
                        ),
                        Panel("Torques (figure 5c)", result.time, result.effort, "N m", "torque", ARMS),
                    ),
                    f"Figure 5. {TITLES[name]}, {gains_of(name)}; {omega3.SETUPS[setup].about}. "
                    "Dotted: 3 mm from 0.3 s on.",
                )
            )
    return shown


SECTIONS: tuple[Callable[[Found], Section], ...] = (
    paper_section,
    lambda found: Section("Figures 4 and 5", figures(found)),
    cost_section,
    lambda _: Section(
        "Errata of the Omega-3's paper",
        (errata_table("Omega-3: what is printed or open, and what holds", ERRATA),),
        printed=False,
    ),
)
"""The parts of the page, each from what `tasks` gave."""
