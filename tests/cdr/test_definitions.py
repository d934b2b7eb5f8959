"""Definitions of messages, as bags carry them."""

from __future__ import annotations

from pathlib import Path

import pytest
from rosbags.typesys import get_types_from_msg

from bt_mission.base.interface_files import share_folders
from bt_mission.cdr.definitions import SEPARATOR, Definitions, NoDefinitionError
from bt_mission.ros.interface_types import installed

DEFINITIONS = Definitions(share_folders())
ACTION_PARTS = ("_FeedbackMessage", "_SendGoal_Event", "_GetResult_Event")


def write(share: Path, package: str, file: str, text: str) -> None:
    """Make a file of an interface package."""
    path = share / package / file
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")


def test_what_a_message_is_made_of_follows_it_once_each(tmp_path: Path) -> None:
    """In the order in which it is met; ``Header`` alone is that of std_msgs."""
    write(tmp_path, "a", "msg/Top.msg", "Header header\nInner[<=3] inners  # some\nb/Far far\n")
    write(tmp_path, "a", "msg/Inner.msg", "string<=5 name\nb/msg/Far[2] pair\nint32 X=3\n")
    write(tmp_path, "b", "msg/Far.msg", "float64[] values\n")
    write(tmp_path, "std_msgs", "msg/Header.msg", "string frame_id\n")
    assert Definitions([tmp_path]).of("a/msg/Top") == (
        "Header header\nInner[<=3] inners  # some\nb/Far far\n"
        f"{SEPARATOR}\nMSG: std_msgs/Header\nstring frame_id\n"
        f"{SEPARATOR}\nMSG: a/Inner\nstring<=5 name\nb/msg/Far[2] pair\nint32 X=3\n"
        f"{SEPARATOR}\nMSG: b/Far\nfloat64[] values\n"
    )


def test_an_actions_feedback_is_put_together(tmp_path: Path) -> None:
    """Of the part of the file that is its feedback, and of the goal's id."""
    write(tmp_path, "a", "action/Do.action", "int32 g\n---\nint32 r\n---\nfloat32 f\n")
    write(tmp_path, "unique_identifier_msgs", "msg/UUID.msg", "uint8[16] uuid\n")
    assert Definitions([tmp_path]).of("a/action/Do_FeedbackMessage") == (
        "unique_identifier_msgs/UUID goal_id\na/Do_Feedback feedback\n"
        f"{SEPARATOR}\nMSG: unique_identifier_msgs/UUID\nuint8[16] uuid\n"
        f"{SEPARATOR}\nMSG: a/Do_Feedback\nfloat32 f\n"
    )


@pytest.mark.parametrize(
    ("type_name", "missing"),
    [("a/msg/Nothing", "a/Nothing"), ("a/msg/Top", "a/Gone"), ("a/srv/No_Event", "service_msgs")],
)
def test_what_is_not_installed_is_named(tmp_path: Path, type_name: str, missing: str) -> None:
    """Also where only a part of the message is not there."""
    write(tmp_path, "a", "msg/Top.msg", "Gone gone\n")
    with pytest.raises(NoDefinitionError, match=f"definition of {missing}"):
        Definitions([tmp_path]).of(type_name)


@pytest.mark.thorough
def test_an_independent_parser_reads_every_definition_that_is_installed_here() -> None:
    """Messages, and what services and actions are made of."""
    names = [
        *installed("msg"),
        *(f"{name}_Event" for name in installed("srv")),
        *(f"{name}{part}" for name in installed("action") for part in ACTION_PARTS),
    ]
    assert len(names) > 200
    for name in names:
        assert get_types_from_msg(DEFINITIONS.of(name), name)
