"""Random MJCF: joints of all types, anywhere in their bodies, with references, and equalities that hold in one posture;
and what MuJoCo's own matrices say of their accelerations."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

Rng = np.random.Generator


def words(values) -> str:
    return " ".join(repr(float(value)) for value in np.atleast_1d(values))


def unit(rng: Rng, size: int = 3) -> np.ndarray:
    values = rng.normal(size=size)
    return values / np.linalg.norm(values)


def pose(rng: Rng) -> str:
    """A placement, said in one of the ways that MJCF has."""
    place = f'pos="{words(rng.uniform(-0.3, 0.3, 3))}"'
    ways = ("", f'quat="{words(unit(rng, 4))}"', f'euler="{words(rng.uniform(-1, 1, 3))}"',
            f'axisangle="{words([*unit(rng), rng.uniform(-2, 2)])}"', f'zaxis="{words(unit(rng))}"',
            f'xyaxes="{words(np.concatenate([unit(rng), unit(rng)]))}"')  # fmt: skip
    return f"{place} {ways[rng.integers(len(ways))]}"


def inertia(rng: Rng) -> str:
    """Said as moments, or as geoms."""
    if rng.integers(2):
        shapes = (f'type="box" size="{words(rng.uniform(0.02, 0.1, 3))}"', f'size="{words(rng.uniform(0.02, 0.1))}"',
                  f'type="capsule" size="0.02" fromto="{words(rng.uniform(-0.2, 0.2, 6))}"')  # fmt: skip
        return "".join(
            f"<geom {one} {pose(rng) if 'fromto' not in one else ''}/>" for one in rng.permutation(shapes)[:2]
        )
    points, masses = rng.normal(size=(5, 3)) * 0.1, rng.uniform(0.1, 1.0, 5)
    arms = points - masses @ points / masses.sum()
    tensor = sum(m * (r @ r * np.eye(3) - np.outer(r, r)) for m, r in zip(masses, arms, strict=True))
    entries = [tensor[at] for at in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
    at = words(rng.uniform(-0.1, 0.1, 3))
    return f'<inertial pos="{at}" mass="{masses.sum()}" fullinertia="{words(entries)}"/>'


def joints(rng: Rng, number: int, free: bool, degrees: bool) -> tuple[str, list[str]]:
    """What moves a body, and the names of its hinges and slides."""
    if free:
        return f'<joint name="free{number}" type="free" damping="{rng.uniform(0, 1)}"/>', []
    sets = [
        ["hinge"],
        ["slide"],
        ["ball"],
        ["hinge", "hinge"],
        ["slide", "hinge"],
        ["slide", "ball"],
        ["hinge", "slide"],
    ]
    text, names = "", []
    for count, kind in enumerate(sets[rng.integers(len(sets))]):
        name = f"j{number}{'abc'[count]}"
        physics = f'damping="{rng.uniform(0, 1)}" armature="{rng.uniform(0, 0.1)}" stiffness="{rng.uniform(0, 5)}"'
        at = f'pos="{words(rng.uniform(-0.1, 0.1, 3))}"' if rng.integers(3) else ""
        if kind != "ball":
            names.append(name)
            turned = np.degrees(1.0) if degrees and kind == "hinge" else 1.0
            physics += f' axis="{words(rng.normal(size=3))}"'
            if rng.integers(2):
                physics += f' ref="{turned * rng.uniform(-1, 1)}" springref="{turned * rng.uniform(-1, 1)}"'
        text += f'<joint name="{name}" type="{kind}" {at} {physics}/>'
    return text, names


@dataclass
class Random:
    """A model as text; `single` are its hinges and slides."""

    text: str
    single: list[str]


def random_model(rng: Rng, ties: bool = True) -> Random:
    """A tree of some bodies with equalities; the `connect`s and `weld`s hold at `qpos0`."""
    degrees = bool(rng.integers(2))
    bodies, single, names, sites = "", [], [], ""
    count, opened = int(rng.integers(2, 6)), 0
    for number in range(count):
        while opened and rng.uniform() < 0.4:
            bodies, opened = bodies + "</body>", opened - 1
        text, found = joints(rng, number, opened == 0 and rng.uniform() < 0.3, degrees)
        single += found
        names.append(f"b{number}")
        framed = rng.uniform() < 0.3
        name = f'name="b{number}"'
        if number % 2:
            name += f' gravcomp="{words(rng.spawn(1)[0].uniform(0.1, 1.5))}"'
        bodies += f"<frame {pose(rng)}>" * framed
        bodies += f'<body {name} {pose(rng)}>{text}{inertia(rng)}<site name="s{number}" {pose(rng)}/>'
        bodies, opened = (bodies + "</body></frame>", opened) if framed else (bodies, opened + 1)
    bodies += "</body>" * opened
    sites = f'<site name="world_site" {pose(rng)}/>'
    equality, tendon = _ties(rng, names, single, degrees) if ties else ("", "")
    motors = "".join(f'<motor joint="{name}"/>' for name in single if rng.integers(2))
    text = f"""<mujoco model="random">
  <compiler angle="{"degree" if degrees else "radian"}"/>
  <option gravity="{words(rng.normal(size=3) * 5)}"/>
  <worldbody>{sites}{bodies}</worldbody>
  <tendon>{tendon}</tendon><equality>{equality}</equality><actuator>{motors}</actuator>
</mujoco>"""
    return Random(text, single)


def _ties(rng: Rng, names: list[str], single: list[str], degrees: bool) -> tuple[str, str]:
    equality, tendon = "", ""
    a, b = (f"b{number}" for number in rng.permutation(len(names))[:2])
    at = words(rng.uniform(-0.1, 0.1, 3))
    cuts = ["", f'<connect body1="{a}" anchor="{at}"/>', f'<connect body1="{a}" body2="{b}" anchor="{at}"/>']
    cuts += [f'<weld body1="{a}" body2="{b}" anchor="{at}"/>', f'<weld body1="{a}" anchor="{at}" torquescale="0"/>']
    equality += cuts[rng.integers(len(cuts))]
    if len(single) >= 2 and rng.integers(2):
        one, two = rng.permutation(single)[:2]
        polynomial = words([rng.uniform(-0.2, 0.2), rng.normal(), *(rng.normal(size=3) * 0.3 * rng.integers(2))])
        driver = f'joint2="{two}"' if rng.integers(3) else ""
        equality += f'<joint joint1="{one}" {driver} polycoef="{polynomial}"/>'
    if len(single) >= 3 and rng.integers(2):
        terms = "".join(f'<joint joint="{one}" coef="{rng.normal()}"/>' for one in single[:3])
        tendon += f'<fixed name="sum">{terms}</fixed>'
        other = f'<fixed name="other"><joint joint="{single[-1]}" coef="{rng.normal()}"/></fixed>'
        both = rng.integers(2) and len(single) > 3
        tendon += other * bool(both)
        second = 'tendon2="other"' if both else ""
        equality += f'<tendon tendon1="sum" {second} polycoef="{words(rng.normal(size=5) * 0.3)}"/>'
    if len(single) >= 2 and rng.integers(2):
        terms = "".join(f'<joint joint="{one}" coef="{rng.normal()}"/>' for one in single[-2:])
        acts = f'stiffness="{rng.uniform(0, 3)}" damping="{rng.uniform(0, 1)}"'
        if single[-1][:-1] == single[-2][:-1]:  # MuJoCo leaves out what it weighs between joints of different branches
            acts += f' armature="{rng.uniform(0, 0.3)}"'
        rest = f'springlength="{rng.normal()}"' if rng.integers(2) else ""
        tendon += f'<fixed name="spring" {acts} {rest}>{terms}</fixed>'
    if rng.integers(2):
        ends = rng.permutation(len(names))[:2]
        tendon += f'<spatial name="rod"><site site="s{ends[0]}"/><site site="s{ends[1]}"/></spatial>'
        equality += '<tendon tendon1="rod" polycoef="0.05 0 0 0 0"/>'
    if rng.integers(2):
        acts = f'stiffness="{rng.uniform(1, 9)}" damping="{rng.uniform(0, 1)}"'
        rest = f'springlength="{rng.uniform(0.1, 0.5)}"' if rng.integers(2) else ""
        end = rng.choice(["world_site", *(f"s{number}" for number in range(1, len(names)))])
        tendon += f'<spatial name="elastic" {acts} {rest}><site site="s0"/><site site="{end}"/></spatial>'
    return equality, tendon


def tetrahedron(size: float = 0.3) -> bytes:
    """A binary STL."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype="<f4") * size
    faces = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
    triangles = (np.zeros(3, "<f4").tobytes() + corners[list(face)].tobytes() + b"\0\0" for face in faces)
    return b"\0" * 80 + np.array([4], "<u4").tobytes() + b"".join(triangles)


def jacobian(model, data) -> np.ndarray:
    """Rows of the equalities alone, shape (rows, nv)."""
    rows = np.array(data.efc_J).reshape(-1)[: data.nefc * model.nv].reshape(data.nefc, model.nv)
    return rows[data.efc_type[: data.nefc] == int(mujoco.mjtConstraint.mjCNSTR_EQUALITY)]


def accelerations(model, data, qpos: np.ndarray, qvel: np.ndarray, force: np.ndarray) -> np.ndarray:
    """MuJoCo's `qacc` (nv,) with constraints that do not give, from its own matrices."""
    model.opt.jacobian = int(mujoco.mjtJacobian.mjJAC_DENSE)
    data.qpos[:], data.qvel[:], data.qfrc_applied[:] = qpos, qvel, 0.0
    mujoco.mj_forward(model, data)
    mass, bias, passive = np.zeros((model.nv, model.nv)), data.qfrc_bias.copy(), data.qfrc_passive.copy()
    mujoco.mj_fullM(model, data, mass)
    rows, step = jacobian(model, data), 1e-5
    sides = []
    for sign in (1.0, -1.0):
        data.qpos[:] = qpos
        mujoco.mj_integratePos(model, data.qpos, qvel, sign * step)
        mujoco.mj_forward(model, data)
        sides.append(jacobian(model, data) @ qvel)
    drift = (sides[0] - sides[1]) / (2.0 * step)
    free = np.linalg.solve(mass, np.column_stack([force + passive - bias, rows.T]))
    forces = np.linalg.lstsq(rows @ free[:, 1:], -(rows @ free[:, 0] + drift), rcond=1e-10)[0]
    return free[:, 0] + free[:, 1:] @ forces
