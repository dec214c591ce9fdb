"""Where in a step a joint with stiction begins to stick or to slip, and what follows: the step ends there.

How such a joint moves is in `cutjoint.simulation.stiction`.
"""

from __future__ import annotations

from cutjoint.simulation.coupled import Coupled
from cutjoint.simulation.integrators import Integrator, Step
from cutjoint.simulation.interpolant import Begin, between
from cutjoint.simulation.stiction import LOOKS

RESTEPS = 3
"""How often a step that ends where a joint comes to rest is taken again."""
SAME = 1e-12
"""Part of a step within which its end is the instant at which a joint comes to rest."""


NEAR = 1e-3
"""Part of a step within which it is looked for: further away it is no correction, but another joint's."""


class ModeEnds:
    """When the joints with stiction of a run begin to stick or to slip.

    Args:
        coupled: the equations.
        method: that takes the steps.
        span: length of the whole run [s].
    """

    def __init__(self, coupled: Coupled, method: Integrator, span: float) -> None:
        self._coupled, self._method, self._span, self._stiction = coupled, method, span, coupled.stiction

    def let_go(self, t: float) -> bool:
        """Joints that stick and are not held by their friction start to slip at `t` [s]; whether any does."""
        return self._stiction is not None and self._stiction.settle(*self._coupled.acting(t, self._coupled.y))

    def cut_short(self, begin: Begin, step: Step) -> tuple[Step, int | None]:
        """The step, or its part until a joint begins to stick or to slip, and which joint that is."""
        coupled, method, stiction = self._coupled, self._method, self._stiction
        if stiction is None:
            return step, None
        known = between(coupled, begin, step)
        looks = LOOKS if method.interpolates else 0
        found = stiction.first(begin.t, step.t, lambda t: stiction.passed(*coupled.acting(t, known(t))), looks)
        if found is None:
            return step, None
        t, joint = found
        for _ in range(RESTEPS):
            # the method is more exact at the end of a step than its interpolant within
            again = method.step(coupled.field, *begin, t - begin.t, t, self._span)
            if again.t < t:
                return again, None
            late = stiction.late(joint, *coupled.acting(again.t, again.y))
            if not SAME < abs(late) / (t - begin.t) < NEAR or t - late > step.t:
                break
            t -= late
        return Step(again.t, again.y, None, step.ahead, again.between), joint

    def switch(self, t: float, joint: int) -> None:
        """The mode of a joint has ended at `t` [s]."""
        coupled, stiction = self._coupled, self._stiction
        assert stiction is not None
        stiction.stop(joint)
        coupled.accept(coupled.y)
        stiction.settle(*coupled.acting(t, coupled.y))
