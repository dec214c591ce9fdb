"""The files of the viewer's pages: meshcat's own bundle from its package, and ours beside this module."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from importlib import resources

from cutjoint.errors import ViewerError
from cutjoint.extras import missing
from cutjoint.reprs import line

LIVE_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; "
    "connect-src 'self' ws://{host}; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
"""No `unsafe-eval`: text that reaches the page is never run.  Styles must be allowed because meshcat adds its own."""


@dataclass(frozen=True)
class File:
    """What one path answers; `policy` is its content security policy, in which `{host}` becomes this server."""

    body: bytes
    kind: str
    policy: str = "default-src 'none'"

    __repr__ = line("kind", "policy")


@cache
def page(name: str) -> str:
    """A file of our own pages."""
    return (resources.files("cutjoint.viewer") / "page" / name).read_text(encoding="utf-8")


@cache
def bundle() -> str:
    """meshcat's viewer, one script.

    Raises:
        MissingPackageError: meshcat is not installed.
        ViewerError: its bundle is not where 0.3.2 has it.
    """
    try:
        return (resources.files("meshcat") / "viewer" / "dist" / "main.min.js").read_text(encoding="utf-8")
    except ModuleNotFoundError as error:
        raise missing("meshcat", "the viewer") from error
    except OSError as error:
        raise ViewerError(f"meshcat's viewer is not where version 0.3.2 has it: {error}") from error


def live_files() -> dict[str, File]:
    """What the live viewer's server answers."""
    script, style = "text/javascript; charset=utf-8", "text/css; charset=utf-8"
    return {
        "/": File(page("live.html").encode(), "text/html; charset=utf-8", LIVE_POLICY),
        "/meshcat.js": File(bundle().encode(), script),
        "/look.js": File(page("look.js").encode(), script),
        "/stage.js": File(page("stage.js").encode(), script),
        "/drag.js": File(page("drag.js").encode(), script),
        "/live.js": File(page("live.js").encode(), script),
        "/page.css": File(page("page.css").encode(), style),
        "/favicon.ico": File(b"", "image/x-icon"),
    }
