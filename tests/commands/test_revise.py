"""`bt-mission revise` sends a new version of a mission to the executive that runs it."""

from __future__ import annotations

import json

import pytest

from bt_mission.testing.live_graph import LiveGraph
from tests.support.command_line import CommandLine

MISSION = "mission: m\ntree:\n  sequence:\n    - wait: 600\n      name: nap\n    - log: done\n"


def test_a_file_with_errors_is_bad_input(cli: CommandLine) -> None:
    """It is not sent; the error has its place."""
    cli.write("m.yaml", MISSION.replace("wait: 600", "wiat: 60"))
    error = cli.refused("revise bt_mission m.yaml")
    assert "m.yaml:4:7: error: unknown node type 'wiat'" in error


@pytest.mark.thorough
def test_a_running_mission_is_revised_by_another_process(
    cli: CommandLine, live_graph: LiveGraph
) -> None:
    """The exit code says whether it was applied; a mission that nobody runs is refused."""
    path = cli.write("m.yaml", MISSION)
    other = cli.write("other.yaml", MISSION.replace("mission: m", "mission: n"))
    running = live_graph.run(path, "--editable", "--wall-clock")
    running.until("nap")
    refused = live_graph.start("revise", "bt_mission", other, "--json")
    assert refused.wait() == 1
    result = json.loads(refused.output.splitlines()[-1])
    assert result["reasons"] == ["it is another mission: 'n' instead of 'm'"]
    cli.write(path, MISSION.replace("wait: 600", "wait: 0"))
    shown = live_graph.start("revise", path, "--dry-run")
    assert shown.wait() == 0
    assert "~ nap (0.0): 600 s -> 0 s" in shown.output
    applied = live_graph.start("revise", "m", path)  # the mission's name
    assert applied.wait() == 0
    assert "~ nap (0.0): 600 s -> 0 s" in applied.output
    assert running.wait() == 0
    nobody = live_graph.start("revise", "nobody", path, "--wait", "1", "--json")
    assert nobody.wait() == 1
    assert '{"is_applied": false' in nobody.output


@pytest.mark.thorough
def test_places_are_those_of_the_world_that_runs(cli: CommandLine, live_graph: LiveGraph) -> None:
    """It is named with --world, and the file that is sent names none that this folder has."""
    cli.write("w.yaml", "name: w\nsize: [6, 6]\nzones: [{name: Q, x: 0.5, y: 0.5, radius: 0.2}]\n")
    path = cli.write("m.yaml", MISSION)
    running = live_graph.start(
        "run", path, "--editable", "--world", "w.yaml", "--speed", "1", "--plain"
    )
    running.until("nap")
    there = "    - navigate_to_pose: {pose: zone Q}\n      timeout: 60\n"
    cli.write(path, MISSION.replace("    - log", f"{there}    - log"))
    applied = live_graph.start("revise", "bt_mission", path)
    assert applied.wait() == 0, applied.output
    assert "+ navigate_to_pose" in applied.output
    cli.write(path, MISSION.replace("    - log", f"{there.replace('zone Q', 'zone Z')}    - log"))
    refused = live_graph.start("revise", "bt_mission", path)
    assert refused.wait() == 1
    assert "unknown place 'zone Z' (places: Q)" in refused.output
