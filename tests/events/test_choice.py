"""Which executive is meant."""

from __future__ import annotations

import pytest

from bt_mission.core.errors import BtMissionError
from bt_mission.events.choice import choose, nobody, wanted_name
from bt_mission.events.source import FoundExecutive

ONE, TWO = FoundExecutive("/robot1/bt_mission"), FoundExecutive("/robot2/bt_mission")


@pytest.mark.parametrize("text", ["robot1", "/robot1", "/robot1/", "/robot1/bt_mission"])
def test_a_namespace_or_a_name_will_do(text: str):
    """People type what they have at hand."""
    assert wanted_name(text) == "/robot1/bt_mission"


def test_the_executive_without_a_namespace_has_a_name_too():
    """`bt_mission` and `/` mean the same."""
    assert wanted_name("bt_mission") == wanted_name("/bt_mission") == "/bt_mission"
    assert wanted_name("/") == "/bt_mission"
    assert wanted_name(None) is None


def test_the_only_one_is_chosen():
    """Also by name among several."""
    assert choose([ONE], None) is ONE
    assert choose([ONE, TWO], "/robot2/bt_mission") is TWO
    assert choose([], None) is None
    assert choose([ONE], "/robot2/bt_mission") is None


def test_of_several_one_has_to_be_named():
    """The message lists them."""
    with pytest.raises(BtMissionError) as caught:
        choose([ONE, TWO], None)
    assert str(caught.value) == (
        "there are 2 executives: name one of /robot1/bt_mission, /robot2/bt_mission"
    )


def test_another_version_is_refused():
    """Its messages would be read as what they are not."""
    with pytest.raises(BtMissionError, match="/a/bt_mission: its Tree messages are of another"):
        choose(
            [FoundExecutive("/a/bt_mission", "its Tree messages are of another", is_foreign=True)],
            None,
        )


def test_nobody_there_is_told_with_what_was_looked_for():
    """And what can be watched; with the names of others that are there."""
    assert "no sign of an executive (ROS domain 7)" in nobody(None, [], "ROS domain 7")
    assert "--visible" in nobody(None, [], "")
    assert nobody("/b/bt_mission", [ONE], "x") == (
        "/b/bt_mission is not there (x); there is /robot1/bt_mission"
    )
