"""What the tests of all commands take from these: see `tests/support/command_cases.py`."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

from tests.support.command_cases import InFolder

MISSION = "mission: m\nworld: empty_arena\ntree: {turn: {angle: 5}, timeout: 20}\n"
SITE = """\
site: lab
robot: burger
world: empty_arena
requirements: {is slow: always speed < 0.3}
seeds: 2
"""


def write_site(folder: Path) -> None:
    """Write the file of a site with an approver."""
    from bt_mission.commands.agents.permits import new_key  # noqa: PLC0415 - needs the extra

    line = new_key(folder / "key.pem", "")
    (folder / "site.yaml").write_text(f'{SITE}approvers: ["{line}"]\n')


def calls_of_an_agent(process: subprocess.Popen[str]) -> None:
    """Propose a mission and have it proved, as a client of the protocol does."""
    written, read = process.stdin, process.stdout
    assert written is not None
    assert read is not None

    def send(number: int | None, method: str, **parameters: Any) -> Any:
        message = {"jsonrpc": "2.0", "method": method, "params": parameters}
        written.write(json.dumps(message | ({"id": number} if number else {})) + "\n")
        written.flush()
        while number is not None:
            answer = json.loads(read.readline())
            if answer.get("id") == number:
                return answer["result"]
        return None

    client = {"name": "test", "version": "1"}
    send(1, "initialize", protocolVersion="2025-03-26", capabilities={}, clientInfo=client)
    send(None, "notifications/initialized")
    text = MISSION.replace("world: empty_arena\n", "")
    send(2, "tools/call", name="propose", arguments={"name": "m", "text": text})
    proved = send(3, "tools/call", name="prove", arguments={"name": "m"})
    assert not proved.get("isError"), proved
    written.close()


IN_FOLDER = {
    "mcp": InFolder("mcp --site site.yaml", prepare=write_site, speak=calls_of_an_agent),
    "approve": InFolder("approve --site site.yaml", prepare=write_site),
}
PIPES = ("serve --site pipe.yaml",)
KINDS = {
    "site": ("site.yaml", "site: lab\nrequirements:\n  slow: always speed < 9\nseeds: 5\n"),
}
NOT_RUN_ON_PAGES = {"asks a person, after an agent has proposed": (r"bt-mission approve look",)}
