"""Which plant simulates a robot: the compiled one where there is one, else the robot itself."""

from __future__ import annotations

from typing import NamedTuple, cast

from cutjoint.chain import ClosedChain
from cutjoint.errors import CutjointError
from cutjoint.mechanism import Mechanism, is_mechanism
from cutjoint.simulation.constrained import ConstrainedPlant
from cutjoint.simulation.plant import Plant, ReducedPlant


class Choice(NamedTuple):
    """A plant, and why it is not a compiled one where it might have been."""

    plant: Plant
    not_compiled: str | None = None


def plant_of(robot: Plant | Mechanism) -> Choice:
    """The plant that simulates a robot.  A plant is taken as it is.

    Raises:
        InputError: the robot has no tool.
        ActuationError: a reduced model whose actuators do not tell its motion.
    """
    if not is_mechanism(robot):
        return Choice(cast(Plant, robot))
    try:
        return Choice(_compiled(robot))
    except CutjointError as error:
        plain: Mechanism = getattr(robot, "plain", robot)  # of a compiled robot, the one it was made from
        plant = ConstrainedPlant(plain) if isinstance(plain, ClosedChain) else ReducedPlant(plain)
        return Choice(plant, str(error))


def _compiled(robot: Mechanism) -> Plant:
    """Raises CutjointError where a robot cannot be compiled."""
    from cutjoint import CompiledChain, CompiledPaper, compiled, compiled_plant

    made = robot if isinstance(robot, CompiledChain | CompiledPaper) else compiled(robot, quick=True)
    return compiled_plant(made)


def quick(model: Mechanism) -> Mechanism:
    """A model that a law or a reference asks at every sample: compiled where it can be."""
    from cutjoint import compiled

    if not isinstance(model, ClosedChain):
        return model
    try:
        made = compiled(model, quick=True)
        for what in ("step", "inverse", "tool"):
            made.kernel(what)
    except CutjointError:
        return model
    return made
