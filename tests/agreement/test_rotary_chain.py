"""The CPM limb by limb, and with rotary motors, against the closed chain: robots of random size and mass.

The paper's reduced models know nothing of Pinocchio or of the tree; the chain nothing of equations (1) to (39).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product

import numpy as np
import pinocchio as pin
import pytest

from cutjoint.arrays import readonly
from cutjoint.chain import ClosedChain
from cutjoint.compile import compiled
from cutjoint.crosscheck import SampledState, compare
from cutjoint.description import load_description
from cutjoint.description.model import Frame, Home, Inertial, RobotDescription
from cutjoint.errors import ClosureError, CutjointError, InputError, LimbReachError, SingularError
from cutjoint.mechanism import Posture
from cutjoint.papers.cpm import CpmModel, CpmRotaryModel, Parameters, forward
from cutjoint.papers.cpm import equations as eq
from cutjoint.robots import load

MODES = tuple(product((1, -1), repeat=3))
ALONG = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
TURN = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]])
TO_CENTRE = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])


def place(at: np.ndarray) -> np.ndarray:
    made = np.eye(4)
    made[:3, 3] = at
    return readonly(made)


def built(name: str, p: Parameters, joints: dict[str, float]) -> RobotDescription:
    """A CPM under urdf/ with the sizes and masses of `p`, half of a second rod's mass at each end; home at `joints`."""
    description = load_description(name)
    places = {"limb3_slide": place(np.array([0.0, p.D, 0.0])), "tool_mount": place(p.L * TO_CENTRE[0])}
    for i in range(3):
        limb, along = f"limb{i + 1}", ALONG[i]
        across = np.eye(3) - np.outer(along, along)
        places |= {f"{limb}_elbow": place(p.L1 * along), f"{limb}_wrist": place(p.L2 * along)}
        inertials = {
            "slider": Inertial(p.m3, np.zeros(3), 1e-3 * p.m3 * p.L1**2 * np.eye(3)),
            "proximal": Inertial(p.m1, 0.5 * p.L1 * along, p.m1 * p.L1**2 / 12 * across),
            "distal": Inertial(p.m2, 0.5 * p.L2 * along, p.m2 * p.L2**2 / 4 * across),
            "platform": Inertial(p.m4 / 3, p.L * TO_CENTRE[i], 1e-3 * p.m4 * p.L1**2 * np.eye(3)),
        }
        for part, inertial in inertials.items():
            description = description.with_inertial(f"{limb}_{part}", inertial)
    frames = [Frame(f"limb{i + 1}_platform", place(p.L * TO_CENTRE[i])) for i in range(3)]
    driven = {one: joints[one] for one in description.actuators}
    passive = {one: value for one, value in joints.items() if one not in driven}
    return replace(
        description,
        joints=tuple(replace(j, placement=places.get(j.name, j.placement)) for j in description.joints),
        cuts=tuple(replace(cut, a=frames[0], b=frames[k + 1]) for k, cut in enumerate(description.cuts)),
        homes=(Home("default", driven, passive),),
        gravity=readonly([0.0, 0.0, p.g]),
    )


def joints_of(p: Parameters, tool: np.ndarray, signs: tuple[int, ...]) -> dict[str, float]:
    """All joint coordinates of a posture, from both angles of each limb."""
    model = CpmModel(p, signs)
    values = {f"limb{i + 1}_slide": float(tool[i]) for i in range(3)}
    for i, (first, second) in enumerate(model.angles(model.close(tool)).tolist(), start=1):
        values |= {f"limb{i}_shoulder": first, f"limb{i}_elbow": second - first, f"limb{i}_wrist": -second}
    return values


@dataclass(frozen=True)
class Case:
    """A robot, its chain (linear or rotary) with home at the tool position, and the models of the paper."""

    p: Parameters
    signs: tuple[int, int, int]
    tool: np.ndarray
    scale: float
    chain: ClosedChain

    @property
    def linear(self) -> CpmModel:
        return CpmModel(self.p, self.signs)

    @property
    def rotary(self) -> CpmRotaryModel:
        return CpmRotaryModel(self.p, self.signs)


def cases(name: str, count: int, seed: int, least: float = 0.05) -> list[Case]:
    """Robots a third to three times the size of the paper's, at least so far from a type-2 singularity."""
    rng, made = np.random.default_rng(seed), []
    while len(made) < count:
        scale = 10.0 ** rng.uniform(-0.5, 0.5)
        p = Parameters(
            *(scale * rng.uniform((0.05, 0.35, 0.35, 0.8), (0.2, 0.6, 0.6, 1.2))),
            *rng.uniform(0.3, 2.0, 4),
            rng.uniform(2.0, 15.0),
        )
        tool, signs = scale * rng.uniform(0.1, 0.8, 3), MODES[len(made) % 8]
        ends = np.hypot(*np.transpose(eq.limb_ends(p, tuple(tool))))
        low, high = p.reach
        if (ends < low + 0.15 * (high - low)).any() or (ends > high - 0.15 * (high - low)).any():
            continue
        angles = eq.limb_angles(p, tuple(tool), signs)
        solutions = forward.solutions(p, angles)
        assert len(solutions)
        if abs(measure(p, signs, tool)) < least:
            continue
        chain = ClosedChain(built(name, p, joints_of(p, tool, signs)))
        made.append(Case(p, signs, tool, scale, chain))
    return made


def measure(p: Parameters, signs: tuple[int, ...], tool: np.ndarray) -> float:
    """The paper's condition of type 2: cos cos cos - sin sin sin of theta_12, theta_22, theta_32."""
    model = CpmModel(p, signs)
    second = model.angles(model.close(tool))[:, 1]
    return float(np.prod(np.cos(second)) - np.prod(np.sin(second)))


def posture_of(chain: ClosedChain, joints: dict[str, float]) -> Posture:
    """The chain's posture with all joints as given."""
    q = np.array(chain.home.q_full)
    for name, value in joints.items():
        q[chain.model.idx_qs[chain.model.getJointId(name)]] = value
    return chain.posture(q)


def index(chain: ClosedChain, joint: str) -> int:
    return int(chain.model.idx_vs[chain.model.getJointId(joint)])


def close_to(found: np.ndarray, wanted: np.ndarray, size: float = 0.0, tolerance: float = 1e-10) -> None:
    size = max(float(np.abs(wanted).max()), size)
    np.testing.assert_allclose(found, wanted, rtol=0.0, atol=tolerance * size)


# ---- limb by limb ----------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def linear_cases() -> list[Case]:
    return cases("cpm", 40, seed=1)


def moved(case: Case, rng: np.random.Generator) -> tuple[Posture, Posture, np.ndarray, np.ndarray]:
    """A posture around home in the chain's and in the paper's words, with a velocity and an acceleration."""
    tool = case.tool + 0.02 * case.scale * rng.uniform(-1, 1, 3)
    v, a = case.scale * rng.normal(size=3), 5 * case.scale * rng.normal(size=3)
    return case.chain.close(tool, limits="ignore"), case.linear.close(tool), v, a


def test_both_angles_and_their_rates_are_the_passive_joints(linear_cases: list[Case]) -> None:
    rng = np.random.default_rng(2)
    for case in linear_cases:
        at, there, v, _ = moved(case, rng)
        speeds = case.chain.full_velocity(at, v)
        for i in range(3):
            (first, second), (rate1, rate2) = case.linear.angles(there)[i], case.linear.angle_rates(there, v)[i]
            for joint, angle, rate in (
                ("shoulder", first, rate1),
                ("elbow", second - first, rate2 - rate1),
                ("wrist", -second, -rate2),
            ):
                k = case.chain.model.idx_qs[case.chain.model.getJointId(f"limb{i + 1}_{joint}")]
                off = at.q_full[k] - angle
                assert abs(off - 2 * np.pi * round(off / (2 * np.pi))) < 1e-11
                assert speeds[index(case.chain, f"limb{i + 1}_{joint}")] == pytest.approx(rate, rel=1e-10, abs=1e-10)


def test_energies_of_a_limb_are_those_of_its_bodies(linear_cases: list[Case]) -> None:
    """(12) to (17) against slider and rods in Pinocchio; what is left is the tool's."""
    rng = np.random.default_rng(3)
    for case in linear_cases:
        at, there, v, _ = moved(case, rng)
        model, data = case.chain.model, case.chain.model.createData()
        pin.forwardKinematics(model, data, np.array(at.q_full), np.array(case.chain.full_velocity(at, v)))
        kinetic, potential = np.zeros(4), np.zeros(4)
        for joint in range(1, model.njoints):
            body, limb = model.inertias[joint], int(model.names[joint][4]) - 1
            limb = 3 if model.names[joint].endswith("_wrist") else limb  # a third of the tool
            kinetic[limb] += 0.5 * data.v[joint].dot(body * data.v[joint])
            potential[limb] -= body.mass * model.gravity.linear @ data.oMi[joint].act(body.lever)
        found = case.linear.limb_energies(there, v)
        close_to(found.kinetic, kinetic)
        close_to(found.potential, potential)
        assert found.kinetic.sum() == pytest.approx(
            pin.computeKineticEnergy(model, data, np.array(at.q_full), np.array(case.chain.full_velocity(at, v)))
        )
        close_to(found.potential.sum(), np.array(case.chain.potential_energy(at)), np.abs(potential).max())


def test_multipliers_are_the_moments_on_the_first_rods(linear_cases: list[Case]) -> None:
    """(31) to (35) against Newton and Euler for the first rod with half the second at its end, moved by the chain."""
    rng = np.random.default_rng(4)
    for case in linear_cases:
        at, there, v, a = moved(case, rng)
        v_full, a_full = case.chain.full_motion(at, v, a)
        model, data = case.chain.model, case.chain.model.createData()
        pin.rnea(model, data, np.array(at.q_full), np.array(v_full), np.array(a_full))
        wanted = []
        for i in range(3):
            joint = model.getJointId(f"limb{i + 1}_shoulder")
            body = model.inertias[joint] + pin.Inertia(case.p.m2 / 2, case.p.L1 * ALONG[i], np.zeros((3, 3)))
            force = body * data.a_gf[joint] + data.v[joint].cross(body * data.v[joint])
            wanted.append(TURN[i] @ force.angular)
        close_to(case.linear.multipliers(there, v, a), np.array(wanted))


def test_tensions_are_the_forces_in_the_cuts(linear_cases: list[Case]) -> None:
    """Across the slider, the cut of a limb and its second rod move its third of the tool and the end of that rod."""
    rng = np.random.default_rng(5)
    for case in linear_cases:
        at, there, v, a = moved(case, rng)
        v_full, _ = case.chain.full_motion(at, v, a)
        effort = case.chain.inverse_dynamics(at, v, a)
        motion = case.chain.full_forward_dynamics(at, np.array(v_full), np.array(case.chain.full_effort(effort)))
        pull, angles = case.linear.rod_tensions(there, v, a), case.linear.angles(there)[:, 1]
        needed = (case.p.m4 / 3 + case.p.m2 / 2) * (a - [0.0, 0.0, case.p.g])
        for i in (1, 2):
            rod = np.cos(angles[i]) * ALONG[i] + np.sin(angles[i]) * np.cross(TURN[i], ALONG[i])
            force = motion.loop_forces[f"limb{i + 1}_to_platform"].force - pull[i] * rod
            across = np.eye(3) - np.outer(TURN[i], TURN[i])
            close_to(across @ force, across @ needed, np.abs(pull).max(), 1e-8)


# ---- rotary motors ---------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def rotary_cases() -> list[Case]:
    return cases("cpm_rotary", 40, seed=6)


def test_every_quantity_of_random_robots_in_every_working_mode(rotary_cases: list[Case]) -> None:
    """Jacobian, drift, mass matrix, Coriolis, gravity and both directions of the dynamics."""
    rng, done = np.random.default_rng(7), 0
    for case in rotary_cases:
        model = case.rotary
        for _ in range(8):
            tool = case.tool + 0.05 * case.scale * rng.uniform(-1, 1, 3)
            try:
                if abs(measure(case.p, case.signs, tool)) < 0.05:
                    continue
            except (LimbReachError, SingularError):
                continue
            at = posture_of(case.chain, joints_of(case.p, tool, case.signs))
            there = Posture(at.q, np.array([*at.q, *tool]))
            done += 1
            v, a = rng.normal(size=3), 5 * rng.normal(size=3)
            mine, its = model.tool(there, v), case.chain.tool(at, v)
            close_to(mine.position, its.position, case.scale)
            close_to(mine.jacobian, its.jacobian)
            close_to(mine.drift, its.drift)
            mine_, its_ = model.terms(there, v), case.chain.terms(at, v)
            for name in ("mass", "coriolis", "gravity"):
                close_to(getattr(mine_, name), getattr(its_, name))
            effort = case.chain.inverse_dynamics(at, v, a)
            close_to(model.inverse_dynamics(there, v, a), effort)
            pushed = effort + np.abs(effort).max() * rng.normal(size=3)
            close_to(model.forward_dynamics(there, v, pushed), case.chain.forward_dynamics(at, v, pushed))
    assert done > 200


@pytest.mark.parametrize("signs", MODES)
def test_the_shipped_robot_agrees_in_each_of_its_homes(signs: tuple[int, int, int]) -> None:
    name = "default" if signs == (1, 1, 1) else "".join("p" if sign > 0 else "m" for sign in signs)
    chain, model = load("cpm_rotary", "lumped", name), CpmRotaryModel(signs=signs)
    np.testing.assert_allclose(chain.home.q, model.home.q, rtol=0, atol=1e-12)
    np.testing.assert_allclose(chain.tool(chain.home).position, CpmModel().home.q, rtol=0, atol=1e-12)
    assert model.branch(model.home).signs == signs
    rng, states = np.random.default_rng(8), []
    while len(states) < 12:
        try:
            at = model.reach(CpmModel().home.q + rng.uniform(-0.1, 0.1, 3))
        except SingularError:
            continue
        if abs(model.singularities(at)[1]) > 0.05:
            v, a, effort = rng.normal(size=3), 5 * rng.normal(size=3), 50 * rng.normal(size=3)
            states.append(SampledState(at, model.tool(at).position, v, a, effort))
    compare(chain, model, states).require()


def test_the_compiler_takes_the_chain_and_says_why_not_the_model() -> None:
    """An eighth-degree polynomial has no closed solution; the chain's loops are closed by Newton's method."""
    with pytest.raises(InputError, match="compile the robot's closed chain"):
        compiled(CpmRotaryModel())
    chain, model = load("cpm_rotary", "lumped"), CpmRotaryModel()
    v, effort = np.array([0.3, -0.2, 0.4]), np.array([10.0, 20.0, 5.0])
    found = compiled(chain).forward_dynamics(chain.home, v, effort)
    close_to(found, model.forward_dynamics(model.home, v, effort))


def test_closing_leads_both_to_the_same_posture(rotary_cases: list[Case]) -> None:
    """Walked by two methods, one branch.  Where the straight way is proved to end in a singularity, the chain may find
    a way around it, but never comes out on its other side."""
    rng, same, refused = np.random.default_rng(9), 0, 0
    for case in rotary_cases[:24]:
        home, model = case.chain.home, case.rotary
        start = Posture(home.q, np.array([*home.q, *case.tool]))
        for _ in range(2):
            target = home.q + 0.4 * rng.uniform(-1, 1, 3)
            try:
                there = model.close(target, start)
            except (SingularError, ClosureError):
                refused += 1
                try:
                    at = case.chain.close(target, limits="ignore")
                except CutjointError:
                    continue
                there = Posture(target, np.array([*target, *case.chain.tool(at).position]))
                assert model.branch(there).assembly == model.branch(start).assembly
                continue
            same += 1
            close_to(
                case.chain.tool(case.chain.close(target, limits="ignore")).position, there.q_full[3:], case.scale, 1e-9
            )
    assert same > 20
    assert refused > 2


# ---- singularities ---------------------------------------------------------------------------------------------------


def other_side(case: Case, rng: np.random.Generator) -> np.ndarray | None:
    """A tool position of the same working mode whose measure has the other sign."""
    for _ in range(40):
        tool = case.tool + case.scale * rng.uniform(-0.3, 0.3, 3)
        try:
            if measure(case.p, case.signs, tool) * measure(case.p, case.signs, case.tool) < 0:
                return tool
        except (LimbReachError, SingularError):
            continue
    return None


def test_type_2_of_the_paper_and_of_the_chain_vanish_together(rotary_cases: list[Case]) -> None:
    """Between two postures of other sign: the chain's least singular value is zero where the paper's condition is, and
    on either side grows with it, which changes its sign."""
    rng, found = np.random.default_rng(10), 0
    for case in rotary_cases:
        other = other_side(case, rng)
        if other is None:
            continue

        def mine(s: float, case: Case = case, other: np.ndarray = other) -> float:
            return measure(case.p, case.signs, case.tool + s * (other - case.tool))

        def its(s: float, case: Case = case, other: np.ndarray = other) -> float:
            joints = joints_of(case.p, case.tool + s * (other - case.tool), case.signs)
            return case.chain.mobility(posture_of(case.chain, joints)).type2

        try:
            low, high, first = 0.0, 1.0, mine(0.0)
            for _ in range(50):
                middle = 0.5 * (low + high)
                low, high = (middle, high) if mine(middle) * first > 0 else (low, middle)
            beyond = min(1.0 - high, high, 1e-3)
            here, before, after = ((mine(s), its(s)) for s in (high, high - beyond, high + beyond))
        except (LimbReachError, SingularError):
            continue
        found += 1
        assert abs(here[0]) < 1e-12
        assert here[1] < 1e-9
        assert before[0] * after[0] < 0
        ratios = [side[1] / abs(side[0]) for side in (before, after)]
        assert ratios[0] == pytest.approx(ratios[1], rel=0.1)
        assert min(ratios) > 0.02
        assert its(0.0) > 1e-3
    assert found > 15


def test_type_2_of_the_chain_is_never_small_without_the_papers(rotary_cases: list[Case]) -> None:
    """And the other way round, over random postures: neither is zero without the other."""
    rng, ratios = np.random.default_rng(11), []
    for case in rotary_cases:
        for _ in range(6):
            tool = case.tool + 0.1 * case.scale * rng.uniform(-1, 1, 3)
            try:
                posture = posture_of(case.chain, joints_of(case.p, tool, case.signs))
                mine = abs(measure(case.p, case.signs, tool))
            except (LimbReachError, SingularError):
                continue
            ratios.append(case.chain.mobility(posture).type2 / mine)
    assert len(ratios) > 150
    assert max(ratios) < 50 * min(ratios)


def test_type_1_of_the_paper_and_of_the_chain_vanish_together(rotary_cases: list[Case]) -> None:
    """The motor of one limb turned until the limb is stretched: the chain's tool loses a direction just there."""
    found = 0
    for case in rotary_cases[:24]:
        model, limb = case.rotary, found % 3
        home = case.chain.home.q
        start = Posture(np.array(home), np.array([*home, *case.tool]))
        bend = float(model.singularities(start)[0][limb])
        target = np.array(home)
        target[limb] += 1.6 * np.arcsin(bend)
        try:
            model.close(target, start)
        except (SingularError, ClosureError):
            continue

        def along(s: float, model: CpmRotaryModel = model, start: Posture = start, end: np.ndarray = target) -> Posture:
            return model.close(start.q + s * (end - start.q), start)

        if model.singularities(along(1.0))[0][limb] * bend > 0:
            continue
        low, high = 0.0, 1.0
        for _ in range(45):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if model.singularities(along(middle))[0][limb] * bend > 0 else (low, middle)
        sizes = []
        for s in (high, high - 0.02):
            there = along(s)
            at = case.chain.close(there.q, limits="ignore")
            close_to(case.chain.tool(at).position, there.q_full[3:], case.scale, 1e-9)
            sizes.append((abs(model.singularities(there)[0][limb]), case.chain.mobility(at).type1))
        assert sizes[0][0] < 1e-10
        assert sizes[0][1] < 1e-9
        assert sizes[1][1] > 1e-4
        found += 1
    assert found > 3
