"""The requests of the editor: files, drafts, conflicts, pages that follow, refusals."""

from __future__ import annotations

import asyncio
import json
import os
import select
import subprocess
import sys
from collections.abc import Awaitable, Callable
from http.client import HTTPConnection
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest

from bt_mission.views.web.edit.server import EditServer
from bt_mission.views.web.edit.workspace import Workspace
from bt_mission.views.web.server import WebOptions
from tests.support.web_pages import fetch, play_with
from tests.support.web_scenes import played

TEXT = "mission: m  # \U0001f600\ntree:\n  sequence:\n    - wait: 1\n    - turn: {angel: 90}\n"


class Client:
    """Asks as the page does."""

    def __init__(self, server: EditServer) -> None:
        self.server = server

    async def ask(self, request: str, /, **facts: Any) -> Any:
        """Return the answer to a request."""
        return json.loads((await self.post(f"api/{request}", json.dumps(facts)))[1])

    async def post(self, path: str, body: str, **headers: str) -> tuple[int, str]:
        """Return status and body of an answer."""
        address = urlsplit(self.server.link)
        lines = {"Host": address.netloc, "Connection": "close", **headers}
        reader, writer = await asyncio.open_connection("127.0.0.1", address.port)
        head = "".join(f"{name}: {value}\r\n" for name, value in lines.items())
        length = f"Content-Length: {len(body.encode())}\r\n"
        writer.write(f"POST {address.path}{path} HTTP/1.1\r\n{head}{length}\r\n{body}".encode())
        answer = (await reader.read()).decode()
        writer.close()
        first, _, rest = answer.partition("\r\n\r\n")
        return int(first.split()[1]), rest


@pytest.fixture
def play(tmp_path: Path) -> Callable[..., None]:
    """Play a scene at the server of a folder with one mission."""
    (tmp_path / "m.yaml").write_text(TEXT)

    def play(scene: Callable[[Client], Awaitable[None]], *, is_read_only: bool = False) -> None:
        options = WebOptions(port=0, is_read_only=is_read_only)
        play_with(EditServer(Workspace(tmp_path), options), lambda server: scene(Client(server)))

    return play


def names_in(folder: Path) -> list[str]:
    """The names of the files of a folder."""
    return sorted(path.name for path in folder.iterdir())


@played("play")
async def test_a_text_is_checked_drawn_and_kept_beside_its_file(
    client: Client, tmp_path: Path
) -> None:
    """Offsets are those of JavaScript; a save removes the text beside the file."""
    answer = await client.ask("check", name="m.yaml", text=TEXT)
    (mark,) = (mark for mark in answer["marks"] if mark["severity"] == "error")
    units = TEXT.encode("utf-16-le")
    assert units[2 * mark["from"] : 2 * mark["to"]].decode("utf-16-le") == "angel"
    assert mark["code"] == "BT-502"
    kinds = [box["kind"] for box in answer["boxes"]]
    assert kinds == ["mission", "sequence", "wait", "turn"]
    assert not (tmp_path / ".m.yaml.unsaved").exists()
    better = TEXT.replace("angel", "angle")
    await client.ask("check", name="m.yaml", text=better)
    opened = await client.ask("open", name="m.yaml")
    assert (opened["text"], opened["draft"]) == (TEXT, better)
    assert await client.ask("save", name="m.yaml", text=better, base=TEXT) == {"text": better}
    assert (tmp_path / "m.yaml").read_text() == better
    assert (await client.ask("open", name="m.yaml"))["draft"] is None


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("scenario: s\nmission: square\nfaults: 3\n", "BT-301"),
        ("fleet: f\nrobots: {}\n", "BT-707"),
        ("world: w\nsize: [4]\nwalls: []\n", "BT-202"),
        ("requirements: {safe: always}\n", "BT-401"),
        ("seeds: [1, 2\n", "BT-105"),
    ],
)
@played("play")
async def test_files_of_other_kinds_are_checked_as_text(
    client: Client, tmp_path: Path, text: str, code: str
) -> None:
    """They have no tree."""
    (tmp_path / "other.yaml").write_text(text)
    answer = await client.ask("check", name="other.yaml", text=text)
    assert [mark["code"] for mark in answer["marks"]][:1] == [code]
    assert not answer["boxes"]


@played("play")
async def test_a_file_that_changed_meanwhile_is_not_overwritten(
    client: Client, tmp_path: Path
) -> None:
    """The answer has the text on disk; a forced save replaces it. Line ends stay."""
    (tmp_path / "m.yaml").write_bytes(b"mission: other\r\n")
    answer = await client.ask("save", name="m.yaml", text="mission: n\n", base=TEXT)
    assert (answer["code"], answer["theirs"]) == ("BT-1303", "mission: other\n")
    state = await client.ask("state", name="m.yaml", page="a", base=TEXT, text="mission: n\n")
    assert state == {"leads": True, "is_changed": True, "exists": True}
    await client.ask("save", name="m.yaml", text="mission: n\n", base=TEXT, is_forced=True)
    assert (tmp_path / "m.yaml").read_bytes() == b"mission: n\r\n"
    (tmp_path / "m.yaml").unlink()
    gone = await client.ask("save", name="m.yaml", text="x: 1\n", base="mission: n\n")
    assert gone["theirs"] is None


@played("play")
async def test_files_are_created_renamed_and_deleted(client: Client, tmp_path: Path) -> None:
    """Unsaved text goes with a renamed file; a file that changed meanwhile is not deleted."""
    (tmp_path / "other.yaml").symlink_to("/etc/hostname")
    (tmp_path / "out").symlink_to("/tmp")  # noqa: S108 - nothing is written there
    assert await client.ask("create", name="new.yaml") == {"name": "new.yaml"}
    assert (tmp_path / "new.yaml").read_text() == ""
    for name in ("new.yaml", "other.yaml", "out/x.yaml", "../x.yaml", "none/x.yaml", "x.txt"):
        assert "error" in await client.ask("create", name=name), name
        assert "error" in await client.ask("rename", name="m.yaml", other=name), name
    await client.ask("check", name="m.yaml", text="mission: draft\n")
    assert (await client.ask("rename", name="m.yaml", other="n.yaml"))["name"] == "n.yaml"
    opened = await client.ask("open", name="n.yaml")
    assert (opened["text"], opened["draft"]) == (TEXT, "mission: draft\n")
    answer = await client.ask("delete", name="n.yaml", base="mission: older\n")
    assert (answer["code"], answer["theirs"]) == ("BT-1303", TEXT)
    assert await client.ask("delete", name="n.yaml", base=TEXT) == {}
    assert "error" in await client.ask("delete", name="n.yaml", base=TEXT)
    assert names_in(tmp_path) == ["new.yaml", "other.yaml", "out"]


@played("play")
async def test_versions_of_a_text_are_shown_side_by_side(client: Client) -> None:
    """Each hunk has the lines before, on disk and in the page."""
    answer = await client.ask("merge", base="a\nb\n", theirs="x\nb\n", mine="a\nb\nc\n")
    assert answer["hunks"] == [
        {"base": "a\n", "theirs": "x\n", "mine": "a\n", "choice": "theirs"},
        {"base": "b\n", "theirs": "b\n", "mine": "b\n", "choice": "theirs"},
        {"base": "", "theirs": "", "mine": "c\n", "choice": "mine"},
    ]


@played("play")
async def test_a_second_page_follows_until_it_takes_over(client: Client) -> None:
    """It receives the text of the first one."""
    assert (await client.ask("state", name="m.yaml", page="a", text="a: 1\n"))["leads"]
    assert await client.ask("state", name="m.yaml", page="b") == {"leads": False, "text": "a: 1\n"}
    assert (await client.ask("state", name="m.yaml", page="b", take=True))["leads"]
    assert not (await client.ask("state", name="m.yaml", page="a"))["leads"]


@pytest.mark.parametrize(
    "name", ["../m.yaml", "/etc/x.yaml", ".m.yaml", "m.txt", "a\0.yaml", "l.yaml"]
)
@played("play")
async def test_only_yaml_files_of_the_folder_are_read(
    client: Client, tmp_path: Path, name: str
) -> None:
    """Links that lead out of it are refused, too."""
    (tmp_path / "l.yaml").symlink_to("/etc/hostname")
    listed = (await client.ask("files"))["files"]
    assert [row["name"] for row in listed] == ["m.yaml"]
    assert (await client.ask("open", name=name))["code"] == "BT-1302"
    assert (await client.ask("save", name=name, text="", base=""))["code"] == "BT-1302"


@played("play", is_read_only=True)
async def test_a_read_only_page_writes_and_runs_nothing(client: Client, tmp_path: Path) -> None:
    """It checks, and keeps no text beside the file."""
    await client.ask("check", name="m.yaml", text="mission: x\n")
    for request in ("save", "run", "prove", "create", "rename", "delete"):
        answer = await client.ask(
            request, name="m.yaml", text="mission: x\n", base=TEXT, speed="1", other="o.yaml"
        )
        assert "read-only" in answer["error"]
    assert names_in(tmp_path) == ["m.yaml"]


@played("play")
async def test_the_page_is_guarded_as_the_others_are(client: Client) -> None:
    """Other origins, large bodies and nonsense are refused; only its own pages may frame it."""
    status, _ = await client.post("api/files", "{}", Origin="http://example.org")
    assert status == 403
    status, headers, _ = await fetch(client.server, urlsplit(client.server.link).path)
    assert status == 200
    assert "frame-ancestors 'self'" in headers["content-security-policy"]
    for body in ("{", "[]", '{"do": 1}', '{"do": "fly"}', '{"do": "move", "path": [1.5]}'):
        assert "error" in json.loads((await client.post("api/act", body))[1])
    assert "exceeds" in (await client.ask("files", text="x" * 4_000_001))["error"]


@pytest.mark.process
def test_a_run_ends_with_an_editor_that_is_killed(tmp_path: Path) -> None:
    """The next editor removes the text of the run."""
    text = TEXT.replace("wait: 1", "wait: 600").replace("angel", "angle")
    (tmp_path / "m.yaml").write_text(text)
    command = [sys.executable, "-m", "bt_mission", "edit", str(tmp_path), "--port=0"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as editor:
        assert editor.stderr is not None
        line = next(line for line in editor.stderr if "in a browser: " in line)
        address = urlsplit(line.split()[-1])

        def ask(request: str, **facts: Any) -> Any:
            connection = HTTPConnection(address.netloc)
            connection.request("POST", f"{address.path}api/{request}", json.dumps(facts))
            answer = json.loads(connection.getresponse().read())
            connection.close()
            return answer

        ask("run", name="m.yaml", text=text, speed="1")
        while ask("ran")["state"] == "starting":
            continue  # what follows must not end by a broken pipe
        listed = Path(f"/proc/{editor.pid}/task/{editor.pid}/children")
        while len(children := listed.read_text().split()) < 2:
            continue  # the run, and the process that gets ready for the next one
        ends = [os.pidfd_open(int(child)) for child in children]
        assert select.select(ends, [], [], 0.0)[0] == []
        editor.kill()
    for end in ends:
        assert select.select([end], [], [], 30.0)[0] == [end]
        os.close(end)
    trial = tmp_path / ".m.yaml.run.yaml"
    assert trial.read_text() == text
    EditServer(Workspace(tmp_path), WebOptions(port=0)).close()
    assert not trial.exists()


@played("play")
async def test_the_unsaved_text_of_a_deleted_file_is_offered(
    client: Client, tmp_path: Path
) -> None:
    """The file is listed as long as its text is kept."""
    await client.ask("check", name="m.yaml", text="mission: mine\n")
    (tmp_path / "m.yaml").unlink()
    files = (await client.ask("files"))["files"]
    assert files == [{"name": "m.yaml", "kind": "mission", "is_unsaved": True}]
    opened = await client.ask("open", name="m.yaml")
    assert (opened["text"], opened["draft"]) == ("", "mission: mine\n")
