"""The gateway as a client of the SDK sees it."""

from __future__ import annotations

import asyncio
import base64
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from mcp.client import Client

from bt_mission.commands.agents.gateway import MOST_PICTURE
from bt_mission.commands.agents.jobs import CommandEnd
from tests.commands.agents.played import TURN, Played


def test_a_mission_is_proposed_proved_simulated_and_driven_with_a_permit(played: Played) -> None:
    """Each answer names what is missing next."""
    proposed = played.call("propose", name="look", text=TURN)
    assert proposed["missing"][0] == "no proof of this version: call prove"
    assert "+mission: look" in proposed["diff"]
    assert played.call("prove", name="look")["missing"] == [
        "no simulated runs of this version: call simulate (2 runs)"
    ]
    assert played.call("simulate", name="look")["missing"] == []
    assert "has no permit" in played.call("drive", name="look")
    played.approve()
    assert played.call("drive", name="look") == {"is_driving": True, "why": ""}
    (mission,) = played.robot.driven
    halting = {each.name for each in mission.requirements if each.on_violation == "halt"}
    assert halting == {"keeps clear", "is slow"}
    # `clearance` is true room, which no sensor of a robot measures.
    assert played.call("site")["only_simulated"] == ["keeps clear"]


PICTURE = ("proposals", "look", "results", "recordings", "0.png")


def _draws(played: Played) -> None:
    """Have `sweep` leave a recording, and `report` a picture of it."""
    answer = played.command

    async def command(words: Sequence[str]) -> CommandEnd:
        for output in [Path(word[9:]) for word in words if word.startswith("--output=")]:
            if words[0] == "report":
                output.write_bytes(b"a picture")
                return CommandEnd(None, [])
            (output / "recordings").mkdir(parents=True)
            (output / "recordings" / "0.mcap").touch()
        return await answer(words)

    played.command = command  # type: ignore[method-assign]
    played.restart()


def test_results_have_a_picture_of_the_worst_run(played: Played) -> None:
    """A client may leave it out; a picture that is too large is not sent."""

    async def kinds(**more: Any) -> list[str]:
        async with Client(played.server) as client:
            result = await client.call_tool("results", {"name": "look", **more})
        assert result.structured_content["missing"] == []
        pictures = [part for part in result.content if part.type == "image"]
        assert all(base64.b64decode(part.data) == b"a picture" for part in pictures)
        return [part.type for part in result.content]

    _draws(played)
    played.prepare()
    assert asyncio.run(kinds()) == ["text", "image"]
    assert asyncio.run(kinds(picture=False)) == ["text"]
    played.folder.path(*PICTURE).write_bytes(b"x" * (MOST_PICTURE + 1))
    assert asyncio.run(kinds()) == ["text"]
