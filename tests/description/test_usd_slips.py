"""USD: what others write is left alone, and damaged files are refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from kit.usd_robots import spatial

from cutjoint.description import read_checked

pytest.importorskip("pxr", reason="usd-core is not installed")
SEED = (Path(__file__).parent / "samples" / "everything.usda").read_text(encoding="utf-8")


def problems(folder: Path, text: str) -> set[tuple[str, str]]:
    """Severity and finding of each problem."""
    file = folder / "stage.usda"
    file.write_text(text, encoding="utf-8")
    return {(one.severity, one.found) for one in read_checked(file).problems}


OTHERS = """
    bool physxRigidBody:retainAccelerations = 1
    int physxRigidBody:solverPositionIterationCount = 32
    float physxRigidBody:sleepThreshold = 0.005
    bool physxArticulation:enabledSelfCollisions = 0
    int physxArticulation:solverVelocityIterationCount = 16
    float physxCollision:restOffset = 0
    float2[] primvars:st = [(0, 0)]
    custom string userProperties:blender:object_name = "arm"
    string isaac:nameOverride = "arm"
    token ui:displayGroup = "Material Graphs"
    bool omni:kit:locked = 0
    int semantic:Semantics:params:semanticData = 3
"""
PHYSX = ("PhysxArticulationAPI", "PhysxCollisionAPI", "PhysxContactReportAPI", "PhysxConvexHullCollisionAPI")
APIS = (*PHYSX, "IsaacRobotAPI", "IsaacLinkAPI", "SemanticsAPI:Semantics", "NewtonArticulationRootAPI", "IsaacJointAPI")


def test_what_others_write_is_left_alone(tmp_path: Path) -> None:
    named = ", ".join(f'"{one}"' for one in APIS)
    text = SEED.replace('"PhysicsRigidBodyAPI"', f'"PhysicsRigidBodyAPI", {named}', 1)
    text = text.replace("float physics:mass = 0.5", f"float physics:mass = 0.5{OTHERS}", 1)
    text = text.replace(
        "primvars:displayColor = [", "primvars:displayColor:indices = [0]\ncolor3f[] primvars:displayColor = ["
    )
    text = text.replace("color3f[] primvars:displayColor:indices", "int[] primvars:displayColor:indices")
    text += 'def OmniGraph "graph"\n{\n}\ndef RenderProduct "view"\n{\n}\ndef DistantLight "sun"\n{\n}\n'
    assert problems(tmp_path, text) == problems(tmp_path, SEED)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_damaged_binary_files_are_refused_or_read(seed: int, tmp_path: Path) -> None:
    """Bytes of a .usdc changed, cut off or repeated: the library may crash, this program may not."""
    from pxr import Sdf

    rng = np.random.default_rng(seed)
    (tmp_path / "robot.usda").write_text(spatial(rng).usda, encoding="utf-8")
    Sdf.Layer.FindOrOpen(str(tmp_path / "robot.usda")).Export(str(tmp_path / "robot.usdc"))
    whole = (tmp_path / "robot.usdc").read_bytes()
    for number in range(60):
        data = bytearray(whole)
        if number % 4 == 0:
            del data[int(rng.integers(len(data))) :]
        elif number % 4 == 1:
            start = int(rng.integers(len(data)))
            data[start:start] = data[start : start + int(rng.integers(64))]
        else:
            for at in rng.integers(len(data), size=int(rng.integers(1, 16))):
                data[at] = int(rng.integers(256))
        (tmp_path / "damaged.usdc").write_bytes(data)
        reading = read_checked(tmp_path / "damaged.usdc")
        assert reading.description is not None or any(one.severity == "error" for one in reading.problems)
