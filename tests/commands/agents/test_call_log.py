"""The log of calls: whole lines, of several servers, through a full disk."""

from __future__ import annotations

import asyncio
import errno
import fcntl
import json
import os
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from mcp.client import Client
from mcp.shared.exceptions import MCPError
from mcp_types import EmptyResult, Request

from bt_mission.commands.agents.call_log import MOST_WAITING, CallLog, LogError, read_log
from tests.commands.agents.played import TURN, Played

LINE = {"client": "a", "call": "check", "arguments": {}, "outcome": "done"}


def _note(log: CallLog, call: str = "check") -> None:
    log.note("a", call, {}, "done")


def _calls(path: Path) -> list[str]:
    return [json.loads(line)["call"] for line in path.read_text().splitlines() if line]


def test_two_servers_share_a_log(tmp_path: Path) -> None:
    """Their lines alternate; a line that meets the lock of the other is written with the next."""
    path = tmp_path / "calls.jsonl"
    first, second = CallLog(path), CallLog(path)
    for number in range(3):
        _note(first, f"one {number}")
        _note(second, f"two {number}")
    assert _calls(path) == ["one 0", "two 0", "one 1", "two 1", "one 2", "two 2"]
    with path.open() as other:
        fcntl.flock(other, fcntl.LOCK_EX)
        _note(first, "waits")
        assert str(read_log(path)) == "log of calls: 6 calls"
    _note(first, "after it")
    assert _calls(path)[6:] == ["waits", "after it"]
    first.close()
    second.close()


def test_a_full_disk_costs_no_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Half of a line is taken back; what could not be written follows once there is space."""
    path = tmp_path / "calls.jsonl"
    log = CallLog(path)
    _note(log, "first")
    write = os.write

    def full(file: int, data: bytes) -> int:
        return write(file, data[:20])

    monkeypatch.setattr("bt_mission.commands.agents.call_log.os.write", full)
    with pytest.raises(LogError, match="no space left"):
        _note(log, "second")

    def none(*_: Any) -> int:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("bt_mission.commands.agents.call_log.os.write", none)
    with pytest.raises(LogError, match="No space left"):
        _note(log, "third")
    assert _calls(path) == ["first"]
    monkeypatch.undo()
    _note(log, "fourth")
    assert _calls(path) == ["first", "second", "third", "fourth"]
    log.close()


def test_lines_that_wait_are_bounded(tmp_path: Path) -> None:
    """Then calls are refused, until the lines are written."""
    path = tmp_path / "calls.jsonl"
    log = CallLog(path)
    with path.open() as other:
        fcntl.flock(other, fcntl.LOCK_EX)
        for _ in range(MOST_WAITING):
            with suppress(LogError):
                _note(log)
        with pytest.raises(LogError, match="another process holds it; 200 lines wait"):
            _note(log)
    _note(log)
    log.close()
    assert read_log(path).calls == MOST_WAITING + 1


@pytest.mark.parametrize("tail", [b'{"call": "cu', b"\0\0\0", b"[1]\n", b"\xff\n\n"])
def test_a_damaged_line_costs_itself_only(tmp_path: Path, tail: bytes) -> None:
    """It is named; the log goes on, on a line of its own."""
    path = tmp_path / "calls.jsonl"
    path.write_bytes(json.dumps(LINE).encode() + b"\n" + tail)
    log = CallLog(path)
    _note(log)
    log.close()
    log.close()
    assert str(read_log(path)) == "log of calls: 2 calls; 1 line cannot be read: 2"


@pytest.mark.parametrize("kind", ["link", "pipe", "folder"])
def test_what_is_not_a_file_is_refused(tmp_path: Path, kind: str) -> None:
    """Neither a reader nor a writer waits for it."""
    path = tmp_path / "calls.jsonl"
    if kind == "link":
        path.symlink_to(tmp_path / "other")
    elif kind == "pipe":
        os.mkfifo(path)
    else:
        path.mkdir()
    for use in (CallLog, read_log):
        with pytest.raises(LogError):
            use(path)


def test_stops_share_a_line(played: Played) -> None:
    """The first is logged at once, those of ten seconds together; each reaches the robot.

    A request of another method with that name is none.
    """

    async def stops(client: Client) -> None:
        with pytest.raises(MCPError, match="Method not found"):
            await client.session.send_request(Request(method="stop", params=None), EmptyResult)
        for second in (0.0, 0.1, 0.2, 10.0):
            played.seconds = second
            await client.call_tool("stop", {})

    played.talk(stops)
    assert played.robot.stops == 4
    lines = [json.loads(line) for line in played.folder.log.read_text().splitlines()]
    outcomes = ["error: Method not found", "passed on", "passed on, 3 since the last line"]
    assert [line["outcome"] for line in lines] == outcomes


def test_no_call_is_passed_on_while_an_earlier_one_is_not_logged(
    played: Played, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The line of the earlier one waits. `stop` works all the time."""

    def none(*_: Any) -> int:
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patched:
        patched.setattr("bt_mission.commands.agents.call_log.os.write", none)
        assert played.call("check", text=TURN)["is_valid"]
        assert "No space left on device" in played.call("propose", name="look", text=TURN)
        assert played.call("stop") == {"is_stopped": True, "why": ""}
    assert played.call("check", text=TURN)["is_valid"]
    asyncio.run(played.gateway.close())
    assert _calls(played.folder.log) == ["check", "propose", "stop", "check"]
    assert played.folder.names() == []
    played.restart()
