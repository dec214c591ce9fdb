# /// script
# requires-python = ">=3.11"
# dependencies = ["drake>=1.40"]
# ///
"""A closed robot in Drake: its URDF as a MultibodyPlant, its cuts as Drake's constraints, and a free swing compared.

A revolute cut is two ball constraints on its axis; a spherical one is one, a fixed one AddWeldConstraint.  Drake has
them in discrete plants alone, whose steps are of first order: the difference goes down with the step.  With the
matrices of Drake's tree and hard loops the accelerations are those of cutjoint to rounding.

cutjoint itself comes from a checkout: pip install '.[compile]' drake
"""

import tempfile
from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JacobianWrtVariable
from pydrake.systems.analysis import Simulator

import cutjoint
from cutjoint.description import CutType, write
from cutjoint.simulation import run

APART, DURATION = 0.1, 0.3
"""Of the two balls of a revolute cut [m]; of the swing [s]."""


def points_of(chain):
    """Bodies and points in them, a and b, that the cuts hold together, for spherical and revolute cuts."""
    for cut in chain.description.closing:
        assert cut.type in (CutType.SPHERICAL, CutType.REVOLUTE), f"{cut.name}: not in this example"
        for shift in (0.0,) if cut.type is CutType.SPHERICAL else (-0.5 * APART, 0.5 * APART):
            yield [(one.link, (one.placement @ [0.0, 0.0, shift, 1.0])[:3]) for one in (cut.a, cut.b)]


def plant_of(chain, step):
    """Drake's plant of the open tree, with the cuts as constraints where it is discrete (step > 0)."""
    plant = MultibodyPlant(step)
    with tempfile.TemporaryDirectory() as folder:
        write(chain.description, Path(folder), "loops")
        Parser(plant).AddModels(str(Path(folder) / "robot.urdf"))
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName(chain.description.root), RigidTransform())
    plant.mutable_gravity_field().set_gravity_vector(np.array(chain.description.gravity))
    for (link_a, point_a), (link_b, point_b) in points_of(chain) if step else ():
        plant.AddBallConstraint(plant.GetBodyByName(link_a), point_a, plant.GetBodyByName(link_b), point_b)
    plant.Finalize()
    return plant


def order_of(chain, plant):
    """Where each joint of the chain (one coordinate each) stands in Drake's vectors."""
    assert chain.nq == chain.nv == plant.num_positions() == plant.num_velocities()
    return [plant.GetJointByName(name).velocity_start() for name in list(chain.model.names)[1:]]


def hard_acceleration(chain, plant, at, v, efforts):
    """Acceleration (nv,) of all joints from Drake's matrices of the tree, with loops that do not give."""
    order, context, world = order_of(chain, plant), plant.CreateDefaultContext(), plant.world_frame()
    place, speed, push = np.zeros(chain.nv), np.zeros(chain.nv), np.zeros(chain.nv)
    place[order], speed[order], push[order] = at.q_full, v, efforts
    plant.SetPositions(context, place)
    plant.SetVelocities(context, speed)
    rows, drift = [], []
    for pair in points_of(chain):
        jacobians, biases = [], []
        for link, point in pair:
            about = context, JacobianWrtVariable.kV, plant.GetFrameByName(link), point[:, None], world, world
            jacobians.append(plant.CalcJacobianTranslationalVelocity(*about))
            biases.append(plant.CalcBiasTranslationalAcceleration(*about)[:, 0])
        rows.append(jacobians[1] - jacobians[0])
        drift.append(biases[1] - biases[0])
    rows, drift = np.concatenate(rows), np.concatenate(drift)
    mass = plant.CalcMassMatrix(context)
    push += plant.CalcGravityGeneralizedForces(context) - plant.CalcBiasTerm(context)
    free, moved = np.linalg.solve(mass, push), np.linalg.solve(mass, rows.T)
    force = np.linalg.lstsq(rows @ moved, -(rows @ free + drift), rcond=1e-10)[0]
    return (free + moved @ force)[order]


def swung(chain, step):
    """Configuration (nq,) after a free fall from home, in Drake with steps of `step` [s]."""
    plant = plant_of(chain, step)
    order, simulator = order_of(chain, plant), Simulator(plant)
    context, place = simulator.get_mutable_context(), np.zeros(chain.nq)
    place[order] = chain.home.q_full
    plant.SetPositions(context, place)
    simulator.AdvanceTo(DURATION)
    return plant.GetPositions(context)[order]


def main():
    """Compare accelerations, and a fall with two sizes of Drake's step."""
    chain, rng, worst = cutjoint.load("fivebar"), np.random.default_rng(0), 0.0
    plant = plant_of(chain, 0.0)
    for _ in range(20):
        at = chain.close(chain.home.q + 0.1 * rng.normal(size=chain.n))
        v, efforts = chain.full_velocity(at, rng.normal(size=chain.n)), chain.full_effort(rng.normal(size=chain.n))
        ours = chain.full_forward_dynamics(at, v, efforts).acceleration
        worst = max(worst, np.abs(hard_acceleration(chain, plant, at, v, efforts) - ours).max() / np.abs(ours).max())
    print(f"accelerations from Drake's matrices: {worst:.1e} apart, relative")
    assert worst < 1e-9

    ours = run(chain, duration=DURATION).q_full[-1]
    moved = np.abs(ours - chain.home.q_full).max()
    apart = {step: np.abs(swung(chain, step) - ours).max() for step in (1e-3, 1e-4)}
    told = ", ".join(f"{one:.1e} rad apart at steps of {step} s" for step, one in apart.items())
    print(f"a fall of {DURATION} s by {moved:.2f} rad: {told}")
    assert apart[1e-4] < 2e-3
    assert 5.0 < apart[1e-3] / apart[1e-4] < 20.0, "the difference should be that of a method of first order"


if __name__ == "__main__":
    main()
