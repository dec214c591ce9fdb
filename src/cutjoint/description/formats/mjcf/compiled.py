"""What the child process tells of a model that MuJoCo has compiled: plain values, lengths and radians, names as there.

Indices of bodies, joints, sites and tendons count as in the compiled model; `line` is that of the text handed over.
"""

from __future__ import annotations

from dataclasses import dataclass

Numbers = tuple[float, ...]


@dataclass(frozen=True)
class Request:
    """A text to compile, files that it attaches, the folders where its meshes may be, and whether cutjoint wrote it."""

    text: str
    models: dict[str, str]
    folders: tuple[str, ...]
    own: bool


@dataclass(frozen=True)
class Refused:
    """MuJoCo's words where it refuses a text, and all that it knows (`mujoco.mj_printSchema`).

    Without words the inertia of a body would come from one of the `meshes` that is not there.
    """

    text: str
    schema: str
    meshes: tuple[MeshRow, ...] = ()


@dataclass(frozen=True)
class JointRow:
    """A joint.  `damping` and `stiffness` are the coefficients of powers 1, 2, 3; `soft` names softened constraints."""

    name: str
    kind: str
    line: int | None
    address: int
    position: Numbers
    axis: Numbers
    ref: float
    range: Numbers | None
    force: Numbers | None
    damping: Numbers
    stiffness: Numbers
    spring: float
    springyield: float
    friction: float
    armature: float
    soft: tuple[str, ...]


@dataclass(frozen=True)
class GeomRow:
    """A geom; `mesh` is the name of its mesh where it is one, `colour` None where the file gives none."""

    name: str
    kind: str
    line: int | None
    size: Numbers
    position: Numbers
    quaternion: Numbers
    colour: Numbers | None
    mesh: str
    visual: bool


@dataclass(frozen=True)
class MeshRow:
    """A mesh: the full path of its file (and as it is `shown` in the file), whether it is there, and if not, the body
    that has its inertia from it."""

    name: str
    line: int | None
    file: str
    shown: str
    scale: Numbers
    there: bool
    needed: str


@dataclass(frozen=True)
class SiteRow:
    """A site on a body."""

    name: str
    body: int
    position: Numbers
    quaternion: Numbers


@dataclass(frozen=True)
class BodyRow:
    """A body in its parent at `qpos0`; `inertia` is mass, centre of mass and xx, yy, zz, xy, xz, yz, or None."""

    name: str
    line: int | None
    parent: int
    position: Numbers
    quaternion: Numbers
    inertia: tuple[float, Numbers, Numbers] | None
    gravcomp: float
    mocap: bool
    joints: tuple[JointRow, ...]
    geoms: tuple[GeomRow, ...]


@dataclass(frozen=True)
class EqualityRow:
    """An equality: indices of bodies, sites, joints or tendons (-1 for none), and MuJoCo's `eq_data`."""

    name: str
    kind: str
    line: int | None
    active: bool
    by_sites: bool
    first: int
    second: int
    data: Numbers


@dataclass(frozen=True)
class TendonRow:
    """A tendon.  `path` has (kind, index, number): joints with their coefficients, sites, or else."""

    name: str
    line: int | None
    path: tuple[tuple[str, int, float], ...]
    length: float
    rest: Numbers
    stiffness: Numbers
    damping: Numbers
    springyield: float
    friction: float
    armature: float
    range: Numbers | None
    force: Numbers | None


@dataclass(frozen=True)
class ActuatorRow:
    """An actuator: what it acts on (`joint`, `tendon`, or MuJoCo's word for else), and how much at most.

    `control` is the range of its control where its force is `gain` times that, else None.
    """

    name: str
    line: int | None
    on: str
    target: int
    gear: float
    force: Numbers | None
    control: Numbers | None
    gain: float
    armature: float
    damping: Numbers


@dataclass(frozen=True)
class KeyRow:
    """A keyframe that says where the joints are."""

    name: str
    qpos: Numbers


@dataclass(frozen=True)
class Model:
    """A compiled model; body 0 is the world."""

    name: str
    gravity: Numbers
    bodies: tuple[BodyRow, ...]
    sites: tuple[SiteRow, ...]
    meshes: tuple[MeshRow, ...]
    equalities: tuple[EqualityRow, ...]
    tendons: tuple[TendonRow, ...]
    actuators: tuple[ActuatorRow, ...]
    keys: tuple[KeyRow, ...]
    qpos0: Numbers
    schema: str
    """All that MuJoCo knows, where plugins were left out and names in the file are still to be looked at."""
