"""What holds for every command: exit status, what goes to stdout and stderr, how broad lines are, for usual, odd and
wrong arguments at 80 columns, piped, without colour.

A new command needs rows here.
"""

from __future__ import annotations

import fcntl
import gc
import json
import os
import pty
import re
import struct
import subprocess
import sys
import termios
import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
import typer.main
from kit.regions import region

from cutjoint.cli import COMMANDS, app, main
from cutjoint.commands import progress
from cutjoint.control import law
from cutjoint.description import catalogue
from cutjoint.robots import load
from cutjoint.simulation import ConstrainedPlant, run, save
from cutjoint.texts import broad
from cutjoint.workspace import save as save_workspace

WIDTH = 80
HOSTILE = ("stewert", "a\nb", "\x1b[31mred\x1b[0m", "[bold]x[/]", "漢字" * 50, "x" * 1_000_000, "\udcff", "-" * 3)
# the folder of the test; what is in it is made by `folder`
HERE = "{here}"
STUDY = """
robot = "cpm"
model = "published"
runs = 40
duration = 0.02
controller = { name = "pd" }
vary = [{ path = "payload", uniform = [0.0, 1.0] }, { path = "gains.kp", relative = 0.1 }]
"""
HELPS = typer.main.get_command(app).commands  # type: ignore[attr-defined]
"""Command -> its arguments and options."""
ODD = "[red]漢 crank[/]"

USUAL: dict[str, list[tuple[str, int]]] = {
    "new": [("crank1 --crank 0.05", 0), ("robot2 -t blank --json", 0)],
    "cut": [("fourbar", 0), (f"fourbar --json -o {HERE}/cut", 0), (f"{HERE}/open.urdf", 1)],
    "plot": [("run.npz -o run.html", 0)],
    "report": [],
    "states": [("run.npz -o run.jsonl", 0)],
    "list": [("", 0), ("--json", 0)],
    "info": [("underactuated --no-modes", 0), ("redundant --no-modes --json", 0)],
    "check": [("redundant", 0), (f"{HERE}/wrong.urdf", 1), (f"{HERE}/wrong.urdf --json", 1), ("nothing", 1)],
    "crosscheck": [("cpm --samples 1", 0), ("omega3 --samples 1 --json -", 0)],
    "simulate": [
        ("fourbar --free --duration 0.01 --plant chain", 0),
        ("fourbar --free --duration 0.01 --plant chain --json", 0),
    ],
    "size": [(f"fourbar --motors {HERE}/motors.csv --json", 1)],
    "reproduce": [],
    "synthesise": [(f"{HERE}/order.toml --designs 2", 0), (f"{HERE}/order.toml --designs 2 --json", 0)],
    "view": [(f"fourbar --html {HERE}/page.html", 0)],
    "workspace": [
        ("fivebar --cells 6 --map effort", 0),
        ("fivebar --cells 4 --axes x --json", 0),
        (f"fivebar --cells 8 --save {HERE}/space.npz --largest box -o {HERE}/space.svg", 0),
        ("fivebar --certify x=-0.6..0.6 --json", 1),
    ],
    "play": [],
    "study": [],
    "export": [(f"fourbar -o {HERE}/fourbar.xml", 0), (f"cpm --to loops -o {HERE}/folder", 0)],
    "compile": [("fourbar --functions tool --no-cache", 0)],
    "stiffness": [
        ("fourbar --actuator 1e3 --joint *.x=1e6 --load tool:0,0,-10 --load coupler_link:1,0,0", 0),
        ("fourbar --actuator 1e3 --json", 0),
    ],
    "accuracy": [
        ("fourbar -t joints.*.origin.x=0.1mm --backlash 1arcmin --warm 10 --material steel --samples 100", 0),
        ("fourbar -t tool.x=1e-4 --samples 0 --json", 0),
    ],
    "tune": [("fourbar --by poles --duration 0.1 --json", 0)],
    "retime": [],
}
SLOW: dict[str, list[tuple[str, int]]] = {
    "plot": [
        ("run.npz", 0),
        ("run.npz --what reactions,joints,gap --from 0.002 --to 0.009 -o some.png", 0),
        ("run.npz other.npz -o two.svg", 0),
    ],
    "report": [("run.npz", 0), ("run.npz other.npz -o two.html --robot fourbar", 0)],
    "states": [("run.npz --out bag --robot fourbar", 0)],
    "cut": [("stewart", 0), ("stewart --cut leg1_tilt --json", 0), (f"{HERE}/hostile -o {HERE}/cut", 0)],
    "new": [(f"{one}_1 -t {one}", 0) for one in ("fivebar", "delta", "stewart", "leg")],
    "study": [
        ("study.toml", 0),
        ("study.toml --json -o of", 0),
        ("study.toml --dry-run --json", 0),
        ("study.toml --dry-run --no-report", 0),
    ],
    "list": [("--examples", 0)],
    "info": [
        *((one, 0) for one in ("omega3", "stewart", "cpm", "redundant", "talos", "stewart --json")),
        (f"{HERE}/hostile", 0),
        ("cpm --variant lumped --no-modes", 0),
    ],
    "check": [("omega3", 0), ("talos", 0), ("talos --json", 0), ("fourbar --json", 0), (f"{HERE}/hostile", 0)],
    "crosscheck": [
        ("all --samples 50", 0),
        ("all --samples 50 --engine yourdfpy", 0),
        ("cpm --variant distributed", 0),
        ("cpm_rotary --samples 1 --variant distributed --engine mujoco", 0),
    ],
    "simulate": [
        (f"omega3 --duration 0.05 --save {HERE}/run.npz --reactions {HERE}/run.csv", 0),
        ("cpm --duration 0.2 --rate 100 --noise 1e-5 --controller pd-gravity", 0),
    ],
    "size": [
        ("fourbar", 0),
        (f"omega3 --trajectory about-home --bearings -o {HERE}/size.png --csv {HERE}/size.csv --payload 0.1", 0),
        (f"cpm --motors {HERE}/motors.csv --pitch 0.01 --gear 1,3,10 -o {HERE}/size.svg", 1),
        ("fivebar --trajectory about-home --trajectory hold --load tool:0,0,-5 --bearings", 0),
        ("fivebar --workspace --tool-speed 1 --tool-acceleration 5 --samples 10 --json", 0),
        (f"{HERE}/hostile --trajectory about-home --bearings", 0),
    ],
    "synthesise": [(f"{HERE}/order.toml --designs 12 -o better", 0), (f"{HERE}/never.toml --designs 3", 1)],
    "play": [(f"fivebar --trajectory hold --html {HERE}/page.html", 0)],
    "view": [(f"fivebar --workspace space.npz --map condition --html {HERE}/page.html", 0)],
    "workspace": [
        (f"fivebar --cells 20 --map condition --largest box,sphere --margin 0.01 --save {HERE}/x.vti --json", 0),
        (f"omega3 --cells 12 --surface {HERE}/x.stl --largest cylinder -o {HERE}/x.png --through z=0.01", 0),
        ("omega3 --cells 10 --map condition,bearing", 0),
        ("fivebar --cells 10 --modes all --json", 0),
        ("stewart --dextrous 0.1 --cells 8 --hold rz=0", 0),
        ("cpm --published --assembly any", 0),
        ("redundant --cells 4", 0),
        (f"fivebar --certify x=0..0.02,z=0.29..0.31 --certificate {HERE}/box.png", 0),
        ("fivebar --certify x=-0.6..0.6", 1),
    ],
    "export": [(f"stewart --to urdf -o {HERE}/stewart.urdf", 0)],
    "tune": [
        ("cpm --plant inferred --controller pd-gravity", 0),
        (f"fivebar --by poles --rate 500 --delay 2e-3 --payload 0 --payload 0.1 -o {HERE}/bode.png", 0),
        ("fivebar --by poles --bandwidth 200 --rate 100", 1),
        ("fourbar --by poles --duration 0.1 --limit 1e-6 --json", 1),
        ("fourbar --by poles --duration 0.1 --rate 500 --noise 1e-5 --draws 2", 0),
        ("omega3 --by optimise --controller pid --trials 20 --rate 1000 --noise 1e-5 --json", 0),
        (f"{HERE}/hostile --by poles", 0),
    ],
    "compile": [
        ("omega3 --functions tool,step --no-cache --measure", 0),
        ("fourbar --functions tool --no-cache --json", 0),
    ],
    "stiffness": [
        (f"{HERE}/hostile --actuator 1e3 --joint *=1e6 -o {HERE}/stiff.png", 0),
        (f"cpm --actuator 1e6 --trajectory paper --samples 5 -o {HERE}/stiff.svg", 0),
        ("omega3 --springs stiff.toml --preload tool:0,0,-5 --at 0.1,0.1,0.2 --json", 0),
        ("cpm --actuator 1e6 --trajectory hold --samples 2 --json", 0),
    ],
    "accuracy": [
        (f"{HERE}/hostile -t cuts.*.a.*[xyz]=0.1mm -o {HERE}/off.png --springs bearings.toml", 0),
        ("omega3 --errors off.toml --reach 0.11,0.01,0 --json", 0),
        (f"fivebar -t joints.*.origin.x=1e-4 --samples 1000 --exact -o {HERE}/off.svg", 0),
    ],
    "retime": [
        (f"fourbar --acceleration 9 --effort inf --save {HERE}/quick.csv -o {HERE}/quick.svg", 0),
        (f"{HERE}/hostile --effort inf --acceleration 3 --json", 0),
        (f"fourbar --to crank=0.5 --to home --acceleration 9 --jerk 90 --save {HERE}/go.csv -o {HERE}/go.svg", 0),
        ("fivebar --to left_shoulder=2.0 --to x=0.05 --acceleration 50 --jerk 2000 --payload 0.1 --json", 0),
    ],
}
WRONG: dict[str, list[str]] = {
    "new": [
        "",
        "cpm",
        "1abc",
        "name --crank nan",
        "name --crank long",
        "name --crank 100",
        "name -t delta --crank 1",
        "name -t none",
        "name --density 0",
        f"name -o {HERE}/hostile",
        f"name -o {HERE}/text.npz",
        "[red]x[/]",
    ],
    "cut": [
        "",
        "none",
        f"{HERE}",
        f"{HERE}/wrong.urdf",
        "fourbar --cut none",
        "fourbar --type revolute",
        "fourbar --type coupler_to_rocker=none",
        f"fourbar -o {HERE}/hostile",
    ],
    "plot": [
        "",
        ".",
        "run.csv",
        "no.npz",
        "text.npz",
        "run.npz run.npz",
        "run.npz -o run.txt",
        f"run.npz -o {HERE}/no/run.svg",
        "run.npz --what non",
        "run.npz --what orientation",
        "run.npz --from nan",
        "run.npz --from 2 -o run.html",
        "run.npz --from 0.009 --to 0.001 -o run.html",
        "run.npz --robot cpm -o run.html",
        "run.npz --variant lumped",
    ],
    "report": ["", ".", "no.npz", "text.npz", "run.npz -o run.txt", f"run.npz -o {HERE}", "run.npz --robot cpm"],
    "states": [
        "",
        "run.npz",
        ". -o x.jsonl",
        "text.npz -o x.jsonl",
        "run.npz -o x.txt",
        f"run.npz -o {HERE}/hostile",
        "run.npz -o x.jsonl --robot cpm",
    ],
    "study": [
        "",
        ".",
        "no.toml",
        "text.npz",
        "wrong.toml",
        "study.toml --scheduler here",
        "study.toml --workers 0",
        "study.toml --out",
        "study.toml --dryrun",
    ],
    "list": ["omega3", "--exmaples", "--json=1"],
    "info": [
        "",
        "cpm --variant none",
        "cpm --home none",
        f"{HERE}",
        f"{HERE}/no.urdf",
        f"{HERE}/wrong.urdf",
        "cpm --mods",
    ],
    "check": ["", "cpm cpm", "--lenint cpm"],
    "crosscheck": ["stewart", "cpm --samples 0", "cpm --samples many", "cpm --seed -1", "cpm --engine none"],
    "simulate": [
        "fourbar --controller none2",
        "cpm --controller pdd",
        "cpm --trajectory circel",
        "cpm --load tool",
        "cpm --step -1",
        "cpm --plant none",
        "cpm --save run.txt",
        "cpm --delay 0.1",
        f"cpm --free --save {HERE}/no/run.npz",
        f"cpm --efforts {HERE}/no.csv",
    ],
    "size": [
        "",
        "none",
        "redundant",
        "fourbar --trajectory none",
        "fourbar --trajectory hold --trajectory hold",
        "fourbar --gear 3",
        f"fourbar --motors {HERE}/motors.csv --gear 0",
        f"fourbar --motors {HERE}/motors.csv --efficiency 2",
        f"fourbar --motors {HERE}/wrong.csv",
        f"fourbar --motors {HERE}/no.csv",
        f"cpm --motors {HERE}/motors.csv",
        "fourbar --workspace",
        "fourbar --tool-speed 1",
        "fourbar -o size.pdf",
        f"fourbar -o {HERE}/no/size.png",
        "fourbar --csv size.txt",
        "fourbar --load tool",
        "fourbar --payload -1",
    ],
    "reproduce": ["delta", f"cpm --output {HERE}/no/page.html", f"cpm --output {HERE}"],
    "synthesise": [
        "",
        f"{HERE}",
        f"{HERE}/no.toml",
        f"{HERE}/text.npz",
        f"{HERE}/wrong.toml",
        f"{HERE}/order.toml --designs 1",
        f"{HERE}/order.toml -o {HERE}/hostile",
        f"{HERE}/order.toml -o {HERE}/no/folder",
    ],
    "view": [
        "",
        "cpm --port -1",
        "cpm --size 3 --html x.html",
        f"cpm --html {HERE}/no/page.html",
        "cpm --workspace run.npz --html x.html",
        "cpm --workspace space.npz --html x.html",
        "fivebar --workspace space.npz --map none --html x.html",
        "cpm --map condition --html x.html",
    ],
    "workspace": [
        "",
        "fivebar -o x.gif",
        f"fivebar --save {HERE}/no/x.npz",
        "fivebar --save x.txt",
        "fivebar --surface x.off",
        "fivebar --largest cone",
        "fivebar --largest box --margin -1",
        "fivebar --margin 1",
        "fivebar --through z=1",
        "fivebar --modes all --save x.npz",
        "fivebar --certify x",
        "fivebar --certify x=1..0",
        "fivebar --certify y=0..1",
        "fivebar --certify x=0..nan",
        "fivebar --certify x=0..0.1,x=0..0.1",
        "fivebar --certify x=0..0.1 --cells 4",
        "fivebar --certify x=0..0.1 --seconds 0",
        "fivebar --certify x=0..0.1 --most 0",
        "fivebar --certify x=0..0.1 --certificate box.txt",
        "fivebar --certificate box.png",
        "redundant --certify x=0..0.1",
        "none",
        "fivebar --axes q",
        "fivebar --cells 0",
        "fivebar --cells 50000",
        "fivebar --hold x",
        "fivebar --hold y=0",
        "fivebar --range x=1",
        "fivebar --range x=0.2:0.1",
        "fivebar --map condtion",
        "fivebar --collisions",
        "fivebar --dextrous 0.1",
        "fivebar --dextrous 0.1 --reachable 0.1",
        "fivebar --modes all --range x=0:1",
        "fivebar --published",
    ],
    "play": ["", "cpm", "none.npz", f"{HERE}/text.npz", f"cpm --trajectory hold --html {HERE}/no/page.html"],
    "export": ["cpm --to none", f"cpm -o {HERE}"],
    "tune": [
        "",
        "cpm --controller none",
        "cpm --controller pdd",
        "cpm --error -1",
        "cpm --controller pd-gravity --limit 1",
        "cpm --bandwidth 20",
        "cpm --by poles --error 1e-3",
        "cpm --by poles --bandwidth 0",
        "cpm --by poles --damping nan",
        "cpm --by optimise --trials 2",
        "cpm --by poles --draws 2",
        "cpm --by magic",
        "cpm --payload -1",
        "cpm --after 99",
        "cpm --delay 1e-3",
        "cpm --gain kp=1",
        "cpm --plant none",
        "fivebar --plant inferred",
        "fivebar --controller pid --error 1e-3 --limit 10",
        "fivebar --error 1e-3",
        "underactuated",
        "cpm -o bode.txt",
        f"cpm -o {HERE}/no/bode.png",
    ],
    "retime": [
        "",
        "fourbar --effort 0",
        "fourbar --effort nan",
        "fourbar --effort 1,2,3",
        "fourbar --effort crnk=3",
        "fourbar --effort crank=x",
        "fourbar --effort crank=1,crank=2",
        "fourbar --speed fast",
        "fourbar --effort inf",
        "fourbar --effort 9 --tool-speed 0",
        "fourbar --effort 9 --ramp 0",
        "fourbar --to home --acceleration 9 --jerk 90",
        "fourbar --to crank=0.5 --jerk 90 --effort 9",
        "fourbar --to crank=0.5 --acceleration 9",
        "fourbar --to crnk=0.5 --acceleration 9 --jerk 90",
        "fourbar --to crank=x --acceleration 9 --jerk 90",
        "fourbar --to 0.5,0.5 --acceleration 9 --jerk 90",
        "fourbar --to nan --acceleration 9 --jerk 90",
        "fourbar --to rz=0.5 --acceleration 9 --jerk 90",
        "fourbar --to crank=0.5,x=1 --acceleration 9 --jerk 90",
        "fourbar --to crank=0.5 --acceleration 9 --jerk 90 --trajectory circle",
        "fourbar --to crank=0.5 --acceleration 9 --jerk 90 --round",
        "fourbar --to crank=0.5 --acceleration 9 --jerk 90 --effort 1e-6",
        "fourbar --effort 9 --payload -1",
        "fourbar --effort 9 --load tool",
        "fourbar --effort 9 --trajectory circel",
        "fourbar --effort 9 --variant none",
        "fourbar --effort 9 --save run.npz",
        f"fourbar --effort 9 --save {HERE}/no/run.csv",
        "fourbar --effort 9 -o run.txt",
        "redundant --effort 9",
    ],
    "compile": ["fourbar --functions none", "fourbar --arguments none", "cpm --variant none"],
    "stiffness": [
        "",
        "fourbar",
        "fourbar --actuator",
        "fourbar --actuator much",
        "fourbar --actuator 1N/m",
        "fourbar --actuator none=1",
        "fourbar --joint crank.rz=1e3",
        "fourbar --rod base=1",
        "fourbar --actuator 1e3 --load crnk_link:0,0,1",
        "fourbar --actuator 1e3 --at 1,2",
        "fourbar --actuator 1e3 --at 1 --reach 0,0,0",
        "fourbar --actuator 1e3 --trajectory hold --at 1",
        "fourbar --actuator 1e3 -o x.txt",
        f"fourbar --springs {HERE}/text.npz",
        "fourbar --springs none.toml",
        "underactuated --actuator 1e3",
    ],
    "accuracy": [
        "",
        "fourbar",
        "fourbar -t tool.x",
        "fourbar -t tool.x=long",
        "fourbar -t tool.x=1deg",
        "fourbar -t tool.w=1mm",
        "fourbar -t links.crank_link.mass=1",
        "fourbar -t tool.x=1mm -t tool.x=2mm",
        "fourbar --warm 10",
        "fourbar --warm 10 --material wood",
        "fourbar --backlash none=1",
        "fourbar --backlash 1mm",
        "fourbar --backlash 1arcmin -o x.png",
        "fourbar -t tool.x=1mm -o x.txt",
        "fourbar -t tool.x=1mm --samples -1",
        "fourbar --errors none.toml",
        "omega3 -t cuts.ball1a.b.z=0.1mm --exact",
        "underactuated -t tool.x=1mm",
    ],
}
TAKES_A_ROBOT = (
    "info",
    "crosscheck",
    "simulate",
    "size",
    "reproduce",
    "view",
    "play",
    "export",
    "compile",
    "workspace",
    "stiffness",
    "accuracy",
    "tune",
    "retime",
)


@dataclass
class Ended:
    """How a command ended."""

    status: int
    out: str
    err: str


Cutjoint = Callable[..., Ended]


@pytest.fixture(scope="module")
def result() -> bytes:
    """A file of a short run."""
    robot = load("fourbar")
    found = run(ConstrainedPlant(robot), law("none", robot, {}), duration=0.01)
    with TemporaryDirectory() as place:
        return save(found, Path(place) / "run.npz").read_bytes()


@pytest.fixture
def folder(tmp_path: Path, result: bytes) -> Path:
    """Files of robots, of runs and of nonsense."""
    source, hostile = catalogue.path("fourbar").parent, tmp_path / "hostile"
    hostile.mkdir()
    for file in source.iterdir():
        if file.suffix in (".urdf", ".toml"):
            text = file.read_text(encoding="utf-8").replace('"crank"', f'"{ODD}"')
            text = text.replace("{ crank =", f'{{ "{ODD}" =')
            (hostile / file.name).write_text(text, encoding="utf-8")
    (tmp_path / "wrong.urdf").write_text("<robot name='x'><link name='[b]a&#10;&#9;'/><link nme='b'/></robot>")
    (tmp_path / "open.urdf").write_text("<robot name='x'><link name='a'/></robot>")
    save_workspace(
        region(lambda x, z: x**2 + z**2 < 1.0, 6, axes=2, names=("x", "z"), robot="fivebar"), tmp_path / "space.npz"
    )
    for name in ("run", "other"):
        (tmp_path / f"{name}.npz").write_bytes(result)
    (tmp_path / "text.npz").write_text("this is no result")
    headings = "name,rated_torque [N m],peak_torque [N m],max_speed [rpm],rotor_inertia [kg cm2]"
    (tmp_path / "motors.csv").write_text(f"{headings}\n{ODD},1e-6,2e-6,3000,0.1\n")
    (tmp_path / "wrong.csv").write_text(f"{headings.replace('[rpm]', '[kg]')}\na,1,2,3000,0.1\n")
    order = '[[vary]]\npath = "links.crank_link.mass"\nrange = [0.1, 0.9]\n[[want]]\nquantity = "mass"\n'
    (tmp_path / "order.toml").write_text(f'robot = "fourbar"\n{order}')
    (tmp_path / "never.toml").write_text(f'robot = "fourbar"\n{order}at_most = 0.01\n')
    (tmp_path / "wrong.toml").write_text(f'robot = "fourbar"\ndesings = 3\n{order}')
    (tmp_path / "stiff.toml").write_text("[actuators]\n'*' = '3e4 N m/rad'\n[rods]\n'rod*_link' = '20 N/um'\n")
    (tmp_path / "bearings.toml").write_text("[joints]\n'*' = 1e6\n")
    (tmp_path / "off.toml").write_text("[tolerances]\n'cuts.ball*.b.z' = '0.1 mm'\n[backlash]\n'*' = '1 arcmin'\n")
    (tmp_path / "study.toml").write_text(STUDY)
    (tmp_path / "wrong.toml").write_text(STUDY.replace("runs", "rnus"))
    return tmp_path


@pytest.fixture
def cutjoint(folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Iterator[Cutjoint]:
    """Runs the command line in this process, as it is piped."""
    monkeypatch.setattr("cutjoint.interrupts.watch", lambda: None)  # this process lives on
    monkeypatch.setattr(warnings, "showwarning", warnings.showwarning)
    monkeypatch.setattr("cutjoint.viewer.server.bridge.Bridge.wait", lambda _: pytest.fail("a page is served"))
    monkeypatch.chdir(folder)
    for name, value in {"COLUMNS": str(WIDTH), "NO_COLOR": "1", "TERM": "dumb"}.items():
        monkeypatch.setenv(name, value)
    thresholds = gc.get_threshold()

    def run(*words: str) -> Ended:
        monkeypatch.setattr(sys, "argv", ["cutjoint", *words])
        with pytest.raises(SystemExit) as ended:
            main()
        return Ended(int(ended.value.code or 0), *capsys.readouterr())

    yield run
    gc.set_threshold(*thresholds)


def words_of(command: str, arguments: str, folder: Path) -> list[str]:
    return [command, *(word.replace(HERE, str(folder)) for word in arguments.split())]


def too_broad(text: str) -> list[str]:
    """Lines that are broader than there is room, but for single words, such as paths, that cannot be broken."""
    return [line for line in text.splitlines() if broad(line) > WIDTH and len(line.split()) > 1]


def judge(ended: Ended, status: int, *, as_json: bool) -> None:
    """What holds however a command ends."""
    assert ended.status == status, ended.err[-500:]
    assert "Traceback" not in ended.err
    for text in (ended.out, ended.err):
        assert all(one.isprintable() or one == "\n" for one in text)
    if as_json:
        assert ended.out[0] in "{["
        json.loads(ended.out, parse_constant=lambda text: pytest.fail(f"{text} is no JSON"))
    else:
        assert too_broad(ended.out) == []
        assert [line for line in ended.out.splitlines() if line != line.rstrip()] == []
    if status == 2:
        assert ended.out == ""
        assert "Error: " in ended.err.splitlines()[0]
        assert len(ended.err) < 3000


def rows(table: dict[str, list[tuple[str, int]]]) -> list[tuple[str, str, int]]:
    return [(command, arguments, status) for command, found in table.items() for arguments, status in found]


def wrong(table: dict[str, list[str]]) -> list[tuple[str, str, int]]:
    return rows({command: [(one, 2) for one in found] for command, found in table.items()})


def test_every_command_has_rows() -> None:
    for table in (USUAL, WRONG):
        assert set(table) == set(COMMANDS), "a new command needs usual and wrong arguments here"
    assert all(WRONG.values())


@pytest.mark.parametrize(("command", "arguments", "status"), rows(USUAL) + wrong(WRONG))
def test_commands_keep_the_contract(
    command: str, arguments: str, status: int, cutjoint: Cutjoint, folder: Path
) -> None:
    judge(cutjoint(*words_of(command, arguments, folder)), status, as_json=status < 2 and "--json" in arguments)


@pytest.mark.slow
@pytest.mark.parametrize(("command", "arguments", "status"), rows(SLOW))
def test_large_robots_and_long_runs_keep_the_contract(
    command: str, arguments: str, status: int, cutjoint: Cutjoint, folder: Path
) -> None:
    if "talos" in arguments and not catalogue.example_names():
        pytest.skip("example-robot-data is not installed")
    judge(cutjoint(*words_of(command, arguments, folder)), status, as_json="--json" in arguments)


@pytest.mark.parametrize(
    "command", [one if one == "info" else pytest.param(one, marks=pytest.mark.slow) for one in TAKES_A_ROBOT]
)
def test_hostile_names_are_told_as_they_are(command: str, cutjoint: Cutjoint) -> None:
    more = ["--trajectory", "hold"] if command == "play" else []
    for name in HOSTILE:
        judge(cutjoint(command, *more, "--", name), 2, as_json=False)


@pytest.mark.parametrize("command", ["", *COMMANDS])
def test_help_fits_and_is_plain(command: str, cutjoint: Cutjoint) -> None:
    ended = cutjoint(*[command] if command else [], "--help")
    assert ended.status == 0
    assert "\x1b" not in ended.out
    assert too_broad(ended.out) == []
    assert command or all(name in ended.out for name in (*COMMANDS, "--install-completion", "Exit status"))
    if command:
        shown = re.sub(r"[│\s]+", "", ended.out)
        told = [getattr(one, "help", None) or "" for one in HELPS[command].params]
        units = [unit.replace(" ", "") for text in told for unit in re.findall(r"\[[^],:][^],]*\]", text)]
        assert [unit for unit in units if unit not in shown] == []  # not taken for markup


def test_odd_names_of_joints_are_printed_as_they_are(cutjoint: Cutjoint, folder: Path) -> None:
    assert f"{ODD}   rotation" in cutjoint("info", str(folder / "hostile"), "--no-modes").out


def test_mistakes_are_told_with_what_is_near(cutjoint: Cutjoint) -> None:
    for words, near in (
        (["info", "stewert"], "did you mean 'stewart'?"),
        (["info", "OMEGA3"], "did you mean 'omega3'?"),
        (["simulat", "cpm"], "Did you mean 'simulate'?"),
        (["info", "cpm", "--jsn"], "--json"),
        (["simulate", "cpm", "--trajectory", "circel"], "did you mean 'circle'?"),
        (["simulate", "cpm", "--controller", "computed-torqe"], "did you mean 'computed-torque'?"),
    ):
        ended = cutjoint(*words)
        judge(ended, 2, as_json=False)
        assert near in ended.err
        assert len(ended.err.splitlines()) == 1
        assert len(ended.err) < 200
    ended = cutjoint("info", "zzzz")
    assert "cpm, cpm_rotary" in ended.err
    assert "cutjoint list" in ended.err
    assert ended.err.count(",") < 12


@pytest.mark.parametrize(
    ("error", "status", "told"),
    [
        (OSError(28, "No space left on device", "a\nfile"), 2, "OSError: a\\nfile: No space left on device"),
        (FileNotFoundError(2, "No such file or directory", "x"), 2, "FileNotFoundError: x: No such file or directory"),
        (MemoryError("Unable to allocate 7 TiB"), 2, "Unable to allocate 7 TiB"),
        (UnicodeDecodeError("utf-8", b"\xff", 0, 1, "invalid start byte"), 2, "invalid start byte"),
        (np.linalg.LinAlgError("Singular\nmatrix"), 70, "InternalError: LinAlgError: Singular matrix; this is a fault"),
        (RecursionError("maximum recursion depth exceeded"), 70, "InternalError: RecursionError"),
        (RuntimeError(""), 70, "InternalError: RuntimeError; this"),
        (AssertionError("\x1b[31m"), 70, "\\x1b[31m"),
    ],
    ids=lambda one: type(one).__name__ if isinstance(one, Exception) else "",
)
def test_foreign_errors_are_one_line(
    error: Exception, status: int, told: str, cutjoint: Cutjoint, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr("cutjoint.robots.load", fail)
    for json_wanted in ([], ["--json"]):
        ended = cutjoint("info", "cpm", *json_wanted)
        assert (ended.status, ended.out) == (status, "")
        assert told in ended.err
        assert len(ended.err.splitlines()) == 1
    monkeypatch.setenv("CUTJOINT_TRACEBACK", "1")
    assert "Traceback" in cutjoint("info", "cpm").err


def test_progress_is_a_log_where_nobody_looks(cutjoint: Cutjoint, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(progress, "EVERY", 0.002)
    ended = cutjoint("crosscheck", "cpm", "--samples", "20", "--json", "-")
    judge(ended, 0, as_json=True)
    lines = ended.err.splitlines()
    assert lines
    assert all(line.startswith("cpm (lumped): cross-check: ") for line in lines)
    assert " of 20 states after " in lines[-1]


@pytest.mark.slow
def test_progress_without_an_end_is_told_too(cutjoint: Cutjoint, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(progress, "EVERY", 0.002)
    ended = cutjoint("info", "fivebar", "--json")
    judge(ended, 0, as_json=True)
    assert "fivebar: searching modes: 0 s so far" in ended.err


def test_completion_offers_what_there_is(cutjoint: Cutjoint, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("_CUTJOINT_COMPLETE", "complete_bash")
    for line, offered in {
        "cutjoint comp": ["compile"],
        "cutjoint info om": ["omega3"],
        "cutjoint view cp": ["cpm", "cpm_rotary"],
        "cutjoint info cpm --variant ": ["distributed", "lumped"],
        "cutjoint simulate cpm --controller pd": ["pd", "pd-gravity"],
        "cutjoint simulate cpm --trajectory li": ["line", "lissajous"],
        "cutjoint export cpm --to u": ["urdf"],
        "cutjoint crosscheck a": ["all"],
        "cutjoint info nothing --variant ": [],
    }.items():
        monkeypatch.setenv("COMP_WORDS", line)
        monkeypatch.setenv("COMP_CWORD", str(len(line.split(" ")) - 1))
        assert cutjoint().out.split() == offered, line


PROGRAM = [sys.executable, "-m", "cutjoint"]


def test_a_reader_that_leaves_is_no_error() -> None:
    with subprocess.Popen([*PROGRAM, "list"], stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        assert process.stderr.read() == b""
        assert process.wait(60) == 0


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no /dev/full")
def test_output_that_cannot_be_written_is_an_error() -> None:
    with open("/dev/full", "w") as full:
        done = subprocess.run([*PROGRAM, "list"], stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert (done.returncode, done.stderr) == (2, "OSError: standard output: No space left on device\n")


def on_a_terminal(words: Sequence[str], columns: int, folder: Path, **settings: str) -> tuple[int, str]:
    """Exit status of a command on a terminal so many columns wide, and all that it shows there."""
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
    others = {name: value for name, value in os.environ.items() if name not in ("NO_COLOR", "COLUMNS", "TERM")}
    with subprocess.Popen(
        [*PROGRAM, *words], cwd=folder, stdout=theirs, stderr=theirs, env=others | settings
    ) as process:
        os.close(theirs)
        found = b""
        try:
            while part := os.read(ours, 4096):
                found += part
        except OSError:  # the other end is closed
            pass
    os.close(ours)
    return process.returncode, found.decode().replace("\r\n", "\n")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("columns", "settings"),
    [
        (80, {"TERM": "xterm"}),
        (60, {"TERM": "xterm"}),
        (80, {"TERM": "dumb"}),
        (60, {"TERM": "xterm", "NO_COLOR": "1"}),
    ],
)
def test_no_line_is_folded_on_a_terminal(columns: int, settings: dict[str, str], folder: Path) -> None:
    for table in (USUAL, {"report": [("run.npz -o page.html", 0)]}):
        for command, arguments, wanted in rows(table):
            status, shown = on_a_terminal(words_of(command, arguments, folder), columns, folder, **settings)
            assert status == wanted, shown
            assert "Traceback" not in shown
            # a line that is told while one waits begins anew, and is taken back
            plain = [
                re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", part) for line in shown.split("\n") for part in line.split("\r")
            ]
            if "--json" not in arguments:
                assert [one for one in plain if broad(one) > columns and len(one.split()) > 1] == [], (
                    command,
                    arguments,
                )
            if settings != {"TERM": "xterm"}:
                assert "\x1b[3" not in shown, (command, arguments)


@pytest.mark.slow
def test_a_terminal_has_colours(tmp_path: Path) -> None:
    status, shown = on_a_terminal(["info", "cpm", "--no-modes"], 80, tmp_path, TERM="xterm")
    assert status == 0
    assert "\x1b[32m✓ they determine the motion\x1b[0m" in shown
