from __future__ import annotations

import asyncio
import http.client
import json
import socket
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest
import tornado.httpclient
import tornado.websocket

from cutjoint.errors import ViewerError
from cutjoint.viewer.picture.scene import Scene
from cutjoint.viewer.server import tabs as room
from cutjoint.viewer.server.addresses import PORTS_TRIED
from cutjoint.viewer.server.assets import File
from cutjoint.viewer.server.bridge import Bridge

SECONDS = 60.0
"""For an answer, on a machine that has much else to do."""
PAGE = {"/": File(b"hello", "text/html", "connect-src ws://{host}")}


class Heard:
    def __init__(self) -> None:
        self.messages: list[dict[str, Any]] = []

    def __call__(self, tab: int, message: dict[str, Any]) -> bool:
        self.messages.append(message)
        return "sense" in message


@pytest.fixture
def heard() -> Heard:
    return Heard()


@pytest.fixture
def server(heard: Heard) -> Iterator[Bridge]:
    scene = Scene()
    scene.set_transform("a", np.eye(4))
    with Bridge(PAGE, scene, handler=heard, greeting=lambda tab: [{"tab": tab}], port=0) as bridge:
        yield bridge


def get(bridge: Bridge, path: str = "/", method: str = "GET", **headers: str) -> tuple[int, bytes, dict[str, str]]:
    connection = http.client.HTTPConnection("127.0.0.1", bridge.port, timeout=SECONDS)
    connection.request(method, path, headers=headers)
    answer = connection.getresponse()
    found = answer.status, answer.read(), {k.lower(): v for k, v in answer.getheaders()}
    connection.close()
    return found


async def open_socket(bridge: Bridge, **headers: str) -> Any:
    headers.setdefault("Origin", f"http://127.0.0.1:{bridge.port}")
    request = tornado.httpclient.HTTPRequest(
        f"ws://127.0.0.1:{bridge.port}/scene", headers={k: v for k, v in headers.items() if v}, request_timeout=SECONDS
    )
    return await tornado.websocket.websocket_connect(request)


def talk(action: Callable[[], Any]) -> Any:
    """In a thread of its own, because playwright, once in use, keeps a loop running in this one."""
    with ThreadPoolExecutor(1) as thread:
        return thread.submit(lambda: asyncio.run(asyncio.wait_for(action(), SECONDS))).result()


def eventually(check: Callable[[], bool], seconds: float = SECONDS) -> bool:
    until = time.monotonic() + seconds
    while not check():
        if time.monotonic() > until:
            return False
        time.sleep(0.01)
    return True


def test_it_serves_its_page_with_a_policy_that_names_it(server: Bridge) -> None:
    status, body, headers = get(server)
    assert (status, body) == (200, b"hello")
    assert headers["content-security-policy"] == f"connect-src ws://127.0.0.1:{server.port}"
    assert headers["x-content-type-options"] == "nosniff"
    assert "server" not in headers


@pytest.mark.parametrize(
    "host", ["evil.example", "evil.example:{port}", "127.0.0.1", "127.0.0.1:1", "127.0.0.2:{port}", ""]
)
def test_a_forged_host_gets_403(server: Bridge, host: str) -> None:
    assert get(server, Host=host.format(port=server.port))[0] in (400, 403)
    assert get(server, "/nothing", Host=host.format(port=server.port))[0] in (400, 403)


def test_localhost_is_the_same_machine(server: Bridge) -> None:
    assert get(server, Host=f"localhost:{server.port}")[0] == 200


@pytest.mark.parametrize("path", ["/../../etc/passwd", "/%2e%2e/etc/passwd", "/static/", "//", "/scene/../x"])
def test_only_the_known_paths_answer(server: Bridge, path: str) -> None:
    assert get(server, path)[0] == 404


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "OPTIONS"])
def test_nothing_can_be_written(server: Bridge, method: str) -> None:
    assert get(server, method=method)[0] == 405


@pytest.mark.parametrize(
    "origin", ["http://evil.example", "null", "", "https://127.0.0.1:{port}", "http://127.0.0.1:1"]
)
def test_a_foreign_page_cannot_open_the_socket(server: Bridge, origin: str) -> None:
    with pytest.raises(tornado.httpclient.HTTPClientError, match="403"):
        talk(lambda: open_socket(server, Origin=origin.format(port=server.port)))
    assert server.tabs == 0


def test_a_forged_host_cannot_open_the_socket_even_with_its_own_origin(server: Bridge) -> None:
    with pytest.raises(tornado.httpclient.HTTPClientError, match="403"):
        talk(lambda: open_socket(server, Host="evil.example:80", Origin="http://evil.example:80"))


def test_a_tab_gets_the_scene_then_the_greeting_then_every_change(server: Bridge) -> None:
    async def tab() -> list[Any]:
        one = await open_socket(server)
        found = [await one.read_message(), await one.read_message()]
        assert server._scene is not None
        server._scene.set_transform("b", np.eye(4))
        server.broadcast({"news": 1})
        return [*found, await one.read_message(), await one.read_message()]

    scene, greeting, change, news = talk(tab)
    assert b"set_transform" in scene
    assert int.from_bytes(scene[:4], "little") == len(scene) - 4
    assert json.loads(greeting) == {"tab": 1}
    assert b"/b" in change
    assert json.loads(news) == {"news": 1}


GARBAGE = ["", "x", "[", "[" * 1500, "null", "[]", '{"nonsense": 1}', '{"sense": NaN', b"\x00\x01", b"", "\ud7ff" * 300]


def test_garbage_stops_neither_the_server_nor_other_tabs(server: Bridge, heard: Heard) -> None:
    async def noise() -> tuple[int, int | None]:
        good = await open_socket(server)
        await good.read_message()
        await good.read_message()
        bad = await open_socket(server)
        for i in range(3 * room.GARBAGE_ALLOWED):
            piece = GARBAGE[i % len(GARBAGE)]
            try:
                await bad.write_message(piece, binary=isinstance(piece, bytes))
            except tornado.websocket.WebSocketClosedError:
                break
        while await bad.read_message() is not None:
            pass
        await good.write_message('{"sense": 1}')
        server.broadcast({"still": "here"})
        assert json.loads(await good.read_message()) == {"still": "here"}
        while {"sense": 1} not in heard.messages:
            await asyncio.sleep(0.01)
        return bad.close_code, good.close_code

    assert talk(noise) == (1008, None)
    assert get(server)[0] == 200


def test_a_message_that_is_too_long_ends_that_tab_only(server: Bridge, heard: Heard) -> None:
    async def long() -> int | None:
        tab = await open_socket(server)
        await tab.write_message("x" * (room.MESSAGE_BYTES + 1))
        while await tab.read_message() is not None:
            pass
        return tab.close_code

    assert talk(long) == 1009
    assert not heard.messages
    assert get(server)[0] == 200


def test_a_flood_reaches_the_handler_at_a_bounded_rate(server: Bridge, heard: Heard) -> None:
    async def flood() -> float:
        tab = await open_socket(server)
        start = time.monotonic()
        for _ in range(int(20 * room.MESSAGES_PER_SECOND)):
            try:
                await tab.write_message('{"sense": 1}')
            except tornado.websocket.WebSocketClosedError:
                break
        while await tab.read_message() is not None:
            pass
        return time.monotonic() - start

    seconds = talk(flood)
    assert len(heard.messages) <= room.MESSAGES_PER_SECOND * (1 + seconds) + 1


def test_raw_bytes_on_the_port_do_not_stop_it(server: Bridge) -> None:
    for noise in (b"\x00" * 4096, b"GET / HTTP/1.1\r\n" + b"a: b\r\n" * 5000, b"\x16\x03\x01\x02\x00", b"\r\n\r\n"):
        with socket.create_connection(("127.0.0.1", server.port), timeout=SECONDS) as raw:
            raw.sendall(noise)
    assert get(server)[0] == 200


def test_too_many_tabs_are_sent_away(server: Bridge) -> None:
    async def crowd() -> int | None:
        tabs = [await open_socket(server) for _ in range(room.TABS)]
        for tab in tabs:
            await tab.read_message()
        last = await open_socket(server)
        assert await last.read_message() is None
        assert len(tabs) == server.tabs
        for tab in tabs:
            tab.close()
        return last.close_code

    assert talk(crowd) == 1013
    assert eventually(lambda: server.tabs == 0)


def other_addresses() -> list[str]:
    """Addresses of this machine besides 127.0.0.1."""
    found = {"127.0.0.2"}
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(("192.0.2.1", 9))  # sends nothing: it only asks which address would be used
            found.add(probe.getsockname()[0])
        except OSError:
            pass
    return sorted(found - {"127.0.0.1"})


def answers(address: str, port: int) -> bool:
    try:
        with socket.create_connection((address, port), timeout=2):
            return True
    except OSError:
        return False


def test_a_second_address_of_the_machine_gets_no_answer(server: Bridge) -> None:
    assert answers("127.0.0.1", server.port)
    assert not any(answers(address, server.port) for address in other_addresses())
    assert not server.open_to_others


def test_opened_on_purpose_it_still_refuses_foreign_names() -> None:
    with Bridge(PAGE, host="0.0.0.0", port=0) as bridge:
        assert bridge.open_to_others
        assert any(answers(address, bridge.port) for address in other_addresses())
        assert get(bridge, Host=f"192.0.2.7:{bridge.port}")[0] == 200
        assert get(bridge, Host=f"evil.example:{bridge.port}")[0] == 403


def test_a_taken_port_moves_on_to_the_next_free_one(server: Bridge) -> None:
    with Bridge(PAGE, port=server.port) as second:
        assert server.port < second.port < server.port + PORTS_TRIED
        assert get(second)[1] == b"hello"
        assert str(second.port) in second.url


def test_an_address_that_is_not_ours_is_an_error() -> None:
    with pytest.raises(ViewerError, match="cannot listen on"):
        Bridge(PAGE, host="192.0.2.1", port=0)


def test_stopping_closes_the_port_and_the_thread_and_may_be_repeated(server: Bridge) -> None:
    server.stop()
    server.stop()
    assert not answers("127.0.0.1", server.port)
    server.broadcast({"to": "nobody"})
    server.wait()


def test_waiting_for_a_browser_has_an_end(server: Bridge) -> None:
    with pytest.raises(ViewerError, match="no browser opened"):
        server.wait_for_tab(0.05)
    talk(lambda: open_socket(server))
    server.wait_for_tab(SECONDS)
