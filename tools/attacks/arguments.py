"""Hostile arguments of every command and option: exit status 0, 1 or 2, one error in words, in time."""

from __future__ import annotations

import contextlib
import io
import os
import sys
from collections.abc import Iterator
from functools import cache, partial
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
import typer.main

from attacks.judging import Attack, Wrong
from cutjoint import cli

NUMBERS = (
    *("nan", "inf", "-inf", "1e308", "-1e308", "1.8e308", "1e-320", "5e-324", "-0", "0", "-1", "1e9", "1e-12", "1e400"),
    *("1,000", "1_0", "٣", "½", "0x10", "1e", "--", "", " ", "9" * 400, "1" + "0" * 400, "1.0.0", "true", "None", "1j"),
    *("1,2", "1,2,3", "1,2,3,4,5,6,7", ",", "1,,2", "nan,nan,nan", "1e308,1e308,1e308", "[[1]]", "[[1,2],[3]]", "[[]]"),
    *("[" * 1000, "[[1e400]]", "[[NaN]]", '["a"]', "[null]", "[{}]", "[[[1]]]", "7" * 5000, "1e308 ", "+5", "inf,1,1"),
)
TEXTS = (
    *("", " ", "x", "-", "--", "..", "/", "\x00", "\ud800", "ä" * 200, "n" * 300, "a/" * 3000, "%s%n", "{0}", "[bold]"),
    *(
        "/dev/zero",
        "/dev/stdin",
        "/dev/null",
        "/proc/self/mem",
        "/proc/kmsg",
        "/etc/passwd",
        ".",
        "cpm.urdf",
        ":",
        "a:b",
    ),
    *(
        "x.py:A",
        "/dev/zero.py:x",
        "nowhere.py",
        "line:1",
        "circle:nan",
        "paper:1",
        "line:1e308",
        "tool:1,2",
        "tool:nan,0,0",
    ),
    *(
        "tool:1e308,0,0",
        "nolink:1,2,3",
        "kp=1",
        "kp=",
        "=1",
        "kp=nan",
        "0x0",
        "1x1",
        "99999999x99999999",
        "-1x5",
        "1e3x2",
    ),
    *(
        "error,effort",
        "tool",
        "reactions",
        "run.npz",
        "revolute",
        "coupler_to_rocker=spherical",
        "crank",
        "delta",
        "leg",
    ),
    *("all", "cpm,", "omega3/", "fourbar ", "٣", "0.0.0.0:99", "256.1.1.1", "http://x", "\n", "\x1b[31m"),
)
BASES = {
    "new": ["robot", "--out", "{folder}/{number}"],
    "cut": ["fourbar"],
    "plot": ["{folder}/run.npz", "-o", "{folder}/plot.html"],
    "report": ["{folder}/run.npz", "-o", "{folder}/report.html"],
    "states": ["{folder}/run.npz", "-o", "{folder}/states.jsonl"],
    "list": [],
    "info": ["fourbar"],
    "check": ["fourbar"],
    "crosscheck": ["cpm", "--states", "3"],
    "simulate": ["fourbar", "--free", "--duration", "0.02"],
    "reproduce": ["nothing"],
    "view": ["fourbar", "--html", "{folder}/view.html"],
    "play": ["fourbar", "--trajectory", "home", "--html", "{folder}/play.html"],
    "export": ["fourbar", "--out", "{folder}/out.xml"],
    "compile": ["fourbar", "--functions", "tool"],
}
RUNS = (
    BASES["simulate"],
    ["cpm", "--duration", "0.01"],
    ["cpm", "--duration", "0.01", "--rate", "1000"],
    ["omega3", "--duration", "0.01", "--plant", "chain", "--step", "0.001"],
    ["fourbar", "--trajectory", "home", "--controller", "pd", "--kp", "10", "--kd", "1", "--duration", "0.01"],
    ["stewart", "--free", "--duration", "0.005", "--save", "{folder}/free.npz"],
    ["fourbar", "--trajectory", "hold", "--duration", "0.01", "--plant", "chain", "--save", "{folder}/run.npz"],
)
"""Of `simulate`, which has most options."""
LONG = {"--help", "-h", "--png", "--open", "--no-open", "--measure"}
"""Options that start a browser, or take long by what they are."""


def attacks(seed: int, count: int, folder: Path) -> Iterator[Attack]:
    """`count` command lines."""
    _pipe(folder)
    for run in RUNS:  # what is compiled for the first time takes long
        outcome(["simulate", *(one.format(folder=folder) for one in run)], folder)
    for number in range(count):
        rng = np.random.default_rng([seed, number])
        arguments = _line(rng, number, folder)
        shown = " ".join(one if len(one) < 60 else f"{one[:30]}...({len(one)})" for one in arguments)
        yield Attack(f"arguments {seed}:{number} ({shown!a})", partial(outcome, arguments, folder))


def outcome(arguments: list[str], folder: Path) -> str:
    """What a command line came to; raises `Wrong` or what escaped."""
    return outcome_and_output(arguments, folder)[0]


def outcome_and_output(arguments: list[str], folder: Path) -> tuple[str, str]:
    """What a command line came to, and what it wrote to standard output; raises `Wrong` or what escaped."""
    out, err = io.StringIO(), io.StringIO()
    before, status = (sys.argv, os.getcwd()), 0
    try:
        os.chdir(folder)
        sys.argv = ["cutjoint", *arguments]
        # the program watches signals for as long as it lives; this process lives on
        unwatched = patch("cutjoint.interrupts.watch")
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err), unwatched:
            cli.main()
    except SystemExit as end:
        status = end.code if isinstance(end.code, int) else 1 if end.code else 0
    finally:
        sys.argv = before[0]
        os.chdir(before[1])
    words = err.getvalue()
    if "Traceback" in words or "Warning: " in words:
        raise Wrong(f"a traceback or a warning of Python: {words[-500:]}")
    if status not in (0, 1, 2):
        raise Wrong(f"exit status {status}")
    if status == 2 and not words.strip():
        raise Wrong("refused without a word")
    if len(words) > 20_000:
        raise Wrong(f"an error of {len(words)} characters: {words[:200]}")
    # `export` prints paths for programs, as they are
    for text in (words,) if arguments[:1] == ["export"] else (out.getvalue(), words):
        if moving := next((one for one in text if one != "\n" and not one.isprintable()), ""):
            raise Wrong(f"prints {moving!a}: {text[:300]!a}")
    return {0: "done", 1: "did not hold", 2: "refused"}[status], out.getvalue()


def _pipe(folder: Path) -> None:
    for name in ("pipe", "pipe.npz", "pipe.csv", "pipe.toml", "pipe.py", "pipe.urdf"):
        with contextlib.suppress(FileExistsError):
            os.mkfifo(folder / name)


@cache
def _commands() -> dict[str, Any]:
    group: Any = typer.main.get_command(cli.app)
    return dict(group.commands)


def _line(rng: np.random.Generator, number: int, folder: Path) -> list[str]:
    """A sound command line with one to three options of any value, or with its words spoiled."""
    names = [*BASES, *["simulate"] * 8, "play", "crosscheck"]  # those with most options more often
    name = names[number % len(names)]
    line = [one.format(folder=folder, number=number) for one in BASES[name]]
    if name == "simulate":
        line = [one.format(folder=folder) for one in RUNS[int(rng.integers(len(RUNS)))]]
    if name == "reproduce":
        line = [_value(rng, folder, False).replace("all", "al")]  # all of it takes minutes
    command = _commands()[name]
    every = [one for one in command.params if one.param_type_name == "option" and not LONG & {*one.opts}]
    for _ in range(int(rng.integers(1, 3))):
        if not every or not rng.integers(12):
            line.insert(int(rng.integers(len(line) + 1)), _value(rng, folder, bool(rng.integers(2))))
            continue
        option = every[int(rng.integers(len(every)))]
        word = option.opts[0]
        if option.is_flag:
            line.append(word)
        elif rng.integers(2):
            line += [word, _value(rng, folder, _is_number(option))]
        else:
            line.append(f"{word}={_value(rng, folder, _is_number(option))}")
    if line and name != "reproduce" and not rng.integers(8):
        line[0] = _value(rng, folder, False)
    return [name, *line]


def _is_number(option: Any) -> bool:
    return option.type_descriptor.annotation in (float, int) or option.metavar in ("K", "N", "S", "HZ", "KG")


def _value(rng: np.random.Generator, folder: Path, number: bool) -> str:
    if rng.integers(5) == 0:
        number = not number
    if not number and rng.integers(4) == 0:
        pipes = [f"{folder}/{one}" for one in ("pipe", "pipe.npz", "pipe.csv", "pipe.toml", "pipe.py:x", "pipe.urdf")]
        return str(rng.choice(pipes))
    choices = NUMBERS if number else TEXTS
    return choices[int(rng.integers(len(choices)))]
