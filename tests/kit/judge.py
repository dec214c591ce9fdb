"""Cutjoint's dynamics of a robot against the oracle's, as relative differences by quantity.

Everything is compared dimensionless: lengths over the robot's length, forces times it.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from kit.by_joint import by_joint, full, placed
from kit.postures import scale_of
from oracles.maximal import Maximal
from oracles.motion import Motion, State

from cutjoint.errors import ActuationError, DynamicsError, SingularError

Array = np.ndarray


def relative(found: Array, wanted: Array, least: float = 0.0) -> float:
    """Largest difference against the largest wanted number, or `least` where that is smaller; NaN is infinite."""
    difference = float(np.abs(np.asarray(found) - np.asarray(wanted)).max(initial=0.0))
    size = max(float(np.abs(wanted).max(initial=0.0)), least)
    if difference == 0.0:
        return 0.0
    return difference / size if np.isfinite(difference) and size > 0.0 else np.inf


def mobility(chain: Any, oracle: Maximal, at: Any) -> None:
    """Mobility, ranks and redundancy are the oracle's."""
    p, report = placed(chain, oracle, at.q_full), chain.mobility(at)
    rows = len(p.loop_rows)
    found = (report.velocities, report.rows, report.rank, report.mobility, len(report.redundant_rows))
    wanted = (oracle.velocities, rows, p.loop_rank, p.mobility, rows - p.loop_rank)
    assert found == wanted, f"velocities, rows, rank, mobility, redundant {found}, wanted {wanted}, {p.margin}"
    assert bool(report.free) == bool(p.locked.shape[1]), f"free {report.free}, wanted {p.locked.shape[1]}"


def forward(chain: Any, state: State, at: Any, v: Array, effort: Array, compiled: Any = None) -> dict[str, float]:
    """Full forward dynamics: accelerations, both equations, loop forces."""
    motion = state.driven(by_joint(chain, effort))
    result = chain.full_forward_dynamics(at, v, effort)
    differences = {
        "acceleration": apart(chain, motion, result.acceleration),
        "unchecked": apart(chain, motion, chain.full_acceleration(at.q_full, v, effort)),
        "loop forces": loop_forces(motion, result),
        **equations(chain, motion, result.acceleration),
    }
    if compiled is not None:
        differences["compiled"] = apart(chain, motion, compiled.full_acceleration(at.q_full, v, effort))
    return differences


def apart(chain: Any, motion: Motion, acceleration: Array) -> float:
    """Accelerations of all joints against the oracle's; motions that move no mass are free to differ."""
    state = motion.state
    scale = scale_of(chain, state.placed.oracle)
    wanted = full(chain, motion.joints)
    difference = (acceleration - wanted) / scale
    if state.massless.shape[1]:
        names = state.placed.oracle.velocity
        free = np.stack([full(chain, {n: c[own] for n, own in names.items()}) / scale for c in state.massless.T], 1)
        basis = np.linalg.qr(free)[0]
        difference = difference - basis @ (basis.T @ difference)
    size = max(float(np.abs(wanted / scale).max(initial=0.0)), _falling(state))
    return float(np.abs(difference).max(initial=0.0)) / size if np.isfinite(difference).all() else np.inf


def _falling(state: State) -> float:
    """What a free fall over the robot's length is as a dimensionless acceleration: what structures are measured by."""
    oracle = state.placed.oracle
    return float(np.linalg.norm(oracle.robot.gravity)) / oracle.length


def equations(chain: Any, motion: Motion, acceleration: Array) -> dict[str, float]:
    """What an acceleration of all joints leaves of the projected Newton equation and of the constraints."""
    state, p = motion.state, motion.state.placed
    flat = p.oracle.flat(by_joint(chain, acceleration))
    twists = state._tree_start + p.tree @ flat
    left = p.motions.T @ (p.mass @ twists - motion.load)
    terms = np.abs(p.motions.T) @ (np.abs(p.mass @ twists) + np.abs(motion.load))
    rows = p.loop_rows @ twists + state.constraint_drift[len(p.tree_rows) :]
    entries = np.abs(p.loop_rows) @ np.abs(p.tree)  # before anything cancels
    rates = entries @ (np.abs(flat) + _falling(state) * p._velocity_scale)
    rates = rates + np.abs(state.constraint_drift[len(p.tree_rows) :])
    rates = rates + 1e-6 * float(np.abs(twists).max(initial=0.0))  # where the cuts' frames stand still
    return {
        "Newton's equation": relative(left, np.zeros_like(left), float(terms.max(initial=1e-300))),
        "K a + gamma": relative(rows, np.zeros_like(rows), float(rates.max(initial=1e-300))),
    }


def loop_forces(motion: Motion, result: Any) -> float:
    """Wrenches of all cuts and forces of all couplings against the least ones."""
    p = motion.state.placed
    length = p.oracle.length
    assert set(result.loop_forces) == set(motion.wrenches)
    assert set(result.couplings) == set(motion.couplings)
    found, wanted = [], []
    for name, (force, moment) in motion.wrenches.items():
        one = result.loop_forces[name]
        found += [length * np.asarray(one.force), np.asarray(one.moment)]
        wanted += [length * force, moment]
    for name, force in motion.couplings.items():
        found.append(np.array([result.couplings[name] * p._unit(_joint_of(p, name))]))
        wanted.append(np.array([force * p._unit(_joint_of(p, name))]))
    if not wanted:
        return 0.0
    # where the loops carry nothing, what is left is measured by the loads that they might have carried
    loads = float(np.abs(p._velocity_scale * (p.tree.T @ motion.load)).max(initial=0.0))
    return relative(np.concatenate(found), np.concatenate(wanted), 1e-3 * loads)


def _joint_of(p: Any, coupling: str) -> str:
    return next(one.joint for one in p.oracle.robot.couplings if one.name == coupling)


def actuated(chain: Any, oracle: Maximal, at: Any, rng: np.random.Generator, compiled: Any = None) -> dict[str, float]:
    """Inverse and forward dynamics in actuated coordinates; empty where the actuators do not determine the motion.

    Speeds and accelerations are of the size that gravity gives to a robot as large.  Freedoms that no actuator moves
    are let be where they do not move the tool; where they do, cutjoint must refuse.  Where a robot has such freedoms
    and no tool it may do either.
    """
    p = placed(chain, oracle, at.q_full)
    names = oracle.robot.actuators
    if leverage(p) < WELL_LED:
        return {}
    left = p.locked.shape[1]
    determined = len(names) + left == p.mobility
    if not determined or (left and (oracle.robot.tool is None or not p.idle)):
        refused = _refuses(chain, at)
        assert refused or (determined and oracle.robot.tool is None), "the actuators do not determine the motion"
        if refused:
            return {}
    falling = float(np.linalg.norm(oracle.robot.gravity)) / oracle.length or 1.0
    speeds = np.sqrt(falling) * rng.normal(size=len(names)) * _sizes(chain)
    changes = falling * rng.normal(size=len(names)) * _sizes(chain)
    state = p.with_actuators(dict(zip(names, speeds, strict=True)))
    efforts, motion = state.led(dict(zip(names, changes, strict=True)))
    if opens(motion):
        assert _refuses(chain, at, speeds), "inverse dynamics where no acceleration keeps the loops closed"
        return {}
    wanted = np.array([efforts[name] for name in names])
    differences: dict[str, float] = {}
    for what, robot in {"": chain, "compiled ": compiled}.items():
        if robot is None:
            continue
        effort = robot.inverse_dynamics(at, speeds, changes)
        size = _sizes(chain)
        loads = 1e-3 * float(np.abs(p._velocity_scale * (p.tree.T @ motion.load)).max(initial=0.0))
        differences[f"{what}inverse"] = relative(effort * size, wanted * size, loads)
        back = robot.forward_dynamics(at, speeds, effort)
        differences[f"{what}round trip"] = relative(back / size, changes / size, _drift(chain, motion))
        there = robot.forward_dynamics(at, speeds, wanted)
        differences[f"{what}forward"] = relative(there / size, changes / size, _drift(chain, motion))
        mass = robot.terms(at, speeds).mass
        differences[f"{what}kinetic energy"] = relative(0.5 * speeds @ mass @ speeds, state.kinetic_energy)
    return differences


WELL_LED = 0.01
"""Nearer to a type-2 singularity than this, what actuators determine is not judged."""


def leverage(p: Any) -> float:
    """How well the actuators tell apart the motions that they lead: the smallest singular value that counts."""
    held = p.joint_motions()[p._actuated] / p._velocity_scale[p._actuated, None]
    values = np.linalg.svd(held, compute_uv=False) if held.size else np.zeros(0)
    return float(values[values > 1e-9].min(initial=1.0))


def _drift(chain: Any, motion: Motion) -> float:
    """Size of the accelerations that the actuators' own stand beside, dimensionless."""
    return float(np.abs(full(chain, motion.joints) / scale_of(chain, motion.state.placed.oracle)).max(initial=0.0))


def _sizes(chain: Any) -> Array:
    return np.array([chain.length if one.kind == "translation" else 1.0 for one in chain.actuators])


def _refuses(chain: Any, at: Any, speeds: Array | None = None) -> bool:
    speeds = np.zeros(chain.n) if speeds is None else speeds
    try:
        chain.inverse_dynamics(at, speeds, np.zeros(chain.n))
    except (ActuationError, SingularError, DynamicsError):
        return True
    return False


def opens(motion: Motion) -> bool:
    """Whether a singular posture's velocities open the loops in the next moment, whatever the accelerations."""
    return motion.unmet[0] > 1e-7 * (1.0 + float(np.abs(motion.state.constraint_drift).max(initial=0.0)))


def full_inverse(chain: Any, state: State, at: Any, v: Array, effort: Array) -> float:
    """Least efforts for a motion that the actuators can produce, against the oracle's."""
    motion = state.driven(by_joint(chain, effort))
    acceleration = full(chain, motion.joints)
    wanted, part = state.efforts_for(motion.joints)
    assert part < 1e-9, "the oracle's own motion by its actuators needs others"
    found = chain.full_inverse_dynamics(at, v, acceleration).effort
    p = state.placed
    # efforts are what is left of the terms of all bodies, whose rounding they bear
    terms = np.abs(p.tree).T @ (np.abs(p.mass) @ np.abs(motion.accelerations) + np.abs(motion.load))
    loads = 1e-3 * float((p._velocity_scale * terms).max(initial=0.0))
    return relative(found * _sizes(chain), np.array(list(wanted.values())) * _sizes(chain), loads)


def potential_energy(chain: Any, oracle: Maximal, at: Any) -> float:
    """Potential energy against the oracle's, relative to the weights times their distances."""
    p = placed(chain, oracle, at.q_full)
    size = sum(body.mass for body in oracle.robot.bodies.values()) * np.linalg.norm(oracle.robot.gravity)
    far = max(float(np.linalg.norm(pose.position)) for pose in p.poses.values())
    reach = far + float(np.linalg.norm(oracle.origin)) + oracle.length
    return relative(np.array(chain.potential_energy(at)), np.array(p.potential_energy), float(size * reach))


def everything(
    chain: Any, oracle: Maximal, at: Any, v: Array, effort: Array, rng: np.random.Generator, compiled: Any = None
) -> dict[str, float]:
    """All of the above at a posture; v (nv,) must be a motion that the loops allow, effort (nv,) is arbitrary."""
    p = placed(chain, oracle, at.q_full)
    state = p.moving(by_joint(chain, v))
    mobility(chain, oracle, at)
    own = np.zeros(chain.nv)
    own[chain._actuated.v_index] = effort[chain._actuated.v_index]
    return {
        "gap": p.gap,
        "open velocity": state.unmet,
        "potential energy": potential_energy(chain, oracle, at),
        "full inverse": full_inverse(chain, state, at, v, own),
        **forward(chain, state, at, v, effort, compiled),
        **actuated(chain, oracle, at, rng, compiled),
    }


def require(differences: dict[str, float], limit: float, what: str = "") -> None:
    """Fail with those quantities that are off by more than the limit."""
    off = {name: value for name, value in differences.items() if not value <= limit}
    assert not off, f"{what}{': ' if what else ''}{off}"
