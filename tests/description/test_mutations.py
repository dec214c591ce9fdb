"""Valid files spoiled at random, in every format: each loads as a sound description or is refused with problems.

`tools/fuzz.py` does the same by the thousand.
Never anything else: no other exception, no endless loop, no number that is not finite in what was loaded.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools"))

from attacks.seeds import seeds

from cutjoint.description import RobotDescription, check_description, load_description
from cutjoint.errors import DescriptionError

HOSTILE = [
    *[
        "nan",
        "inf",
        "-inf",
        "1e308",
        "-1e308",
        "1e-320",
        "0",
        "-0",
        "-1",
        "1e9",
        "1e-9",
        "0x10",
        "1_000",
        "1,5",
        "9" * 400,
    ],
    *["", " ", "½", "\u0000", "\ud7ff", "&amp;", "&#0;", "<", ">", '"', "'", "[", "]", "{", "}", "=", "\n", "#", "a/b"],
    *["${x}", "$(arg y)", "<!--", "]]>", "<!DOCTYPE x>", "<?x?>", "universe", "world", "base", "cutjoint:"],
    *["true", "fixed", "floating", "spherical", "universal", "planar", "continuous", "prismatic"],
]
SOURCES = [one for one in seeds() if not one.endswith(".xacro")]  # each of which would be a process
TOKEN = re.compile(r"[\w.+-]+|[^\w\s]")
NUMBER = re.compile(r"(?<![\w.#])-?\d+(\.\d+)?(e[+-]?\d+)?(?![\w.])")
KINDS = ["number"] * 6 + ["token"] * 2 + ["swap", "drop", "double", "move", "cut", "insert", "chars"]
FACTORS = [0.0, -1.0, 0.5, 2.0, 1e-3, 1e3, 1e-8, 1e8, 1.0 + 1e-9]


@st.composite
def mutated(draw: st.DrawFn, text: str) -> str:
    """A text with one to three random changes."""
    for _ in range(draw(st.integers(1, 3))):
        lines = text.split("\n")
        kind = draw(st.sampled_from(KINDS))
        if kind == "number":
            numbers = list(NUMBER.finditer(text))
            if numbers:
                at = draw(st.sampled_from(numbers))
                value = float(at.group()) * draw(st.sampled_from(FACTORS)) + draw(
                    st.sampled_from([0.0, 0.0, 0.1, -1.0])
                )
                text = f"{text[: at.start()]}{value!r}{text[at.end() :]}"
        elif kind in ("token", "swap"):
            tokens = list(TOKEN.finditer(text))
            if not tokens:
                continue
            at = draw(st.sampled_from(tokens))
            other = draw(st.sampled_from(tokens)).group() if kind == "swap" else draw(st.sampled_from(HOSTILE))
            text = text[: at.start()] + other + text[at.end() :]
        elif kind == "drop":
            del lines[draw(st.integers(0, len(lines) - 1))]
            text = "\n".join(lines)
        elif kind == "double":
            number = draw(st.integers(0, len(lines) - 1))
            text = "\n".join([*lines[: number + 1], *lines[number:]])
        elif kind == "move":
            line = lines.pop(draw(st.integers(0, len(lines) - 1)))
            lines.insert(draw(st.integers(0, len(lines))), line)
            text = "\n".join(lines)
        elif kind == "cut":
            text = text[: draw(st.integers(0, len(text)))]
        elif kind == "insert":
            where = draw(st.integers(0, len(text)))
            text = text[:where] + draw(st.sampled_from(HOSTILE)) + text[where:]
        else:
            where = draw(st.integers(0, len(text)))
            text = text[:where] + draw(st.text(max_size=4)) + text[where + draw(st.integers(0, 4)) :]
    return text


@st.composite
def spoiled_files(draw: st.DrawFn) -> dict[str, bytes]:
    """The files of a robot, the one to load first, one of them spoiled."""
    texts = dict(seeds()[draw(st.sampled_from(SOURCES))])
    victim = draw(st.sampled_from(list(texts)))
    texts[victim] = draw(mutated(texts[victim]))
    return {name: text.encode("utf-8", errors="surrogatepass") for name, text in texts.items()}


def loaded(files: dict[str, bytes]) -> RobotDescription | None:
    """The robot in these files, or None where they were refused with problems."""
    with TemporaryDirectory() as folder:
        for name, content in files.items():
            (Path(folder) / name).write_bytes(content)
        refused = None
        try:
            return load_description(Path(folder) / next(iter(files)))
        except DescriptionError as error:
            refused = error
    assert any(problem.severity == "error" for problem in refused.problems)
    assert all(problem.found for problem in refused.problems)
    assert str(refused)
    return None


def assert_sound(robot: RobotDescription) -> None:
    assert not [one for one in check_description(robot) if one.severity == "error"]
    assert robot.root
    arrays = [joint.placement for joint in robot.joints] + [joint.axis for joint in robot.joints]
    arrays += [link.inertial.inertia for link in robot.links if link.inertial]
    arrays += [frame.placement for cut in robot.cuts for frame in (cut.a, cut.b)]
    assert all(np.isfinite(array).all() for array in arrays)


@settings(max_examples=100, deadline=None, suppress_health_check=list(HealthCheck))
@given(spoiled_files())
def test_spoiled_files_load_soundly_or_are_refused(files: dict[str, bytes]) -> None:
    robot = loaded(files)
    if robot is not None:
        assert_sound(robot)


@pytest.mark.parametrize("source", SOURCES)
def test_what_is_spoiled_here_is_sound(source: str) -> None:
    description = loaded({name: text.encode() for name, text in seeds()[source].items()})
    assert description is not None
    assert_sound(description)


@settings(max_examples=200, deadline=None)
@given(st.binary(max_size=300), st.sampled_from(["x.urdf", "x.toml", "x.yaml", "x.sdf", "x.xml", "x", "x.stl"]))
def test_any_bytes_are_refused(content: bytes, name: str) -> None:
    assert loaded({name: content}) is None
