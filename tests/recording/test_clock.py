"""Recordings of a graph with `/clock`: they begin at its time, and nothing in them is early."""

from __future__ import annotations

from collections import defaultdict
from pathlib import Path
from typing import Any

import pytest
from builtin_interfaces.msg import Time
from geometry_msgs.msg import TransformStamped
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from nav_msgs.msg import Odometry
from rosbags.highlevel import AnyReader
from rosgraph_msgs.msg import Clock
from tf2_msgs.msg import TFMessage

from bt_mission.base.stamps import NS, set_ns, to_ns
from bt_mission.recording.reader import read_run
from bt_mission.recording.writer import RunRecorder
from bt_mission.ros.graph import NodeOptions
from bt_mission.ros.mission_node import MissionNode
from bt_mission.ros.mission_runner import RunnerOptions
from bt_mission.sessions.load import load
from bt_mission.sessions.session import MissionRun, Session
from tests.support.live_rig import Live

START_NS = 1_217 * NS
MISSION = "mission: m\ntree: {wait: 0.2}\n"


class LiveSession(Session):
    """A mission whose steps a test takes."""

    def __init__(self, mission: MissionNode, live: Live) -> None:
        super().__init__()
        self.runs = (MissionRun.of(mission.runner),)
        self._live = live

    def step(self) -> None:
        """Have the recorder look."""
        self._call_onlookers()

    def _serve(self, node: Any) -> None:
        self._live.executor.add_node(node)

    def _drop(self, node: Any) -> None:
        self._live.executor.remove_node(node)
        node.destroy_node()


class Graph:
    """A mission that is recorded in a graph whose clock the test moves."""

    def __init__(self, live: Live, path: Path) -> None:
        self.live = live
        self.robot = live.node("robot")
        self.clock = self.robot.create_publisher(Clock, "/clock", 10)
        self.odometry = self.robot.create_publisher(Odometry, "/odom", 10)
        self.transforms = self.robot.create_publisher(TFMessage, "/tf", 10)
        options = RunnerOptions(has_presence=False)
        node = NodeOptions(context=live.context, use_sim_time=True)
        self.mission = MissionNode(load(MISSION), options, node=node)
        live.nodes.append(self.mission)
        live.executor.add_node(self.mission)
        self.session = LiveSession(self.mission, live)
        self.recorder = RunRecorder(self.session, path)
        live.until(lambda: self.odometry.get_subscription_count() and self.is_matched)

    @property
    def is_matched(self) -> bool:
        """Do mission and recorder read everything?"""
        return self.transforms.get_subscription_count() > 0 and (
            self.clock.get_subscription_count() >= 1
        )

    def move(self, time_ns: int) -> None:
        """Move the clock, and have the recorder look."""
        self.clock.publish(Clock(clock=set_ns(Time(), time_ns)))
        self.live.until(lambda: self.mission.get_clock().now().nanoseconds == time_ns)
        self.session.step()

    def send(self, time_ns: int) -> None:
        """Send measurements of an instant that the clock has not reached."""
        message = Odometry()
        set_ns(message.header.stamp, time_ns)
        self.odometry.publish(message)
        transform = TransformStamped()
        set_ns(transform.header.stamp, time_ns)
        self.transforms.publish(TFMessage(transforms=[transform]))
        self.session.step()


@pytest.fixture
def recorded(live: Live, tmp_path: Path) -> Path:
    """A mission in a graph whose clock has run for 1,217 s."""
    path = tmp_path / "run.mcap"
    graph = Graph(live, path)
    graph.session.step()
    for step in range(30):
        graph.send(START_NS + step * NS // 50)
        graph.move(START_NS + step * NS // 50)
        if step == 0:
            live.until(lambda: graph.mission.runner.executive.started_ns)
    assert graph.mission.runner.is_done
    graph.send(START_NS + NS)
    graph.recorder.finish(graph.mission.runner.report().as_dict())
    return path


def test_it_begins_at_the_time_of_the_clock(recorded: Path) -> None:
    """For our reader, that of mcap, and rosbags: no message and no attachment is at 0 s."""
    assert read_run(recorded).facts["start_ns"] == str(START_NS)
    with recorded.open("rb") as stream:
        reader = make_reader(stream)
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        assert summary.statistics.message_start_time == START_NS
        assert {attachment.log_time for attachment in reader.iter_attachments()} == {START_NS}
    with AnyReader([recorded]) as bag:
        assert bag.start_time == START_NS
        assert bag.duration <= 1.01 * NS


def test_no_message_is_earlier_than_its_header(recorded: Path) -> None:
    """Measurements that came ahead of `/clock` have the time of their stamp."""
    times = defaultdict(list)
    with recorded.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        for _, channel, message, decoded in reader.iter_decoded_messages(["/odom", "/tf"]):
            holder = decoded if channel.topic == "/odom" else decoded.transforms[0]
            times[channel.topic].append((message.log_time, to_ns(holder.header.stamp)))
    expected = [START_NS + step * NS // 50 for step in range(30)] + [START_NS + NS]
    assert dict(times) == {topic: [(at, at) for at in expected] for topic in ("/odom", "/tf")}
