"""Who takes part: names that can be namespaces, each once."""

import pytest

from sim.entrants import MOST, Entrant, EntrantError, check


def test_a_robot_alone_needs_no_name(waffle):
    """Its parts and topics have no prefix."""
    check([Entrant(waffle)])
    assert Entrant(waffle).prefix == ""
    assert Entrant(waffle, "robot1").prefix == "robot1/"


@pytest.mark.parametrize(
    ("names", "words"),
    [
        ([], "expected 1 to 16 robots in a world, got 0"),
        (["", "b"], "expected a name of small letters"),
        (["a", "B-2"], "got 'B-2'"),
        (["a", "a"], "two robots are named 'a'"),
        ([f"r{n}" for n in range(MOST + 1)], "got 17"),
    ],
)
def test_several_have_a_name_each(waffle, names, words):
    """The message says which is wrong."""
    with pytest.raises(EntrantError, match=words):
        check([Entrant(waffle, name) for name in names])
