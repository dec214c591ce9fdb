"""Without an optional package a command works, or says which extra brings it: in processes that cannot import it."""

from __future__ import annotations

import os
import subprocess
import sys
import tomllib
from collections.abc import Sequence
from importlib.metadata import requires
from pathlib import Path

import pytest

from cutjoint import extras
from cutjoint.cli import COMMANDS
from cutjoint.description import catalogue
from cutjoint.errors import MissingPackageError

DISTRIBUTIONS = {
    "umsgpack": "u-msgpack-python",
    "zmq": "meshcat",
    "yaml": "pyyaml",
    "example_robot_data": "example-robot-data",
    "pxr": "usd-core",
    "skimage": "scikit-image",
}
"""What brings a package where that is not called as it is imported."""

ROOT = Path(__file__).resolve().parents[2]
HIDE = """
import importlib.machinery, os
hidden = set(os.environ.get("HIDDEN_PACKAGES", "").split(","))
usual = importlib.machinery.PathFinder.find_spec
def find_spec(name, path=None, target=None):
    return None if name.partition(".")[0] in hidden else usual(name, path, target)
importlib.machinery.PathFinder.find_spec = staticmethod(find_spec)
if "example_robot_data" in hidden:
    import pathlib
    known = pathlib.Path.is_dir
    pathlib.Path.is_dir = lambda self: "example-robot-data" not in self.parts and known(self)
"""
"""Run when a Python starts, its children too: packages of these names are not there, nor is the folder of robots."""
URDF_WITH_XACRO = """<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro">
<xacro:property name="a" value="1"/><link name="base"/></robot>
"""
LOOPS_WITH_MJCF = '<mujoco><worldbody><body name="a"><joint name="j"/><geom size="0.1"/></body></worldbody></mujoco>'


STUDY = """robot = "cpm"
model = "published"
method = "random"
runs = 48
duration = 0.01
controller = { name = "pd" }
vary = [{ path = "payload", uniform = [0.0, 1.0] }]
"""
ORDER = """robot = "fourbar"
[[vary]]
path = "links.crank_link.mass"
range = [0.1, 0.9]
[[want]]
quantity = "mass"
goal = "least"
"""


class World:
    """A folder with files of every kind, in which commands run without some packages."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        (folder / "site").mkdir()
        (folder / "site" / "sitecustomize.py").write_text(HIDE)
        (folder / "arm.urdf").write_text(URDF_WITH_XACRO)
        (folder / "arm.xml").write_text(LOOPS_WITH_MJCF)
        (folder / "arm.usda").write_text("#usda 1.0\n")
        (folder / "robot.yaml").write_text("closed_loop: []\n")
        (folder / "study.toml").write_text(STUDY)
        (folder / "indices.toml").write_text(STUDY.replace("random", "saltelli"))
        (folder / "order.toml").write_text(ORDER)
        (folder / "front.toml").write_text(f'{ORDER}[[want]]\nquantity = "effort"\ngoal = "least"\n')
        (folder / "robot.urdf").write_text('<robot name="r"><link name="base"/></robot>')

    def run(self, hidden: Sequence[str], *words: str) -> subprocess.CompletedProcess[str]:
        """`cutjoint WORDS` where the packages `hidden` are not installed; run.npz is there for those who read it."""
        if "run.npz" in words[:2] and not (self.folder / "run.npz").exists():
            made = self.run((), "simulate", "fourbar", "--duration", "0.02", "--plant", "chain", "--save", "run.npz")
            assert made.returncode == 0, made.stderr
        paths = [str(self.folder / "site"), str(ROOT / "src")]
        return subprocess.run(
            [sys.executable, "-m", "cutjoint", *words],
            capture_output=True,
            text=True,
            timeout=120,
            cwd=self.folder,
            check=False,
            env={
                **os.environ,
                "PYTHONPATH": os.pathsep.join(paths),
                "HIDDEN_PACKAGES": ",".join(hidden),
                "CUTJOINT_CACHE": str(self.folder / "cache"),
            },
        )


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> World:
    return World(tmp_path_factory.mktemp("without"))


def told(done: subprocess.CompletedProcess[str], package: str) -> None:
    """The command said which extra brings the package, and nothing else went wrong."""
    assert done.returncode == 2, (done.returncode, done.stderr)
    assert "Traceback" not in done.stderr
    assert extras.how_to_get(package) in " ".join(done.stderr.split()), done.stderr


# ---- the table -----------------------------------------------------------------------------------------------------


def test_the_table_is_that_of_the_project() -> None:
    wanted = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    for package, extra in extras.EXTRAS.items():
        distribution = DISTRIBUTIONS.get(package, package)
        assert any(one.startswith(distribution) for one in wanted[extra]), (package, extra)
    listed = {one.split(">")[0].split("<")[0].strip() for name in set(extras.EXTRAS.values()) for one in wanted[name]}
    assert listed == {DISTRIBUTIONS.get(package, package) for package in extras.EXTRAS}
    apart = {"all", "test", "dev", "docs", "bench", "engines"}
    assert set(wanted) - apart == set(extras.EXTRAS.values())
    assert all(one.split(">")[0] in listed for one in wanted["engines"])


def test_zmq_comes_with_meshcat() -> None:
    assert any("zmq" in one for one in requires("meshcat") or ())


def test_what_is_no_optional_package_is_no_missing_extra() -> None:
    assert extras.needed("matplotlib.figure", "a plot").__name__ == "matplotlib.figure"
    with pytest.raises(ImportError, match="no_such_module"):
        extras.needed("no_such_module", "a test")
    with pytest.raises(MissingPackageError, match=r"a test needs matplotlib.*'cutjoint\[report\]'") as found:
        raise extras.missing("matplotlib.figure", "a test")
    assert (found.value.package, found.value.extra) == ("matplotlib", "report")


def test_a_robot_of_a_missing_package(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(catalogue, "_example_files", dict)
    with pytest.raises(MissingPackageError, match=r"'ur5' .*example-robot-data.*cutjoint\[formats\]"):
        catalogue.resolve("ur5")
    with pytest.raises(catalogue.UnknownNameError):  # near one that ships: a slip of the pen
        catalogue.resolve("stewrt")


# ---- commands ------------------------------------------------------------------------------------------------------

NEEDS: dict[str, tuple[tuple[str, ...], ...]] = {
    "meshcat": (("view", "fourbar", "--html", "x.html"), ("view", "fourbar", "--no-open")),
    "tornado": (("view", "fourbar", "--no-open"),),
    "umsgpack": (("view", "fourbar", "--html", "x.html"),),
    "zmq": (("view", "fourbar", "--html", "x.html"),),
    "llvmlite": (
        ("compile", "fourbar"),
        ("accuracy", "fourbar", "-t", "tool.x=1mm", "--exact"),
        ("study", "study.toml"),
        ("workspace", "fourbar"),
    ),
    "matplotlib": (
        ("reproduce", "cpm", "--output", "page"),
        ("plot", "run.npz", "-o", "run.svg"),
        ("stiffness", "fourbar", "--actuator", "1e3", "-o", "x.png"),
        ("accuracy", "fourbar", "-t", "tool.x=1mm", "-o", "x.png"),
        ("workspace", "fourbar", "-o", "x.png"),
        ("size", "fourbar", "-o", "x.png"),
        ("retime", "fourbar", "--effort", "9", "-o", "x.png"),
        ("synthesise", "order.toml", "-o", "better"),
    ),
    "pyarrow": (("study", "study.toml"), ("workspace", "fourbar", "--save", "x.parquet")),
    "skimage": (("workspace", "omega3", "--surface", "x.stl"),),
    "optuna": (("synthesise", "front.toml"), ("tune", "fourbar", "--by", "optimise", "--method", "optuna")),
    "SALib": (("study", "indices.toml"),),
    "distributed": (("study", "study.toml", "--scheduler", "tcp://127.0.0.1:1"),),
    "ruckig": (("retime", "fourbar", "--to", "crank=0.5", "--acceleration", "9", "--jerk", "90"),),
    "control": (("tune", "fourbar", "--by", "poles"),),
    "rosbags": (("states", "run.npz", "-o", "bag"),),
    "yaml": (("info", "robot.yaml"), ("simulate", "robot.yaml")),
    "example_robot_data": (("info", "ur5"), ("simulate", "ur5"), ("view", "ur5")),
    "xacro": (("info", "arm.urdf"),),
    "mujoco": (("info", "arm.xml"), ("crosscheck", "fourbar", "--engine", "mujoco")),
    "pxr": (("info", "arm.usda"),),
}
"""Commands that cannot work without a package."""
WITHOUT_ANY: tuple[tuple[str, ...], ...] = (
    ("list",),
    ("info", "stewart"),
    ("check", "stewart"),
    ("simulate", "fourbar", "--save", "run.npz"),
    ("simulate", "fourbar", "--rate", "500"),
    ("crosscheck", "cpm", "--samples", "3"),
    ("export", "fourbar", "--to", "urdf"),
    ("new", "walker", "-t", "leg"),
    ("cut", "stewart"),
    ("plot", "run.npz", "-o", "curves.html"),
    ("report", "run.npz"),
    ("states", "run.npz", "-o", "run.jsonl"),
    ("stiffness", "fourbar", "--actuator", "1e3"),
    ("accuracy", "fourbar", "-t", "tool.x=1mm"),
    ("size", "fourbar", "--trajectory", "hold"),
    ("retime", "fourbar", "--effort", "9"),
    ("synthesise", "order.toml", "--designs", "3"),
)
"""Commands that need none."""


@pytest.mark.slow
@pytest.mark.parametrize(("package", "words"), [(package, words) for package, all_ in NEEDS.items() for words in all_])
def test_a_command_says_what_it_needs(world: World, package: str, words: tuple[str, ...]) -> None:
    told(world.run([package], *words), package)


@pytest.mark.slow
@pytest.mark.parametrize("words", WITHOUT_ANY, ids=" ".join)
def test_a_command_that_needs_no_extra(world: World, words: tuple[str, ...]) -> None:
    done = world.run([*extras.EXTRAS], *words)
    assert done.returncode == 0, done.stderr
    if words[0] == "simulate":
        assert "not compiled" in done.stdout


@pytest.mark.slow
@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_has_its_help(world: World, name: str) -> None:
    done = world.run([*extras.EXTRAS], name, "--help")
    assert done.returncode == 0, done.stderr


def test_a_simulation_without_a_compiler_says_so(world: World) -> None:
    done = world.run([*extras.EXTRAS], "simulate", "fourbar", "--duration", "0.05", "--json")
    assert done.returncode == 0, done.stderr
    assert extras.how_to_get("llvmlite") in done.stdout


def test_the_viewer_is_asked_for_before_anything_is_drawn(world: World) -> None:
    told(world.run(["tornado"], "view", "fourbar", "--no-open"), "tornado")
