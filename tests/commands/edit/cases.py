"""What the tests of all commands take from this one: see `tests/support/command_cases.py`."""

from __future__ import annotations

import json
from http.client import HTTPConnection
from typing import Any
from urllib.parse import urlsplit

from tests.support.command_cases import InFolder

MISSION = "mission: m\nworld: empty_arena\ntree: {turn: {angle: 5}, timeout: 20}\n"


def asks_of_the_page(line: str) -> None:
    """Check, run and prove a mission as the page of the editor does."""
    address = urlsplit(line.rsplit(maxsplit=1)[-1])

    def ask(request: str, **facts: Any) -> Any:
        connection = HTTPConnection(address.netloc)
        connection.request("POST", f"{address.path}api/{request}", json.dumps(facts))
        answer = json.loads(connection.getresponse().read())
        connection.close()
        return answer

    assert "error" not in ask("check", name="m.yaml", page="a", text=MISSION)
    ask("prove", name="m.yaml", text=MISSION)
    ask("run", name="m.yaml", text=MISSION, speed="16")
    while not (proved := ask("proved"))["is_over"]:
        continue
    assert proved["result"]["findings"] is not None, proved
    while (ran := ask("ran"))["state"] == "starting":
        continue
    assert ran["state"] == "served", ran


IN_FOLDER = {"edit": InFolder("edit . --port 0", "in a browser: ", act=asks_of_the_page)}
SERVED_UNTIL_CTRL_C = ("edit",)
STAYS_ON_PAGES = {r"bt-mission edit\b[^|]*$": ""}
