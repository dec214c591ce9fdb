"""Keeps one headless browser: starts it, ends it with all its processes, and removes its folder.

Run by its file name as a process in a session of its own, because only somebody else can tidy up after a program that
was killed.  It holds the reading end of a pipe, the leash.  When the program lets go of the other end, by a byte or by
ceasing to exist, the browser gets a moment to end by itself and is killed after that.  Its exit status is the
browser's, 128 and the number of the signal if one ended it, and 127 if it does not start.

Everything that the browser writes goes into the folder: profile, crash reports, temporary files, the socket with which
it guards its profile.  That socket is why the folder is not always in TMPDIR: Chromium makes it in its temporary
folder and aborts (`Socket path too long`) where its path is longer than the system allows for a socket.

Nothing of cutjoint is imported: it has to be there before the browser, in a few hundredths of a second.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import select
import shutil
import signal
import sys
import tempfile
import time
from collections.abc import Sequence

NOT_STARTED = 127
PREFIX = "cutjoint-"
LONGEST_FOLDER = 53
"""Bytes of the folder's path: a socket's path has at most 103 (macOS; 107 on Linux), and Chromium appends 45, such as
`/org.chromium.Chromium.abcdef/SingletonSocket`; five to spare."""
_PAUSE = 0.02
_REMOVING = 2.0


def make_folder(place: str) -> str:
    """A new folder in `place`, or in /tmp or /var/tmp where its path would be too long there.

    Raises:
        OSError: there is no room in any of them.
    """
    tried = []
    for parent in (place, "/tmp", "/var/tmp"):
        if len(os.fsencode(parent)) + len(f"/{PREFIX}abcdefgh") > LONGEST_FOLDER:
            tried.append(f"{parent} is too long a path")
            continue
        try:
            return tempfile.mkdtemp(prefix=PREFIX, dir=parent)
        except OSError as error:
            tried.append(str(error))
    raise OSError("no folder for the browser's profile: " + "; ".join(tried))


def start(path: str, arguments: Sequence[str], folder: str, commands: int, answers: int) -> int:
    """The process of a browser that lives in `folder`, reads commands from file 3 and answers on file 4."""
    own = {"TMPDIR": folder, "BREAKPAD_DUMP_LOCATION": os.path.join(folder, "crashes")}
    # out of the way of 3 and 4, which each of them may be, and no third copy for the browser
    ends = [fcntl.fcntl(end, fcntl.F_DUPFD_CLOEXEC, 10) for end in (commands, answers)]
    os.close(commands)
    os.close(answers)
    try:
        return os.posix_spawn(
            path,
            [path, *arguments, f"--user-data-dir={os.path.join(folder, 'profile')}"],
            {**os.environ, **own},
            file_actions=[(os.POSIX_SPAWN_DUP2, ends[0], 3), (os.POSIX_SPAWN_DUP2, ends[1], 4)],
            setpgroup=0,
            setsigdef=[signal.SIGPIPE],
        )
    finally:
        for end in ends:
            os.close(end)


def wait(process: int, leash: int, grace: float) -> int:
    """The exit status of the browser, which has `grace` [s] from the moment that the leash is let go."""
    held = select.poll()
    held.register(leash, select.POLLIN)
    until = None
    while True:
        ended, status = os.waitpid(process, os.WNOHANG)
        if ended:
            code = os.waitstatus_to_exitcode(status)
            return code if code >= 0 else 128 - code
        if until is not None:
            time.sleep(_PAUSE)
            if time.monotonic() > until:
                kill(process)
        elif held.poll(1000 * _PAUSE):
            until = time.monotonic() + grace


def kill(group: int) -> None:
    """End what is left of the browser's processes."""
    with contextlib.suppress(ProcessLookupError, PermissionError):  # macOS refuses a group that is dead already
        os.killpg(group, signal.SIGKILL)


def remove(folder: str) -> None:
    """Remove `folder`; processes that are dying may still write into it for a moment."""
    until = time.monotonic() + _REMOVING
    shutil.rmtree(folder, ignore_errors=True)
    while os.path.lexists(folder) and time.monotonic() < until:
        time.sleep(_PAUSE)
        shutil.rmtree(folder, ignore_errors=True)


def main(leash: str, commands: str, answers: str, grace: str, place: str, path: str, *arguments: str) -> int:
    """Keep the browser `path`: three open files, a time [s] and the folder for its folder, as command-line words."""
    os.set_inheritable(int(leash), False)
    folder = None
    try:
        folder = make_folder(place)
        process = start(path, arguments, folder, int(commands), int(answers))
        try:
            return wait(process, int(leash), float(grace))
        finally:
            kill(process)
    except OSError as error:
        print(error, file=sys.stderr)
        return NOT_STARTED
    finally:
        if folder is not None:
            remove(folder)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
