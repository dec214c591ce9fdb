"""The CPM's part of the reproduction: runs, tables, figures 9 to 22, claims."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from cutjoint.arrays import Array
from cutjoint.experiments import cpm, cpm_law_claims
from cutjoint.experiments.cpm_claims import RULED, TITLES, Found, claims, rule_of, run_of
from cutjoint.experiments.tables import claims_table, cost_table, errata_table
from cutjoint.papers.cpm.errata import ERRATA
from cutjoint.papers.cpm.published import CIRCLE, FORCE_LIMIT, SETTLING_TIME, Table3Row
from cutjoint.pool import Key, Task
from cutjoint.report import Panel, Section, ToolPath, figure
from cutjoint.report.page import Picture
from cutjoint.robots import hypothesis_cost_of
from cutjoint.simulation import Result
from cutjoint.tables import TextTable

FIRST_FIGURE = {"pd": 11, "pd-gravity": 14, "feedforward": 17, "computed-torque": 20}
SMALL = ("feedforward", "computed-torque")  # their late errors need a scale of their own
AGREE = {(True, True): "both", (True, False): "inferred", (False, True): "(39)", (False, False): "neither"}
AXES = ("x (limb 1)", "y (limb 2)", "z (limb 3)")


def tasks() -> dict[Key, Task]:
    """Everything that has to be run, the longest first, so that no core is left with it at the end."""
    wanted: dict[Key, Task] = {}
    for column in ("equation", "inferred"):
        for name in RULED:
            wanted["rule", name, column] = (cpm.gain_rule, (name, column))
    wanted |= cpm_law_claims.tasks()
    for column in ("lumped", "distributed", "inferred", "steps", "equation"):
        for name in cpm.ROWS:
            wanted["run", name, column] = (cpm.table_3_run, (name, column))
    wanted["cost"] = (hypothesis_cost_of, ("cpm",))
    return wanted


def paper_section(found: Found) -> Section:
    """What the paper says, with verdicts."""
    return Section(
        "Cartesian Parallel Manipulator",
        (
            "Elkady, Elkobrosy, Hanna and Sobh (2008) control the robot along a circle of 0.175 m in four seconds "
            "with four controllers. Every controller here uses the model of its column and the printed gains; the "
            "robot starts at rest at the first point of the circle, on the elbow branch (+, -, +).",
            claims_table("What the paper says of table 3", claims(found)),
            "Sections 4.2 to 4.6 say what each of the four laws is good for. The runs behind these verdicts use "
            "equation (39) for robot and controller and the gains of table 3; where the paper speaks of a robot "
            "that follows its path, it starts on the path and at its speed.",
            claims_table("What the paper says of the control laws", cpm_law_claims.claims(found)),
        ),
        level=2,
    )


def cost_section(found: Found) -> Section:
    """What the paper's hypothesis costs."""
    return Section(
        "What lumping the second rod costs",
        (
            "The paper puts half of each second rod's mass at either of its ends. The same robot with uniform rods "
            "needs this much other force along the circle.",
            cost_table("CPM, lumped against uniform second rods, along the circle", found["cost"]),
        ),
    )


def table_3(found: Found) -> tuple[TextTable, ...]:
    """Position and velocity errors by (49), a table each."""
    heads = {
        "inferred": "inferred, solver steps",
        "steps": "(39), solver steps",
        "equation": "(39), uniform 1 ms",
        "lumped": "Pinocchio, lumped",
        "distributed": "Pinocchio, distributed",
    }
    tables = []
    for index, quantity, unit in ((0, "position", "m"), (1, "velocity", "m/s")):
        rows = []
        for name, row in cpm.ROWS.items():
            printed = row.position_error if index == 0 else row.velocity_error
            errors = {column: run_of(found, name, column).rmse()[index] for column in heads}
            over_time = run_of(found, name, "equation").rmse_over_time()[index]
            agree = (printed.agrees(errors["inferred"]), printed.agrees(errors["steps"]))
            cells = [f"{error:.5g}" for error in (*errors.values(), over_time)]
            rows.append((TITLES[name], str(printed), *cells, AGREE[agree]))
        columns = ("controller", "printed", *heads.values(), "(39), mean over time", "printed digits")
        tables.append(
            TextTable(
                f"Table 3, root mean square {quantity} error [{unit}]",
                columns,
                rows,
                right=columns[1:-1],
                note="The sample at t = 0 alone, where the velocity is wrong by 0.2749 m/s, makes up a part of the "
                "velocity error that depends on the number of samples, and the steps of an adaptive solver crowd "
                "there. The mean over time does not depend on the samples."
                if index == 1
                else "Solver steps: the mean runs over the steps of the adaptive solver; uniform 1 ms, as Pinocchio "
                "too: over a sample every millisecond. So the two columns over solver steps differ in the model "
                "alone, the first two of (39) in the averaging alone. Inferred: the model that explains most of the "
                "paper's figures (see the errata), an inference after the fact. Pinocchio: all joints of the tree, cut "
                "joints as constraints; the controller believes equation (39). Last column: which of the two models "
                "gives the printed digits over the solver's steps. Computed torque cancels its model: there both do.",
            )
        )
    return tuple(tables)


def gain_table(found: Found) -> TextTable:
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
    return TextTable(
        "Smallest integer K_P whose error along every axis stays below the bound from 0.3 s on, K_D = 436",
        columns,
        rows,
        right=columns[1:],
        note="Every 2 ms from 0.3 s exactly on, RK4; found by secant and settled by the two neighbouring integers.",
    )


def force_table() -> TextTable:
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
    return TextTable(
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
                ToolPath("Path of the tool (figure 9)", "xy", plain.desired_tool, run_of(found, "pd", "equation").tool),
                Panel("Desired force (figure 10)", plain.time[::4], force, "N", "force", AXES),
            ),
            "Figures 9 and 10. Left: the circle, and where PD alone takes the tool. Right: the force that equation "
            f"(39) needs along the circle: Fx {_range(force[:, 0])}, Fy {_range(force[:, 1])}, "
            f"Fz {_range(force[:, 2])} N.",
        ),
    ]
    return shown + [_of_law(name, row, run_of(found, name, "equation")) for name, row in cpm.ROWS.items()]


def _of_law(name: str, row: Table3Row, result: Result) -> Picture:
    """Errors and force of one control law."""
    number = FIRST_FIGURE[name]
    bound = f" Dotted: the bound of {1e3 * row.bound:g} mm from 0.3 s on." if row.bound is not None else ""
    return Picture(
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


def _range(values: Array) -> str:
    return f"{values.min():.3f} to {values.max():.3f}"


SECTIONS: tuple[Callable[[Found], Section], ...] = (
    paper_section,
    lambda found: Section("Table 3", table_3(found)),
    lambda found: Section("The rule for the gains", (gain_table(found), force_table())),
    lambda found: Section("Figures 9 to 22", figures(found)),
    cost_section,
    lambda _: Section(
        "Errata of the CPM's paper",
        (errata_table("CPM: what is printed, and what holds", ERRATA),),
        printed=False,
    ),
)
"""The parts of the page, each from what `tasks` gave."""
