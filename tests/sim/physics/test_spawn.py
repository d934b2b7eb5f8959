"""Who takes part: names that can be namespaces, each once."""

import pytest

from sim.physics.spawn import MOST, RobotSpawn, RobotSpawnError, check, read
from sim.world.world import Spawn


def test_a_robot_alone_needs_no_name(waffle):
    """Its parts and topics have no prefix."""
    check([RobotSpawn(waffle)])
    assert RobotSpawn(waffle).prefix == ""
    assert RobotSpawn(waffle, "robot1").prefix == "robot1/"


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
    with pytest.raises(RobotSpawnError, match=words):
        check([RobotSpawn(waffle, name) for name in names])


def test_one_is_read_from_a_word():
    """Name, model and place; the yaw or the place may be left out."""
    full = read("one=waffle@-1,0.5,90")
    assert (full.name, full.robot.name, full.spawn) == ("one", "waffle", Spawn(x=-1, y=0.5, yaw=90))
    assert read("two=burger@1,2").spawn == Spawn(x=1, y=2)
    assert read("two=burger").spawn is None


@pytest.mark.parametrize(
    "text", ["waffle", "one=", "one=waffle@", "one=waffle@1", "one=waffle@1,2,3,4", "a=waffle@x,y"]
)
def test_a_word_that_is_none_is_told_what_was_expected(text):
    """With an example."""
    with pytest.raises(RobotSpawnError, match=r"such as one=waffle@-1,0,90, got"):
        read(text)
