"""What options of several commands share: NAME=VALUE, paths to type, and options made of a table."""

from __future__ import annotations

import shlex
from pathlib import Path

import pytest

from cutjoint.commands.options import as_argument, assigned, with_options
from cutjoint.errors import InputError


def test_names_and_values_are_told_apart() -> None:
    assert assigned("a gain", "--gain NAME=K", ["kp = 1,2", "kd=[[1]]"]) == {"kp": "1,2", "kd": "[[1]]"}


@pytest.mark.parametrize(
    ("texts", "told"),
    [(["kp"], "--gain NAME=K, found 'kp'"), (["=1"], "found '=1'"), (["kp= "], "found"), (["a=1", "a=2"], "twice")],
)
def test_what_is_no_assignment_is_refused(texts: list[str], told: str) -> None:
    with pytest.raises(InputError, match="a gain is given") as caught:
        assigned("a gain", "--gain NAME=K", texts)
    assert told in str(caught.value)


@pytest.mark.parametrize("path", ["arm", "my arm", "it's", "-x", "cpm", "a/b"])
def test_a_path_comes_back_from_the_shell_as_the_same_place(path: str) -> None:
    (word,) = shlex.split(as_argument(Path(path)))
    assert Path(word) == Path(path)
    assert not word.startswith("-")
    assert word != "cpm"  # which would be the robot that ships


def test_an_option_of_a_table_may_not_hide_another() -> None:
    def command(json: bool = False, **sizes: str | None) -> None:
        """A command."""

    with pytest.raises(ValueError, match="json"):
        with_options(command, {"json": "a size"}, "M", "Sizes")
