"""A sketch as the text of its two files, to be read and changed by hand: `robot.urdf` and `loops.toml`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import floor, log10
from textwrap import fill

from cutjoint.arrays import Array
from cutjoint.drafting.sketch import COLOURS, ZERO, LinkSketch, Loop, Sketch, Solid, Tie, Vector

WIDTH = 100
GRAVITY = 9.81
SPARE = 6.0
"""How many times the weight of the whole robot, held out at its length, the motors may give."""
QUICK = 20.0
"""Limit of the speeds of joints [rad/s], and of slides in lengths of the robot a second."""


def urdf_text(name: str, sketch: Sketch, density: float) -> str:
    """The open tree as URDF, commented."""
    head = [f"{sketch.title}: the open tree. What closes it is in loops.toml.", *sketch.notes]
    head.append(f"Masses are those of the solids at {number(density)} kg/m3; lengths in m, angles in rad.")
    lines = ['<?xml version="1.0"?>', f'<robot name="{name}">', *_comment(head, "  "), ""]
    used = {one.colour for body in sketch.bodies for one in (*body.solids, *body.looks)}
    for colour in (one for one in COLOURS if one in used):
        lines.append(f'  <material name="{colour}"><color rgba="{COLOURS[colour]}"/></material>')
    effort = _effort(sketch, density)
    above = {tie.child: tie for tie in sketch.ties}
    for body in sketch.bodies:
        lines += ["", *_body(body, density)]
        if body.name in above:
            lines += _tie(above[body.name], effort)
    return "\n".join([*lines, "</robot>", ""])


def _comment(lines: Sequence[str], indent: str) -> list[str]:
    whole = [fill(line, WIDTH, initial_indent=f"{indent}     ", subsequent_indent=f"{indent}     ") for line in lines]
    whole[0] = f"{indent}<!-- {whole[0].lstrip()}"
    return "\n".join([*whole[:-1], f"{whole[-1]} -->"]).split("\n")


def _body(body: LinkSketch, density: float) -> Iterator[str]:
    if body.about:
        yield from _comment([body.about], "  ")
    if not (body.solids or body.looks):
        yield f'  <link name="{body.name}"/>'
        return
    yield f'  <link name="{body.name}">'
    if body.solids:
        mass, com, inertia = body.inertial(density)
        yield "    <inertial>"
        yield f'      <origin xyz="{_rough(com)}"/>'
        yield f'      <mass value="{mass:.6g}"/>'
        entries = (("ixx", 0, 0), ("iyy", 1, 1), ("izz", 2, 2), ("ixy", 0, 1), ("ixz", 0, 2), ("iyz", 1, 2))
        noise = 1e-12 * float(inertia.max())
        parts = (f'{key}="{0.0 if abs(inertia[i, j]) < noise else inertia[i, j]:.6g}"' for key, i, j in entries)
        yield f"      <inertia {' '.join(parts)}/>"
        yield "    </inertial>"
    for solid in (*body.solids, *body.looks):
        yield from _solid(solid)
    yield "  </link>"


def _solid(solid: Solid) -> Iterator[str]:
    size = [f"{one:.6g}" for one in solid.size]
    if solid.kind == "box":
        shape = f'<box size="{" ".join(size)}"/>'
    elif solid.kind == "cylinder":
        shape = f'<cylinder radius="{size[0]}" length="{size[1]}"/>'
    else:
        shape = f'<sphere radius="{size[0]}"/>'
    rpy = f' rpy="{_rough(solid.rpy)}"' if solid.rpy != ZERO else ""
    yield "    <visual>"
    if rpy or solid.xyz != ZERO:
        yield f'      <origin xyz="{_rough(solid.xyz)}"{rpy}/>'
    yield f"      <geometry>{shape}</geometry>"
    yield f'      <material name="{solid.colour}"/>'
    yield "    </visual>"


def _tie(tie: Tie, effort: float) -> Iterator[str]:
    if tie.about:
        yield from _comment([tie.about], "  ")
    yield f'  <joint name="{tie.name}" type="{tie.type}">'
    yield f'    <parent link="{tie.parent}"/>'
    yield f'    <child link="{tie.child}"/>'
    rpy = f' rpy="{_words(tie.rpy)}"' if tie.rpy != ZERO else ""
    if rpy or tie.xyz != ZERO:
        yield f'    <origin xyz="{_words(tie.xyz)}"{rpy}/>'
    if tie.type not in ("fixed", "floating"):
        yield f'    <axis xyz="{_words(tie.axis)}"/>'
    limits = "" if tie.limits is None else f'lower="{tie.limits[0]:.6g}" upper="{tie.limits[1]:.6g}" '
    if limits or tie.driven:
        fast = QUICK * (max(map(abs, tie.limits or (1.0,))) if tie.type == "prismatic" else 1.0)
        yield f'    <limit {limits}effort="{effort if tie.driven else 0:.6g}" velocity="{_round(fast):.6g}"/>'
    yield "  </joint>"


def _effort(sketch: Sketch, density: float) -> float:
    """A limit that holds the whole robot up: a force [N] where something slides, else a moment [N m]."""
    weight = GRAVITY * sum(body.inertial(density)[0] for body in sketch.bodies if body.solids)
    lengths = [abs(x) for tie in sketch.ties for x in tie.xyz] + [abs(x) for cut in sketch.loops for x in cut.a[1]]
    slides = any(tie.driven and tie.type == "prismatic" for tie in sketch.ties)
    return _round(SPARE * weight * (1.0 if slides else max(lengths)))


def _round(value: float) -> float:
    """Up to one digit."""
    ten = 10.0 ** floor(log10(value))
    return float(f"{-(-value // ten) * ten:.1g}")


def loops_text(name: str, sketch: Sketch) -> str:
    """What closes the tree, and how it is driven, commented."""
    lines = [
        f"# {sketch.title}: what closes the tree of robot.urdf, and how it is driven.",
        "# Every key: docs/description.md of cutjoint. After a change: cutjoint check on this folder.",
        *(f"# {one}" for one in sketch.changes),
        "schema = 1",
        f'name = "{name}"',
        f'title = "{sketch.title}"',
        'urdf = "robot.urdf"',
        f'source = "{sketch.source}"',
        f"gravity = [0.0, 0.0, {-GRAVITY}]                # m/s2, in the frame of the base",
        f"actuators = [{', '.join(map(_quoted, sketch.driven))}]",
        "",
        "# The frame that does the work: reach, trajectories and the viewer lead it.",
        "[tool]",
        f'frame = "{sketch.tool}"',
        "",
        "# The joints that were left out to get a tree. Each joins two frames: a link, or a point of it",
        "# (xyz [m], and rpy [rad] where its axes are turned). A revolute cut turns about z of both.",
    ]
    for loop in sketch.loops:
        lines += _loop(loop)
    lines += [
        "",
        "# The posture in which the robot starts: actuated coordinates exactly, passive ones roughly;",
        "# they pick the branch, cutjoint closes the loops from there.",
        "[home.default]",
        f'about = "{sketch.about_home}"',
        "actuated = { " + ", ".join(f"{joint} = {number(value)}" for joint, value in sketch.home.items()) + " }",
        "[home.default.passive]",
    ]
    for joint, value in sketch.passive.items():
        rough = f"[{', '.join(map(_decimal, value))}]" if isinstance(value, tuple) else _decimal(value)
        lines.append(f"{joint} = {rough}")
    return "\n".join([*lines, ""])


def _loop(loop: Loop) -> list[str]:
    about = [f"# {loop.about}"] if loop.about else []
    return [
        "",
        *about,
        "[[cut]]",
        f'name = "{loop.name}"',
        f'type = "{loop.type}"',
        f"frames = [{_frame(*loop.a)}, {_frame(*loop.b)}]",
    ]


def _frame(link: str, xyz: Vector) -> str:
    if xyz == ZERO:
        return _quoted(link)
    return f'{{ link = "{link}", xyz = [{", ".join(map(number, xyz))}] }}'


def _quoted(text: str) -> str:
    return f'"{text}"'


def _rough(values: Sequence[float] | Array) -> str:
    """What is only seen, or weighs: six digits, noise around zero is zero."""
    least = 1e-12 * max((abs(float(one)) for one in values), default=0.0)
    return " ".join("0" if abs(one) <= least else f"{one:.6g}" for one in values)


def _words(values: Sequence[float]) -> str:
    return " ".join(number(one).removesuffix(".0") for one in values)


def _decimal(value: float) -> str:
    short = f"{value:.5g}"
    return short if any(one in short for one in ".e") else f"{short}.0"


def number(value: float) -> str:
    """`value` up to its last two bits, with as few digits as that takes; noise around zero is zero."""
    short = float(f"{value:.12g}")
    return repr(0.0 if abs(value) < 1e-16 else short if abs(short - value) <= 4e-16 * abs(value) else float(value))
