"""Keys of missions that were renamed: the old ones are read, with a warning."""

import pytest

from bt_mission.core.diagnostics import InputError
from bt_mission.language.loader import load_text
from bt_mission.language.nodes.action import GoalNode

MISSION = """\
mission: m
limits: {answer_timeout: 3}
servers:
  turn: {silence_timeout: 4}
tree:
  turn: {angle: 90}
  timeout: 30
  answer_timeout: 5
  silence_timeout: 2
"""


def test_an_old_key_is_the_new_one_with_a_warning():
    """At a node, in the limits of the mission, and in those of a server."""
    mission = load_text(MISSION)
    new = load_text(
        MISSION.replace("answer_timeout", "acceptance_timeout").replace(
            "silence_timeout", "feedback_timeout"
        )
    )
    assert new.warnings == ()
    assert isinstance(mission.tree, GoalNode)
    assert (mission.tree.acceptance_timeout, mission.tree.feedback_timeout) == (5, 2)
    assert [str(one).splitlines()[0] for one in mission.warnings] == [
        "<text>:2:10: warning: 'answer_timeout' is deprecated; write 'acceptance_timeout'",
        "<text>:4:10: warning: 'silence_timeout' is deprecated; write 'feedback_timeout'",
        "<text>:8:3: warning: 'answer_timeout' is deprecated; write 'acceptance_timeout'",
        "<text>:9:3: warning: 'silence_timeout' is deprecated; write 'feedback_timeout'",
    ]


def test_both_names_of_a_key_are_an_error():
    """The old one is then no modifier."""
    text = MISSION.replace("  silence_timeout: 2", "  acceptance_timeout: 2")
    with pytest.raises(InputError, match="no modifier 'answer_timeout' for turn"):
        load_text(text)
