"""`cutjoint info`: what a robot is and how it can move at home."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from cutjoint.commands.mobility import find_modes, show_mobility
from cutjoint.commands.output import console, print_json, table

if TYPE_CHECKING:
    from cutjoint.chain import ClosedChain, MobilityReport
    from cutjoint.mechanism import Posture

MOST_MODES = 16


def command(
    robot: Annotated[str, typer.Argument(metavar="ROBOT", help="Name of a robot (see `cutjoint list`) or a path.")],
    variant: Annotated[str | None, typer.Option(help="Named set of inertias, such as lumped.")] = None,
    home: Annotated[str | None, typer.Option(help="Named home posture; default the first.")] = None,
    modes: Annotated[bool, typer.Option("--modes/--no-modes", help="Search the working modes.")] = True,
    json: Annotated[bool, typer.Option("--json", help="Machine-readable output.")] = False,
) -> None:
    """Mobility at home, masses, actuators, cut joints, working modes and source of a robot."""
    from cutjoint.robots import load

    chain = load(robot, variant, home)
    report = chain.mobility()
    found = find_modes(chain) if modes else None
    if json:
        print_json(_data(chain, report, found))
    else:
        _show(chain, report, found)


def _data(chain: ClosedChain, report: MobilityReport, modes: tuple[Posture, ...] | None) -> dict[str, Any]:
    robot = chain.description
    return {
        "name": robot.name,
        "title": robot.title,
        "source": robot.source,
        "variant": robot.variant_name,
        "path": str(robot.path or ""),
        "mass_kg": sum(link.inertial.mass for link in robot.links if link.inertial),
        "gravity_m_s2": robot.gravity,
        "characteristic_length_m": chain.length,
        "mobility": {key: getattr(report, key) for key in report.__dataclass_fields__},
        "actuators": [
            {"name": actuator.name, "kind": actuator.kind, "unit": actuator.unit, "home": value}
            for actuator, value in zip(chain.actuators, chain.home.q, strict=True)
        ],
        "cuts": [{"name": c.name, "type": str(c.type), "links": [c.a.link, c.b.link]} for c in robot.cuts],
        "couplings": [
            {"name": c.name, "joint": c.joint, "driver": c.driver, "ratio": c.ratio} for c in robot.couplings
        ],
        "links": [{"name": link.name, "mass_kg": link.inertial.mass if link.inertial else 0.0} for link in robot.links],
        "working_modes": None if modes is None else [mode.q for mode in modes],
    }


def _show(chain: ClosedChain, report: MobilityReport, modes: tuple[Posture, ...] | None) -> None:
    robot, out = chain.description, console()
    masses = [link.inertial.mass for link in robot.links if link.inertial]
    out.print(
        f"[bold]{robot.title or robot.name}[/]" + (f", variant {robot.variant_name}" if robot.variant_name else "")
    )
    if robot.source:
        out.print(f"[dim]{robot.source}[/]")
    out.print(f"{len(robot.links)} links, {sum(masses):.6g} kg in all; gravity {_vector(robot.gravity)} m/s2")
    out.print()

    show_mobility(report)

    actuators = table("actuators", ("joint", "kind", "home", "unit"), right=("home",))
    for actuator, value in zip(chain.actuators, chain.home.q, strict=True):
        actuators.add_row(actuator.name, actuator.kind, f"{value:.6g}", actuator.unit)
    actuators.print()

    if robot.cuts or robot.couplings:
        cuts = table("cut joints", ("cut", "type", "rows", "between"), right=("rows",))
        for cut in robot.cuts:
            cuts.add_row(cut.name, str(cut.type), str(cut.type.rows), f"{cut.a.link} - {cut.b.link}")
        for ratio in robot.couplings:
            cuts.add_row(
                ratio.name, "coupling", "1", f"{ratio.joint} = {ratio.ratio:g} {ratio.driver} + {ratio.offset:g}"
            )
        cuts.print()

    if modes is not None:
        _show_modes(chain, modes)


def _show_modes(chain: ClosedChain, modes: tuple[Posture, ...]) -> None:
    names = (
        "mode",
        *(f"{actuator.name} [{actuator.unit}]" for actuator in chain.actuators),
        "other joints that differ",
    )
    shown = table(f"working modes found: {len(modes)} (the tool in the pose of home)", names, right=names[1:-1])
    model = chain.model
    passive = [
        (name, int(model.idx_qs[joint]))
        for joint, name in enumerate(model.names)
        if joint > 0 and model.nqs[joint] == 1 and name not in chain.description.actuators
    ]
    for number, mode in enumerate(modes[:MOST_MODES], start=1):
        moved = [
            f"{name} {mode.q_full[i]:+.3f}" for name, i in passive if abs(mode.q_full[i] - chain.home.q_full[i]) > 1e-6
        ]
        label = f"{number} (home)" if number == 1 else str(number)
        shown.add_row(label, *(f"{value:.6f}" for value in mode.q), f"[dim]{', '.join(moved)}[/]")
    shown.print()
    if len(modes) > MOST_MODES:
        console().print(f"and {len(modes) - MOST_MODES} more; --json lists all of them")


def _vector(values: Any) -> str:
    return "(" + ", ".join(f"{value:g}" for value in values) + ")"
