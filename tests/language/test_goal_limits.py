"""Limits of goals: the node, its server, the mission, and ours, in this order."""

from __future__ import annotations

import pytest

from bt_mission.base.diagnostics import InputError
from bt_mission.base.yaml.document import read_text
from bt_mission.language.nodes.action import GoalNode
from bt_mission.sessions.load import load

HEAD = """\
mission: m
limits: {timeout: 60, acceptance_timeout: 7}
servers:
  turn: {timeout: 30, cancel_timeout: 9}
  /backup: {feedback_timeout: 4}
tree:
  sequence:
"""


def limits(text: str) -> list[tuple[object, ...]]:
    """Of each action: goal, silence, server, answer, cancel."""
    mission = load(HEAD + text)
    return [
        (
            step.timeout,
            step.feedback_timeout,
            step.server_timeout,
            step.acceptance_timeout,
            step.cancel_timeout,
        )
        for step in mission.tree.walk()
        if isinstance(step, GoalNode)
    ]


def test_the_nearest_word_counts():
    """A node that says something is heard, else its server, else the mission, else the default."""
    assert limits(
        "    - turn: {angle: 9}\n      timeout: 3\n"
        "    - action: {name: /turn, type: bt_mission_interfaces/action/Turn}\n"
        "    - back_up: {speed: 0.1}\n      acceptance_timeout: 1\n"
        "    - move: {secs: 2}\n"
    ) == [
        (3, None, 5.0, 7.0, 9.0),
        (30.0, None, 5.0, 7.0, 9.0),
        (60.0, 4.0, 5.0, 1.0, 3.0),
        (60.0, None, 5.0, 7.0, 3.0),
    ]


def test_a_limit_of_the_mission_is_one_for_the_warning(tmp_path):
    """What ends by itself is not warned of, also in a tree of another file."""
    (tmp_path / "lib.yaml").write_text("trees:\n  go: {do: {turn: {angle: 9}}}\n")
    path = tmp_path / "m.yaml"
    path.write_text("mission: m\ninclude: [lib.yaml]\nlimits: {timeout: 9}\ntree: {tree: go}\n")
    mission = load(path)
    assert mission.warnings == ()
    body = mission.trees["go"].body
    assert isinstance(body, GoalNode)
    assert body.timeout == 9


@pytest.mark.parametrize(
    ("head", "message"),
    [
        (
            "servers: {trun: {timeout: 3}}",
            "m.yaml:2:11: error: the mission sends no goals to 'trun' (but to: turn); did you mean",
        ),
        ("limits: {timeout: 0}", "m.yaml:2:19: error: expected seconds above 0, got the number 0"),
        ("limits: {timeout: $x}", "m.yaml:2:19: error: expected seconds above 0, got string '$x'"),
        ("limits: {time_out: 3}", "m.yaml:2:10: error: unknown key 'time_out' (valid: "),
        ("servers: {turn: 3}", "m.yaml:2:17: error: expected a mapping, got the number 3"),
    ],
)
def test_mistakes_are_located(head, message):
    """As everywhere in the file."""
    with pytest.raises(InputError) as caught:
        load(read_text(f"mission: m\n{head}\ntree: {{turn: {{angle: 9}}, timeout: 3}}\n", "m.yaml"))
    assert str(caught.value).startswith(message)
