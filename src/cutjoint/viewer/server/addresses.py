"""Where the viewer listens: addresses, ports and the names by which it may be called."""

from __future__ import annotations

import ipaddress
import socket

from tornado.netutil import bind_sockets

from cutjoint.errors import ViewerError

LOOPBACK = "127.0.0.1"
PORT = 7000
PORTS_TRIED = 100


def bind(host: str, port: int) -> tuple[list[socket.socket], int]:
    """Sockets that listen on `host`, at `port` or the next free one, and that port.

    Raises:
        ViewerError: no port is free, or the address is not one of this machine.
    """
    last = ""
    for candidate in range(port, port + (PORTS_TRIED if port else 1)):
        if candidate > 65535:
            break
        try:
            sockets = bind_sockets(candidate, host)
        except (OSError, UnicodeError) as error:
            last = str(error)
            continue
        return sockets, int(sockets[0].getsockname()[1])
    raise ViewerError(f"the viewer cannot listen on {host or 'all addresses'}, ports {port} and up: {last}")


class Address:
    """Where a server listens, and who may call it by which name."""

    def __init__(self, host: str, port: int) -> None:
        self._port = port
        self.open_to_others = not is_loopback(host)
        self.url = url_of(host, port)
        self._names = own_names(host)

    def allows(self, host: str) -> bool:
        """Whether a Host header names this server (a foreign name means a page that rebound its DNS name to us)."""
        name, _, port = host.rpartition(":")
        if not name or not port.isascii() or not port.isdigit() or int(port) != self._port:
            return False
        return name.lower() in self._names or (self.open_to_others and is_address(name))


def own_names(host: str) -> frozenset[str]:
    """Names in a Host header that mean this server, listening on `host`."""
    own = {"127.0.0.1", "localhost", "[::1]"}
    if host not in ("", LOOPBACK, "localhost", "::1"):
        own |= {host.lower(), f"[{host}]", socket.gethostname().lower(), socket.getfqdn().lower()}
    return frozenset(own)


def is_loopback(host: str) -> bool:
    """Whether only this machine can reach `host`."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def url_of(host: str, port: int) -> str:
    """What to type into a browser on this machine."""
    name = {"": LOOPBACK, "0.0.0.0": LOOPBACK, "::": "::1"}.get(host, host)
    return f"http://[{name}]:{port}/" if ":" in name else f"http://{name}:{port}/"


def is_address(name: str) -> bool:
    """Whether a host is given by number, so that no foreign name server stands behind it."""
    try:
        ipaddress.ip_address(name.strip("[]"))
    except ValueError:
        return False
    return True
