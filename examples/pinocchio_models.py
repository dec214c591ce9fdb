# /// script
# requires-python = ">=3.11"
# dependencies = []
# ///
"""A closed robot in the hands of somebody who works with Pinocchio itself: constraint dynamics, shapes, collisions.

All that is handed out is fresh and the caller's own; nothing of it is a workspace of cutjoint.

cutjoint itself comes from a checkout: pip install '.[viewer]'
"""

import numpy as np
import pinocchio as pin

import cutjoint


def acceleration(chain, q, v, effort):
    """Acceleration of all joints (nv,) by `pin.constraintDynamics`, with the motors' efforts (n,)."""
    model, data = chain.model, chain.model.createData()
    constraints = chain.constraint_models()
    datas = chain.constraint_datas(constraints)
    pin.initConstraintDynamics(model, data, constraints, datas)
    settings = pin.ProximalSettings(1e-12, 1e-12, 1e-8, 20)  # redundant rows are normal, so the last but one is not 0
    return pin.constraintDynamics(model, data, q, v, chain.actuation @ effort, constraints, datas, settings)


def main():
    """Dynamics of the robots that ship with cutjoint, and what of a five-bar comes near what."""
    random, worst = np.random.default_rng(0), 0.0
    for name in ("fourbar", "fivebar", "cpm", "omega3", "stewart"):
        chain = cutjoint.load(name)
        at = chain.close(chain.home.q + 0.02 * random.normal(size=chain.n))
        v, effort = chain.full_velocity(at, random.normal(size=chain.n)), random.normal(size=chain.n)
        theirs = acceleration(chain, np.array(at.q_full), v, effort)
        ours = chain.full_forward_dynamics(at, v, chain.full_effort(effort)).acceleration
        worst = max(worst, np.abs(theirs - ours).max() / np.abs(ours).max())
    print(f"accelerations of five robots: {worst:.1e} apart, relative")
    assert worst < 1e-9

    chain = cutjoint.load("stewart")
    shapes = chain.visual_model()
    placed = pin.GeometryData(shapes)
    pin.updateGeometryPlacements(chain.model, chain.model.createData(), shapes, placed, np.array(chain.home.q_full))
    links, apart = chain.link_placements(chain.home), 0.0
    for one, where in zip(shapes.geometryObjects, placed.oMg, strict=True):
        link = chain.description.link(chain.model.frames[one.parentFrame].name)
        own = link.visuals[int(one.name.rpartition("_")[2])].placement
        apart = max(apart, np.abs(where.homogeneous - links[link.name] @ own).max())
    print(f"{shapes.ngeoms} shapes of a Stewart platform: placed alike to {apart:.1e} m")
    assert apart < 1e-12


if __name__ == "__main__":
    main()
