"""What the server answers a request: a fixed set of files, and only to those who call it by one of its names."""

from __future__ import annotations

from collections.abc import Mapping

from tornado.web import HTTPError, RequestHandler

from cutjoint.viewer.server.addresses import Address
from cutjoint.viewer.server.assets import File


class Guarded(RequestHandler):  # type: ignore[misc]
    """Refuses a foreign Host, and sends the headers that keep the page to itself."""

    address: Address

    def set_default_headers(self) -> None:
        self.clear_header("Server")
        self.set_header("X-Content-Type-Options", "nosniff")
        self.set_header("Referrer-Policy", "no-referrer")
        self.set_header("Cross-Origin-Resource-Policy", "same-origin")
        self.set_header("Cache-Control", "no-store")

    def prepare(self) -> None:
        if not self.address.allows(self.request.host):
            raise HTTPError(403)

    def write_error(self, status_code: int, **_: object) -> None:
        self.set_header("Content-Type", "text/plain")
        self.finish(f"{status_code}\n")


class Page(Guarded):
    """A fixed file from memory."""

    def initialize(self, address: Address, files: Mapping[str, File]) -> None:
        self.address, self.files = address, files

    def get(self) -> None:
        file = self.files.get(self.request.path)
        if file is None:
            raise HTTPError(404)
        self.set_header("Content-Type", file.kind)
        self.set_header("Content-Security-Policy", file.policy.replace("{host}", self.request.host))
        self.write(file.body)

    head = get
