# /// script
# requires-python = ">=3.11"
# dependencies = ["crocoddyl>=3.2"]
# ///
"""A swing of a five-bar by optimal control with crocoddyl, over the constraint dynamics of the closed chain.

The state is that of all joints of the open tree; `pin.constraintDynamics` with `chain.constraint_models()` closes the
loops, and Baumgarte's terms hold them closed between the nodes.  Derivatives are finite differences: Pinocchio 4.1's
`computeConstraintDynamicsDerivatives` is wrong by 100 % and more for contacts of three rows between two moving bodies,
which revolute and spherical cuts are.  The efforts that are found are replayed in cutjoint.

cutjoint itself comes from a checkout: pip install '.[compile]' crocoddyl
"""

import crocoddyl
import numpy as np
import pinocchio as pin

import cutjoint
from cutjoint.simulation import run

NODES, DT = 25, 0.016
BAUMGARTE = pin.BaumgarteCorrectorParameters(100.0, 20.0)


class Loops(crocoddyl.DifferentialActionModelAbstract):
    """The closed chain; its cost is that of the efforts and of the distance from a state, both with weights."""

    def __init__(self, chain, goal, effort_weight, goal_weight):
        state = crocoddyl.StateMultibody(chain.model)
        super().__init__(state, chain.n, chain.n + state.ndx)
        self.chain, self.goal, self.weights = chain, goal, (effort_weight, goal_weight)
        self.constraints = chain.constraint_models()
        for one in self.constraints:
            one.setBaumgarteCorrectorParameters(BAUMGARTE)
        self.datas = chain.constraint_datas(self.constraints)
        self.tree, self.work = chain.model, chain.model.createData()
        self.settings = pin.ProximalSettings(1e-14, 1e-14, 1e-8, 30)
        pin.initConstraintDynamics(self.tree, self.work, self.constraints, self.datas)

    def acceleration(self, q, v, u):
        efforts = self.chain.actuation @ u
        return pin.constraintDynamics(self.tree, self.work, q, v, efforts, self.constraints, self.datas, self.settings)

    def calc(self, data, x, u=None):
        u = np.zeros(self.nu) if u is None else u
        data.xout = self.acceleration(x[: self.tree.nq], x[self.tree.nq :], u)
        data.r = np.concatenate([self.weights[0] * u, self.weights[1] * self.state.diff(self.goal, x)])
        data.cost = 0.5 * data.r @ data.r


def swing(chain, to):
    """States (NODES + 1, nq + nv) and efforts (NODES, n) from home to the posture `to`, at rest there."""
    rest = np.zeros(chain.nv)
    start, goal = np.concatenate([chain.home.q_full, rest]), np.concatenate([to.q_full, rest])

    def node(effort_weight, goal_weight):
        differentiated = crocoddyl.DifferentialActionModelNumDiff(Loops(chain, goal, effort_weight, goal_weight), True)
        differentiated.disturbance = 1e-6
        return crocoddyl.IntegratedActionModelRK(differentiated, crocoddyl.RKType.four, DT)

    problem = crocoddyl.ShootingProblem(start, [node(0.1, 0.0)] * NODES, node(0.0, 100.0))
    solver = crocoddyl.SolverFDDP(problem)
    solver.th_stop = 1e-7
    converged = solver.solve([start] * (NODES + 1), [chain.terms(chain.home).gravity] * NODES, 40)
    print(f"FDDP: {solver.iter} iterations, cost {solver.cost:.4g}, converged: {converged}")
    assert converged, "FDDP did not converge"
    return np.array(solver.xs), np.array(solver.us)


def main():
    """Swing the five-bar's tool by 8 cm in 0.4 s."""
    chain = cutjoint.load("fivebar")
    assert not chain.description.acting, "friction, springs and dampers are cutjoint's own, pin.Model has none"
    to = chain.reach(chain.tool(chain.home).position + np.array([0.06, 0.0, 0.05]))
    states, efforts = swing(chain, to)
    gap = max(max(chain.gap(x[: chain.nq])) for x in states)
    missed = np.abs(states[-1, : chain.nq] - to.q_full).max()
    most = np.abs(efforts).max()
    print(f"swing: loops open by {gap:.1e}, {missed:.1e} rad from the goal, efforts up to {most:.2f} N m")

    result = run(chain, lambda t: efforts[min(int(t / DT + 1e-9), NODES - 1)], rate=1.0 / DT, duration=NODES * DT)
    ends = np.array([np.interp(DT * np.arange(NODES + 1), result.time, one) for one in result.q_full.T]).T
    apart = np.abs(ends - states[:, : chain.nq]).max()
    print(f"replayed in cutjoint ({result.about['plant']}): {apart:.1e} rad from crocoddyl's states")
    assert gap < 1e-6
    assert missed < 1e-4
    assert apart < 5e-5


if __name__ == "__main__":
    main()
