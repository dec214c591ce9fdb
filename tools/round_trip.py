"""Writes robots in every format that can be written, reads them back, and says what has changed.

    python tools/round_trip.py FOLDER               every robot of tools/published/corpus.toml that loads
    python tools/round_trip.py FOLDER --only cassie     those whose name or path has the word
    python tools/round_trip.py --random 100 [SEED]      random robots of tests/kit with everything that there is

What must hold: all values come back, and the accelerations at home; MuJoCo finds those of the chain in the MJCF, where
it has words for the robot; what cannot be written is refused by name.  Exit status 1 and a line per fault.
"""

from __future__ import annotations

import argparse
import dataclasses
import signal
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

import numpy as np

from cutjoint.arrays import Array
from cutjoint.chain import ClosedChain
from cutjoint.description import JointPhysics, Link, RobotDescription, load_description, read_checked
from cutjoint.description.formats import WRITERS, left_out, unsaid, write
from cutjoint.description.formats.common.unsaid import MESHES, drawn
from cutjoint.errors import CutjointError, InputError

TOOLS = Path(__file__).resolve().parent
sys.path[:0] = [str(TOOLS), str(TOOLS.parent / "tests")]

from corpus import LIST, entries  # noqa: E402
from published.peer import compare, without_friction  # noqa: E402

DESCRIBED = import_module("kit.described")

SECONDS = 60
"""A robot gets, all in all."""
SHOWN = 8
"""Faults of a robot that are told."""
SAME = 1e-12
"""Relative difference of accelerations that is rounding in a robot that is well conditioned."""
SHAKEN, TIMES = 4e-16, 30.0
"""How far all frames are turned and moved, and how much more than what comes of that the difference may be."""
ENGINE = 1e-8
"""Relative difference from MuJoCo's accelerations that is of its own J_dot v."""


def published(folder: Path, word: str) -> Iterator[tuple[str, RobotDescription]]:
    """Those of the list that load."""
    for entry in entries(LIST.read_text(encoding="utf-8")):
        if word in f"{entry.name} {entry.place}".lower() and (folder / entry.place).is_file():
            robot = read_checked(folder / entry.place, lenient=True).description
            if robot is not None:
                yield f"{entry.address}: {entry.path}", robot


def made_up(count: int, seed: int) -> Iterator[tuple[str, RobotDescription]]:
    """Random robots: trees with random cuts and curves, and machines; half of them with physics and bushings."""
    curved, physics, robots = (import_module(f"kit.{name}") for name in ("curved", "physics", "random_robots"))
    makers = list(curved.CURVED.values())
    for number in range(seed, seed + count):
        rng = np.random.default_rng([number, 71])
        with tempfile.TemporaryDirectory() as place:
            folder = Path(place)
            if number % 3 == 0:
                plan = makers[number // 3 % len(makers)](rng).plan
            else:
                size = int(rng.integers(1, 9)), int(rng.integers(0, 5))
                plan = robots.random_robot(rng, *size, folder / "tried", curved=bool(number % 3 == 1))
            robot = load_description(plan.write(folder / "robot"))
        if rng.integers(2):
            robot = physics.with_any_cuts(physics.with_any_physics(robot, rng), rng)
        yield f"random {number}", robot


def accelerations(chain: ClosedChain, seed: int = 0) -> Array | None:
    """Of all joints at home at a random velocity and effort, shape (nv,); None where the chain has none."""
    rng = np.random.default_rng(seed)
    _, v = chain.project(chain.home.q_full, rng.uniform(-1.0, 1.0, chain.nv))
    try:
        return chain.full_acceleration(chain.home.q_full, v, rng.uniform(-1.0, 1.0, chain.nv))
    except CutjointError:
        return None


def beyond(a: Array, b: Array) -> float:
    """Relative difference of accelerations."""
    return float(np.abs(a - b).max(initial=0.0) / max(1.0, np.abs(a).max(initial=0.0)))


def shaken(robot: RobotDescription, seed: int) -> RobotDescription:
    """The robot with its joints a few units of rounding elsewhere."""
    rng = np.random.default_rng(seed)

    def moved(placement: Array) -> Array:
        turned = placement @ rotation(*rng.normal(size=3))
        turned[:3, 3] += SHAKEN * rng.normal(size=3) * np.abs(placement[:3, 3]).max()
        return turned

    def rotation(x: float, y: float, z: float) -> Array:
        small = np.eye(4)
        small[:3, :3] += SHAKEN * np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        return small

    joints = tuple(dataclasses.replace(one, placement=moved(one.placement)) for one in robot.joints)
    return dataclasses.replace(robot, joints=joints)


def rounding(robot: RobotDescription, before: Array | None) -> float:
    """How much the accelerations change where the last digits of the robot do."""
    if before is None:
        return 0.0
    found = [accelerations(ClosedChain(shaken(robot, seed))) for seed in range(3)]
    return max(np.inf if one is None else beyond(before, one) for one in found)


def plain(robot: RobotDescription) -> RobotDescription:
    """The robot without what MJCF has no word for: stops, smooth friction, and what cuts do by themselves."""
    robot = without_friction(robot)
    cuts = tuple(dataclasses.replace(one, physics=JointPhysics()) for one in robot.closing)
    links = tuple(
        dataclasses.replace(one, inertial=None) if one.inertial is not None and one.inertial.mass == 0.0 else one
        for one in robot.links
    )  # fmt: skip
    return dataclasses.replace(robot, links=links, cuts=cuts)


def drawable(link: Link) -> Link:
    """The link without the shapes that MuJoCo cannot draw."""
    kept = [tuple(one for one in shapes if drawn(one, MESHES)) for shapes in (link.visuals, link.collisions)]
    return dataclasses.replace(link, visuals=kept[0], collisions=kept[1])


def tripped(robot: RobotDescription, form: str, folder: Path, before: Array | None) -> tuple[str, list[str]]:
    """How one robot fares in one format, in a word, and its faults."""
    try:
        path = write(robot, folder / DESCRIBED.FILES[form], to=form)[0]
    except InputError as error:
        return "refused", [] if "cannot say" in str(error) or "MJCF calls" in str(error) else [str(error)]
    back = read_checked(path)
    lenient = back.description is None
    if lenient:
        back = read_checked(path, lenient=True)
    if back.description is None:
        return "not read", [str(one) for one in back.problems if one.severity == "error"][:3]
    wanted = dataclasses.replace(robot, variant_name="")
    if left_out(robot, form):
        wanted = dataclasses.replace(wanted, links=tuple(map(drawable, wanted.links)))
    faults = DESCRIBED.differences(wanted, back.description)
    if before is not None:
        chain = ClosedChain(back.description)
        after = accelerations(chain)
        off = np.inf if after is None else beyond(before, after)
        if off > SAME and off > TIMES * rounding(robot, before):
            faults.append(f"accelerations: {off:.1e}")
    return "lenient" if lenient else "same" if not faults else "changed", faults


def engine(robot: RobotDescription, folder: Path) -> tuple[str, list[str]]:
    """What MuJoCo makes of the MJCF."""
    if any("inertia" in one for one in unsaid(robot, "mjcf")):
        return "MuJoCo evens out inertias", []
    robot = plain(robot)
    try:
        path = write(robot, folder / "engine.xml", to="mjcf")[0]
        chain = ClosedChain(robot)
        found = compare(path, chain)
    except InputError:
        return "refused", []
    except CutjointError as error:
        return f"no {type(error).__name__}", []
    except np.linalg.LinAlgError as error:
        return f"{error}", []
    except ValueError as error:
        return "MuJoCo refuses", [f"MuJoCo: {' '.join(str(error).split())[:200]}"]
    if found.unmapped:
        return "unmapped", []
    if any(chain.mobility().dropped_rows):
        return "closes only up to rounding", []
    sizes = {
        "rest": found.rest,
        "moving": found.moving,
        "pose": found.pose,
        "gap": found.gap - chain.gap(chain.home)[0],
    }
    bound = ENGINE + 10.0 * TIMES * rounding(robot, accelerations(chain))
    faults = [f"MuJoCo {what}: {value:.1e}" for what, value in sizes.items() if not value <= bound]
    return "MuJoCo differs" if faults else "MuJoCo agrees", faults


def tried(name: str, robot: RobotDescription, counts: Counter[str]) -> list[str]:
    """All formats for one robot; the faults."""
    faults = []
    with tempfile.TemporaryDirectory() as place:
        try:
            before = accelerations(ClosedChain(robot))
        except CutjointError:
            before = None
        for form in WRITERS:
            what, found = tripped(robot, form, Path(place) / form, before)
            counts[f"{form}: {what}"] += 1
            faults += [f"{name}, {form}: {one}" for one in found]
        if before is not None:
            what, found = engine(robot, Path(place))
            counts[what] += 1
            faults += [f"{name}: {one}" for one in found]
    return faults


def late(*_: object) -> None:
    """A robot has had its time."""
    raise TimeoutError


def main(arguments: list[str] | None = None) -> int:
    """Entry point."""
    parser = argparse.ArgumentParser(prog="round_trip", description=__doc__)
    parser.add_argument("folder", type=Path, nargs="?")
    parser.add_argument("--only", default="")
    parser.add_argument("--random", type=int, nargs="+", default=[])
    chosen = parser.parse_args(arguments)
    robots = made_up(*[*chosen.random, 0][:2]) if chosen.random else published(chosen.folder, chosen.only.lower())
    counts, bad = Counter[str](), 0
    signal.signal(signal.SIGALRM, late)
    for name, robot in robots:
        counts["robots"] += 1
        signal.alarm(SECONDS)
        try:
            faults = tried(name, robot, counts)
        except TimeoutError:
            faults = [f"{name}: more than {SECONDS} s"]
        signal.alarm(0)
        bad += len(faults)
        for one in faults[:SHOWN]:
            print(one[:400], flush=True)
        if len(faults) > SHOWN:
            print(f"{name}: and {len(faults) - SHOWN} more")
    print(", ".join(f"{count} {what}" for what, count in sorted(counts.items())), f"{bad} faults", sep="; ")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
