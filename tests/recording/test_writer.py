"""Runs on the stage, recorded, and read by another client."""

from __future__ import annotations

import hashlib
import json
from collections import Counter
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rclpy.node import Node
from rosbags.convert.converter import convert
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore
from std_msgs.msg import Float64

import bt_mission
from bt_mission import read_recording
from bt_mission.base.files import names
from bt_mission.base.stamps import to_ns
from bt_mission.cdr.definitions import NoDefinitionError, definition_of
from bt_mission.executive.events.events import ClockJumped, StateChanged
from bt_mission.executive.events.log import INFO, WARN, rosout_line
from bt_mission.recording import writer
from bt_mission.recording.contents import files_of
from bt_mission.recording.file import McapFile
from bt_mission.sessions.load import load
from bt_mission.sessions.stage import Stage
from tests.recording.test_file import FullDisk
from tests.support.recorded_runs import TWO_TURNS, messages_for_others, summary_of
from tests.support.thorough import sample

S = 1_000_000_000


def data_of(path: Path, topic: str) -> list[Any]:
    """The field ``data`` of each message of a topic."""
    return [each.message.data for each in messages_for_others(path, topic)]


def bare_trace(text: str, folder: Path) -> str:
    """The trace of a run that nobody records."""
    with Stage(load(text), image_folder=folder, say=lambda _: None) as stage:
        while not stage.is_done:
            stage.step()
        return stage.trace.sha256


@pytest.mark.thorough
@pytest.mark.parametrize("name", sample(names("missions"), every=99))
def test_others_read_every_message_of_each_mission(record: Callable[..., Any], name: str) -> None:
    """All of them, to the last byte; and times that never go back."""
    run = record(name)
    messages = messages_for_others(run.path)
    assert len(messages) == run.recorder.file.messages
    assert run.recorder.missing == ""
    times = [message.time_ns for message in messages]
    assert times == sorted(times)
    assert times[0] == S


@pytest.mark.thorough
def test_mcap_ros2_support_reads_every_message(record: Callable[..., Any]) -> None:
    """As it is: goals, results, cancels and feedback among them."""
    run = record("explore")
    with run.path.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        messages = [
            (schema.name, channel.topic)
            for schema, channel, _, _ in reader.iter_decoded_messages()
            if schema is not None
        ]
    assert len(messages) == run.recorder.file.messages
    assert {
        ("bt_mission_interfaces/msg/TurnFeedbackMessage", "/turn/_action/feedback"),
        ("bt_mission_interfaces/msg/TurnSendGoalEvent", "/turn/_action/send_goal/_service_event"),
        ("bt_mission_interfaces/msg/TurnGetResultEvent", "/turn/_action/get_result/_service_event"),
    } < set(messages)


@pytest.mark.thorough
def test_rosbags_converts_a_recording(record: Callable[..., Any], tmp_path: Path) -> None:
    """To the other storage of rosbag2, message by message."""
    run = record()
    typestore = get_typestore(Stores.EMPTY)
    convert(
        [run.path],
        tmp_path / "bag",
        dst_storage="sqlite3",
        dst_version=9,
        compress=None,
        compress_mode="file",
        default_typestore=typestore,
        typestore=None,
        exclude_topics=[],
        include_topics=[],
        exclude_msgtypes=[],
        include_msgtypes=[],
    )
    with Reader(tmp_path / "bag") as bag:
        assert bag.message_count == run.recorder.file.messages


def test_raw_actions_keep_the_names_of_ros(record: Callable[..., Any]) -> None:
    """And the file tells the same of its goals."""
    goals = []
    for raw_actions in (False, True):
        path = record(raw_actions=raw_actions).path
        schemas = {schema.name for schema in summary_of(path).schemas.values()}
        assert ("bt_mission_interfaces/action/Turn_SendGoal_Event" in schemas) is raw_actions
        lives = read_recording(path).goals
        goals.append([(goal.type_name, goal.values["angle"], goal.status) for goal in lives])
    assert goals[0] == goals[1]
    assert goals[0][0][0] == "bt_mission_interfaces/action/Turn"


def test_attachments_are_named_from_the_folder_of_the_mission(tmp_path: Path) -> None:
    """Not by the folders of this machine, however the mission was named."""
    (tmp_path / "parts").mkdir()
    (tmp_path / "m.yaml").write_text("mission: m\ninclude: [parts/w.yaml]\ntree:\n  tree: w\n")
    (tmp_path / "parts" / "w.yaml").write_text("trees:\n  w:\n    do: {wait: 0.1}\n")
    mission = load(tmp_path / "m.yaml")
    assert Path(mission.file).is_absolute()
    assert [name for name, _ in files_of(mission)] == ["m.yaml", "parts/w.yaml"]


def test_the_run_is_the_same_with_and_without(record: Callable[..., Any], tmp_path: Path) -> None:
    """Bit for bit, also when pictures are drawn that nobody else wants."""
    bare = bare_trace(TWO_TURNS, tmp_path)
    assert record().trace == bare
    assert record(camera="compressed").trace == bare


@pytest.mark.thorough
def test_everything_is_there_at_its_rate(record: Callable[..., Any]) -> None:
    """What the robot says, what moves it, and what the mission does."""
    run = record()
    counts = Counter(message.topic for message in messages_for_others(run.path))
    seconds = (run.stage.now_ns - S) / S
    for topic in ("odom", "imu", "joint_states", "battery_state", "ground_truth/odom", "tf"):
        assert counts[f"/{topic}"] == pytest.approx(20 * seconds, abs=2), topic
    assert counts["/scan"] == pytest.approx(10 * seconds, abs=2)
    assert counts["/cmd_vel"] > 20
    assert counts["/turn/_action/feedback"] > 20
    assert (counts["/map"], counts["/tf_static"], counts["/motors_on"]) == (1, 1, 1)
    assert counts["/bt_mission/tree"] == 1
    assert counts["/bt_mission/changes"] >= 3
    assert not [topic for topic in counts if topic.startswith("/camera")]
    assert "/clock" not in counts


def test_each_message_has_the_time_of_its_instant(record: Callable[..., Any]) -> None:
    """That of its stamp, where a sensor has just made it."""
    topics = ("/scan", "/odom", "/imu", "/ground_truth/odom", "/cmd_vel")
    stamped = messages_for_others(record().path, *topics)
    assert len(stamped) > 200
    assert all(each.time_ns == to_ns(each.message.header.stamp) for each in stamped)


def test_the_trace_in_the_file_is_that_of_the_run(record: Callable[..., Any]) -> None:
    """So its hash can be computed from the file."""
    run = record()
    text = "".join(f"{line}\n" for line in data_of(run.path, "/bt_mission/trace"))
    assert hashlib.sha256(text.encode()).hexdigest() == run.trace


def test_goals_are_service_events(record: Callable[..., Any]) -> None:
    """Request and answer each, in the form of ROS's own service introspection."""
    path = record().path
    sent, results = (
        [each.message for each in messages_for_others(path, f"/turn/_action/{name}/_service_event")]
        for name in ("send_goal", "get_result")
    )
    kinds = [(item.info.event_type, item.info.sequence_number) for item in sent]
    assert kinds == [(0, 1), (3, 1), (0, 2), (3, 2)]
    assert [item.request[0].goal.angle for item in sent] == [90.0, 90.0, -45.0, -45.0]
    assert [item.response[0].accepted for item in sent[1::2]] == [True, True]
    assert [result.response[0].status for result in results[1::2]] == [4, 4]
    assert results[1].response[0].result.angle_turned == pytest.approx(90, abs=1)


def test_what_the_mission_says_is_a_log(record: Callable[..., Any]) -> None:
    """On the topic and in the form in which tools look for logs."""
    lines = [each.message for each in messages_for_others(record().path, "/rosout")]
    assert (20, "off we go") in [(line.level, line.msg) for line in lines]
    assert lines[-1].msg == "mission: success"


def test_the_file_holds_the_mission_and_what_it_came_to(record: Callable[..., Any]) -> None:
    """As an attachment, and as metadata at both ends."""
    run = record()
    with run.path.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        attached = {attachment.name: attachment.data for attachment in reader.iter_attachments()}
        notes = {entry.name: entry.metadata for entry in reader.iter_metadata()}
    assert attached.pop("<text>").decode() == TWO_TURNS
    source = Path(__file__).parents[2]
    for name in ("worlds/empty_arena.yaml", "robots/waffle.yaml"):
        assert attached.pop(name) == (source / name).read_bytes()
    assert attached.keys() == {"simulation.mjb.gz"}
    assert notes["bt_mission"]["seed"] == "3"
    assert notes["bt_mission"]["world"] == "empty_arena"
    assert "mujoco" in json.loads(notes["bt_mission"]["versions"])
    assert json.loads(notes["bt_mission_summary"]["status"]) == "success"
    assert json.loads(notes["bt_mission_summary"]["trace_sha256"]) == run.trace


def test_qos_is_written_as_rosbag2_does(record: Callable[..., Any]) -> None:
    """A player needs to know what is latched."""
    channels = summary_of(record().path).channels.values()
    offers = {channel.topic: channel.metadata["offered_qos_profiles"] for channel in channels}
    assert "durability: transient_local" in offers["/tf_static"]
    assert "reliability: best_effort" in offers["/scan"]
    assert "depth: 10\n  reliability: reliable\n  durability: volatile" in offers["/odom"]


@pytest.mark.egl
@pytest.mark.parametrize(
    ("camera", "topic"), sample([("compressed", "/compressed"), ("raw", "")], 9)
)
def test_pictures_are_recorded_on_demand(
    record: Callable[..., Any], camera: str, topic: str
) -> None:
    """Small, or as they are."""
    run = record(camera=camera, steps=40)
    run.recorder.close()
    sent = messages_for_others(run.path, f"/camera/image_raw{topic}")
    pictures = [each.message for each in sent]
    assert len(pictures) >= 15
    if camera == "compressed":
        assert pictures[0].format == "rgb8; jpeg compressed bgr8"
        assert bytes(pictures[0].data[:2]) == b"\xff\xd8"
    else:
        assert (pictures[0].width, pictures[0].height) == (320, 240)


@pytest.mark.thorough
@pytest.mark.egl
def test_saved_pictures_are_taken_in(record: Callable[..., Any]) -> None:
    """With the names that they have below the run's folder."""
    run = record("sweep")
    with run.path.open("rb") as stream:
        attached = {
            attachment.name: attachment.data
            for attachment in make_reader(stream).iter_attachments()
        }
    pictures = {name: data for name, data in attached.items() if name.endswith(".png")}
    assert len(pictures) == 6
    folder = run.stage.image_folder
    assert all((folder / name).read_bytes() == data for name, data in pictures.items())


def test_a_full_disk_does_not_end_the_mission(record: Callable[..., Any], tmp_path: Path) -> None:
    """It goes on as if nothing were recorded, and what is missing is said."""
    file = McapFile(tmp_path / "run.mcap", "test", FullDisk(100_000))
    run = record(file=file)
    assert run.status == "success"
    assert run.trace == bare_trace(TWO_TURNS, tmp_path)
    assert run.recorder.missing.startswith("everything after ")
    assert run.recorder.missing.endswith(" s (No space left on device)")


def test_a_recorder_that_fails_does_not_end_the_mission(
    record: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever goes wrong in it, wherever it is called from."""

    def fail(*_: object) -> None:
        raise ValueError("broken")

    monkeypatch.setattr(McapFile, "write", fail)
    run = record()
    assert run.status == "success"
    assert run.trace == bare_trace(TWO_TURNS, tmp_path)
    assert "the recorder failed: ValueError: broken (" in run.recorder.missing


@pytest.mark.thorough
def test_a_topic_whose_type_is_not_installed_is_named(
    record: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The others are recorded."""

    def without_scans(type_name: str) -> str:
        if type_name.endswith("/LaserScan"):
            raise NoDefinitionError(f"the definition of {type_name} is not installed")
        return definition_of(type_name)

    monkeypatch.setattr(writer, "definition_of", without_scans)
    run = record()
    missing = "/scan (the definition of sensor_msgs/msg/LaserScan is not installed)"
    assert run.recorder.missing == missing
    counts = Counter(message.topic for message in messages_for_others(run.path))
    assert counts["/scan"] == 0
    assert counts["/odom"] > 20


@pytest.mark.thorough
def test_a_topic_that_a_users_own_node_publishes_too(
    record: Callable[..., Any], tmp_path: Path
) -> None:
    """Its messages are recorded, and each of the others is, once, as without that node."""
    topic, sent = "total_distance", 0
    with Stage(load(TWO_TURNS), image_folder=tmp_path, say=lambda _: None) as stage:
        with bt_mission.record(stage, tmp_path / "own.mcap") as recorder:
            node = Node("own", context=stage.context)
            stage.add_node(node)
            publisher = node.create_publisher(Float64, topic, 10)
            while not stage.is_done:
                stage.step()
                if stage.now_ns > 3.1 * S:  # after its look at what is new
                    publisher.publish(Float64(data=-1.0))
                    sent += 1
            recorder.finish({})
        stage.clock.remove_node(node)
        node.destroy_node()
    values = data_of(tmp_path / "own.mcap", f"/{topic}")
    assert [value for value in values if value >= 0] == data_of(record().path, f"/{topic}")
    assert values.count(-1.0) == sent > 10


def test_a_closed_recorder_leaves_no_trace(record: Callable[..., Any]) -> None:
    """The session goes on without it."""
    run = record(steps=20)
    listeners = len(run.stage.executive.events)
    run.recorder.close()
    assert len(run.stage.executive.events) == listeners - 1
    before = run.recorder.file.messages
    run.recorder.close()
    assert not len(run.stage.trace.lines)
    assert not len(run.stage.runner.exchanges)
    while not run.stage.is_done:
        run.stage.step()
    assert run.recorder.file.messages == before


def test_a_mission_that_waits_for_a_listener_waits_on(
    record: Callable[..., Any], tmp_path: Path
) -> None:
    """The recorder is nobody to talk to, and still hears what is said to nobody."""
    text = (
        "mission: m\nworld: empty_arena\ntree:\n  sequence:\n"
        "    - publish: {topic: /lamp, type: std_msgs/msg/Bool, message: {data: true}}\n"
        "      readers: {readers}\n      server_timeout: 2\n    - wait: 0.1\n"
    )
    assert record(text=text.replace("{readers}", "1")).status == "failure"
    run = record(text=text.replace("{readers}", "0"))
    assert run.status == "success"
    assert data_of(run.path, "/lamp") == [True]


IMAGES = """\
mission: images
world: empty_arena
tree:
  sequence:
    - take_pictures: {nseconds: 2}
      timeout: 10
      outputs: {all_pictures: pictures}
    - set: {sides: [1, 2.5]}
    - wait: 0.5
"""


def test_a_variable_that_holds_messages_does_not_end_the_recording(
    record: Callable[..., Any],
) -> None:
    """It is left out of the signals; what comes after it is recorded, lists of numbers too."""
    run = record(text=IMAGES)
    assert run.recorder.missing == ""
    lines = data_of(run.path, "/bt_mission/signals")
    values = [name for line in lines for name in json.loads(line).get("values", {})]
    assert "$pictures" not in values
    assert "$sides" in values


def test_what_happens_between_two_ticks_is_said() -> None:
    """Pauses, and what was done to the clock."""
    paused, resumed = (StateChanged(1, "r", "m", word, "by hand") for word in ("paused", "running"))
    assert rosout_line(paused, ()) == (WARN, "paused: by hand")
    assert rosout_line(resumed, ()) == (INFO, "resumed")
    assert rosout_line(ClockJumped(1, -9.5), ()) == (WARN, "the ROS clock was set back by 9.5 s")
    assert rosout_line(ClockJumped(1, 100.0), ()) == (WARN, "the ROS clock skipped 100 s")


def test_details_are_told_twice_a_second_and_when_something_happens(
    record: Callable[..., Any],
) -> None:
    """By the mission's clock: progress, and each state of a goal until it has ended."""
    messages = messages_for_others(record().path, "/bt_mission/details")
    times = [message.time_ns for message in messages]
    assert all(0 <= after - before <= 550_000_000 for before, after in pairwise(times))
    values = [node.value for message in messages for node in message.message.running if node.limit]
    assert len(values) > 5
    states: dict[str, list[str]] = {}
    for message in messages:
        for goal in message.message.goals:
            states.setdefault(goal.owner, []).append(goal.state)
    assert [state[-1] for state in states.values()] == ["succeeded", "succeeded"]
    assert "active" in states["back"]


def test_the_first_details_have_every_variable(record: Callable[..., Any]) -> None:
    """Later ones have those that have changed."""
    text = """\
mission: m
world: empty_arena
inputs: {a: 1, b: two}
tree: {sequence: [{set: {c: 2}}, {wait: 3}]}
"""
    messages = messages_for_others(record(text=text).path, "/bt_mission/details")
    results = [
        [(variable.name, variable.value) for variable in each.message.variables]
        for each in messages
    ]
    assert ("b", '"two"') in results[0]
    assert sum(("b", '"two"') in result for result in results) == 1
