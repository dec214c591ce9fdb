# /// script
# requires-python = ">=3.11"
# dependencies = ["mujoco>=3.3.7"]
# ///
"""A closed robot in MuJoCo: exported, compared in acceleration, and driven there by a law written over cutjoint.

MuJoCo's loops are soft: they give a little, by its impedance, and it never closes them exactly.  What is compared here
is therefore close, not equal; `cutjoint crosscheck --engine mujoco` takes the softness away and agrees to rounding.

cutjoint itself comes from a checkout: pip install '.[compile,engines]'
"""

import tempfile
from pathlib import Path

import mujoco
import numpy as np

import cutjoint
from cutjoint.description import write
from cutjoint.simulation import run

RATE, DURATION = 1000.0, 0.5


def exported(chain):
    """The robot as MuJoCo's model, with loops as stiff as MuJoCo takes them."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "robot.xml"
        write(chain.description, file, "mjcf")
        model = mujoco.MjModel.from_xml_path(str(file))
    model.eq_solimp[:, :2] = 0.9999
    model.opt.timestep, model.opt.integrator = 1.0 / RATE, mujoco.mjtIntegrator.mjINT_RK4
    return model


def accelerations_apart(chain, model):
    """The largest difference of the accelerations of all joints, relative, at postures and velocities around home."""
    data, rng, worst = mujoco.MjData(model), np.random.default_rng(0), 0.0
    for _ in range(20):
        at = chain.close(chain.home.q + 0.1 * rng.normal(size=chain.n))
        v, effort = chain.full_velocity(at, rng.normal(size=chain.n)), rng.normal(size=chain.n)
        data.qpos[:], data.qvel[:], data.ctrl[:] = chain.to_mujoco(at), v, effort
        mujoco.mj_forward(model, data)
        ours = chain.full_forward_dynamics(at, v, chain.full_effort(effort)).acceleration
        worst = max(worst, np.abs(data.qacc - ours).max() / np.abs(ours).max())
    return worst


def main():
    """Compare accelerations, and half a second under one law in both."""
    chain = cutjoint.load("fivebar")
    model = exported(chain)
    apart = accelerations_apart(chain, model)
    print(f"accelerations: {apart:.1e} apart, relative")
    assert apart < 3e-4

    goal = chain.reach(chain.tool(chain.home).position + np.array([0.06, 0.0, 0.05]))
    hold = chain.terms(goal).gravity

    def law(t, desired, q, v):
        return hold + 8.0 * (goal.q - q) - 0.8 * v

    data, followed = mujoco.MjData(model), []
    data.qpos[:] = chain.to_mujoco(chain.home)
    for _ in range(round(RATE * DURATION)):
        q_full = chain.from_mujoco(data.qpos)  # open by what MuJoCo gives: assemble(q_full) would be the posture
        followed.append(chain.actuated(q_full))
        data.ctrl[:] = law(data.time, None, followed[-1], chain.actuated_velocity(data.qvel))
        mujoco.mj_step(model, data)

    result = run(chain, law, rate=RATE, duration=DURATION, start=chain.home)
    ours = np.array([np.interp(np.arange(len(followed)) / RATE, result.time, one) for one in result.q.T]).T
    apart, gap = np.abs(ours - followed).max(), max(chain.gap(chain.from_mujoco(data.qpos)))
    moved, left = np.abs(goal.q - chain.home.q).max(), np.abs(goal.q - ours[-1]).max()
    print(f"driven: {apart:.1e} rad apart over {moved:.2f} rad, {left:.1e} rad from the goal, loops open by {gap:.1e}")
    assert apart < 1e-6
    assert left < 0.05 * moved
    assert gap < 1e-6


if __name__ == "__main__":
    main()
