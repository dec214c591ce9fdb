"""What a law is shown where nothing is to be followed: the time, and a clear error where it asks for more."""

from __future__ import annotations

from typing import NoReturn

from cutjoint.errors import InputError
from cutjoint.motion import Desired


class Undesired(Desired):
    """The desired motion of a robot that is to follow nothing, which has a time `t` [s] and no more."""

    def __init__(self, t: float, law: str) -> None:
        self.__dict__.update(t=t, law=law)

    def __getattr__(self, name: str) -> NoReturn:
        if name.startswith("__"):
            raise AttributeError(name)
        law = self.__dict__.get("law", "?")
        raise InputError(
            f"controller '{law}' asks for '{name}' of the desired motion, but the robot is to follow nothing: give "
            "it a reference (a trajectory), or take a controller that needs none"
        )
