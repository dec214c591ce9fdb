"""Motions from files: what is written is what is led, in whatever units and order; and what is no motion is told by
line and column."""

import csv
import io
import warnings
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cutjoint import load
from cutjoint.errors import CutjointError, MotionFileError, UnknownNameError
from cutjoint.mechanism import Actuator, Pose, Task
from cutjoint.motion import JointSpline, PointSpline, PoseSpline, Reference, motion_from_file
from cutjoint.motion import table as tables
from cutjoint.motion.catalogue import trajectory

ARMS = (Actuator("arm1", "rotation"), Actuator("Slide_2", "translation"))
NAMES = ("x", "y", "z", "rx", "ry", "rz")


def robot(seed=None, axes="world", actuators=ARMS):
    """As much of a mechanism as a file needs to know, standing as it happens."""
    pose = Pose.of([0.0] * 6 + [1.0])
    if seed is not None:
        rng = np.random.default_rng(seed)
        pose = Pose(rng.normal(size=3), Rotation.random(random_state=seed).as_matrix())
    home = SimpleNamespace(q=np.arange(1.0, len(actuators) + 1.0))
    return SimpleNamespace(name="robot", actuators=actuators, home=home, task=Task(NAMES, pose, "robot", axes))


@pytest.fixture
def written(tmp_path):
    """Writes a file; returns its path."""

    def write(content, name="way.csv"):
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return write


def rows_of(headings, columns, separator=",", end="\n"):
    lines = [separator.join(headings), *(separator.join(map(repr, map(float, row))) for row in np.transpose(columns))]
    return end.join(lines) + end


# ---- what is written is what is led --------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(10))
def test_a_smooth_motion_comes_back(written, seed):
    """A closed motion, sampled unevenly, under random headings, units, order, separators and signs of quaternions."""
    rng = np.random.default_rng(seed)
    phases, sizes, counts = rng.uniform(0, 6, 6), rng.uniform(0.1, 1.0, 6), rng.integers(1, 3, 6)

    def of(s, order=0):
        angle = 2 * np.pi / 3.0 * counts * np.asarray(s)[..., None] + phases
        return sizes * (2 * np.pi / 3.0 * counts) ** order * np.sin(angle + order * np.pi / 2)

    n = 1500
    times = np.linspace(0.0, 3.0, n)
    times[1:-1] += rng.uniform(-0.4, 0.4, n - 2) * 3.0 / n
    values = of(times)
    turns = Rotation.from_rotvec(values[:, 3:])
    lengths = ["x [mm]", " Y(cm)", "z_m"]
    columns = [times * 1e3, *(values[:, :3].T * [[1e3], [1e2], [1.0]])]
    headings = ["T [ms]", *lengths]
    if seed % 2:
        signs = rng.choice([-1.0, 1.0], n)
        headings += ["qx", "QY", "qz", "qw"]
        columns += list(turns.as_quat().T * signs)
    else:
        roll, pitch, yaw = turns.as_euler("xyz").T
        headings += ["roll [rad]", "pitch_deg", "Yaw (deg)"]
        columns += [roll, np.rad2deg(pitch), np.rad2deg(yaw)]
    order = rng.permutation(len(headings))
    text = rows_of([headings[i] for i in order], [columns[i] for i in order], separator=",;\t"[seed % 3])
    motion = motion_from_file(written(text), robot())
    assert isinstance(motion, PoseSpline)
    assert (motion.closed, motion.given, motion.name) == (True, NAMES, "way")
    assert np.isclose(motion.duration, 3.0, rtol=0.0, atol=1e-12)
    for t in rng.uniform(0.0, 7.0, 40):
        at, wanted = motion.at(t), of(t)
        turn = Rotation.from_rotvec(wanted[3:])
        assert np.allclose(at.position, wanted[:3], rtol=0.0, atol=1e-9)
        assert np.allclose(at.velocity, of(t, 1)[:3], rtol=0.0, atol=1e-6)
        assert np.allclose(at.rotation, turn.as_matrix(), rtol=0.0, atol=1e-8)
        h = 1e-6
        rate = (Rotation.from_rotvec(of(t + h)[3:]) * Rotation.from_rotvec(of(t - h)[3:]).inv()).as_rotvec() / (2 * h)
        assert np.allclose(at.angular_velocity, rate, rtol=0.0, atol=1e-6)


@pytest.mark.parametrize("axes", ["world", "tool"])
@pytest.mark.parametrize("seed", range(4))
def test_what_has_no_column_stays_as_at_home(written, seed, axes):
    """In the axes of the task, as the coordinates of the task count."""
    where = robot(seed, axes)
    task = where.task
    headings, numbers = ["t", "z", "rz [rad]"], [[0.0, 1.0], [0.3, 0.4], [0.1, -0.2]]
    motion = motion_from_file(written(rows_of(headings, numbers)), where)
    assert motion.given == ("z", "rz")
    for t, z, rz in np.transpose(numbers):
        wanted = task.pose({"z": z, "rz": rz})
        assert np.allclose(motion.at(t).position, wanted.position, rtol=0.0, atol=1e-13)
        assert np.allclose(motion.at(t).rotation, wanted.rotation, rtol=0.0, atol=1e-13)
    points = motion_from_file(written(rows_of(["t", "y"], [[5.0, 6.5], [0.3, 0.4]])), where)
    assert isinstance(points, PointSpline)
    assert (points.given, points.duration) == (("y",), 1.5)
    assert np.allclose(points.at(1.5).position, task.pose({"y": 0.4}).position, rtol=0.0, atol=1e-13)


@pytest.mark.parametrize("axes", ["world", "tool"])
@pytest.mark.parametrize("seed", range(4))
def test_orientations_in_all_ways_are_one(written, seed, axes):
    rng = np.random.default_rng(seed)
    where = robot(seed, axes)
    home = where.task.home
    turns = Rotation.random(6, random_state=seed)
    frame = home.rotation if axes == "tool" else np.eye(3)
    wanted = frame @ turns.as_matrix()
    since = turns if axes == "tool" else turns * Rotation.from_matrix(home.rotation).inv()
    times = np.cumsum(rng.uniform(0.1, 1.0, 6))
    ways = (
        (["qx", "qy", "qz", "qw"], turns.as_quat()),
        (
            ["roll [deg]", "pitch [deg]", "yaw [deg]"],
            np.unwrap(turns.as_euler("xyz", degrees=True), axis=0, period=360.0),
        ),
        (["rx [rad]", "ry [rad]", "rz [mrad]"], since.as_rotvec() * [1.0, 1.0, 1e3]),
    )
    for headings, numbers in ways:
        motion = motion_from_file(written(rows_of(["t", *headings], [times, *numbers.T])), where)
        assert motion.given == NAMES[3:]
        for t, turn in zip(times - times[0], wanted, strict=True):
            assert np.allclose(motion.at(t).rotation, turn, rtol=0.0, atol=1e-12)
            assert np.allclose(motion.at(t).position, home.position, rtol=0.0, atol=1e-15)


def test_yaw_alone_keeps_roll_and_pitch_of_home(written):
    where = robot(3)
    roll, pitch, _ = Rotation.from_matrix(where.task.home.rotation).as_euler("xyz")
    motion = motion_from_file(written("t,yaw [deg]\n0,170\n1,-170\n2,-150\n"), where)
    assert motion.given == NAMES[3:]
    for t, yaw in ((0.0, 170), (1.0, 190), (2.0, 210)):
        wanted = Rotation.from_euler("xyz", [roll, pitch, np.deg2rad(yaw)]).as_matrix()
        assert np.allclose(motion.at(t).rotation, wanted, rtol=0.0, atol=1e-12)
    upright = robot()
    upright.task = Task(NAMES, Pose(np.zeros(3), Rotation.from_euler("y", 90, degrees=True).as_matrix()), "robot")
    with pytest.raises(MotionFileError, match="pitch of 90 degrees"):
        motion_from_file(written("t,yaw [deg]\n0,1\n1,2\n"), upright)


def test_actuators_in_their_units_and_the_others_at_home(written):
    motion = motion_from_file(written("ARM1 [deg];t\n90;0\n180;1\n"), robot())
    assert isinstance(motion, JointSpline)
    assert np.allclose(motion.at(9.0).q, [np.pi, 2.0])
    both = motion_from_file(written("t,slide_2_mm,arm1\n0,5,1\n1,6,2\n3,5,1\n"), robot())
    assert both.closed
    assert np.allclose(both.at(1.0).q, [2.0, 6e-3])
    own = motion_from_file(written("t,Slide_2\n0,5\n1,6\n"), robot())
    assert np.allclose(own.at(1.0).q, [1.0, 6.0])
    gantry = robot(actuators=(Actuator("x", "translation"),))
    assert isinstance(motion_from_file(written("t,joint.x\n0,5\n1,6\n"), gantry), JointSpline)
    assert isinstance(motion_from_file(written("t,tool.x\n0,5\n1,6\n"), gantry), PointSpline)


def test_comments_blank_lines_quotes_and_foreign_ends_of_lines(written):
    plain = motion_from_file(written("t,x\n0,1\n2,3\n"), robot())
    text = '\ufeff# a way\r\n\r\n "t" , "x" \r\n  # from here\r\n"0", 1 \r\n   \r\n2.0e0,+3'
    for content in (text, text.replace("\r\n", "\r"), text.replace("\r\n", "\n")):
        other = motion_from_file(written(content), robot())
        assert np.array_equal(other.times, plain.times)
        assert np.array_equal(other.points, plain.points)


# ---- what is none --------------------------------------------------------------------------------------------------

FLAWS = {
    # text -> line, column, what the message says
    "": (None, None, "blank ones"),
    "# nothing\n\n": (None, None, "blank ones"),
    "t,x\n": (1, None, "no row"),
    "t,x\n0,1\n": (2, None, "one row"),
    "0,1\n1,2\n": (1, None, "comments=''"),
    "t x y\n0 1 2\n": (1, None, "one heading"),
    "t,x,\n0,1,2\n1,2,3\n": (1, None, "column 3 of 3 has no heading"),
    "t,x\n0,1\n1\n": (3, None, "found 1 cells; expected 2"),
    "t,x\n0,1\n\n1,2,3\n": (4, None, "found 3 cells; expected 2"),
    "t,x\n0,5,1\n": (2, None, "decimal comma"),
    "t,x,y\n0,1,2\n1,,2\n": (3, "2 'x'", "empty cell"),
    "t,x\n0,1\n1,nan\n2,2\n": (3, "2 'x'", "finite"),
    "t,x [mm]\n0,1\n1,-inf\n": (3, "2 'x [mm]'", "finite"),
    "t,x\n0,1\n1,1e999\n": (3, "2 'x'", "finite"),
    "t,x\n0,1\n1,one\n": (3, "2 'x'", "'one'; expected a number"),
    "t,x\n0,1\n1,1_000\n": (3, "2 'x'", "'1_000'; expected a number"),
    "t,x\n0,1\n1,2 # here\n": (3, "2 'x'", "expected a number"),
    "t,x\n0,1\n1,2\n1,3\n": (4, "1 't'", "1.0 a second time"),
    "x,t [ms]\n1,5\n2,7\n3,6\n": (4, "2 't [ms]'", "6.0 after 7.0"),
    "x,y\n0,1\n2,2\n": (1, None, "no column t"),
    "t\n0\n1\n": (1, None, "one heading"),
    "t,velocity\n0,1\n2,2\n": (1, "2 'velocity'", "unknown heading"),
    "t,ar1\n0,1\n2,2\n": (1, "2 'ar1'", "did you mean 'arm1'"),
    "t,Pitsch [deg],x\n0,1,1\n2,2,1\n": (1, "2 'Pitsch [deg]'", "did you mean 'pitch'"),
    "t,x [foot]\n0,1\n2,2\n": (1, "2 'x [foot]'", "'foot'; expected one of m, cm, mm"),
    "t,x [deg]\n0,1\n2,2\n": (1, "2 'x [deg]'", "expected one of m"),
    "t,arm1 [mm]\n0,1\n2,2\n": (1, "2 'arm1 [mm]'", "expected one of rad"),
    "t,yaw\n0,1\n2,2\n": (1, "2 'yaw'", r"'yaw \[deg\]' or 'yaw \[rad\]'"),
    "t,x,X [mm]\n0,1,2\n2,2,3\n": (1, "3 'X [mm]'", "second column for x"),
    "t,time,x\n0,1,2\n2,2,3\n": (1, "2 'time'", "second column for t"),
    "t,qx,qy,qz\n0,0,0,0\n2,0,0,0\n": (1, None, "without qw"),
    "t,qx,qy,qz,qw,yaw [deg]\n0,0,0,0,1,0\n2,0,0,0,1,0\n": (1, None, "in 2 ways"),
    "t,qx,qy,qz,qw\n0,0,0,0,1\n2,0,0,0,1.1\n": (3, "2 'qx'", "length 1.1"),
    "t,qx,qy,qz,qw\n0,0,0,0,1\n2,0,0,0,0\n": (3, "2 'qx'", "length 0"),
    "t,qx,qy,qz,qw\n0,0,0,0,1\n2,1,0,0,0\n": (3, None, "180 degrees"),
    "t,yaw [deg]\n0,0\n1,10\n2,280\n": (4, "2 'yaw [deg]'", "from 10 to 280; .* write -80 for 280"),
    "t,yaw [deg]\n0,-120\n1,120\n": (3, "2 'yaw [deg]'", "from -120 to 120; .* write -240 for 120"),
    "t,rz [deg]\n0,0\n1,360\n": (3, "2 'rz [deg]'", "from 0 to 360; .*give rows between"),
    "t,x,arm1\n0,1,2\n1,2,3\n": (1, None, "one or the other"),
    "t,x\n0,1\n1,-1e101\n": (3, "2 'x'", "at most 1e\\+100"),
    "t,x\n0,1\n1e-13,2\n": (3, "1 't'", "1e-13 after 0.0"),
    "t,x\n0,1\n2e9,2\n": (3, None, "are the most"),
    b"t,x\n0,1\n1,\xff\n": (3, None, "0xff, which is no UTF-8"),
    b"t,x\n0,1\n\x00,2\n": (3, None, "zero byte"),
    "t,x\n0,1\n".encode("utf-16"): (None, None, "UTF-8|zero byte"),
}


@pytest.mark.parametrize(("content", "told"), FLAWS.items())
def test_a_flaw_is_told_once_with_its_place(written, content, told):
    line, column, about = told
    path = written(content)
    with pytest.raises(MotionFileError, match=about) as caught:
        motion_from_file(path, robot())
    error = caught.value
    assert error.path == str(path)
    if line is not None:
        assert (error.line, error.column) == (line, column)
        assert str(error).startswith(f"{path}:{line}" + (f", column {column}: " if column else ": "))


def test_an_actuator_called_like_a_coordinate_is_asked_about(written):
    gantry = robot(actuators=(Actuator("X", "translation"),))
    with pytest.raises(MotionFileError, match=r"expected 'joint\.x' or 'tool\.x'"):
        motion_from_file(written("t,x\n0,1\n1,2\n"), gantry)


def test_what_is_no_file_is_told(written, tmp_path, monkeypatch):
    for path, about in (
        (tmp_path / "none.csv", "no such file"),
        (tmp_path, "a directory"),
        ("/dev/zero", "a device"),
        ("a\0b.csv", "zero byte"),
    ):
        with pytest.raises(MotionFileError, match=about):
            motion_from_file(path, robot())
    path = written("")
    with path.open("wb") as file:
        file.truncate(10_000_000_000)  # a hole: takes no room
    with pytest.raises(MotionFileError, match="10000 MB, at most 200 MB are read"):
        motion_from_file(path, robot())
    monkeypatch.setattr(tables, "LARGEST", 8)
    with pytest.raises(MotionFileError, match="at most"):
        motion_from_file(written("t,x\n0,1\n1,2\n"), robot())


def test_whatever_bytes_change_it_is_a_motion_or_one_error(written):
    """Files with a few bytes changed, dropped or doubled; whatever loads gives finite numbers."""
    rng = np.random.default_rng(0)
    turns = Rotation.random(5, random_state=1)
    good = [
        rows_of(["t", "x [mm]", "qx", "qy", "qz", "qw"], [range(5), rng.normal(size=5), *turns.as_quat().T]),
        rows_of(["t", "y", "roll [deg]", "yaw_deg"], [range(5), *rng.uniform(-1.0, 1.0, (3, 5)).round(3)], ";"),
        rows_of(["t [ms]", "arm1", "Slide_2 [mm]"], [range(4), *rng.normal(size=(2, 4))], end="\r\n"),
    ]
    loaded = refused = 0
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for _ in range(500):
            content = bytearray(good[rng.integers(3)].encode())
            for _ in range(rng.integers(1, 4)):
                at = int(rng.integers(len(content)))
                new = rng.choice([*b'0159-+.eE,;\t\n\r #"[]_', *rng.integers(256, size=4)])
                content[at : at + int(rng.integers(0, 3))] = bytes([new] * int(rng.integers(0, 3)))
            path = written(bytes(content))
            try:
                motion = motion_from_file(path, robot(2))
            except MotionFileError:
                refused += 1
                continue
            loaded += 1
            for t in (0.0, 0.3 * motion.duration, motion.duration):
                arrays = [one for one in vars(motion.at(t)).values() if isinstance(one, np.ndarray)]
                assert all(np.isfinite(one).all() for one in arrays)
    assert min(loaded, refused) > 50


# ---- on robots -----------------------------------------------------------------------------------------------------


def sampled(task, n=81):
    """A round trip of the tool from home in 2 s, by the coordinates of the task, 12 mm and 0.06 rad wide."""
    t = np.linspace(0.0, 2.0, n)
    values = np.array([task.coordinates(task.home)] * n)
    for column, name in enumerate(task.names):
        way = np.sin(np.pi * (column % 2 + 1) * t) ** 2
        values[:, column] += (0.06 if name.startswith("r") else 0.012) * way
    return t, values


@pytest.mark.parametrize("name", ["stewart", "omega3", "fivebar"])
def test_robots_follow_a_file(written, name):
    """By the coordinates of the task; the tool is where the rows say at their times."""
    mechanism = load(name)
    task = mechanism.task
    t, values = sampled(task)
    headings = [f"{one} [rad]" if one.startswith("r") else one for one in task.names]
    motion = trajectory(str(written(rows_of(["t", *headings], [t, *values.T]))), mechanism)
    reference = Reference(motion, mechanism)
    for row in (0, 7, 40, 66):
        desired = reference.at(float(t[row]))
        tool = mechanism.tool(desired.posture, desired.v)
        assert np.allclose(task.coordinates(tool.pose), values[row], rtol=0.0, atol=1e-10)
    before, now, after = (reference.at(0.61 + s) for s in (-1e-4, 0.0, 1e-4))
    assert np.allclose((after.q - before.q) / 2e-4, now.v, rtol=0.0, atol=1e-6)


def test_actuators_follow_a_file(written):
    mechanism = load("omega3")
    q = mechanism.home.q + np.array([[0.0] * 3, [0.1, 0.05, 0.0], [0.1, 0.1, 0.1]])
    headings = ["t", *(f"{one.name} [deg]" for one in mechanism.actuators)]
    path = written(rows_of(headings, [[0.0, 0.4, 1.0], *np.rad2deg(q).T]))
    reference = Reference(motion_from_file(path, mechanism), mechanism)
    assert np.allclose(reference.at(0.4).q, q[1], rtol=0.0, atol=1e-12)


def test_the_command_line_takes_a_path(written, monkeypatch):
    mechanism = robot()
    text = "t,x\n0,1\n1,2\n"
    path = written(text)
    assert isinstance(trajectory(str(path), mechanism), PointSpline)
    assert isinstance(trajectory(str(written(text, "motion.txt")), mechanism), PointSpline)
    with pytest.raises(MotionFileError, match="no such file"):
        trajectory(str(path.with_name("other.csv")), mechanism)
    with pytest.raises(UnknownNameError):
        trajectory("wya", mechanism)


def test_python_writes_what_is_read(written):
    """csv.writer with all quoted, and numpy.savetxt, make files that are taken."""
    values = np.array([[0.0, 0.1, 0.2], [1.0, 0.3, 0.1], [2.5, 0.0, 0.3]])
    text, array_text = io.StringIO(), io.StringIO()
    writer = csv.writer(text, quoting=csv.QUOTE_ALL)
    writer.writerow(["t", "x", "z"])
    writer.writerows(values.tolist())
    np.savetxt(array_text, values, delimiter=",", header="t,x,z", comments="")
    one, two = (motion_from_file(written(made.getvalue()), robot()) for made in (text, array_text))
    assert np.array_equal(one.points, two.points)
    assert issubclass(MotionFileError, CutjointError)
