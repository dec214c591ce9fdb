"""A synthesis drawn, and its page: the designs over the goals, where the front's variables lie, old against new."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from cutjoint.errors import CutjointError
from cutjoint.report.answers.sheet import sheet
from cutjoint.report.figures import BLUE, GREY, INK, ORANGE, Drawing, drawable
from cutjoint.report.page import Picture, Section, page
from cutjoint.synthesis import Subject, Synthesis

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def synthesis_sheet(found: Synthesis, taken: int | None = None) -> Drawing:
    """The designs over the first two goals, or over their number where there is one goal, and the front's variables.

    Args:
        found: the synthesis.
        taken: number of the design that is taken; default the best.

    Raises:
        InputError: no design does.
        MissingPackageError: matplotlib is not installed.
    """
    taken = found.best if taken is None else taken

    def draw(drawn: Figure) -> None:
        left, right = drawn.subplots(1, 2, width_ratios=(1.25, 1.0))
        _designs(left, found, taken)
        _variables(right, found, taken)

    return sheet(draw, f"{found.problem.robot.name}: {len(found.designs)} designs")


def _designs(ax: Axes, found: Synthesis, taken: int) -> None:
    goals = [*found.problem.goals, *found.problem.wants]
    several = len(found.problem.goals) > 1
    second = goals[1] if several else goals[0]
    doing = [k for k, one in enumerate(found.designs) if not one.why]
    if not several:
        numbers = {k: float(k) for k in range(len(found.designs))}
        ax.set_xlabel("design, in the order of the search")
    else:
        numbers = {k: found.designs[k].found[goals[0].name] for k in doing}
        ax.set_xlabel(_label(found, goals[0].name))
    others = [k for k in doing if k not in found.front]
    for which, colour, mark, size, name in (
        (others, GREY, "o", 22, "other designs"),
        (list(found.front), BLUE, "o", 46, "none beats it"),
        ([0] if 0 in doing else [], INK, "s", 80, "as it is"),
        ([taken], ORANGE, "*", 240, f"taken: {taken}"),
    ):
        if which:
            heights = [found.designs[k].found[second.name] for k in which]
            ax.scatter(
                [numbers[k] for k in which],
                heights,
                s=size,
                c=colour,
                marker=mark,
                label=name,
                zorder=3,
                edgecolors="white",
                linewidths=0.7,
            )
    ax.set_ylabel(_label(found, second.name))
    ax.set_title("designs")
    ax.legend(loc="best", frameon=True, framealpha=0.9, edgecolor="none")


def _label(found: Synthesis, name: str) -> str:
    goal = next(one.goal for one in found.problem.wants if one.name == name)
    side = {"most": ", more is better", "least": ", less is better"}.get(str(goal), "")
    return drawable(f"{name} [{found.units[name] or '1'}]{side}")


def _variables(ax: Axes, found: Synthesis, taken: int) -> None:
    """Where in its range every variable lies."""
    variables = found.problem.variables
    low, high = np.array([one.low for one in variables]), np.array([one.high for one in variables])
    rows = np.arange(len(variables))[::-1]
    marks: dict[int, tuple[int, str, str, float]] = dict.fromkeys(found.front, (46, BLUE, "o", 0.45))
    marks |= {0: (80, INK, "s", 1.0), taken: (240, ORANGE, "*", 1.0)}
    for k, (size, colour, mark, opacity) in marks.items():
        places = (found.designs[k].values - low) / (high - low)
        ax.scatter(places, rows, s=size, c=colour, marker=mark, alpha=opacity, zorder=2, edgecolors="white")
    units = {"": " (ratio)", "SI": ""}
    names = [
        f"{one.name}{units.get(one.unit, f' [{one.unit}]')}\n{one.low:.3g} ... {one.high:.3g}" for one in variables
    ]
    ax.set_yticks(rows, [drawable(name.replace("\n", "\x00")).replace("\\x00", "\n") for name in names])
    ax.set_xlim(-0.06, 1.06)
    ax.set_ylim(-0.6, len(variables) - 0.4)
    ax.set_xticks([0.0, 0.5, 1.0], ["least", "middle", "most"])
    ax.set_xlabel("place in the range [1]")
    ax.set_title("variables")


MOST_ACTUATORS = 12


def efforts_sheet(found: Synthesis, taken: int, spec: str) -> Drawing | None:
    """Efforts along a trajectory, of the robot as it is and of the design that is taken, an actuator a frame; None
    where one of them cannot follow it, or there are more than a dozen."""
    try:
        robots = [Subject(found.robot(number), found.problem.trajectories) for number in (0, taken)]
        efforts = [one.efforts(spec) for one in robots]
    except CutjointError:
        return None
    actuators = robots[0].chain.actuators
    if len(actuators) > MOST_ACTUATORS:
        return None
    times = [one.t for one in robots[0].along(spec)]
    columns = min(3, len(actuators))
    rows = -(-len(actuators) // columns)
    alike = len(robots[0].kinds) == 1

    def draw(drawn: Figure) -> None:
        frames = drawn.subplots(rows, columns, squeeze=False, sharex=True, sharey=alike)
        for k, ax in enumerate(frames.flat):
            if k >= len(actuators):
                ax.set_axis_off()
                continue
            ax.plot(times, efforts[0][:, k], color=INK, linestyle="--", label="as it is")
            ax.plot(times, efforts[1][:, k], color=ORANGE, label=f"design {taken}")
            ax.set_title(drawable(actuators[k].name))
            if k % columns == 0 or not alike:
                ax.set_ylabel(f"effort [{actuators[k].effort_unit}]")
            if k + columns >= len(actuators):
                ax.set_xlabel("time [s]")
        calm = int(np.abs(efforts).max(axis=(0, 1)).argmin())  # where there is most room
        frames.flat[calm].legend(loc="best", frameon=True, framealpha=0.9, edgecolor="none")

    return sheet(draw, f"{found.problem.robot.name}: effort along {spec}", (11.0, 1.0 + 2.8 * rows))


def _efforts(found: Synthesis, taken: int) -> list[Section]:
    """Efforts of old and new, of every trajectory that is named."""
    drawn = [(spec, efforts_sheet(found, taken, spec)) for spec in found.problem.trajectories]
    pictures = [
        Picture(one, f"Effort of every actuator along {spec}, of the robot as it is and of design {taken}.")
        for spec, one in drawn
        if one is not None
    ]
    return [Section("Effort", tuple(pictures), level=2)] if pictures else []


def synthesis_page(found: Synthesis, taken: int | None = None) -> str:
    """Old against new as one page of HTML.

    Raises:
        InputError, MissingPackageError: as of `synthesis_sheet`.
    """
    taken = found.best if taken is None else taken
    problem = found.problem
    reasons = [f"{count} designs do not do: {why}." for why, count in found.reasons()]
    wanted = [
        f"{one.name}: {one.goal or 'within bounds'}"
        + (f", at least {one.at_least:g}" if one.at_least is not None else "")
        + (f", at most {one.at_most:g}" if one.at_most is not None else "")
        + "."
        for one in problem.wants
    ]
    sections = [
        Section("Old against new", (found.against_old(taken),), level=2),
        Section(
            "The designs",
            (
                Picture(
                    synthesis_sheet(found, taken),
                    "Left: what the designs come to. Right: where in their ranges the variables of the front lie.",
                ),
                found.front_table(),
                *reasons,
            ),
            level=2,
        ),
        *_efforts(found, taken),
        Section("What was wanted", tuple(wanted), level=2),
    ]
    lead = f"{len(found.designs)} designs judged; design {taken} is taken. " + " ".join(f"{one}." for one in found.told)
    return page(f"{problem.robot.name}: synthesis", lead, sections)
