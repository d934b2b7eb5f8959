"""Checks of proposals in another process."""

from __future__ import annotations

import asyncio

import pytest
from mcp.client import Client

from bt_mission.commands.agents.examiner import Examiner
from bt_mission.commands.agents.folder import Proposal
from bt_mission.commands.agents.gateway import AgentGateway
from bt_mission.commands.agents.server import agent_server
from tests.commands.agents.played import TURN, Played

POSES = ", ".join(["[1, 0.5, 0]"] * 900)
LONG = f"mission: look\ninputs: {{p: [{POSES}]}}\ntree:\n  sequence:\n"
LONG += "    - {follow_waypoints: {poses: $p}, timeout: 9}\n" * 150
"""Its check takes half a minute."""


@pytest.mark.thorough
def test_stop_waits_for_no_check(played: Played) -> None:
    """A check that takes too long is ended, and the next one has a new process."""
    examiner = Examiner(played.site, most_wall_s=2.0)
    gateway = AgentGateway(played.site, played.folder, played.robot, played.command, examiner)

    async def scene() -> None:
        async with Client(agent_server(gateway)) as client:
            call = asyncio.create_task(client.call_tool("check", {"text": LONG}))
            stopped = await client.call_tool("stop", {})
            assert stopped.structured_content == {"is_stopped": True, "why": ""}
            assert not call.done()
            assert "not ended within 2 s" in str((await call).content)
            valid = await client.call_tool("check", {"text": TURN})
            assert valid.structured_content == {"is_valid": True, "diagnostics": []}
        await examiner.close()
        await gateway.close()

    asyncio.run(scene())


def test_it_finds_what_the_site_does(played: Played) -> None:
    """Also that the files are no longer those that were read."""
    proposal = Proposal("look", TURN.replace("turn", "trun"))

    async def diagnostics_of(examiner: Examiner) -> object:
        try:
            return (await examiner(proposal)).diagnostics
        finally:
            await examiner.close()

    assert asyncio.run(diagnostics_of(Examiner(played.site))) == played.site.examine(proposal)[1]
