"""Runs with code of users, of another simulator, on a graph: which can be forked, and where."""

from __future__ import annotations

import argparse
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from rclpy.node import Node

from bt_mission.cli import main
from bt_mission.commands import replay
from bt_mission.recording.writer import RunRecorder
from bt_mission.sessions.load import load
from bt_mission.sessions.stage import Stage
from bt_mission.sessions.stage_robot import StageOptions
from tests.support.command_line import CommandLine
from tests.support.own_nodes import written
from tests.support.project import ROOT
from tests.support.recordings import recording, with_facts
from tests.support.report_pages import data_of

WAITS = "mission: m\nworld: empty_arena\ntree: {wait: 1}\n"
SIMULATOR = "sim.ir_sim:IrSim"


def test_a_fork_makes_them_again_where_it_may(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """As Python leaves: the code on this machine is run only where that was asked for."""
    monkeypatch.chdir(tmp_path)
    written(tmp_path)
    Path("it.scenario.yaml").write_text(
        "scenario: it\nmission: turns.yaml\nnodes: [server.py:TurnServer]\n", encoding="utf-8"
    )
    assert main(["run", "it.scenario.yaml", "--plain", "--record", "run.mcap"]) == 0
    assert main(["fork", "run.mcap", "--at", "0"]) == 2
    assert "the Python node 'server.py:TurnServer' is refused" in capsys.readouterr().err
    assert main(["fork", "run.mcap", "--at", "0", "--import-python", "--json"]) == 0
    assert '"is_identical": true' in capsys.readouterr().out


def test_a_fork_runs_whole_programs_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Up to the instant of the fork they do the same, and then go on."""
    monkeypatch.chdir(tmp_path)
    for name in ("sleepy_server.py", "sleepy_numbers.yaml"):
        shutil.copy(ROOT / "docs" / "tutorials" / "code" / name, tmp_path)
    assert main(["run", "sleepy_numbers.yaml", "--plain", "--record", "run.mcap"]) == 0
    assert main(["fork", "run.mcap", "--at", "3"]) == 2
    assert "the Python node 'sleepy_server.py --threads' is refused" in capsys.readouterr().err
    assert main(["fork", "run.mcap", "--at", "3", "--import-python", "--json"]) == 0
    assert '"is_identical": true' in capsys.readouterr().out


def test_a_run_with_nodes_of_a_program_cannot_be_forked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """They are not in the recording."""
    mission = load(WAITS)
    path, options = tmp_path / "run.mcap", StageOptions(nodes=[lambda **o: Node("mine", **o)])
    with (
        Stage(mission, image_folder=tmp_path, options=options) as stage,
        RunRecorder(stage, path) as recorder,
    ):
        while not stage.is_done:
            stage.step()
        recorder.finish(stage.report().as_dict())
    assert main(["fork", str(path), "--at", "0"]) == 2
    assert "needs nodes that a program created" in capsys.readouterr().err


def test_a_recording_names_it_and_is_not_forked(cli: CommandLine) -> None:
    """A fork runs in MuJoCo."""
    (cli.folder / "nap.yaml").write_text("mission: nap\ntree: {wait: 1}\n", encoding="utf-8")
    assert cli.call(f"run nap.yaml --simulator {SIMULATOR} --record nap.mcap") == 0, cli.err
    assert cli.call("fork nap.mcap --at 0.5 --set a=1") != 0
    assert f"another simulator moved the robot, {SIMULATOR}" in cli.err


def test_forks_are_offered_with_the_file_as_it_was_named(
    cli: CommandLine, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A run on a graph, which cannot run again, says so; who may only look is offered none."""
    pages: list[str] = []

    class Server:
        async def serve(self, until: Callable[[], bool]) -> None:
            """There are no viewers."""

    @contextmanager
    def server(_: argparse.Namespace, page: str) -> Iterator[Server]:
        pages.append(page)
        yield Server()

    monkeypatch.setattr(replay, "page_server", server)
    Path("my run.mcap").write_bytes(recording().read_bytes())
    with_facts(Path("live.mcap"), {"world": None})
    for words in ("'my run.mcap'", "live.mcap", "'my run.mcap' --read-only"):
        cli(f"replay {words} --web", 130)
    offered, refused, none = (next(iter(data_of(page).values())).get("fork", {}) for page in pages)
    assert offered == {"command": "bt-mission fork 'my run.mcap' --at", "refusal": ""}
    assert "on a running graph" in refused["refusal"]
    assert none == {}
