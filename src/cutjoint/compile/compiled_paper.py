"""Published models, compiled."""

from __future__ import annotations

import threading
from collections.abc import Hashable, Mapping
from dataclasses import replace

import numpy as np

from cutjoint.arrays import Array
from cutjoint.compile.batch import PaperBatch
from cutjoint.compile.functions.library import Library, Options
from cutjoint.compile.functions.verify import Checker
from cutjoint.compile.mechanism import CompiledMechanism
from cutjoint.compile.once import once
from cutjoint.compile.sources.interface import PAYLOAD
from cutjoint.compile.sources.paper import PaperModel, PaperSource
from cutjoint.doors import door
from cutjoint.mechanism import ActuatedCoordinates, JointLimits, Posture, TargetLike


class CompiledPaper(CompiledMechanism[PaperModel]):
    """A published model, compiled from its own equations.  Each branch is compiled when first used.

    Args:
        model: the published model.
        options: how to compile.

    Raises:
        UnknownNameError: parameters that the model does not have.
    """

    def __init__(self, model: PaperModel, options: Options | None = None) -> None:
        options = Options() if options is None else options
        nominal = np.array(
            [0.0 if name == PAYLOAD else getattr(model.parameters, name, 0.0) for name in options.parameters],
            dtype=np.float64,
        )
        super().__init__(model, options, nominal)
        self.paper = model
        self.source = PaperSource(model, options.parameters)
        self._libraries: dict[Hashable, Library] = {}
        self._making = threading.Lock()

    def library(self, at: Posture | None = None) -> Library:
        """The compiled functions for the branch of `at` (default: of home)."""
        branch = self.source.branch if at is None else self.paper.branch(at)
        if branch not in self._libraries:
            with self._making:
                if branch not in self._libraries:
                    source = PaperSource(self.paper, self.options.parameters, branch)
                    on_branch = self.paper if branch == self.source.branch else self.paper.on_branch(branch)
                    check = Checker(source, on_branch, self._nominal)
                    self._libraries[branch] = Library(source, check, self.options)
        return self._libraries[branch]

    def positions(self, at: Posture) -> Array:
        """The actuated coordinates."""
        return at.q

    @once
    def batch(self) -> PaperBatch:
        """The same on many states at once."""
        return PaperBatch(self)

    def close(self, q: ActuatedCoordinates, near: Posture | None = None, *, limits: JointLimits = "respect") -> Posture:
        """See the published model; closed form, so there is nothing to compile."""
        return self.plain.close(q, near, limits=limits)

    def reach(
        self, target: TargetLike, near: Posture | None = None, *, free: bool = False, limits: JointLimits = "respect"
    ) -> Posture:
        """See the published model; closed form, so there is nothing to compile."""
        return self.plain.reach(target, near, free=free, limits=limits)

    def _rebuilt(self, parameters: Mapping[str, float]) -> PaperModel:
        own = {name: value for name, value in parameters.items() if name != PAYLOAD}
        made: PaperModel = self.paper.with_parameters(replace(self.paper.parameters, **own))
        return made.with_payload(parameters[PAYLOAD]) if parameters.get(PAYLOAD) else made

    @door
    def with_payload(self, mass: float) -> CompiledPaper:
        """The same robot carrying `mass` [kg] more.  Compiled anew unless `payload` is an argument."""
        if PAYLOAD in self.options.parameters:
            self.paper.with_payload(mass)
            return self.with_parameters(**{PAYLOAD: self.parameters[PAYLOAD] + mass})
        return CompiledPaper(self.paper.with_payload(mass), self.options)
