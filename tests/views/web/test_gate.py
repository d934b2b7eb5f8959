"""Who gets the page: whoever has the link, from a browser that means this server."""

from __future__ import annotations

import re
from importlib.resources import files
from typing import Any

import pytest
from websockets.exceptions import InvalidStatus

from bt_mission.views.web.server import WebServer
from tests.support.web_pages import fetch, live
from tests.support.web_scenes import served


async def websocket_is_refused(server: WebServer, **options: Any) -> None:
    """Assert that the server gives no WebSocket."""
    with pytest.raises(InvalidStatus) as error:
        async with live(server, **options):
            pass
    assert error.value.response.status_code == 403


@served
async def test_the_page_and_its_files_come_with_the_token_in_their_path(server: WebServer) -> None:
    """Each with a policy that allows nothing from elsewhere and no script but files."""
    for name, kind in (("", "text/html"), ("app.js", "text/javascript"), ("style.css", "text/css")):
        status, headers, body = await fetch(server, f"/{server.token}/{name}")
        assert (status, headers["content-type"]) == (200, f"{kind}; charset=utf-8")
        policy = headers["content-security-policy"]
        assert policy.startswith("default-src 'none'; script-src 'self'; style-src 'self';")
        assert "unsafe" not in policy
        assert headers["referrer-policy"] == "no-referrer"
        assert headers["cache-control"] == "no-store"
        assert "<script>" not in body
        assert " style=" not in body
        assert " onclick" not in body


@served
async def test_a_link_without_its_last_slash_leads_to_the_page(server: WebServer) -> None:
    """The files of the page have relative names."""
    status, headers, _ = await fetch(server, f"/{server.token}")
    assert (status, headers["location"]) == (307, server.link)


@pytest.mark.parametrize("path", ["/", "/app.js", "/wrong/", "/wrong/app.js", "//", "/%C3%A9/"])
@served
async def test_without_the_token_there_is_nothing(server: WebServer, path: str) -> None:
    """But a word on what to do."""
    status, _, body = await fetch(server, path)
    assert status == 403
    assert "open the link that the command printed" in body


@pytest.mark.parametrize(
    "name", ["../server.py", "..%2fserver.py", "%2e%2e/server.py", "x.js", "app.py", ".."]
)
@served
async def test_no_other_file_is_served(server: WebServer, name: str) -> None:
    """Whatever is tried in its name."""
    status, _, body = await fetch(server, f"/{server.token}/{name}")
    assert (status, "import" in body) == (404, False)


@pytest.mark.parametrize(
    "host", ["evil.example", "evil.example:80", "10.0.0.1", "", "a b", "127.0.0.1;x"]
)
@served
async def test_a_name_that_was_made_to_point_here_is_refused(server: WebServer, host: str) -> None:
    """DNS rebinding: the browser names somebody else's server, and reaches this one."""
    status, _, body = await fetch(server, f"/{server.token}/", Host=host)
    assert status in (400, 403)
    assert "<html" not in body


@pytest.mark.parametrize("host", ["localhost:9000", "127.0.0.1:1", "[::1]:8080"])
@served
async def test_a_tunnel_may_have_another_port(server: WebServer, host: str) -> None:
    """Addresses of this machine cannot be made to point elsewhere."""
    status, headers, _ = await fetch(server, f"/{server.token}/", Host=host)
    assert status == 200
    assert f"ws://{host};" in headers["content-security-policy"]


@pytest.mark.parametrize("origin", ["http://evil.example", "null", None, "https://127.0.0.1"])
@served
async def test_pages_of_others_get_no_websocket(server: WebServer, origin: Any) -> None:
    """Nor does what says of no page that it is one."""
    await websocket_is_refused(server, origin=origin)


@served
async def test_a_wrong_token_gets_no_websocket(server: WebServer) -> None:
    """As of a page that was left open over a restart."""
    server.link = server.link.replace(server.token, "A" * len(server.token))
    await websocket_is_refused(server)


def test_every_key_of_the_page_is_listed_on_it():
    """In the lists that it shows, and at the button that does the same."""
    page = files("bt_mission.views.web") / "page"
    scripts, markup = ((page / name).read_text("utf-8") for name in ("app.js", "index.html"))
    listed = "".join(re.findall(r"<kbd>(.*?)</kbd>", markup))
    keys = {
        name: key.strip('"')
        for line in re.findall(r"_KEYS = \{ (.*) \};", scripts)
        for key, name in re.findall(r'("?[^\s,"]+"?): "([\w-]+)"', line)
    }
    assert len(keys) == 13
    for name, key in keys.items():
        assert key in listed, name
        assert f'id="{name}" aria-keyshortcuts="{key}"' in markup
