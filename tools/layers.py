"""Checks which part of cutjoint imports which: rooms flow one way, and light things stay light.

    python tools/layers.py [SOURCE]        exit status 1 and a line per offence where a rule is broken

The rules are the tables below.  Every import statement counts: inside functions, and under `if TYPE_CHECKING` too.  A
room is a module or package directly under `cutjoint`.  With the default source it also starts Python to see what
`import cutjoint` and `cutjoint --help` load.
"""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

PACKAGE = "cutjoint"
SOURCE = Path(__file__).resolve().parents[1] / "src" / PACKAGE

# Room -> the rooms it may import, besides itself.  `cutjoint` is the package's own __init__.
BASE = frozenset(
    {
        "errors",
        "arrays",
        "doors",
        "extras",
        "files",
        "findings",
        "interrupts",
        "pool",
        "reprs",
        "tables",
        "texts",
        "tolerances",
        "toml",
        "units",
    }
)
MODEL = BASE | {"mechanism"}
CHAIN = MODEL | {"description", "chain"}
RUN = CHAIN | {"motion", "control", "simulation"}
COMPILED = RUN | {"papers", "compile"}
ROBOTS = COMPILED | {"crosscheck", "robots"}
ANSWERS = frozenset({"workspace", "sizing", "retiming", "stiffness", "accuracy", "tuning", "studies"})
ALLOWED: Mapping[str, frozenset[str]] = {
    "errors": frozenset(),
    "arrays": frozenset({"doors", "errors"}),
    "doors": frozenset({"errors"}),
    "extras": frozenset({"errors"}),
    "tables": frozenset({"reprs", "texts"}),
    "texts": frozenset(),
    "reprs": frozenset({"errors"}),
    "files": frozenset({"errors", "interrupts"}),
    "interrupts": frozenset(),
    "pool": frozenset({"errors", "interrupts"}),
    "findings": frozenset({"errors", "files", "reprs"}),
    "toml": frozenset({"errors", "findings"}),
    "units": frozenset({"errors"}),
    "tolerances": frozenset(),
    "plugins": frozenset({"errors", "files"}),
    "mechanism": BASE,
    "description": MODEL,
    "chain": MODEL | {"description", PACKAGE},  # chain.compile() asks the package for the compiler, at call time
    "papers": MODEL,
    "motion": MODEL | {"plugins"},
    "control": MODEL | {"motion", "plugins"},
    "crosscheck": MODEL,
    "simulation": CHAIN | {"motion", "control", "plugins", PACKAGE},  # simulation.choice asks for compiled plants
    "compile": RUN | {"papers"},
    "viewer": RUN,
    "handover": RUN,
    "engines": CHAIN | {"crosscheck"},
    "drafting": CHAIN,
    "robots": ROBOTS,
    "workspace": COMPILED,
    "sizing": COMPILED,
    "retiming": COMPILED,
    "stiffness": COMPILED,
    "accuracy": COMPILED | {"stiffness"},
    "tuning": COMPILED,
    "studies": ROBOTS | {"plugins"},
    "synthesis": ROBOTS | ANSWERS,
    "experiments": ROBOTS | {"report", "tuning"},
    "report": ROBOTS | ANSWERS | {"viewer", "synthesis"},
    "commands": ROBOTS
    | ANSWERS
    | {"drafting", "engines", "experiments", "handover", "viewer", "report", "plugins", "synthesis", PACKAGE},
    "cli": BASE | {"commands", PACKAGE},
    "__main__": frozenset({"cli", "interrupts"}),
    PACKAGE: ROBOTS | ANSWERS | {"report", "synthesis", "viewer"},  # at call time: result.plot(), and cutjoint.viewer
}

# Room -> the only packages from outside the standard library that it may import.
OUTSIDE: Mapping[str, frozenset[str]] = {
    "errors": frozenset({"numpy"}),
    "arrays": frozenset({"numpy"}),
    "doors": frozenset({"numpy"}),
    "extras": frozenset(),
    "files": frozenset(),
    "interrupts": frozenset(),
    "pool": frozenset(),
    "reprs": frozenset({"numpy"}),
    "findings": frozenset(),
    "toml": frozenset(),
    "units": frozenset(),
    "tables": frozenset(),
    "texts": frozenset({"rich"}),
    "tolerances": frozenset(),
    "plugins": frozenset(),
    "mechanism": frozenset({"numpy"}),
    "papers": frozenset({"numpy"}),
    "motion": frozenset({"numpy", "scipy"}),
    "control": frozenset({"numpy"}),
    PACKAGE: frozenset(),
}

# Package from outside the standard library -> the only rooms that may import it.  One that is not here is not a
# dependency of the project (docs/dependencies.md); numpy is everybody's.
OWNERS: Mapping[str, frozenset[str]] = {
    "pinocchio": frozenset({"chain", "compile", "engines", "simulation", "viewer"}),
    "eigenpy": frozenset({"chain"}),
    "scipy": frozenset({"simulation", "crosscheck", "chain", "motion", "synthesis"}) | ANSWERS,
    "yourdfpy": frozenset({"description", "engines"}),
    "lxml": frozenset({"description"}),
    "yaml": frozenset({"description"}),
    "xacro": frozenset({"description"}),
    "example_robot_data": frozenset({"description"}),
    "pxr": frozenset({"description"}),
    "trimesh": frozenset({"description", "viewer"}),
    "meshcat": frozenset({"viewer"}),
    "tornado": frozenset({"viewer"}),
    "umsgpack": frozenset({"viewer"}),
    "zmq": frozenset({"viewer"}),
    "IPython": frozenset({"viewer"}),
    "matplotlib": frozenset({"report"}),
    "llvmlite": frozenset({"compile"}),
    "pyarrow": frozenset({"compile", "studies", "workspace"}),
    "rosbags": frozenset({"handover"}),
    "skimage": frozenset({"workspace"}),
    "ruckig": frozenset({"retiming"}),
    "control": frozenset({"tuning"}),
    "dask": frozenset({"studies"}),
    "distributed": frozenset({"studies"}),
    "SALib": frozenset({"studies"}),
    "optuna": frozenset({"tuning", "synthesis"}),
    "mujoco": frozenset({"description", "engines"}),
    "typer": frozenset({"cli", "commands"}),
    "rich": frozenset({"cli", "commands", "texts"}),
}

# What is too heavy to be loaded by a program that only starts.
HEAVY = frozenset(
    {
        "pinocchio",
        "eigenpy",
        "scipy",
        "matplotlib",
        "meshcat",
        "llvmlite",
        "pyarrow",
        "mujoco",
        "pxr",
        "trimesh",
        "yourdfpy",
        "lxml",
        "skimage",
        "ruckig",
        "control",
        "distributed",
        "SALib",
        "optuna",
    }
)
STARTS: Mapping[str, str] = {
    "import cutjoint": "import cutjoint",
    "cutjoint --help": (
        "import sys; sys.argv = ['cutjoint', '--help']\n"
        "from cutjoint.cli import main\n"
        "try:\n    main()\nexcept SystemExit as stop:\n    assert not stop.code, stop.code"
    ),
}


@dataclass(frozen=True)
class Import:
    """One imported module: which module imports it, and at which line."""

    module: str
    line: int
    target: str


def modules(source: Path) -> dict[str, Path]:
    """Dotted name -> file of every module of the package at `source`."""
    found = {}
    for file in sorted(source.rglob("*.py")):
        parts = [PACKAGE, *file.relative_to(source).with_suffix("").parts]
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = file
    return found


def imports(module: str, file: Path, known: Mapping[str, Path]) -> Iterator[Import]:
    """The imports of one file.  `from package import submodule` is an import of the submodule.

    So is `import_module` of a name, and of an f-string that begins with `cutjoint.` or `{__name__}.`: of every module
    whose name begins so.
    """
    tree = ast.parse(file.read_text(encoding="utf-8"), filename=str(file))
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for target in {alias.name for alias in node.names}:
                yield Import(module, node.lineno, target)
        elif isinstance(node, ast.ImportFrom):
            base = _absolute(module, node, is_package=file.stem == "__init__")
            inner = {f"{base}.{alias.name}" for alias in node.names}
            for target in {one if one in known else base for one in inner}:
                yield Import(module, node.lineno, target)
        elif isinstance(node, ast.Call) and getattr(node.func, "id", getattr(node.func, "attr", "")) == "import_module":
            for target in _by_name(node.args[0], module, known):
                yield Import(module, node.lineno, target)


def _by_name(name: ast.expr, module: str, known: Mapping[str, Path]) -> list[str]:
    """The modules that `import_module(name)` may import, as far as the source tells."""
    if isinstance(name, ast.Constant):
        return [str(name.value)]
    if not isinstance(name, ast.JoinedStr):
        return []
    start = ""
    for part in name.values:
        if isinstance(part, ast.Constant):
            start += str(part.value)
        elif isinstance(part, ast.FormattedValue) and getattr(part.value, "id", "") == "__name__":
            start += module
        else:
            break
    return [one for one in known if start and one.startswith(start)]


def _absolute(module: str, node: ast.ImportFrom, *, is_package: bool) -> str:
    """The module named by `from ... import`, with leading dots resolved."""
    if not node.level:
        return node.module or ""
    parts = module.split(".")
    parts = parts[: len(parts) - node.level + (1 if is_package else 0)]
    return ".".join([*parts, node.module] if node.module else parts)


def room_of(module: str) -> str:
    """The room a module of the package lives in."""
    parts = module.split(".")
    return parts[1] if len(parts) > 1 else PACKAGE


def offences(source: Path) -> list[str]:
    """Every broken rule of the package at `source`, a line each, files given relative to the folder above it."""
    known = modules(source)
    found = [one for module, file in known.items() for one in imports(module, file, known)]
    lines = []
    for one in found:
        where = f"{known[one.module].relative_to(source.parent)}:{one.line}"
        lines += [f"{where}: {why}" for why in _judge(one, known)]
    unruled = sorted({room_of(module) for module in known} - ALLOWED.keys())
    lines += [f"{room}: a new room; say in tools/layers.py what it may import" for room in unruled]
    lines += [f"import cycle: {' -> '.join([*cycle, cycle[0]])}" for cycle in circles(modules_graph(found, known))]
    lines += [f"folders need each other: {', '.join(circle)}" for circle in circles(folders_graph(found, known))]
    return lines


def _judge(one: Import, known: Mapping[str, Path]) -> Iterator[str]:
    """What is wrong with one import."""
    here, package = room_of(one.module), one.target.split(".")[0]
    if package == PACKAGE:
        there = room_of(one.target)
        if there != here and there not in ALLOWED.get(here, {there}):
            yield f"{here} may not import {there} ({one.target})"
        if one.target not in known:
            yield f"there is no module {one.target}"
    elif package not in sys.stdlib_module_names:
        if here in OUTSIDE and package not in OUTSIDE[here]:
            yield f"{here} may not import {package}, only {', '.join(sorted(OUTSIDE[here])) or 'the standard library'}"
        elif package not in OWNERS and package != "numpy":
            yield f"{package} is not among the packages of tools/layers.py; is it a dependency of the project?"
        elif package in OWNERS and here not in OWNERS[package]:
            yield f"{here} may not import {package}; that is left to {', '.join(sorted(OWNERS[package]))}"


def modules_graph(found: Sequence[Import], known: Mapping[str, Path]) -> dict[str, set[str]]:
    """Module -> the modules that it imports: late imports and those for types alone count too.

    The package's own __init__ is left out: it offers what the rooms below it make and loads them on first use.
    """
    graph: dict[str, set[str]] = {module: set() for module in known if module != PACKAGE}
    for one in found:
        if one.module in graph and one.target in graph and one.target != one.module:
            graph[one.module].add(one.target)
    return graph


def folders_graph(found: Sequence[Import], known: Mapping[str, Path]) -> dict[str, set[str]]:
    """Folder inside a room -> such folders that its modules import, but for those that one of them lies in."""

    def folder_of(module: str) -> str:
        parts = module.split(".") if known[module].stem == "__init__" else module.split(".")[:-1]
        return ".".join(parts) if len(parts) > 2 else ""

    graph: dict[str, set[str]] = {folder: set() for folder in sorted({folder_of(module) for module in known} - {""})}
    for one in found:
        here, there = (folder_of(module) if module in known else "" for module in (one.module, one.target))
        if here and there and not f"{here}.".startswith(f"{there}.") and not f"{there}.".startswith(f"{here}."):
            graph[here].add(there)
    return graph


def circles(graph: Mapping[str, set[str]]) -> list[list[str]]:
    """Groups that need each other: the strongly connected parts of a graph."""

    def reachable(start: str) -> set[str]:
        seen: set[str] = set()
        queue = list(graph[start])
        while queue:
            module = queue.pop()
            if module not in seen:
                seen.add(module)
                queue += graph[module]
        return seen

    reach = {module: reachable(module) for module in graph}
    groups = {tuple(sorted(a for a in reach[b] if b in reach[a])) for b in graph if b in reach[b]}
    return [list(group) for group in sorted(groups)]


def loaded_at_start() -> list[str]:
    """The heavy packages that a start loads, a line each.  Runs the installed package."""
    lines = []
    for name, code in STARTS.items():
        probe = f"{code}\nimport sys\nprint('heavy:', *sorted({set(HEAVY)!r} & set(sys.modules)))"
        run = subprocess.run([sys.executable, "-c", probe], capture_output=True, text=True, timeout=60, check=False)
        answer = run.stdout.rstrip().rpartition("\n")[2]
        if run.returncode or not answer.startswith("heavy:"):
            lines.append(f"`{name}` failed: {run.stderr.strip() or run.stdout.strip()}")
        elif heavy := answer.removeprefix("heavy:").split():
            lines.append(f"`{name}` loads {', '.join(heavy)}: import them where they are used")
    return lines


def main(arguments: Sequence[str]) -> int:
    """Check the package at the path given, or cutjoint's own source; the exit status."""
    source = Path(arguments[0]) if arguments else SOURCE
    lines = offences(source) + ([] if arguments else loaded_at_start())
    for line in lines:
        print(line)
    print(f"layers: {len(modules(source))} modules, {len(lines)} offence{'' if len(lines) == 1 else 's'}")
    return 1 if lines else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
