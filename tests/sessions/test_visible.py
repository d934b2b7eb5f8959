"""A run on the stage that other processes can see."""

from __future__ import annotations

from pathlib import Path

from bt_mission.sessions.load import load
from bt_mission.sessions.stage import Stage
from bt_mission.sessions.stage_robot import StageOptions

WAIT = """\
mission: wait
world: empty_arena
tree:
  sequence: [wait: 0.1]
"""


def services(folder: Path, *, visible: bool) -> tuple[set[str], set[str]]:
    """The names of all nodes and of all services of a run."""
    options = StageOptions(visible=visible)
    with Stage(load(WAIT), image_folder=folder, say=lambda _: None, options=options) as stage:
        while not stage.is_done:
            stage.step()
        node = stage.node
        names = {name for name, _ in node.get_service_names_and_types()}
        return set(node.get_node_names()), names


def test_every_node_that_others_see_answers_for_its_parameters(tmp_path):
    """`ros2 param list` asks each node that is announced, and waits for each that does not."""
    nodes, names = services(tmp_path, visible=True)
    assert {"bt_mission", "bt_mission_servers", "bt_mission_sim"} <= nodes
    assert {f"/{node}/list_parameters" for node in nodes} <= names


def test_nodes_that_nobody_sees_have_none(tmp_path):
    """They would cost time in every run."""
    _, names = services(tmp_path, visible=False)
    assert not {name for name in names if name.endswith("/list_parameters")}
