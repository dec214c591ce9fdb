"""USD: the same robots as in a loops.toml, Pixar's own reading of the same files, and what is refused."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from kit.usd_robots import UsdRobot, planar, spatial, stewart

from cutjoint.chain import ClosedChain
from cutjoint.description import CutType, JointType, load_description, read_checked, write

pytest.importorskip("pxr", reason="usd-core is not installed")
HERE = Path(__file__).resolve().parent


def loaded(robot: UsdRobot, folder: Path) -> tuple[ClosedChain, ClosedChain]:
    """A robot read out of USD, and the same out of a loops.toml."""
    file = folder / "robot.usda"
    file.write_text(robot.usda, encoding="utf-8")
    plain = load_description(write(robot.description, folder / "plain")[0])
    return ClosedChain(load_description(file)), ClosedChain(plain)


def same_motion(one: ClosedChain, other: ClosedChain, rng: np.random.Generator) -> float:
    """How far accelerations of the same state under the same efforts are apart, relative to the largest."""
    at = one.home
    there = other.posture(_carried(one, other, at.q_full, "q"))
    v = one.project(at.q_full, rng.normal(size=one.nv))[1]
    effort = rng.normal(size=one.nv)
    a = one.full_forward_dynamics(at, v, effort).acceleration
    b = other.full_forward_dynamics(there, _carried(one, other, v, "v"), _carried(one, other, effort, "v")).acceleration
    assert np.abs(a).max() > 0.1
    return float(np.abs(_carried(one, other, a, "v") - b).max() / np.abs(b).max())


def _carried(one: ClosedChain, other: ClosedChain, values: np.ndarray, space: str) -> np.ndarray:
    """Values of all joints in the order of another chain, joints matched by name."""
    found = np.zeros(other.model.nq if space == "q" else other.nv)
    for number, name in enumerate(other.model.names):
        if number:
            index = one.model.getJointId(name)
            start, size = _at(one, index, space)
            to, _ = _at(other, number, space)
            found[to : to + size] = values[start : start + size]
    return found


def _at(chain: ClosedChain, joint: int, space: str) -> tuple[int, int]:
    model = chain.model
    if space == "q":
        return int(model.idx_qs[joint]), int(model.nqs[joint])
    return int(model.idx_vs[joint]), int(model.nvs[joint])


UNITS = ({}, {"length": 0.25, "mass": 0.5}, {"length": 0.0078125, "mass": 2.0})


@pytest.mark.parametrize("bars", [4, 5])
def test_planar_linkages(bars: int, tmp_path: Path) -> None:
    for seed in range(4):
        rng = np.random.default_rng(seed)
        usd, plain = loaded(planar(rng, bars, **UNITS[seed % 3]), tmp_path)
        assert usd.mobility().mobility == plain.mobility().mobility == bars - 3
        assert same_motion(usd, plain, rng) < 1e-12


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(40))
def test_any_mechanism(seed: int, tmp_path: Path) -> None:
    rng = np.random.default_rng(seed)
    robot = spatial(rng, **UNITS[seed % 3])
    usd, plain = loaded(robot, tmp_path)
    assert usd.mobility().mobility == plain.mobility().mobility
    assert [(c.name, c.type) for c in usd.description.cuts] == [(c.name, c.type) for c in plain.description.cuts]
    assert same_motion(usd, plain, rng) < 1e-12
    places = usd.link_placements(usd.home)
    assert max(np.abs(places[name] - robot.mounting[name]).max() for name in robot.masses) < 1e-4


def stage(body: str, head: str = "metersPerUnit = 1", up: str = "Z") -> str:
    """A stage with some prims."""
    return f'#usda 1.0\n(\n    {head}\n    upAxis = "{up}"\n)\n{body}\n'


def xform(
    name: str, inside: str = "", apis: str = '"PhysicsRigidBodyAPI", "PhysicsMassAPI"', kind: str = "Xform"
) -> str:
    """A prim with schemas."""
    return f'def {kind} "{name}" (\n    prepend apiSchemas = [{apis}]\n)\n{{\n{inside}\n}}'


HEAVY = (
    "float physics:mass = 2\nfloat3 physics:diagonalInertia = (0.5, 0.5, 0.5)\npoint3f physics:centerOfMass = (0, 0, 0)"
)


def joint(name: str, kind: str, inside: str = "", apis: str = "", ends: tuple[str, str] = ("", "/a")) -> str:
    """A joint between two bodies."""
    rels = "".join(f"rel physics:body{n} = <{end}>\n" for n, end in enumerate(ends) if end)
    schemas = f" (\n    prepend apiSchemas = [{apis}]\n)" if apis else ""
    return f'def Physics{kind}Joint "{name}"{schemas}\n{{\n{rels}{inside}\n}}'


def read(folder: Path, text: str):
    """What is read of a stage, checked."""
    file = folder / "stage.usda"
    file.write_text(text, encoding="utf-8")
    return read_checked(file)


def robot_of(folder: Path, text: str):
    """The description in a stage without errors."""
    reading = read(folder, text)
    assert reading.description is not None, "\n".join(map(str, reading.problems))
    return reading.description


def errors(folder: Path, text: str) -> str:
    """What is wrong with a stage."""
    return "\n".join(str(one) for one in read(folder, text).problems if one.severity == "error")


def warned(folder: Path, text: str) -> str:
    """The warnings of a stage without errors."""
    robot_of(folder, text)
    return "\n".join(map(str, read(folder, text).problems))


def test_a_stewart_platform_stands_as_in_its_file(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    robot = stewart(rng)
    usd, plain = loaded(robot, tmp_path)
    assert usd.mobility().mobility == plain.mobility().mobility == 12  # 6 legs spin
    assert same_motion(usd, plain, rng) < 1e-12
    places = usd.link_placements(usd.home)
    assert max(np.abs(places[name] - robot.mounting[name]).max() for name in robot.masses) < 1e-5


ROUND = "double radius = 0.2\ndouble height = 0.7"
SHAPES = {
    "box": ("Cube", "double size = 0.5\nfloat3 xformOp:scale = (1, 2, 0.5)"),
    "ball": ("Sphere", "double radius = 0.3\nfloat3 xformOp:scale = (0.5, 0.5, 0.5)"),
    "can": ("Cylinder", f'{ROUND}\nuniform token axis = "X"\nfloat3 xformOp:scale = (2, 0.5, 0.5)'),
    "pill": ("Capsule", f'{ROUND}\nuniform token axis = "Y"\nfloat3 xformOp:scale = (1, 1, 1)'),
}


def collider(name: str, extra: str = "", apis: str = '"PhysicsCollisionAPI"') -> str:
    kind, inside = SHAPES[name]
    order = 'uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateXYZ", "xformOp:scale"]'
    move = "double3 xformOp:translate = (0.1, 0.2, -0.3)\nfloat3 xformOp:rotateXYZ = (20, 30, 40)"
    return xform(name, f"{inside}\n{move}\n{order}\n{extra}", apis, kind)


def sampled(name: str, rng: np.random.Generator) -> np.ndarray:
    """Points (n, 3) evenly in a collider, in the frame of its body, by Pixar's own matrices of the same prims."""
    from pxr import Usd, UsdGeom

    layer = Usd.Stage.CreateInMemory()
    layer.GetRootLayer().ImportFromString(stage(xform("a", collider(name))))
    prim = layer.GetPrimAtPath(f"/a/{name}")
    matrix = np.array(UsdGeom.XformCache().GetLocalToWorldTransform(prim)).T
    points = rng.uniform(-0.56, 0.56, (400_000, 3))
    if name == "box":
        inside = np.abs(points).max(axis=1) <= 0.25
    elif name == "ball":
        inside = np.linalg.norm(points, axis=1) <= 0.3
    else:
        axis = {"can": 0, "pill": 1}[name]
        along, across = points[:, axis], np.delete(points, axis, axis=1)
        over = np.maximum(np.abs(along) - 0.35, 0.0)
        radius = np.linalg.norm(across, axis=1)
        inside = (radius <= 0.2) & (over == 0.0) if name == "can" else np.hypot(radius, over) <= 0.2
    share = inside.mean() * 1.12**3 * abs(np.linalg.det(matrix[:3, :3]))
    return points[inside] @ matrix[:3, :3].T + matrix[:3, 3], share


@pytest.mark.slow
@pytest.mark.parametrize("name", SHAPES)
def test_solids_weigh_as_their_points_do(name: str, tmp_path: Path) -> None:
    """Mass, centre and inertia of a scaled, turned and shifted collider against 400 000 random points."""
    points, volume = sampled(name, np.random.default_rng(0))
    text = stage(xform("a", collider(name) + "\nfloat physics:density = 500"))
    found = robot_of(tmp_path, text).link("a").inertial
    arms = points - points.mean(axis=0)
    inertia = 500.0 * volume * (np.eye(3) * (arms**2).sum() / len(arms) - arms.T @ arms / len(arms))
    assert found.mass == pytest.approx(500.0 * volume, rel=0.02)
    assert np.abs(found.com - points.mean(axis=0)).max() < 0.01
    assert np.abs(found.inertia - inertia).max() < 0.04 * np.abs(inertia).max()


@pytest.mark.parametrize("height", [0.0, 0.3, 2.0])
def test_a_capsule_is_the_sum_of_its_slices(height: float) -> None:
    from cutjoint.description import Shape
    from cutjoint.description.formats.usd.mass import solid

    radius, (nodes, weights) = 0.7, np.polynomial.legendre.leggauss(40)
    volume, across, about = 0.0, 0.0, 0.0
    for low, high in ((-radius, 0.0), (0.0, height), (height, height + radius)):
        z = low + 0.5 * (high - low) * (nodes + 1.0)
        square = radius**2 - np.clip(np.maximum(-z, z - height), 0.0, None) ** 2
        share = 0.5 * (high - low) * weights * math.pi * square
        volume += share.sum()
        across += (share * (0.25 * square + (z - 0.5 * height) ** 2)).sum()
        about += (share * 0.5 * square).sum()
    found, moments = solid(Shape("capsule", (radius, height)))
    assert found == pytest.approx(volume, rel=1e-12)
    assert moments == pytest.approx([across, across, about], rel=1e-12)


@pytest.mark.parametrize("scale", ["(2, 2, 2)", "(1, 2, 3)"])
def test_frames_of_scaled_bodies_are_scaled(scale: str, tmp_path: Path) -> None:
    """Positions of joints and centres of mass are in the scaled axes of the body, as Pixar's own reading has them."""
    from pxr import Usd, UsdPhysics

    order = 'uniform token[] xformOpOrder = ["xformOp:rotateXYZ", "xformOp:scale"]'
    body = f"{HEAVY.replace('(0, 0, 0)', '(0.1, 0.2, 0.3)')}\nfloat3 xformOp:rotateXYZ = (10, 20, 30)"
    body = xform("a", f"{body}\nfloat3 xformOp:scale = {scale}\n{order}")
    text = stage(f"{body}\n{joint('j', 'Fixed', 'point3f physics:localPos1 = (0.4, 0.5, 0.6)')}")
    robot = robot_of(tmp_path, text)
    (desc,) = UsdPhysics.LoadUsdPhysicsFromRange(Usd.Stage.Open(str(tmp_path / "stage.usda")), ["/"])[
        UsdPhysics.ObjectType.FixedJoint
    ][1]
    moved = next(one for one in robot.joints if one.child == "a")
    assert np.linalg.inv(moved.placement)[:3, 3] == pytest.approx(list(desc.localPose1Position), abs=1e-6)
    assert robot.link("a").inertial.com == pytest.approx(pixar(text)[1], abs=1e-6)


def test_angles_in_the_file_are_within_their_limits(tmp_path: Path) -> None:
    turned = xform("a", f'{HEAVY}\ndouble xformOp:rotateX = 190\nuniform token[] xformOpOrder = ["xformOp:rotateX"]')
    limits = "float physics:lowerLimit = {}\nfloat physics:upperLimit = {}"
    for lower, upper, wanted in ((90, 270, 190), (-270, 0, -170), (-10, 10, -170)):
        robot = robot_of(tmp_path, stage(f"{turned}\n{joint('j', 'Revolute', limits.format(lower, upper))}"))
        assert robot.homes[0].actuated["j"] == pytest.approx(math.radians(wanted))


def pixar(text: str) -> tuple[float, np.ndarray, np.ndarray]:
    """Mass, centre and inertia of body /a by UsdPhysics' own rules; volumes are those of this reader's shapes."""
    from pxr import Gf, Usd, UsdPhysics

    from cutjoint.description.formats.usd.bodies import _shape
    from cutjoint.description.formats.usd.frames import stand
    from cutjoint.description.formats.usd.mass import along, solid
    from cutjoint.description.formats.usd.stage import _facts
    from cutjoint.findings import Findings

    opened = Usd.Stage.CreateInMemory()
    opened.GetRootLayer().ImportFromString(text)
    facts = {prim.path: prim for prim in _facts(opened).prims}

    def weigh(prim):
        fact = facts[str(prim.GetPath())]
        body = stand(facts["/a"], 1.0).world
        shape = _shape(fact, body, stand(fact, 1.0), 1.0, Findings())
        volume, moments = solid(shape)
        found = UsdPhysics.RigidBodyAPI.MassInformation()
        turn = along(fact)
        found.volume = volume
        found.inertia = Gf.Matrix3f(*map(float, (turn @ np.diag(moments) @ turn.T).ravel()))
        found.centerOfMass = Gf.Vec3f(0.0)
        place = np.linalg.inv(body) @ stand(fact, 1.0).world
        matrix = Gf.Matrix4d(*map(float, place.T.ravel()))
        found.localPos = Gf.Vec3f(*map(float, place[:3, 3]))
        found.localRot = Gf.Quatf(matrix.ExtractRotationQuat())
        return found

    mass, moments, com, axes = UsdPhysics.RigidBodyAPI(opened.GetPrimAtPath("/a")).ComputeMassProperties(weigh)
    turn = np.array(Gf.Matrix3d(Gf.Rotation(Gf.Quatd(axes)))).T
    return mass, np.array(com), turn @ np.diag(moments) @ turn.T


BODIES = {
    "density of the body": ("float physics:density = 500", ""),
    "mass of the body": ("float physics:mass = 3", ""),
    "mass and centre": ("float physics:mass = 3\npoint3f physics:centerOfMass = (0.1, 0.5, 0.25)", ""),
    "moments of the body": (
        "float3 physics:diagonalInertia = (1, 2, 2.5)\nquatf physics:principalAxes = (0.8, 0.6, 0, 0)",
        "",
    ),
    "nothing": ("", ""),
    "density of a collider": ("float physics:density = 500", "float physics:density = 700"),
    "mass of a collider": ("", "float physics:mass = 4"),
    "centre of a collider": ("", "point3f physics:centerOfMass = (0.25, 0.5, 0.125)"),
    "moments of a collider": ("", "float3 physics:diagonalInertia = (1, 2, 2.5)"),
}


@pytest.mark.parametrize("case", BODIES)
def test_masses_follow_the_rules_of_usdphysics(case: str, tmp_path: Path) -> None:
    of_body, of_collider = BODIES[case]
    schemas = '"PhysicsCollisionAPI", "PhysicsMassAPI"' if of_collider else '"PhysicsCollisionAPI"'
    text = stage(xform("a", f"{of_body}\n{collider('box')}\n{collider('pill', of_collider, schemas)}"))
    found, (mass, com, inertia) = robot_of(tmp_path, text).link("a").inertial, pixar(text)
    assert found.mass == pytest.approx(mass, rel=1e-5)
    assert np.abs(found.com - com).max() < 1e-5
    assert np.abs(found.inertia - inertia).max() < 1e-5 * np.abs(inertia).max()


def test_a_material_gives_the_density_that_nothing_else_does(tmp_path: Path) -> None:
    material = xform("stuff", "float physics:density = 250", '"PhysicsMaterialAPI"', "Material")
    bound = collider("box", "rel material:binding:physics = </stuff>", '"PhysicsCollisionAPI", "MaterialBindingAPI"')
    volume = 0.5 * 1.0 * 0.25
    for extra, density in (("", 250.0), ("float physics:density = 400", 400.0)):
        text = stage(material + "\n" + xform("a", f"{extra}\n{bound}"))
        assert robot_of(tmp_path, text).link("a").inertial.mass == pytest.approx(volume * density, rel=1e-6)


LOCKS = ("transX", "transY", "transZ", "rotX", "rotY", "rotZ")
D6 = {
    "": JointType.FIXED,
    "rotY": JointType.CONTINUOUS,
    "transZ": JointType.PRISMATIC,
    "rotX rotY rotZ": JointType.SPHERICAL,
}


def locked(free: str, extra: str = "") -> str:
    held = [one for one in LOCKS if one not in free.split()]
    rows = [f"float limit:{one}:physics:low = 1\nfloat limit:{one}:physics:high = -1" for one in held]
    apis = ", ".join(f'"PhysicsLimitAPI:{one}"' for one in held)
    return joint("j", "", "\n".join([*rows, extra]), apis)


@pytest.mark.parametrize("free", [*D6, "rotX rotY", "rotX transX", "transX transY", "transX transY transZ"])
def test_general_joints_are_one_of_ours_or_refused(free: str, tmp_path: Path) -> None:
    text = stage(xform("a", HEAVY) + "\n" + locked(free))
    if free in D6:
        found = robot_of(tmp_path, text).joint("j")
        assert found.type is D6[free]
        if found.type.axes:
            assert found.axis["XYZ".index(free[-1])] == 1.0
    else:
        assert f"joint </j> that is free along or about {', '.join(sorted(free.split(), key=LOCKS.index))}" in errors(
            tmp_path, text
        )


def test_limits_drives_and_physics_of_joints_are_in_si_units(tmp_path: Path) -> None:
    inside = (
        'uniform token physics:axis = "Y"\nfloat physics:lowerLimit = -90\nfloat physics:upperLimit = 45\n'
        "float drive:angular:physics:maxForce = 64\nfloat physxJoint:armature = 2\n"
        "float physxJoint:maxJointVelocity = 180\n"
        "float physxJointAxis:angular:dynamicFrictionEffort = 3\nfloat physxJointAxis:angular:armature = 4\n"
        "float physxJointAxis:angular:staticFrictionEffort = 3\nfloat physxJointAxis:angular:maxJointVelocity = 90\n"
        "float physxJointAxis:angular:viscousFrictionCoefficient = 1"
    )
    apis = '"PhysicsDriveAPI:angular", "PhysxJointAPI", "PhysxJointAxisAPI:angular"'
    turning = joint("j", "Revolute", inside, apis)
    sliding = joint(
        "s", "Prismatic", inside.replace("angular", "linear"), apis.replace("angular", "linear"), ("/a", "/b")
    )
    text = stage(
        "\n".join([xform("a", HEAVY), xform("b", HEAVY), turning, sliding]),
        "metersPerUnit = 0.5\n    kilogramsPerUnit = 4",
    )
    robot = robot_of(tmp_path, text)
    turn, slide = robot.joint("j"), robot.joint("s")
    assert turn.type is JointType.REVOLUTE
    assert robot.actuators == ("j", "s")
    assert (turn.limits.lower, turn.limits.upper) == pytest.approx((-math.pi / 2, math.pi / 4))
    assert (turn.limits.velocity, turn.limits.effort) == pytest.approx((math.pi / 2, 64 * 4 * 0.25))
    assert (turn.physics.rotor, turn.physics.friction) == (4 * 4 * 0.25, 3 * 4 * 0.25)
    assert turn.physics.damping == pytest.approx(4 * 0.25 * 180 / math.pi)
    assert (slide.limits.lower, slide.limits.upper, slide.limits.velocity) == (-45.0, 22.5, 45.0)
    assert (slide.limits.effort, slide.physics.rotor, slide.physics.friction) == (64 * 4 * 0.5, 16.0, 3 * 4 * 0.5)
    assert slide.physics.damping == 4.0
    assert robot.link("a").inertial.inertia[0, 0] == 0.5 * 4 * 0.25


def test_gravity(tmp_path: Path) -> None:
    scene = (
        'def PhysicsScene "s" {{\nvector3f physics:gravityDirection = ({})\nfloat physics:gravityMagnitude = {}\n}}\n'
    )
    for up, text, wanted in (
        ("Z", "", (0, 0, -9.81)),
        ("Y", "", (0, -9.81, 0)),
        ("Y", scene.format("0, 0, 0", "-inf"), (0, -9.81, 0)),
        ("Z", scene.format("0, 3, 4", "8"), (0, 2.4, 3.2)),
    ):
        robot = robot_of(tmp_path, stage(xform("a", HEAVY) + "\n" + text, "metersPerUnit = 0.5", up))
        assert robot.gravity == pytest.approx(np.array(wanted)), (up, text)
    none = xform(
        "a",
        HEAVY + "\nbool physxRigidBody:disableGravity = 1",
        '"PhysicsRigidBodyAPI", "PhysicsMassAPI", "PhysxRigidBodyAPI"',
    )
    joints = [joint("j", "Revolute"), joint("k", "Revolute", "", "", ("/a", "/b"))]
    both = robot_of(tmp_path, stage("\n".join([none, xform("b", HEAVY), *joints])))
    assert {link.name: link.gravity_compensation for link in both.links if link.inertial} == {"a": 1.0, "b": 0.0}


TWO = "\n".join(
    [xform("a", HEAVY), xform("b", HEAVY), joint("j", "Revolute"), joint("k", "Revolute", "", "", ("/a", "/b")), ""]
)


def given(name: str, row: str = "", api: str = "", text: str = TWO) -> str:
    """A stage in which a prim has another property and another schema."""
    head, rest = text.split(f'"{name}"', 1)
    before, after = rest.split("{", 1)
    if api and "apiSchemas" in before:
        before = before.replace("[", f'["{api}", ', 1)
    elif api:
        before = f' (\n    prepend apiSchemas = ["{api}"]\n){before}'
    return f'{head}"{name}"{before}{{\n{row}{after}'


def ordered(row: str) -> str:
    """A body with one transformation."""
    name = row.split()[1].split(".")[0]
    return xform("a", f'{HEAVY}\n{row}\nuniform token[] xformOpOrder = ["{name}"]')


RANGE = "float physics:minDistance = 1\nfloat physics:maxDistance = 2"
APART = "bool physics:excludeFromArticulation = 1"
GEAR = 'def PhysxPhysicsGearJoint "g"\n{\n}'
SCENES = 'def PhysicsScene "s" {\n}\ndef PhysicsScene "t" {\nfloat physics:gravityMagnitude = 3\n}'
BALLS = TWO.replace("Revolute", "Spherical")
SHEAR = "matrix4d xformOp:transform = ( (1, 1, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1) )"
MOVING = "double3 xformOp:translate.timeSamples = { 0: (1, 2, 3), 1: (2, 3, 4) }"
COLLIDES = '"PhysicsCollisionAPI"'
TENDON = "PhysxTendonAxisRootAPI:x"
DRIVE = '"PhysicsDriveAPI:angular"'
REFUSED = {
    "a range of distance": (TWO + joint("d", "Distance", RANGE, "", ("", "/b")), "distance joint </d> from 1 to 2"),
    "a missing body": (TWO + joint("d", "Fixed", "", "", ("/a", "/bb")), "</bb>, which does not exist"),
    "itself": (TWO + joint("d", "Revolute", "", "", ("/a", "/a")), "joins 'a' to itself"),
    "the world with itself": (TWO + joint("d", "Revolute", "", "", ("", "")), "joins 'world' to itself"),
    "a gear": (TWO + GEAR, "of type PhysxPhysicsGearJoint closes loops or couples"),
    "a tendon": (given("a", api=TENDON), "PhysxTendonAxisRootAPI:x of </a> closes loops or couples"),
    "a force": (given("a", api="PhysxForceAPI"), "PhysxForceAPI of </a> acts on the robot"),
    "a held body": (given("a", "int physxRigidBody:lockedPosAxis = 3"), "lockedPosAxis holds body </a>"),
    "a shear": (ordered(SHEAR), "scaled askew"),
    "a mirror": (ordered("float3 xformOp:scale = (-1, 1, 1)"), "mirrored"),
    "an animation": (ordered(MOVING), "given by time samples only"),
    "a mass of a mesh": (
        xform("a", xform("m", "", COLLIDES, "Mesh") + "\nfloat physics:mass = 1"),
        "depends on </a/m>, of type Mesh",
    ),
    "a mass alone": (xform("a", "float physics:mass = 1"), "body </a> has a mass only"),
    "no bodies": (xform("a", "", COLLIDES, "Cube"), "a stage without rigid bodies"),
    "a limit of a ball": (
        given("j", "float limit:rotX:physics:low = -10", "PhysicsLimitAPI:rotX", BALLS),
        "PhysicsLimitAPI:rotX of the PhysicsSphericalJoint </j>",
    ),
    "two gravities": (TWO + SCENES, "2 physics scenes with different gravity"),
    "a drive of a cut": (
        TWO + joint("d", "Revolute", APART, DRIVE, ("", "/b")),
        "the drive of joint </d>, which closes a loop",
    ),
    "a mimic of nobody": (given("k", api="PhysxMimicJointAPI:rotX"), "referenceJoint of </k> is none"),
    "an actuator of nothing": (TWO + 'def MjcActuator "m"\n{\n}', "of type MjcActuator acts on the robot"),
    "a property without its schema": (given("j", "float drive:angular:physics:damping = 1"), "apply the schema"),
    "a broken reference": (TWO + 'def Xform "x" (\n    references = @missing.usda@\n)\n{\n}', "USD says"),
    "a syntax error": (TWO + "def def", "USD says"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_read_is_quoted(case: str, tmp_path: Path) -> None:
    body, wanted = REFUSED[case]
    assert wanted in errors(tmp_path, stage(body))


def test_a_syntax_error_has_its_line(tmp_path: Path) -> None:
    problem = read(tmp_path, stage(TWO + "\ndef def")).problems[0]
    assert problem.line is not None


FREE_BODY = xform("c", "", '"PhysicsRigidBodyAPI"') + "\n" + joint("d", "Fixed", "", "", ("/b", "/c"))
MESHED = xform("c", HEAVY + '\ndef Mesh "m"\n{\n}') + "\n" + joint("d", "Fixed", "", "", ("/b", "/c"))
STIFF = "float drive:angular:physics:stiffness = 30"
TOLD = {
    "a switched-off joint": (
        TWO + joint("d", "Fixed", "bool physics:jointEnabled = 0", "", ("", "/b")),
        "joint </d> is switched off",
    ),
    "a kinematic body": (
        TWO + xform("c", HEAVY + "\nbool physics:kinematicEnabled = 1"),
        "body </c> is kinematic",
    ),
    "a start in motion": (given("a", "vector3f physics:velocity = (1, 0, 0)"), "physics:velocity of body </a>"),
    "a cone": (given("j", "float physics:coneAngle0Limit = 30", text=BALLS), "cone of 30"),
    "a joint that breaks": (given("j", "float physics:breakForce = 30"), "physics:breakForce of joint </j>"),
    "nothing held": (TWO + joint("d", "", "", "", ("", "/b")), "joint </d> holds nothing"),
    "no mass at all": (TWO + FREE_BODY, "body </c> has neither mass nor colliders"),
    "gains of a drive": (given("j", STIFF, "PhysicsDriveAPI:angular"), "they are a controller's"),
    "friction of the load": (given("j", "float physxJoint:jointFriction = 0.1"), "jointFriction of joint </j>"),
    "a mesh": (TWO + MESHED, "1 shapes are not drawn: </c/m>"),
    "an actuator of others": (TWO + 'def MjcActuator "m"\n{\nrel mjc:target = </j>\n}', "an actuator of its joint"),
    "an order that leaves one out": (given("a", "double3 xformOp:translate = (1, 2, 3)"), "and does nothing"),
    "a speed by another name": (
        given("a", "vector3f physics:linearVelocity = (1, 0, 0)"),
        "linearVelocity of body </a>",
    ),
    "a number of others": (given("j", "float mjc:damping = 0.1"), "mjc:damping of </j> are not used"),
}


@pytest.mark.parametrize("case", TOLD)
def test_what_is_not_used_is_told(case: str, tmp_path: Path) -> None:
    body, wanted = TOLD[case]
    assert wanted in warned(tmp_path, stage(body))


def test_a_loop_in_the_articulation_is_cut(tmp_path: Path) -> None:
    """Without a flag the last joint of a loop is the cut; driven ones stay in the tree."""
    ring = [xform(name, HEAVY) for name in "abc"]
    ends = [("", "/a"), ("/a", "/b"), ("/b", "/c"), ("/c", "")]
    drive = '"PhysicsDriveAPI:angular"'
    for driven in (0, 3):
        joints = [joint(f"j{n}", "Revolute", "", drive if n == driven else "", end) for n, end in enumerate(ends)]
        robot = robot_of(tmp_path, stage("\n".join([*ring, *joints])))
        assert robot.actuators == (f"j{driven}",)
        assert [cut.name for cut in robot.cuts] == [f"j{3 if driven == 0 else 2}"]
        assert robot.cuts[0].type is CutType.REVOLUTE


def test_other_forms_of_the_file_are_the_same_robot(tmp_path: Path) -> None:
    from kit.described import differences
    from pxr import Sdf, UsdUtils

    text = planar(np.random.default_rng(0), 4).usda
    wanted = robot_of(tmp_path, text)
    for name in ("stage.usdc", "stage.usd"):
        Sdf.Layer.FindOrOpen(str(tmp_path / "stage.usda")).Export(str(tmp_path / name))
    assert UsdUtils.CreateNewUsdzPackage(str(tmp_path / "stage.usdc"), str(tmp_path / "stage.usdz"))
    for name in ("stage.usdc", "stage.usd", "stage.usdz"):
        assert differences(wanted, load_description(tmp_path / name)) == [], name


def test_a_file_that_changes_is_read_anew(tmp_path: Path) -> None:
    for mass in ("2", "3"):
        text = stage(xform("a", HEAVY.replace("mass = 2", f"mass = {mass}")))
        assert robot_of(tmp_path, text).link("a").inertial.mass == float(mass)


def test_without_the_package_it_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("cutjoint.description.formats.usd.reader.is_installed", lambda name: False)
    assert "pip install 'cutjoint[usd]'" in errors(tmp_path, stage(TWO))


def test_shapes_are_drawn_where_they_stand(tmp_path: Path) -> None:
    link = robot_of(tmp_path, stage(xform("a", HEAVY + "\n" + "\n".join(map(collider, SHAPES))))).link("a")
    sizes = {shape.name: (shape.kind, shape.size) for shape in link.visuals}
    assert sizes["box"] == ("box", (0.5, 1.0, 0.25))
    assert sizes["ball"] == ("sphere", (0.15,))
    assert sizes["can"] == ("cylinder", (0.1, 1.4))
    assert sizes["pill"] == ("capsule", (0.2, 0.7))
    assert len(link.collisions) == 4
    along = {shape.name: shape.placement[:3, 2] for shape in link.visuals}
    turn = next(shape.placement[:3, :3] for shape in link.visuals if shape.name == "box")
    assert along["can"] == pytest.approx(turn[:, 0])
    assert along["pill"] == pytest.approx(turn[:, 1])


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(8))
def test_pixars_own_reading_has_the_same_joints(seed: int, tmp_path: Path) -> None:
    """Frames, axes, limits and bodies of all joints, as LoadUsdPhysicsFromRange gives them in single precision."""
    from pxr import Usd, UsdPhysics

    from cutjoint.description.formats.usd.bodies import read_bodies
    from cutjoint.description.formats.usd.joints import read_joints
    from cutjoint.description.formats.usd.stage import read as read_stage
    from cutjoint.findings import Findings

    robot = spatial(np.random.default_rng(seed))
    file = tmp_path / "robot.usda"
    file.write_text(robot.usda, encoding="utf-8")
    facts = read_stage(str(file))
    edges = {edge.prim.path: edge for edge in read_joints(facts, read_bodies(facts, Findings()), Findings())}
    opened = Usd.Stage.Open(str(file))
    parsed = UsdPhysics.LoadUsdPhysicsFromRange(opened, ["/"])
    count = 0
    for kind, (_, descs) in parsed.items():
        for desc in descs if "Joint" in str(kind) else ():
            edge = edges[str(desc.primPath)]
            count += 1
            for frame, at, turn in (
                (edge.a, desc.localPose0Position, desc.localPose0Orientation),
                (edge.b, desc.localPose1Position, desc.localPose1Orientation),
            ):
                assert frame[:3, 3] == pytest.approx(list(at), abs=1e-6)
                quaternion = np.array([turn.GetReal(), *turn.GetImaginary()])
                x, y, z = quaternion[1:] / np.linalg.norm(quaternion)
                w = quaternion[0] / np.linalg.norm(quaternion)
                assert frame[2, 1] - frame[1, 2] == pytest.approx(4 * w * x, abs=1e-6)
                assert frame[0, 2] - frame[2, 0] == pytest.approx(4 * w * y, abs=1e-6)
                assert frame[1, 0] - frame[0, 1] == pytest.approx(4 * w * z, abs=1e-6)
            assert bool(desc.excludeFromArticulation) == edge.apart
    assert count == len(robot.joints) == len(edges)


def test_actuators_of_others_name_their_joints(tmp_path: Path) -> None:
    text = stage(TWO + 'def NewtonActuator "m"\n{\nrel newton:targets = </k>\n}')
    assert robot_of(tmp_path, text).actuators == ("k",)
