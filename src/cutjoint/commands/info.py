"""`cutjoint info`: what a robot is and how it can move at home."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Annotated

import typer

from cutjoint.commands import options
from cutjoint.commands.acting import physics_data, show_physics
from cutjoint.commands.at_home import find_modes, show_mobility, show_task, task_at_home
from cutjoint.commands.output import print_json, say, show
from cutjoint.commands.progress import progress
from cutjoint.tables import TextTable
from cutjoint.texts import Cell

if TYPE_CHECKING:
    from cutjoint.chain import ClosedChain, MobilityReport, Modes
    from cutjoint.description.model import Coupling
    from cutjoint.mechanism import Posture

MOST_MODES = 16


def command(
    robot: options.Robot,
    variant: options.Variant = None,
    home: options.Home = None,
    lenient: options.Lenient = False,
    modes: Annotated[bool, typer.Option("--modes/--no-modes", help="Search the working and assembly modes.")] = True,
    json: options.Json = False,
) -> None:
    """Mobility at home, task, masses, actuators, cut joints, joint physics, modes and source of a robot."""
    from cutjoint.robots import load

    chain = load(robot, variant, home, lenient=lenient)
    report = chain.mobility()
    working, assembly = None, None
    if modes:
        with progress(f"{chain.name}: searching modes"):
            working, assembly = find_modes(chain), find_modes(chain, assembly=True)
    if json:
        print_json(_data(chain, report, working, assembly))
    else:
        _show(chain, report, working, assembly)


def _data(
    chain: ClosedChain, report: MobilityReport, working: Modes | None, assembly: Modes | None
) -> dict[str, object]:
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
        "task": task_at_home(chain),
        "actuators": [
            {"name": actuator.name, "kind": actuator.kind, "unit": actuator.unit, "home": value}
            for actuator, value in zip(chain.actuators, chain.home.q, strict=True)
        ],
        "cuts": [
            {"name": c.name, "type": str(c.type), "links": [c.a.link, c.b.link]}
            | ({"length_m": c.length} if c.type.has_length else {})
            for c in robot.cuts
        ],
        "couplings": [_coupling_data(one) for one in robot.couplings],
        "physics": physics_data(robot),
        "links": [{"name": link.name, "mass_kg": link.inertial.mass if link.inertial else 0.0} for link in robot.links],
        "working_modes": None if working is None else [mode.q for mode in working],
        "assembly_modes": None if assembly is None else [_tool(chain, mode) for mode in assembly],
        "search": {"working_modes": _search(working), "assembly_modes": _search(assembly)},
    }


def _coupling_data(one: Coupling) -> dict[str, object]:
    """A coupling with the curve of every driver: coefficients of a polynomial, or the points of a spline."""
    from cutjoint.description.curves import Table

    drives = [
        {"driver": drive.driver}
        | (
            {"table": drive.curve.points}
            if isinstance(drive.curve, Table)
            else {"polynomial": drive.curve.pieces[0].coefficients}
        )
        for drive in one.drives
    ]
    return {"name": one.name, "joint": one.joint, "drives": drives, "offset": one.offset, "formula": one.formula}


def _search(modes: Modes | None) -> dict[str, object] | None:
    """How sure a list of modes is."""
    kept = ("held", "found", "starts", "closed", "loose", "unseen", "settled")
    return None if modes is None else {key: getattr(modes, key) for key in kept}


def _tool(chain: ClosedChain, at: Posture) -> list[list[float]] | None:
    """World placement (4, 4) of the tool's link."""
    tool = chain.description.tool
    return None if tool is None else chain.link_placements(at)[tool.link].tolist()


def _show(chain: ClosedChain, report: MobilityReport, working: Modes | None, assembly: Modes | None) -> None:
    robot = chain.description
    masses = [link.inertial.mass for link in robot.links if link.inertial]
    variant = f", variant {robot.variant_name}" if robot.variant_name else ""
    say(Cell(robot.title or robot.name, "bold"), variant)
    if robot.source:
        say(Cell(robot.source, "dim"))
    say(f"{len(robot.links)} links, {sum(masses):.6g} kg in all; gravity {_vector(robot.gravity)} m/s2")
    say()

    show_mobility(report)
    show_task(chain)
    motors = [
        (actuator.name, actuator.kind, f"{value:.6g}", actuator.unit)
        for actuator, value in zip(chain.actuators, chain.home.q, strict=True)
    ]
    show(TextTable("actuators", ("joint", "kind", "home", "unit"), motors, right=("home",)))

    cuts = [
        (
            cut.name,
            f"{cut.type} {cut.length:g} m" if cut.type.has_length else str(cut.type),
            str(cut.type.rows),
            f"{cut.a.link} - {cut.b.link}",
        )
        for cut in robot.cuts
    ]
    cuts += [(coupling.name, "coupling", "1", coupling.formula) for coupling in robot.couplings]
    if cuts:
        show(TextTable("cut joints", ("cut", "type", "rows", "between / formula"), cuts, right=("rows",)))

    show_physics(robot)

    if working is not None:
        what = f"working modes found: {len(working)} (the tool's {working.held} as at home)"
        _show_modes(chain, working, what, actuators=True)
    if assembly is not None:
        _show_modes(
            chain, assembly, f"assembly modes found: {len(assembly)} (the actuators as at home)", actuators=False
        )


def _show_modes(chain: ClosedChain, modes: Modes, title: str, actuators: bool) -> None:
    """A table of modes: what they differ in, the actuators or the other joints, and how often each was found."""
    motors = chain.actuators if actuators else ()
    names = ("mode", "found", *(f"{motor.name} [{motor.unit}]" for motor in motors), "other joints that differ")
    numbers = names[1:-1]
    rows: list[tuple[str, ...]] = []
    model = chain.model
    passive = [
        (name, int(model.idx_qs[joint]))
        for joint, name in enumerate(model.names)
        if joint > 0 and model.nqs[joint] == 1 and name not in chain.description.actuators
    ]
    for number, (mode, found) in enumerate(zip(modes[:MOST_MODES], modes.found, strict=False), start=1):
        moved = [
            f"{name} {mode.q_full[i]:+.3f}" for name, i in passive if abs(mode.q_full[i] - chain.home.q_full[i]) > 1e-6
        ]
        label = f"{number} (home)" if number == 1 else str(number)
        values = (f"{value:.6f}" for value in mode.q) if actuators else ()
        rows.append((label, f"{found} x", *values, ", ".join(moved)))
    more = f"and {len(modes) - MOST_MODES} more; --json lists all of them. " if len(modes) > MOST_MODES else ""
    sure = "each was found several times" if modes.settled else "the starts ran out before each was found several times"
    if not any(row[-1] for row in rows):
        names, rows = names[:-1], [row[:-1] for row in rows]
    note = f"{more}{modes.closed} of {modes.starts} starts came to a solution; {sure}"
    show(TextTable(title, names, rows, right=numbers, note=note))
    if modes.unseen > 0.0:
        say(Cell(f"about {100.0 * modes.unseen:.2g} % of further starts would find another", "caution"))


def _vector(values: Iterable[float]) -> str:
    return "(" + ", ".join(f"{value:g}" for value in values) + ")"
