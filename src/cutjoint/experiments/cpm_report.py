"""The CPM's part of the reproduction: runs, tables, figures 9 to 22, claims."""

from __future__ import annotations

from typing import Any

import numpy as np

from cutjoint.crosscheck import hypothesis_cost
from cutjoint.experiments import cpm, cpm_law_claims
from cutjoint.experiments.cpm_claims import RULED, TITLES, Found, claims, rule_of, run_of
from cutjoint.experiments.pool import Task
from cutjoint.experiments.tables import claims_table, cost_table, errata_table
from cutjoint.papers.cpm.errata import ERRATA
from cutjoint.papers.cpm.published import CIRCLE, FORCE_LIMIT, SETTLING_TIME
from cutjoint.report import Panel, Path, Section, Table, figure
from cutjoint.report.page import Picture

FIRST_FIGURE = {"pd": 11, "pd-gravity": 14, "feedforward": 17, "computed-torque": 20}
SMALL = ("feedforward", "computed-torque")  # their late errors need a scale of their own
AXES = ("x (limb 1)", "y (limb 2)", "z (limb 3)")


def tasks() -> dict[Any, Task]:
    """Everything that has to be run, the longest first, so that no core is left with it at the end."""
    wanted: dict[Any, Task] = {}
    for column in ("equation", "inferred"):
        for name in RULED:
            wanted["rule", name, column] = (cpm.gain_rule, (name, column))
    wanted |= cpm_law_claims.tasks()
    for column in ("lumped", "distributed", "inferred", "steps", "equation"):
        for name in cpm.ROWS:
            wanted["run", name, column] = (cpm.table_3_run, (name, column))
    wanted["cost"] = (lumping_cost, ())
    return wanted


def lumping_cost() -> Any:
    """What the lumped second rods cost along the circle."""
    way = cpm.reference("equation").trajectory
    motions = [way.at(float(t)) for t in np.linspace(0.0, way.duration, 401)]
    path = [(motion.position, motion.velocity, motion.acceleration) for motion in motions]
    return hypothesis_cost(cpm.model("equation"), cpm.chain("distributed"), path)


def sections(found: Found) -> list[Section]:
    """The part of the page, from what `tasks` gave."""
    return [
        Section(
            "Cartesian Parallel Manipulator",
            (
                "Elkady, Elkobrosy, Hanna and Sobh (2008) control the robot along a circle of 0.175 m in four seconds "
                "with four controllers. Every controller here uses the model of its column and the printed gains; the "
                "robot starts at rest at the first point of the circle, on the elbow branch (+, -, +).",
                claims_table("Claims of the paper", claims(found)),
            ),
            level=2,
        ),
        Section("Table 3", table_3(found)),
        Section("The rule for the gains", (gain_table(found), force_table())),
        Section("Figures 9 to 22", figures(found)),
        Section(
            "What lumping the second rod costs",
            (
                "The paper puts half of each second rod's mass at either of its ends. The same robot with uniform rods "
                "needs this much other force along the circle.",
                cost_table("CPM, lumped against uniform second rods, along the circle", found["cost"]),
            ),
        ),
        Section("Errata of the CPM's paper", (errata_table("CPM: what is printed, and what holds", ERRATA),)),
    ]


def table_3(found: Found) -> tuple[Table, ...]:
    """Position and velocity errors by (49), a table each."""
    tables = []
    for index, quantity, unit in ((0, "position", "m"), (1, "velocity", "m/s")):
        rows = []
        for name, row in cpm.ROWS.items():
            printed = row.position_error if index == 0 else row.velocity_error
            cells = [f"{run_of(found, name, column).rmse()[index]:.5g}" for column in cpm.COLUMNS]
            agrees = printed.agrees(run_of(found, name, "inferred").rmse()[index])
            over_time = f"{run_of(found, name, 'equation').rmse_over_time()[index]:.5g}"
            rows.append((TITLES[name], str(printed), *cells, over_time, "yes" if agrees else "no"))
        tables.append(
            Table(
                f"Table 3, root mean square {quantity} error [{unit}]",
                (
                    "controller",
                    "printed",
                    "inferred code",
                    "equation (39)",
                    "Pinocchio, lumped",
                    "Pinocchio, distributed",
                    "(39), mean over time",
                    "printed digits",
                ),
                rows,
                right=(
                    "printed",
                    "inferred code",
                    "equation (39)",
                    "Pinocchio, lumped",
                    "Pinocchio, distributed",
                    "(39), mean over time",
                ),
                note="Inferred code: mean over the steps of its own adaptive solver. The others: every millisecond; "
                "the sample at t = 0 alone, where the velocity is wrong by 0.2749 m/s, makes up a part of the velocity "
                "error that depends on the number of samples. The last number is the mean over time, which does not."
                if index == 1
                else "The inferred code is the model that explains most of the paper's figures (see the errata); it is "
                "an inference after the fact; the last column says whether it gives the printed digits. Pinocchio: all "
                "joints of the tree, cut joints as constraints; the controller believes equation (39).",
            )
        )
    return tuple(tables)


def gain_table(found: Found) -> Table:
    """The smallest gains that keep the bounds."""
    rows = []
    for name in RULED:
        row = cpm.ROWS[name]
        cells = [
            cell
            for column in ("inferred", "equation")
            for rule in [rule_of(found, name, column)]
            for cell in (str(rule.gain), f"{1e3 * rule.error:.7g} / {1e3 * rule.error_below:.7g}")
        ]
        rows.append((TITLES[name], f"{1e3 * cpm.bound(name):g}", f"{row.k_p:g}", *cells))
    columns = (
        "controller",
        "bound [mm]",
        "printed K_P",
        "inferred code",
        "error there / one below [mm]",
        "equation (39)",
        "error there / one below [mm]",
    )
    return Table(
        "Smallest integer K_P whose error along every axis stays below the bound from 0.3 s on, K_D = 436",
        columns,
        rows,
        right=columns[1:],
        note="Every 2 ms, RK4; found by secant and settled by the two neighbouring integers.",
    )


def force_table() -> Table:
    """The largest K_D within the limit of force."""
    rows = []
    for name, row in cpm.ROWS.items():
        cells = [
            cell
            for column in ("inferred", "equation")
            for cell in (
                f"{cpm.first_force(column, name, row.k_d):.2f}",
                str(cpm.largest_k_d(column, name, FORCE_LIMIT)),
            )
        ]
        rows.append((TITLES[name], f"{row.k_d:g}", *cells))
    columns = (
        "controller",
        "printed K_D",
        "inferred: first force [N]",
        "largest K_D",
        "(39): first force [N]",
        "largest K_D",
    )
    return Table(
        f"Force at t = 0 and the largest integer K_D that keeps it within {FORCE_LIMIT:g} N",
        columns,
        rows,
        right=columns[1:],
        note="At rest on a path that already moves at 0.2749 m/s the first force is K_D times that speed plus what the "
        "model feeds forward. For computed torque K_P = K_D^2 / 4 does not matter there: the position error is zero.",
    )


def figures(found: Found) -> list[str | Picture]:
    """Figures 9 to 22, by equation (39)."""
    plain = run_of(found, "computed-torque", "equation")
    way = cpm.reference("equation")
    model = cpm.model("equation")
    force = np.array([model.inverse_dynamics(d.posture, d.v, d.a) for d in (way.at(float(t)) for t in plain.time[::4])])
    shown: list[str | Picture] = [
        "Computed with equation (39). The first sample of every force is the answer to the velocity step at t = 0; it "
        "sets the scale of the paper's force figures too.",
        Picture(
            figure(
                Path("Path of the tool (figure 9)", "xy", plain.desired_tool, run_of(found, "pd", "equation").tool),
                Panel("Desired force (figure 10)", plain.time[::4], force, "N", "force", AXES),
            ),
            "Figures 9 and 10. Left: the circle, and where PD alone takes the tool. Right: the force that equation "
            f"(39) needs along the circle: Fx {_range(force[:, 0])}, Fy {_range(force[:, 1])}, "
            f"Fz {_range(force[:, 2])} N.",
        ),
    ]
    for name, row in cpm.ROWS.items():
        result, number = run_of(found, name, "equation"), FIRST_FIGURE[name]
        bound = f" Dotted: the bound of {1e3 * row.bound:g} mm from 0.3 s on." if row.bound is not None else ""
        shown.append(
            Picture(
                figure(
                    Panel(
                        f"Position error (figure {number})",
                        result.time,
                        result.error,
                        "m",
                        "error",
                        AXES,
                        row.bound,
                        SETTLING_TIME,
                        zoom=(SETTLING_TIME, CIRCLE.duration) if name in SMALL else None,
                    ),
                    Panel(
                        f"Velocity error (figure {number + 1})",
                        result.time,
                        result.velocity_error,
                        "m/s",
                        "error",
                        AXES,
                        zoom=(0.0, SETTLING_TIME),
                    ),
                    Panel(
                        f"Force (figure {number + 2})",
                        result.time,
                        result.effort,
                        "N",
                        "force",
                        AXES,
                        FORCE_LIMIT,
                        zoom=(0.0, SETTLING_TIME),
                    ),
                ),
                f"Figures {number} to {number + 2}. {TITLES[name]}, K_P = {row.k_p:g}, K_D = {row.k_d:g}, "
                f"equation (39).{bound} Right, dotted: the limit of {FORCE_LIMIT:g} N.",
            )
        )
    return shown


def _range(values: Any) -> str:
    return f"{values.min():.3f} to {values.max():.3f}"
