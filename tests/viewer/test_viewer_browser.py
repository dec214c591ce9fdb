"""Pictures: browsers that die, hang or talk nonsense, most of them small scripts that speak for a Chromium."""

from __future__ import annotations

import itertools
import json
import os
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from io import BytesIO
from pathlib import Path
from time import monotonic
from typing import Any

import pytest
from kit.quickly import few
from PIL import Image

from cutjoint.errors import BrowserError, ViewerError
from cutjoint.viewer import Document, show
from cutjoint.viewer.browser import camera, devtools, headless, keeper
from cutjoint.viewer.browser.camera import STARTS, photograph

pytestmark = pytest.mark.skipif(os.name != "posix", reason="the browser is steered over inherited pipes")

# Each start takes its turn of the plan, [command, what happens then]; once the plan is done all goes well.
FAKE = """
import base64, json, os, signal, sys, time

book, plan, picture = sys.argv[1], json.loads(sys.argv[2]), base64.b64decode(sys.argv[3])
profile = next(word.partition("=")[2] for word in sys.argv if word.startswith("--user-data-dir="))
with open(book, "a") as file:
    file.write(json.dumps({"profile": profile, "used": os.path.exists(profile), "place": os.environ["TMPDIR"]}) + "\\n")
with open(book) as file:
    turn = len(file.readlines())
os.mkdir(profile)
where, what = plan[turn - 1] if turn <= len(plan) else (None, None)


def say(message):
    data = json.dumps(message).encode() + b"\\0"
    while data:
        data = data[os.write(4, data):]


RESULTS = {
    "Target.createTarget": {"targetId": "a target"},
    "Target.attachToTarget": {"sessionId": "a session"},
    "Runtime.evaluate": {"result": {"type": "boolean", "value": True}},
    "Page.captureScreenshot": {"data": base64.b64encode(picture).decode()},
}
heard = b""
while True:
    while b"\\0" not in heard:
        piece = os.read(3, 65536)
        if not piece:
            sys.exit(0)
        heard += piece
    text, _, heard = heard.partition(b"\\0")
    command = json.loads(text)
    say({"method": "Some.event", "params": {}})
    result = RESULTS.get(command["method"], {})
    if command["method"] == where:
        if what == "die":
            print("no more wine", file=sys.stderr, flush=True)
            os._exit(7)
        if what == "abort":
            os.kill(os.getpid(), signal.SIGABRT)
        if what == "hang":
            time.sleep(1000)
        if what == "close":
            os.close(4)
            time.sleep(1000)
        if what == "crash":
            say({"method": "Inspector.targetCrashed", "params": {}})
            continue
        if what == "refuse":
            say({"id": command["id"], "error": {"code": -32000, "message": "not today"}})
            continue
        if what == "never":
            result = {"result": {"type": "boolean", "value": False}}
        elif what == "offline":
            result = {"errorText": "net::ERR_INTERNET_DISCONNECTED"}
        elif what == "empty":
            result = {}
        elif what == "text":
            result = {"data": "aGVsbG8="}
        elif what == "letters":
            result = {"data": "a"}
        elif what == "list":
            say([])
        elif what == "garbage":
            os.write(4, b"\\xff{nonsense\\0")
        elif what == "deep":
            os.write(4, b"[" * 100000 + b"\\0")
        elif what == "wrong":
            say({"id": command["id"], "result": 3})
    say({"id": command["id"], "result": result})
    if command["method"] == "Browser.close":
        sys.exit(0)
"""
STAGES = {
    "Browser.getVersion": "starting",
    "Target.createTarget": "opening the page",
    "Target.attachToTarget": "opening the page",
    "Emulation.setDeviceMetricsOverride": "opening the page",
    "Page.navigate": "opening the page",
    "Runtime.evaluate": "drawing the page",
    "Page.captureScreenshot": "taking the picture",
}
FAILURES = [
    ("Browser.getVersion", "garbage", "does not speak the DevTools protocol while starting"),
    ("Browser.getVersion", "deep", "does not speak the DevTools protocol while starting"),
    ("Browser.getVersion", "list", "does not speak the DevTools protocol while starting"),
    ("Browser.getVersion", "wrong", "does not speak the DevTools protocol while starting"),
    ("Browser.getVersion", "abort", "ended while starting with exit status 134 (SIGABRT)"),
    ("Target.createTarget", "empty", "does not speak the DevTools protocol while opening the page"),
    ("Target.attachToTarget", "refuse", "refused Target.attachToTarget while opening the page"),
    ("Page.navigate", "offline", "could not open the page: net::ERR_INTERNET_DISCONNECTED"),
    ("Runtime.evaluate", "crash", "lost its page to a crash while drawing the page"),
    ("Page.captureScreenshot", "text", "gave something else than a PNG"),
    ("Page.captureScreenshot", "letters", "gave something else than a PNG"),
]


def png() -> bytes:
    target = BytesIO()
    Image.new("RGB", (3, 2), "teal").save(target, "PNG")
    return target.getvalue()


@pytest.fixture(scope="module")
def document() -> Document:
    from cutjoint.robots import load

    return show(load("cpm"))


@pytest.fixture(autouse=True)
def place(short_folder: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Where the browsers' folders are made; nothing may be left there."""
    monkeypatch.setattr(tempfile, "tempdir", str(short_folder))
    yield short_folder
    assert list(short_folder.iterdir()) == []


@pytest.fixture
def script(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], Path]:
    """Names a shell script as the browser."""

    def use(text: str, first: str = "#!/bin/sh") -> Path:
        file = tmp_path / "fake"
        file.write_text(f"{first}\n{text}\n")
        file.chmod(0o755)
        monkeypatch.setenv(camera.VARIABLE, str(file))
        return file

    return use


@pytest.fixture
def fake(script: Callable[[str], Path], tmp_path: Path) -> Callable[..., Callable[[], list[dict[str, Any]]]]:
    """A browser with a plan; the function that comes back tells of its starts so far."""

    def use(*plan: Sequence[str]) -> Callable[[], list[dict[str, Any]]]:
        import base64

        book = tmp_path / "starts"
        code = tmp_path / "fake.py"
        code.write_text(FAKE)
        words = [sys.executable, "-I", "-S", code, book, json.dumps(plan), base64.b64encode(png()).decode()]
        script(f'exec {shlex.join(map(str, words))} "$@"')
        return lambda: [json.loads(line) for line in book.read_text().splitlines()]

    return use


def test_a_browser_that_does_well_is_started_once(document: Document, fake: Any, place: Path) -> None:
    starts = fake()
    assert photograph(document.files()) == png()
    (start,) = starts()
    assert Path(start["place"]).parent == place
    assert Path(start["profile"]).parent == Path(start["place"])


def test_one_that_always_dies_is_an_error_with_its_status_and_last_words(document: Document, fake: Any) -> None:
    starts = fake(*[("Page.navigate", "die")] * 2 * STARTS)
    with pytest.raises(BrowserError) as caught:
        photograph(document.files())
    assert len(starts()) == STARTS == caught.value.starts
    assert caught.value.status == 7
    assert caught.value.words == "no more wine"
    said = (
        f"ended while opening the page with exit status 7 (start {STARTS} of {STARTS}); its last words:\nno more wine"
    )
    assert said in str(caught.value)


@pytest.mark.parametrize(
    ("where", "what", "said"),
    [(where, "die", f"ended while {stage} with exit status 7") for where, stage in STAGES.items()] + FAILURES,
)
def test_whatever_goes_wrong_is_told_with_its_stage(
    document: Document, fake: Any, where: str, what: str, said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(camera, "STARTS", 1)
    fake((where, what))
    with pytest.raises(BrowserError) as caught:
        photograph(document.files())
    assert said in str(caught.value)
    assert caught.value.starts == 1
    assert caught.value.status == {"die": 7, "abort": 134}.get(what)


@pytest.mark.parametrize("where", [*STAGES][::2])
def test_one_that_dies_gets_a_fresh_one_with_a_fresh_profile(document: Document, fake: Any, where: str) -> None:
    starts = fake(*[(where, "die")] * (STARTS - 1))
    assert photograph(document.files()) == png()
    assert len(starts()) == STARTS == len({start["profile"] for start in starts()})
    assert not any(start["used"] for start in starts())


@pytest.mark.parametrize("first", range(0, len(FAILURES), STARTS - 1))
def test_whatever_goes_wrong_is_tried_again(document: Document, fake: Any, first: int) -> None:
    plan = [(where, what) for where, what, _ in FAILURES[first : first + STARTS - 1]]
    starts = fake(*plan)
    assert photograph(document.files()) == png()
    assert len(starts()) == len(plan) + 1


def test_last_words_are_the_last(document: Document, script: Any) -> None:
    script("for i in $(seq 1000); do echo line $i; echo; done >&2; exit 3")
    with pytest.raises(BrowserError, match="exit status 3") as caught:
        photograph(document.files())
    lines = caught.value.words.splitlines()
    assert lines == [f"line {i}" for i in range(1001 - headless.WORDS_LINES, 1001)]
    script("printf %5000s end >&2")
    with pytest.raises(BrowserError, match="exit status 0") as caught:
        photograph(document.files())
    assert len(caught.value.words) == headless.WORDS_BYTES
    assert caught.value.words.endswith(" end")


def test_a_file_that_cannot_be_run_says_so(document: Document, script: Any) -> None:
    script("", first="#!/no/such/interpreter")
    with pytest.raises(BrowserError, match=r"exit status 127 .*\n.*No such file") as caught:
        photograph(document.files())
    assert caught.value.status == keeper.NOT_STARTED


def test_without_a_browser_a_picture_says_what_to_install(document: Document, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(camera.VARIABLE, "no-such-browser")
    with pytest.raises(ViewerError, match="install Chromium"):
        photograph(document.files())


@pytest.fixture
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(headless, "GRACE", 0.1)
    monkeypatch.setattr(headless, "ENDING", 0.1)


@pytest.mark.usefixtures("impatient")
def test_one_that_hangs_at_its_start_is_ended_and_followed_by_another(
    document: Document, fake: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = headless.run

    def run(path: str, arguments: Sequence[str], seconds: float) -> Any:
        assert seconds == camera.START_SECONDS
        return real(path, arguments, 0.3 if len(started) < STARTS - 1 else seconds)

    started: list[object] = []
    monkeypatch.setattr(headless, "run", lambda *given: (run(*given), started.append(given))[0])
    starts = fake(*[("Browser.getVersion", "hang")] * (STARTS - 1))
    assert photograph(document.files()) == png()
    assert len(started) == STARTS
    assert len({start["profile"] for start in starts()}) == len(starts())


@pytest.mark.slow
@pytest.mark.usefixtures("impatient")
@pytest.mark.parametrize("text", ["trap '' TERM INT HUP PIPE; sleep 1000", "exec sleep 1000"])
def test_one_that_always_hangs_is_an_error(
    document: Document, script: Any, text: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(camera, "START_SECONDS", 0.3)
    script(text)
    with pytest.raises(BrowserError, match=rf"was still starting after [\d.]+ s.*start {STARTS} of {STARTS}") as caught:
        photograph(document.files())
    assert caught.value.status is None


@pytest.mark.usefixtures("impatient")
def test_one_that_never_stops_talking_is_an_error(
    document: Document, script: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(camera, "STARTS", 1)
    monkeypatch.setattr(devtools, "ANSWER_BYTES", 1 << 16)
    script("exec yes >&4")
    with pytest.raises(BrowserError, match=r"does not speak the DevTools protocol while starting: .*y"):
        photograph(document.files())


@pytest.mark.usefixtures("impatient")
def test_one_that_closes_its_pipe_and_lives_on_has_no_status(
    document: Document, fake: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(camera, "STARTS", 1)
    fake(("Page.navigate", "close"))
    with pytest.raises(BrowserError, match=r"closed its pipe while opening the page$") as caught:
        photograph(document.files())
    assert caught.value.status is None


@pytest.mark.slow
@pytest.mark.usefixtures("impatient")
@pytest.mark.parametrize(("what", "where"), [("hang", "Page.navigate"), ("never", "Runtime.evaluate")])
def test_all_starts_together_have_a_limit(
    document: Document, fake: Any, monkeypatch: pytest.MonkeyPatch, what: str, where: str
) -> None:
    monkeypatch.setattr(camera, "SECONDS", 1.5)
    fake(*[(where, what)] * STARTS)
    began = monotonic()
    with pytest.raises(BrowserError, match=r"was still \w+.* after [\d.]+ s") as caught:
        photograph(document.files())
    assert caught.value.starts < STARTS
    assert monotonic() - began < 1.5 + headless.GRACE + headless.TIDYING


def test_once_it_has_answered_a_browser_has_all_the_time_that_is_left(
    document: Document, fake: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    left, real = [], camera._picture

    def draw(tools: devtools.Devtools, *given: Any) -> bytes:
        left.append(tools.until - monotonic())
        return real(tools, *given)

    monkeypatch.setattr(camera, "_picture", draw)
    fake()
    assert photograph(document.files()) == png()
    assert camera.START_SECONDS < left[0] <= camera.SECONDS


@pytest.mark.parametrize("length", [0, 1, 2, 3, 60, 120])
def test_the_folder_leaves_room_for_a_sockets_path(place: Path, length: int) -> None:
    """At and on both sides of the longest place that will do, and far beyond."""
    room = keeper.LONGEST_FOLDER - len(f"/{keeper.PREFIX}abcdefgh")
    folder = place / ("x" * (room - 2 + length - len(str(place)) - 1))
    folder.mkdir()
    made = Path(keeper.make_folder(str(folder)))
    try:
        assert (made.parent == folder) == (length <= 2)
        assert len(str(made / "org.chromium.Chromium.abcdef/SingletonSocket")) <= 103
        assert made.stat().st_mode & 0o077 == 0
    finally:
        made.rmdir()
        folder.rmdir()


def test_where_no_folder_can_be_made_the_error_lists_what_was_tried(
    document: Document, script: Any, monkeypatch: pytest.MonkeyPatch, place: Path
) -> None:
    def full(*, prefix: str, dir: str) -> str:
        raise OSError(28, "No space left on device", dir)

    monkeypatch.setattr(tempfile, "mkdtemp", full)
    with pytest.raises(OSError, match=rf"(?s)no folder.*{place}.*'/tmp'.*'/var/tmp'"):
        keeper.make_folder(str(place))


def steer(script: str, numbers: Sequence[int], place: Path) -> tuple[int, bytes]:
    """Exit status and answer of a browser whose keeper got its three files under these numbers."""
    code = f"""
import os, runpy, sys
sys.argv[1:] = ["{numbers[0]}", "{numbers[1]}", "{numbers[2]}", "1", {str(place)!r}, "/bin/sh", "-c", {script!r}]
ends = [os.pipe() for _ in range(20)][-3:]
os.write(ends[1][1], b"a question\\n")
for (read, write), number, out in zip(ends, {tuple(numbers)}, (False, False, True)):
    os.dup2(write if out else read, number, inheritable=True)
    if out:
        os.close(write)
try:
    runpy.run_path({keeper.__file__!r}, run_name="__main__")
except SystemExit as end:
    os.write(1, os.read(ends[2][0], 100))
    raise
"""
    done = subprocess.run([sys.executable, "-I", "-S", "-c", code], capture_output=True, timeout=60)
    assert done.stderr == b""
    return done.returncode, done.stdout


@pytest.mark.parametrize("numbers", list(itertools.permutations((3, 4, 5))))
def test_the_browser_reads_file_3_and_writes_file_4_whatever_the_keepers_are(
    numbers: Sequence[int], place: Path
) -> None:
    script = 'read line <&3; test -d "$TMPDIR" && echo "heard $line" >&4; test -e /dev/fd/5 || exit 9'
    assert steer(script, numbers, place) == (9, b"heard a question\n")


def test_the_browser_may_die_of_a_broken_pipe(place: Path) -> None:
    """Python ignores that signal, and whoever is started by it would."""
    assert steer("kill -s PIPE $$; exit 0", (5, 6, 7), place) == (141, b"")


@pytest.mark.parametrize("by_word", [True, False], ids=["a byte", "its end"])
def test_let_off_the_leash_a_browser_has_its_grace_and_no_more(by_word: bool, place: Path) -> None:
    leash, hold = os.pipe()
    nulls = [os.open(os.devnull, os.O_RDWR) for _ in range(2)]
    words = [leash, *nulls, 0.2, place, "/bin/sh", "-c", "sleep 1000 & sleep 1000"]
    process = subprocess.Popen(
        [sys.executable, "-I", "-S", keeper.__file__, *map(str, words)],
        pass_fds=(leash, *nulls),
        stdout=subprocess.PIPE,
    )
    for end in (leash, *nulls):
        os.close(end)
    if by_word:
        os.write(hold, b".")
    else:
        os.close(hold)
    try:
        # the output ends when all that may write to it are gone, the browser's own child as well
        assert process.communicate(timeout=60)[0] == b""
        assert process.returncode == 137
    finally:
        process.kill()
        process.wait()
        if by_word:
            os.close(hold)


@pytest.mark.slow
@pytest.mark.browser
@pytest.mark.parametrize("deaths", few(range(STARTS), 1))
def test_a_real_browser_draws_after_others_have_died(
    document: Document, script: Any, tmp_path: Path, chromium: str, deaths: int
) -> None:
    book = tmp_path / "starts"
    script(f'echo >>{book}; [ $(wc -l <{book}) -gt {deaths} ] || kill -s TRAP $$; exec {chromium} "$@"')
    picture = Image.open(BytesIO(photograph(document.files(), width=320, height=200)))
    assert picture.size == (320, 200)
    assert len(set(picture.convert("RGB").get_flattened_data())) > 50
    assert len(book.read_text().splitlines()) == deaths + 1


@pytest.mark.browser
@pytest.mark.usefixtures("chromium")
@pytest.mark.slow
def test_a_picture_does_not_need_a_short_temporary_folder(
    document: Document, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Chromium aborts where the path of its socket is too long; here that of its parent is already."""
    deep = tmp_path / ("deep" * 30)
    deep.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(deep))
    monkeypatch.setenv("TMPDIR", str(deep))
    monkeypatch.setattr(camera, "STARTS", 1)
    assert Image.open(BytesIO(photograph(document.files(), width=320, height=200))).size == (320, 200)
    assert list(deep.iterdir()) == []
