# /// script
# requires-python = ">=3.11"
# dependencies = ["pin-pink>=4.4", "daqp>=0.7"]
# ///
"""Inverse kinematics of a Stewart platform with pink: its tasks lead the platform, the loops are constraints of the QP.

pink works on the open tree, `chain.model`, and knows no loops.  A task made of `chain.constraint_residual` and
`chain.constraint_jacobian` closes them, whatever the cuts are.  The same pose by `chain.reach` is the comparison.

cutjoint itself comes from a checkout: pip install . pin-pink daqp
"""

import numpy as np
import pinocchio as pin
from pink import Configuration, solve_ik
from pink.tasks import FrameTask, Task

import cutjoint

STEPS, DT = 40, 1.0


class Loops(Task):
    """All loops of a closed chain, as independent rows: redundant ones, of which a Stewart platform has none and a
    Delta three, would make the equalities of a QP dependent."""

    def __init__(self, chain):
        super().__init__(cost=1.0, gain=1.0)
        self.chain = chain

    def __repr__(self):
        return f"Loops({self.chain.name})"

    def _rows(self, configuration):
        left, size, right = np.linalg.svd(self.chain.constraint_jacobian(configuration.q), full_matrices=False)
        kept = size > 1e-9 * size[0]
        return left[:, kept], size[kept], right[kept]

    def compute_error(self, configuration):
        left, size, _ = self._rows(configuration)
        return left.T @ self.chain.constraint_residual(configuration.q) / size

    def compute_jacobian(self, configuration):
        return self._rows(configuration)[2]


def solved(chain, target):
    """The configuration (nq,) in which pink has the tool at `target`, with every joint free to go beyond its limits."""
    configuration = Configuration(chain.model, chain.model.createData(), np.array(chain.home.q_full))
    tool, loops = FrameTask(chain.description.tool.link, position_cost=1.0, orientation_cost=1.0), Loops(chain)
    tool.set_target(target)
    for _ in range(STEPS):
        velocity = solve_ik(configuration, [tool], DT, "daqp", limits=[], constraints=[loops], safety_break=False)
        configuration.integrate_inplace(velocity, DT)
    return configuration.q


def main():
    """Lead a Stewart platform and a Delta to a pose, and compare with `reach`."""
    for name in ("stewart", "omega3"):
        chain = cutjoint.load(name)
        home = chain.tool(chain.home).pose
        turn = pin.rpy.rpyToMatrix(0.10, -0.05, 0.15) if name == "stewart" else np.eye(3)
        target = pin.SE3(home.rotation @ turn, home.position + np.array([0.04, -0.03, 0.05]))

        q = solved(chain, target)
        reached = chain.reach(target)

        gap, apart = max(chain.gap(q)), np.abs(chain.actuated(q) - reached.q).max()
        print(f"{name}: loops open by {gap:.1e}, actuators {apart:.1e} from those of reach ({reached.q.round(4)})")
        assert gap < 1e-9, "pink left the loops open"
        assert apart < 1e-6, "pink and reach disagree"


if __name__ == "__main__":
    main()
