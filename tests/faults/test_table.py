"""The table of faults: every fault that tests have, as it can be written."""

from __future__ import annotations

from bt_mission.core.units import UNITS
from bt_mission.faults import FAULTS, Faults
from bt_mission.faults.world import OF_THE_WORLD, WorldFaults
from bt_mission.testing.generators.faults import DRAWN, IN_LEAVES, OF_A_BOX
from bt_mission.testing.generators.kinds import GROUPS


def test_every_fault_of_tests_is_in_the_table() -> None:
    """`clear` is none."""
    public = {
        name
        for base in Faults.__mro__
        for name, method in vars(base).items()
        if callable(method) and hasattr(method, "__wrapped__")
    }
    assert set(FAULTS) == public
    assert set(FAULTS) >= {*DRAWN, *IN_LEAVES}


def test_the_faults_of_the_world_are_named() -> None:
    """Of a fleet, each is for one robot."""
    assert set(OF_THE_WORLD) == {name for name in vars(WorldFaults) if name in FAULTS}


def test_every_fault_and_every_number_says_what_it_is() -> None:
    """A number has a unit, or its text tells of it: a share, a count, a code."""
    bare = {"share", "every", "times", "goals", "on", "code", "grip"}
    relative = {"left_radius", "right_radius", "separation"}
    for kind in FAULTS.values():
        assert kind.text.endswith(".")
        for one in kind.parameters.values():
            if one.form in ("number", "integer", "numbers") and not one.unit:
                assert one.name in bare | relative or kind.name == "camera_noise", one


def test_every_unit_can_be_written_behind_its_number() -> None:
    """And a search has a group for each fault that it may draw."""
    units = {one.unit for kind in FAULTS.values() for one in kind.parameters.values()}
    assert units - {""} <= set(UNITS)
    grouped = {name for group in GROUPS.values() for name in group}
    assert {*DRAWN, *IN_LEAVES} - {*OF_A_BOX, "spawn_box", "spawn_cylinder"} == grouped


def test_how_a_fault_is_written_shows_units_and_choices() -> None:
    """Arguments by position stand without their names."""
    assert FAULTS["delay"].usage == (
        "delay TOPIC <by s> [jitter s] [in_order false] [receiver RECEIVER] [lasting s]"
    )
    assert FAULTS["push"].usage == "push [<ahead N>] [<left N>] [seconds s] [torque Nm]"
    assert FAULTS["block_wheel"].usage == "block_wheel left|right|both [lasting s]"
    assert FAULTS["fail_service"].usage == "fail_service SERVICE [FIELD=VALUE]... [lasting s]"


def test_what_only_python_can_give_is_left_out() -> None:
    """Exceptions and functions."""
    assert list(FAULTS["raise_in_leaf"].parameters) == ["leaf", "method", "on"]
    assert list(FAULTS["abort_goal"].parameters) == ["action", "code", "message"]
    assert FAULTS["corrupt"].parameters["how"].choices[0] == "nan"


def test_arguments_carry_what_their_docstring_says() -> None:
    """For the documentation and for editors."""
    assert FAULTS["drop"].parameters["every"].text == (
        "Lose each so-manieth message instead, beginning with the first."
    )
