"""The requests of the editor: files, drafts, conflicts, pages that follow, refusals."""

from __future__ import annotations

import asyncio
import json
import os
import select
import subprocess
import sys
from collections.abc import Awaitable, Callable, Sequence
from http.client import HTTPConnection
from pathlib import Path
from typing import Any, ClassVar
from urllib.parse import urlsplit

import pytest

from bt_mission.commands.edit.web.server import EditServer
from bt_mission.commands.edit.web.workspace import Workspace
from bt_mission.views.web.server import WebOptions
from tests.support.full_disk import full_after
from tests.support.web_pages import fetch, play_with
from tests.support.web_scenes import played

TEXT = "mission: m  # \U0001f600\ntree:\n  sequence:\n    - wait: 1\n    - turn: {angel: 90}\n"


class Client:
    """Asks as the page does."""

    def __init__(self, server: EditServer) -> None:
        self.server = server

    async def ask(self, request: str, /, **facts: Any) -> Any:
        """Return the answer to a request."""
        asked = json.dumps({"page": "a", **facts})
        return json.loads((await self.post(f"api/{request}", asked))[1])

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
    assert names_in(tmp_path) == ["m.yaml"]
    better = TEXT.replace("angel", "angle")
    await client.ask("check", name="m.yaml", text=better)
    opened = await client.ask("open", name="m.yaml", page="b")
    assert (opened["text"], [draft["text"] for draft in opened["drafts"]]) == (TEXT, [better])
    assert await client.ask("save", name="m.yaml", text=better, base=TEXT) == {"text": better}
    assert (tmp_path / "m.yaml").read_text() == better
    assert (await client.ask("open", name="m.yaml", page="b"))["drafts"] == []
    assert names_in(tmp_path) == ["m.yaml"]


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
    opened = await client.ask("open", name="n.yaml", page="b")
    assert (opened["text"], opened["drafts"][0]["text"]) == (TEXT, "mission: draft\n")
    answer = await client.ask("delete", name="n.yaml", base="mission: older\n")
    assert (answer["code"], answer["theirs"]) == ("BT-1303", TEXT)
    assert await client.ask("delete", name="n.yaml", base=TEXT) == {}
    assert "error" in await client.ask("delete", name="n.yaml", base=TEXT)
    assert names_in(tmp_path) == ["new.yaml", "other.yaml", "out"]


@played("play")
async def test_versions_of_a_text_are_shown_side_by_side(client: Client) -> None:
    """Each hunk has the lines before, on disk and in the page."""
    long = "\n" * 1_000_000
    assert (await client.ask("merge", base=long, theirs=long, mine=long))["hunks"]
    answer = await client.ask("merge", base="a\nb\n", theirs="x\nb\n", mine="a\nb\nc\n")
    assert answer["hunks"] == [
        {"base": "a\n", "theirs": "x\n", "mine": "a\n", "choice": "theirs"},
        {"base": "b\n", "theirs": "b\n", "mine": "b\n", "choice": "theirs"},
        {"base": "", "theirs": "", "mine": "c\n", "choice": "mine"},
    ]


@played("play")
async def test_a_second_page_follows_until_it_takes_over(
    client: Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It receives the text of the first one, which may sleep for ever; a page can leave."""
    assert (await client.ask("state", name="m.yaml", text="a: 1\n"))["leads"]
    follows = {"leads": False, "text": "a: 1\n", "is_asleep": False}
    assert await client.ask("state", name="m.yaml", page="b") == follows
    monkeypatch.setattr("bt_mission.commands.edit.web.server.ASLEEP_S", -1.0)
    follows["is_asleep"] = True
    assert await client.ask("state", name="m.yaml", page="b") == follows
    refused = await client.ask("save", name="m.yaml", page="b", text="b: 1\n", base=TEXT)
    assert "another page" in refused["error"]
    assert (await client.ask("state", name="m.yaml", page="b", take=True))["leads"]
    assert not (await client.ask("state", name="m.yaml"))["leads"]
    await client.ask("leave", name="m.yaml", page="c")
    assert not (await client.ask("state", name="m.yaml"))["leads"]
    await client.ask("leave", name="m.yaml", page="b")
    late = await client.ask("state", name="m.yaml", page="b", text="b: 1\n")
    assert late == {"leads": False, "text": TEXT, "is_asleep": True}
    assert (await client.ask("state", name="m.yaml"))["leads"]


@played("play")
async def test_each_page_keeps_its_own_unsaved_text(
    client: Client, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What was offered stays until it is saved or deleted. The one who edits now has no offer.

    Of many, the newest are read.
    """
    for page in "abc":
        await client.ask("check", name="m.yaml", page=page, text=f"mission: {page}\n")
    await client.ask("state", name="m.yaml", page="c")

    async def offered() -> set[str]:
        opened = await client.ask("open", name="m.yaml")
        return {draft["text"] for draft in opened["drafts"]}

    assert await offered() == {"mission: a\n", "mission: b\n"}
    await client.ask("keep", name="m.yaml", page="d", text="mission: d\n")
    assert await offered() == {"mission: a\n", "mission: b\n", "mission: d\n"}
    await client.ask("drop", name="m.yaml", pages=["b"])
    await client.ask("leave", name="m.yaml", page="c")
    new = {"text": "mission: a\n", "base": TEXT, "restored": ["a"]}
    assert "error" not in await client.ask("save", name="m.yaml", page="d", **new)
    assert await offered() == {"mission: c\n"}
    assert names_in(tmp_path) == [".m.yaml.c.unsaved", "m.yaml"]
    monkeypatch.setattr("bt_mission.commands.edit.web.workspace.MOST_READ", 1)
    (tmp_path / ".m.yaml.old.unsaved").write_text("mission: old\n")
    os.utime(tmp_path / ".m.yaml.old.unsaved", (1, 1))
    assert await offered() == {"mission: c\n"}


@pytest.mark.parametrize(("limit", "most", "shown"), [("MOST_FILES", 2, 2), ("MOST_NAMES", 3, 3)])
@played("play")
async def test_files_beyond_the_limits_are_not_searched_for_and_the_list_says_so(
    client: Client,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    limit: str,
    most: int,
    shown: int,
) -> None:
    """Neither more than are shown, nor those behind too many others. Bad names are bounded, too."""
    for name in ("a.yaml", "b.yaml", "sub/c.yaml", "sub/d.yaml"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text("mission: x\n")
    assert not (await client.ask("files"))["is_cut"]
    for number in range(25):
        (tmp_path / f"\n{number:02}.yaml").touch()
    monkeypatch.setattr(f"bt_mission.commands.edit.web.workspace.{limit}", most)
    answer = await client.ask("files")
    assert answer["is_cut"]
    assert [row["name"] for row in answer["files"]] == ["a.yaml", "b.yaml", "m.yaml"][:shown]
    assert (len(answer["hidden"]), answer["hidden"][-1]) == (21, "and 5 more")


@pytest.mark.parametrize(
    ("before", "text", "after"),
    [
        (b"a\r\nb\nc\rd", "a\nb\nnew\nc\nd", b"a\r\nb\nnew\r\nc\rd"),
        (b"a\r\nb\nc\nd\n", "a\nc\nd\n", b"a\r\nc\nd\n"),
        (b"\xef\xbb\xbfa\r\nb\r\n", "a\nx\nb\n", b"\xef\xbb\xbfa\r\nx\r\nb\r\n"),
        (b"a\rb\rc\n", "A\nb\nc\n", b"A\rb\rc\n"),
        (b"", "a\nb\n", b"a\nb\n"),
    ],
)
@played("play")
async def test_bytes_stay_where_the_text_does(
    client: Client, tmp_path: Path, before: bytes, text: str, after: bytes
) -> None:
    """Line ends of several kinds in one file, and the mark at its beginning."""
    file = tmp_path / "m.yaml"
    file.write_bytes(before)
    base = (await client.ask("open", name="m.yaml"))["text"]
    assert await client.ask("save", name="m.yaml", text=base, base=base) == {"text": base}
    assert file.read_bytes() == before
    await client.ask("save", name="m.yaml", text=text, base=base)
    assert file.read_bytes() == after


@played("play")
async def test_too_many_lines_of_several_ends_that_are_alike_are_refused(
    client: Client, tmp_path: Path
) -> None:
    """Which of them kept their ends cannot be determined."""
    (tmp_path / "m.yaml").write_bytes(b"a\r\nb\n" * 2000)
    base = (await client.ask("open", name="m.yaml"))["text"]
    answer = await client.ask("save", name="m.yaml", text=f"x\n{base}y\n", base=base)
    assert "end in several ways" in answer["error"]
    assert (tmp_path / "m.yaml").read_bytes() == b"a\r\nb\n" * 2000


@played("play")
async def test_odd_files_stop_nothing_and_are_never_waited_for(
    client: Client, tmp_path: Path
) -> None:
    """Rings of links, names that are not UTF-8, pipes and links in place of unsaved texts."""
    (tmp_path / "ring.yaml").symlink_to("ring.yaml")
    (tmp_path / os.fsdecode(b"caf\xe9.yaml")).write_text("mission: x\n")
    os.mkfifo(tmp_path / "pipe.yaml")
    os.mkfifo(tmp_path / ".m.yaml.b.unsaved")
    (tmp_path / ".m.yaml.c.unsaved").symlink_to("/etc/hostname")
    answer = await client.ask("files")
    assert [row["name"] for row in answer["files"]] == ["m.yaml", "pipe.yaml"]
    assert answer["hidden"] == ["caf\\xe9.yaml"]
    assert (await client.ask("open", name="m.yaml"))["drafts"] == []
    assert "device or pipe" in (await client.ask("open", name="pipe.yaml"))["error"]
    assert "error" in await client.ask("open", name="ring.yaml")
    for page in "bc":
        assert (await client.ask("keep", name="m.yaml", page=page, text="x: 1\n"))["lost"] == ""
        assert (tmp_path / f".m.yaml.{page}.unsaved").read_text() == "x: 1\n"
    assert not (tmp_path / ".m.yaml.c.unsaved").is_symlink()


@played("play")
async def test_a_link_stays_and_nobody_else_may_read_an_unsaved_text(
    client: Client, tmp_path: Path
) -> None:
    """Its target in the folder is written, with its permissions."""
    (tmp_path / "sub").mkdir()
    target = tmp_path / "sub" / "t.yaml"
    target.write_text("mission: t\n")
    target.chmod(0o600)
    (tmp_path / "l.yaml").symlink_to("sub/t.yaml")
    await client.ask("keep", name="l.yaml", text="mission: u\n")
    await client.ask("keep", name="new.yaml", text="mission: v\n")
    for name in ("l.yaml", "new.yaml"):
        assert (tmp_path / f".{name}.a.unsaved").stat().st_mode & 0o777 == 0o600
    assert "error" not in await client.ask(
        "save", name="l.yaml", text="mission: u\n", base="mission: t\n"
    )
    assert (tmp_path / "l.yaml").is_symlink()
    assert (target.read_text(), target.stat().st_mode & 0o777) == ("mission: u\n", 0o600)


@played("play")
async def test_a_full_disk_is_named_and_leaves_no_part_of_a_file(
    client: Client, tmp_path: Path
) -> None:
    """Neither beside the file nor in its place."""
    with full_after(10_000):
        text = TEXT + "# more\n" * 5_000
        kept = await client.ask("check", name="m.yaml", text=text)
        saved = await client.ask("save", name="m.yaml", text=text, base=TEXT)
    assert "File too large" in kept["lost"]
    assert "File too large" in saved["error"]
    assert names_in(tmp_path) == ["m.yaml"]
    assert (tmp_path / "m.yaml").read_text() == TEXT


@played("play")
async def test_a_text_that_could_not_be_read_again_is_not_written(
    client: Client, tmp_path: Path
) -> None:
    """Files are read to a limit in bytes, which is that of unsaved texts, too."""
    text = "# " + "é" * 500_000
    assert "1,000,000 bytes" in (await client.ask("keep", name="m.yaml", text=text))["lost"]
    saved = await client.ask("save", name="m.yaml", text=text, base=TEXT)
    assert "1,000,000 bytes" in saved["error"]
    assert names_in(tmp_path) == ["m.yaml"]
    assert (tmp_path / "m.yaml").read_text() == TEXT


@pytest.mark.parametrize("contents", [b"caf\xe9", b"x" * 1_000_001])
@played("play")
async def test_an_unsaved_text_is_kept_beside_a_file_that_cannot_be_read(
    client: Client, tmp_path: Path, contents: bytes
) -> None:
    """Another program may have written it so; the text is offered as soon as it can be read."""
    (tmp_path / "m.yaml").write_bytes(contents)
    assert (await client.ask("keep", name="m.yaml", text="mine: 1\n"))["lost"] == ""
    assert "error" in await client.ask("open", name="m.yaml")
    (tmp_path / "m.yaml").write_text(TEXT)
    (draft,) = (await client.ask("open", name="m.yaml"))["drafts"]
    assert draft["text"] == "mine: 1\n"


@played("play")
async def test_files_outside_of_the_folder_are_not_read(client: Client, tmp_path: Path) -> None:
    """Neither those that a scenario, a fleet or a mission names, nor those of its world."""
    outside = tmp_path.parent / f"{tmp_path.name}_outside"
    outside.mkdir()
    (outside / "secret.yaml").write_text("mission: hush hush\nspawn: {}\n")
    for name in (f"{outside}/secret.yaml", f"../{outside.name}/secret.yaml"):
        texts = [
            f"scenario: s\nmission: {name}\n",
            f"scenario: s\nmission: m.yaml\nworld: {name}\n",
            f"fleet: f\nrobots: {{one: {{mission: {name}}}}}\n",
            f"fleet: f\nrobots: {{one: {{mission: m.yaml, robot: {name}}}}}\n",
            f"mission: m\nworld: {name}\ntree: {{wait: 1}}\n",
            f"mission: m\ninclude: [{name}]\ntree: {{wait: 1}}\n",
        ]
        for text in texts:
            answer = await client.ask("look", name="x.yaml", text=text)
            shown = json.dumps(answer)
            assert "hush" not in shown, text
            assert {mark["code"] for mark in answer["marks"]} & {"BT-110", "BT-112"}, text
            assert (await client.ask("plan", name="x.yaml", text=text))["plan"] is None or (
                "world" not in text
            )


@pytest.mark.parametrize(("request_name", "facts"), [("check", {}), ("act", {"do": "copy"})])
@played("play")
async def test_texts_that_no_file_can_hold_or_nest_too_deeply_are_refused(
    client: Client, request_name: str, facts: dict[str, Any]
) -> None:
    """With words, never with an error of the server."""
    deep = "mission: m\ntree: " + "{invert: " * 450 + "{wait: 1}" + "}" * 450
    half = "mission: m\ntree: {log: \ud83d}\n"
    for text, status, words in ((deep, 200, "nested too deeply"), (half, 400, "U+D83D")):
        asked = {"name": "m.yaml", "page": "a", "path": ["tree"], "text": text, **facts}
        answered, body = await client.post(f"api/{request_name}", json.dumps(asked))
        assert (answered, words in body) == (status, True), body


class PlayedChild:
    """A command that runs until it is stopped, which takes some turns of the loop."""

    running: ClassVar[list[PlayedChild]] = []
    most = 0

    def __init__(self, trial: Path, words: Sequence[str], _: object = None) -> None:
        self.trial, self.words, self.is_over = trial, words, False
        self.running.append(self)
        type(self).most = max(self.most, len(self.running))

    async def stop(self) -> None:
        if self.is_over:
            return
        for _ in range(20):
            await asyncio.sleep(0)  # noqa: TID251 - lets others ask meanwhile
        self.trial.unlink(missing_ok=True)
        self.running.remove(self)
        self.is_over = True


@pytest.mark.parametrize("request_name", ["run", "prove"])
@played("play")
async def test_of_requests_at_once_one_starts_a_run(
    client: Client, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, request_name: str
) -> None:
    """The others are told so. Each run has its own recording, and none is left."""
    monkeypatch.setattr("bt_mission.commands.edit.web.server.ChildCommand", PlayedChild)
    monkeypatch.setattr(PlayedChild, "most", 0)
    words = []
    asked = {"name": "m.yaml", "text": TEXT, "speed": "1"}
    for _ in range(3):
        answers = await asyncio.gather(*(client.ask(request_name, **asked) for _ in range(4)))
        started = [answer for answer in answers if "error" not in answer]
        assert started
        assert all("try again" in answer["error"] for answer in answers if answer not in started)
        assert len(PlayedChild.running) == 1
        words.append(PlayedChild.running[0].words)
    assert PlayedChild.most == 1
    if request_name == "run":
        files = {word for line in words for word in line if word.startswith("--record")}
        assert len(files) == 3
        await client.ask("run", stop=True)
        assert PlayedChild.running == []
        assert names_in(tmp_path) == ["m.yaml"]
    else:
        await PlayedChild.running[0].stop()
        assert names_in(tmp_path) == ["m.yaml"]


@pytest.mark.parametrize(
    "name",
    ["../m.yaml", "/etc/x.yaml", ".m.yaml", "m.txt", "a\0.yaml", "l.yaml", "./m.yaml", "m.yaml/"],
)
@played("play")
async def test_only_yaml_files_of_the_folder_are_read(
    client: Client, tmp_path: Path, name: str
) -> None:
    """Links that lead out of it are refused, too, and other forms of a name."""
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
    for place in (f"[1{'0' * 400}, 0]", "[NaN, 0]", "[0, Infinity]", "[true, 0]", "[1]"):
        facts = f'"do": "place", "section": "boxes", "begin": {place}, "end": [1, 1]'
        status, answer = await client.post("api/act", f'{{"text": "size: [4, 4]\\n", {facts}}}')
        assert (status, "not a place" in answer) == (400, True)
    lines = "a\n" * 30_000
    assert "20,000" in (await client.ask("differ", before=lines, after=""))["error"]
    assert "exceeds" in (await client.ask("files", text="x" * 8_000_001))["error"]


@pytest.mark.thorough
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
    (trial,) = tmp_path.glob(".m.yaml.*.run.yaml")
    assert trial.read_text() == text
    mine = Workspace(tmp_path).trial("m.yaml", text, "run")
    EditServer(Workspace(tmp_path), WebOptions(port=0)).close()
    assert not trial.exists()
    assert mine.exists(), "an editor that runs has it"


@played("play")
async def test_the_unsaved_text_of_a_deleted_file_is_offered(
    client: Client, tmp_path: Path
) -> None:
    """The file is listed as long as its text is kept."""
    await client.ask("check", name="m.yaml", text="mission: mine\n")
    (tmp_path / "m.yaml").unlink()
    files = (await client.ask("files"))["files"]
    assert files == [{"name": "m.yaml", "kind": "mission", "is_unsaved": True}]
    opened = await client.ask("open", name="m.yaml", page="b")
    assert (opened["text"], opened["drafts"][0]["text"]) == ("", "mission: mine\n")
