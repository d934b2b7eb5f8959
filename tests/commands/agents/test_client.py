"""A scripted client of the SDK: refused, mended by the messages, approved, driven, stopped."""

from __future__ import annotations

import asyncio
import re
from typing import Any

import pytest
from bt_mission_interfaces.action import ExecuteMission
from mcp.client import Client
from rclpy.action import ActionClient

from bt_mission.base.wall_clock import Stopwatch
from bt_mission.cli import main
from bt_mission.commands.agents.gateway import AgentGateway
from bt_mission.commands.agents.permitted import PermittedMissions
from bt_mission.commands.agents.robot import UNANSWERED, RosRobot
from bt_mission.commands.agents.server import agent_server
from bt_mission.sessions.scripted_server import ScriptedServer
from tests.commands.agents.played import TURN, Played
from tests.support.mission_goals import Sent

DRAFT = "mission: look\ntree:\n  turn: {angel: 90}\n  timeout: 20\n"


def _mended(text: str, refusal: str) -> str:
    """Correct a text by what the refusal suggests, and by nothing else."""
    (wrong,) = re.findall(r"no field '(\w+)'", refusal)
    (right,) = re.findall(r"did you mean '(\w+)'", refusal)
    return text.replace(wrong, right)


@pytest.fixture
def robot(ros: Any, played: Played) -> RosRobot:
    """A robot on a graph with the server of the site; each look is a step of its clock."""
    played.gateway.log.close()
    ros.serve(PermittedMissions(site=played.site, folder=played.folder))
    robot = RosRobot(ros.node("agents"), ros.step)
    played.gateway = AgentGateway(played.site, played.folder, robot, played.command, played.examine)
    return robot


def test_a_client_mends_its_mission_drives_once_and_stops(
    ros: Any, played: Played, robot: RosRobot
) -> None:
    """The goal reaches the action server after the approval, and its end follows the stop."""
    turn = ros.server()

    async def act(client: Client) -> None:
        async def call(tool: str, **arguments: Any) -> Any:
            result = await client.call_tool(tool, arguments)
            return result.content[0].text if result.is_error else result.structured_content

        refusal = await call("propose", name="look", text=DRAFT)
        assert "[BT-502]" in refusal
        await call("propose", name="look", text=_mended(DRAFT, refusal))
        await call("prove", name="look")
        assert (await call("simulate", name="look"))["missing"] == []
        assert "[BT-1404]" in await call("drive", name="look")
        played.approve()
        assert await call("drive", name="look") == {"is_driving": True, "why": ""}
        while not turn.goals:
            await asyncio.wait([pause()], timeout=1.0)
        assert turn.goal.request.angle == 90.0
        since = Stopwatch()
        assert (await call("stop"))["is_stopped"] is True
        assert since.elapsed_s < 0.3
        turn.goal.cancel()
        while "interrupted" not in (await call("status"))["from_robot"]["state"]:
            await asyncio.wait([pause()], timeout=1.0)
        assert "[BT-1404]" in await call("drive", name="look")

    def pause() -> asyncio.Future[None]:
        future = asyncio.get_running_loop().create_future()
        asyncio.get_running_loop().call_later(0.02, future.set_result, None)
        return future

    async def session() -> None:
        serving = asyncio.create_task(robot.serve_forever())
        async with Client(agent_server(played.gateway, lambda: 0.0)) as client:
            await act(client)
        serving.cancel()

    asyncio.run(session())
    assert len(turn.goals) == 1


def test_a_permit_is_spent_only_when_its_mission_starts(ros: Any, played: Played) -> None:
    """Without one nothing is replaced; with one that waits and is cancelled, it stays valid."""
    ros.serve(PermittedMissions(site=played.site, folder=played.folder))
    turn = ros.server(cancels=None)
    goals = ActionClient(ros.client, ExecuteMission, "execute_mission")
    for name in ("first", "second"):
        played.prepare(name, TURN)
    played.approve("first")
    first = Sent(ros, goals, path="permit:first")
    ros.until(lambda: turn.goals)
    assert "has no permit" in Sent(ros, goals, path="permit:second").end()[1].error_msg
    assert "was used" in Sent(ros, goals, path="permit:first").end()[1].error_msg
    assert (turn.goal.cancels, first.is_done) == (0, False)
    permit = played.approve("second")
    second = Sent(ros, goals, path="permit:second")
    second.cancel()
    assert second.end()[0] == "canceled"
    assert not played.folder.path("used", permit.id).exists()
    late = Sent(ros, goals, path="permit:second")
    played.clock_s += 1e6
    turn.goal.answer_cancel()
    turn.goal.cancel()
    assert first.end()[1].error_msg == "replaced by a newer mission"
    assert "has expired" in late.end()[1].error_msg
    assert len(turn.goals) == 1


def test_while_nobody_answers_a_drive_is_neither_running_nor_refused(
    ros: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The executive may accept it later; its result is then in the status."""
    monkeypatch.setattr("bt_mission.commands.agents.robot.START_S", 0.05)
    kind = "bt_mission_interfaces/action/ExecuteMission"
    served = ScriptedServer(ros.node("server"), kind, "execute_mission", accepts=None)
    robot = RosRobot(ros.node("agents"), ros.step)
    ros.until(robot._goals.server_is_ready)

    async def session() -> dict[str, Any]:
        serving = asyncio.create_task(robot.serve_forever())
        answer = await robot.drive("look")
        served.goal.accept()
        served.goal.abort(error_msg="it fell over")
        ros.until(lambda: robot.status()["result"] is not None)
        serving.cancel()
        return answer

    assert asyncio.run(session()) == {"is_driving": None, "why": UNANSWERED}
    assert robot.status()["result"] == "«it fell over»"


def test_without_a_robot_stop_answers_at_once(ros: Any, played: Played) -> None:
    """It says that nothing was stopped."""
    robot = RosRobot(ros.node("agents"), lambda: None)
    answer = asyncio.run(robot.stop())
    assert answer == {"is_stopped": False, "why": "no executive /bt_mission in this domain"}


def _end_of_input(_: str) -> str:
    raise EOFError  # Ctrl-D


def test_approve_shows_everything_and_asks_in_a_terminal(
    played: Played, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """An answer through a pipe is refused; another word than the name approves nothing."""
    played.prepare()
    words = ["approve", "look", "--site", str(played.root / "site.yaml"), "--key"]
    words.append(str(played.root / "person" / "key.pem"))
    assert main(words) == 2
    shown, refused = capsys.readouterr()
    assert "keeps clear: held in 2 of 2 runs, smallest margin 0.2 m" in shown
    assert "log of calls: 3 calls\n" in shown
    assert "[BT-1406]" in refused
    monkeypatch.setattr("sys.stdin.isatty", lambda: True)
    monkeypatch.setattr("sys.stdout.isatty", lambda: True)
    monkeypatch.setattr("builtins.input", lambda _: "yes")
    assert main(words) == 1
    monkeypatch.setattr("builtins.input", _end_of_input)
    assert main(words) == 1
    assert played.folder.permit("look") is None
    monkeypatch.setattr("builtins.input", lambda _: "look")
    assert main(words) == 0
    assert played.call("drive", name="look") == {"is_driving": True, "why": ""}


def test_a_damaged_proposal_hides_no_other(
    played: Played, capsys: pytest.CaptureFixture[str]
) -> None:
    """The list says what is wrong with it, as the page does."""
    played.prepare()
    played.folder.path("proposals", "bad").mkdir()
    played.folder.path("proposals", "bad", "proposal.json").write_text("{")
    assert main(["approve", "--site", str(played.root / "site.yaml")]) == 0
    damaged = "proposals/bad/proposal.json: expected a JSON object [BT-1401]"
    assert capsys.readouterr().out == f"bad: {damaged}\nlook: can be approved\n"
