"""The plants against each other, and against conservation laws."""

from itertools import pairwise

import numpy as np
import pytest

from cutjoint.control import NoControl
from cutjoint.errors import InputError, SimulationError
from cutjoint.motion import Hold, Reference
from cutjoint.simulation import Adaptive, ConstrainedPlant, DormandPrince, ReducedPlant, RungeKutta4, run

# One law in every run of the tests, the others in the slow ones.
LAWS = [
    "pd",
    *(pytest.param(name, marks=pytest.mark.slow) for name in ("pd-gravity", "feedforward", "computed-torque")),
]


@pytest.mark.slow
@pytest.mark.parametrize("name", LAWS)
def test_constrained_and_reduced_plant_move_alike(robot, name):
    """Two formulations, two programs, one motion: within 1e-8 m all along (1e-13 m for most of them)."""
    settings = {"integrator": RungeKutta4(2e-3), "duration": min(4.0, 2 * robot.trajectory.duration), "every": 0.02}
    reduced = run(ReducedPlant(robot.paper), robot.law(name), robot.reference, **settings)
    constrained = run(ConstrainedPlant(robot.chain), robot.law(name), robot.reference, **settings)
    assert np.abs(reduced.tool - constrained.tool).max() < 1e-8
    assert np.abs(reduced.effort - constrained.effort).max() < 1e-6
    assert np.allclose(reduced.energy - reduced.energy[0], constrained.energy - constrained.energy[0], atol=1e-9)


def crossed(robot, chain, duration=0.5):
    """Controller on one model and plant on the other, both ways, PD + gravity: largest distance of the tools [m]."""
    settings = {"integrator": RungeKutta4(2e-3), "duration": duration, "every": 0.01}
    one = run(ReducedPlant(robot.paper), robot.law("pd-gravity", chain), Reference(robot.trajectory, chain), **settings)
    two = run(ConstrainedPlant(chain), robot.law("pd-gravity"), robot.reference, **settings)
    return np.abs(one.tool - two.tool).max()


@pytest.mark.slow
def test_crossed_pairs_agree_and_a_spoiled_mass_shows(robot):
    assert crossed(robot, robot.chain) < 1e-8
    assert crossed(robot, robot.spoiled(1.01)) > 1e-6


def test_loops_stay_closed_and_drift_without_projection(robot):
    settings = {"integrator": RungeKutta4(5e-3), "duration": 1.0}
    kept = run(ConstrainedPlant(robot.chain), robot.law("feedforward"), robot.reference, **settings)
    left = run(ConstrainedPlant(robot.chain, project=False), robot.law("feedforward"), robot.reference, **settings)
    assert max(kept.loop_gap()) < 1e-12
    assert kept.about["strayed"] > 0.0
    assert left.loop_gap()[0] > 1e3 * max(kept.loop_gap()[0], 1e-15)


@pytest.mark.parametrize("method", [DormandPrince(1e-3, 1e-4), Adaptive(1e-3, 1e-4), Adaptive(1e-3, 1e-4, "RK45")])
def test_every_step_starts_with_the_slope_of_the_state_it_starts_from(robot, method):
    """A step ends with the slope of its own end, which is another state once that was put back onto the loops."""
    moved = []

    class Watched:
        name, interpolates = method.name, method.interpolates

        def first(self, *given):
            return method.first(*given)

        def step(self, field, t, y, slope, h, end, span):
            fresh = field(t, y)
            assert np.abs(slope - fresh).max() <= 1e-11 * np.abs(fresh).max()
            made = method.step(field, t, y, slope, h, end, span)
            moved.append((made.y, made.slope, fresh))
            return made

    plant = ConstrainedPlant(robot.chain)
    found = run(plant, robot.law("pd"), robot.reference, integrator=Watched(), duration=0.2)
    assert found.about["strayed"] > 1e-9
    assert len(moved) > 5
    # The slope at the end of a step differs from the one that the next starts with by far more than rounding.
    apart = [np.abs(end[1] - start[2]).max() for end, start in pairwise(moved)]
    assert max(apart) > 1e-9 * np.abs(moved[-1][2]).max()


@pytest.mark.slow
@pytest.mark.parametrize("plant", ["reduced", "constrained"])
def test_runge_kutta_4_converges_with_slope_4(robot, plant):
    made = ReducedPlant(robot.paper) if plant == "reduced" else ConstrainedPlant(robot.chain)
    start = 0.9 * robot.reference.at(0.0).v
    settings = {"duration": 0.24, "start_velocity": start, "every": 0.24}
    law = robot.law("feedforward")
    truth = run(made, law, robot.reference, integrator=Adaptive(1e-12, 1e-14), **settings).tool[-1]
    errors = [
        np.linalg.norm(run(made, law, robot.reference, integrator=RungeKutta4(h), **settings).tool[-1] - truth)
        for h in (4e-3, 2e-3, 1e-3)
    ]
    slopes = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.allclose(slopes, 4.0, atol=0.2), (slopes, errors)


def test_free_fall_keeps_energy_until_a_limb_is_nearly_singular(robot):
    """No effort, no work: kinetic and potential energy add up until an elbow is within 0.1 rad of stretched."""
    for plant in (ReducedPlant(robot.paper), ConstrainedPlant(robot.chain)):
        still = Reference(Hold(plant.mechanism.tool(plant.mechanism.home).position), plant.mechanism)
        fall = 0.30 if robot.name == "cpm" else 0.21
        result = run(plant, NoControl(), still, integrator=Adaptive(1e-11, 1e-13), duration=fall, every=1e-2)
        assert result.energy_drift() < 1e-8
        assert np.abs(result.work).max() == 0.0
        assert result.kinetic.max() > 0.1 * np.ptp(result.potential) > 0.0


@pytest.mark.slow
def test_the_constrained_plant_passes_limb_singularities_where_the_reduced_one_stops(robot):
    """A stretched limb is a singular point of actuated coordinates, not of the robot."""
    still = Reference(Hold(robot.paper.tool(robot.paper.home).position, 0.5), robot.paper)
    with pytest.raises(SimulationError):
        run(ReducedPlant(robot.paper), NoControl(), still, integrator=Adaptive(1e-9, 1e-11))
    through = run(
        ConstrainedPlant(robot.chain), NoControl(), still, integrator=Adaptive(1e-11, 1e-13), joint_limits="ignore"
    )
    assert through.time[-1] == 0.5
    assert through.energy_drift() < 1e-7
    assert max(through.loop_gap()) < 1e-11


@pytest.mark.slow
@pytest.mark.parametrize("plant", ["reduced", "constrained"])
def test_actuators_do_all_the_work_for_ten_seconds(robot, plant):
    made = ReducedPlant(robot.paper) if plant == "reduced" else ConstrainedPlant(robot.chain)
    result = run(
        made, robot.law("feedforward"), robot.reference, integrator=Adaptive(1e-9, 1e-11), duration=10.0, every=0.1
    )
    assert result.energy_drift() < 1e-8


@pytest.mark.slow
def test_loops_stay_closed_for_a_minute(cpm):
    result = run(
        ConstrainedPlant(cpm.chain),
        cpm.law("feedforward"),
        cpm.reference,
        integrator=RungeKutta4(4e-3),
        duration=60.0,
        every=0.1,
    )
    assert max(result.loop_gap()) < 1e-9


def test_payload_changes_the_plant_and_not_the_controller(robot):
    heavy = robot.chain.with_payload(0.2)
    settings = {"integrator": RungeKutta4(2e-3), "duration": 0.4, "every": 0.01}
    plain = run(ConstrainedPlant(robot.chain), robot.law("computed-torque"), robot.reference, **settings)
    loaded = run(ConstrainedPlant(heavy), robot.law("computed-torque"), robot.reference, **settings)
    aware = run(
        ConstrainedPlant(heavy),
        robot.law("computed-torque", robot.paper.with_payload(0.2)),
        robot.reference,
        **settings,
    )
    assert np.abs(loaded.tool - plain.tool).max() > 1e-4
    assert np.abs(aware.tool - plain.tool).max() < 1e-8


def test_a_chain_without_a_tool_is_refused(cpm):
    from dataclasses import replace

    from cutjoint.chain import ClosedChain

    with pytest.raises(InputError, match="no tool frame"):
        ConstrainedPlant(ClosedChain(replace(cpm.description, tool=None)))
