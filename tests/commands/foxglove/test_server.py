"""Topics of a stage, as a client of the protocol sees them that knows nothing of the server."""

from __future__ import annotations

import json
import re
import select
import socket
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

from bt_mission.base.errors import BtMissionError
from bt_mission.base.interface_files import share_folders
from bt_mission.base.wall_clock import Stopwatch
from bt_mission.cdr.definitions import Definitions, parse
from bt_mission.cli.web import NEEDED
from bt_mission.commands.foxglove import LAYOUT
from bt_mission.language.mission import Mission
from bt_mission.ros.graph import quiet_node
from bt_mission.sessions.load import load
from bt_mission.sessions.stage import Stage
from bt_mission.sessions.stage_robot import StageOptions
from tests.support.project import ROOT

if not all(find_spec(name) for name in NEEDED):
    pytest.skip("the extra 'web' is not installed", allow_module_level=True)

from bt_mission.commands.foxglove import server as server_module
from bt_mission.commands.foxglove.clients import Client
from bt_mission.commands.foxglove.server import FoxgloveServer
from bt_mission.views.web.guarded_server import FrameRate
from tests.commands.foxglove.client import FoxgloveClient
from tests.support.processes import PATIENCE_S

TURNS = """\
mission: turns
world: empty_arena
tree:
  sequence:
    - turn: {angle: 10}
    - wait: 0.1
"""
FOREVER = "mission: forever\nworld: empty_arena\ntree: {wait: 100000}\n"


class ServedStage:
    """A stage whose topics are served, stepped until a test has seen what it waits for."""

    def __init__(self, stage: Stage, server: FoxgloveServer, output: list[str]) -> None:
        self.stage, self.server, self.logged = stage, server, output

    def until(self, is_true: Callable[[], object], *clients: FoxgloveClient) -> None:
        """Step, and have clients take what comes, until something holds."""
        since = Stopwatch()
        while not is_true():
            assert since.elapsed_s < PATIENCE_S
            self.stage.step()
            for client in clients:
                client.take()

    def client_of(self, *topics: str) -> FoxgloveClient:
        """A client that is offered these topics, and subscribes to them."""
        client = FoxgloveClient(self.server.link)
        self.until(lambda: client.channels.keys() >= set(topics), client)
        client.subscribe(*topics)
        return client


def stage_of(mission: Mission, *, watched: bool = True) -> Stage:
    """A stage of a mission that makes no pictures."""
    options = StageOptions(watched=watched)
    return Stage(mission, image_folder=Path("unused"), say=lambda _: None, options=options)


@contextmanager
def served(mission: str | Mission = FOREVER) -> Iterator[ServedStage]:
    """A stage whose topics are served."""
    lines: list[str] = []
    result = load(mission) if isinstance(mission, str) else mission
    with stage_of(result) as stage:
        node = quiet_node("viewer", stage.node.context)
        server = FoxgloveServer(node, 0, lambda: stage.now_ns, lines.append)
        stage.attach(server)
        try:
            yield ServedStage(stage, server, lines)
        finally:
            stage.detach(server)
            server.close()


def test_a_client_gets_the_topics_it_subscribes_to():
    """With the types of recordings, every message as it was sent, marked with ROS time."""
    with served() as it, it.client_of("/odom", "/bt_mission/tree", "/map") as client:
        it.until(lambda: len(client.received["/odom"]) > 3, client)
        it.until(lambda: client.received["/map"] and client.received["/bt_mission/tree"], client)
        assert client.info["name"] == "bt-mission"
        assert client.info["capabilities"] == ["time"]
        offered = client.channels["/odom"]
        assert (offered["encoding"], offered["schemaEncoding"]) == ("cdr", "ros2msg")
        assert offered["schemaName"] == "nav_msgs/msg/Odometry"
        assert offered["schema"] == Definitions(share_folders()).of("nav_msgs/msg/Odometry")
        for time_ns, message in client.received["/odom"]:
            stamp = message.header.stamp
            assert time_ns == stamp.sec * 1_000_000_000 + stamp.nanosec
        (_, tree), *_ = client.received["/bt_mission/tree"]
        assert [node.name for node in tree.nodes] == ["wait"]
        (_, grid), *_ = client.received["/map"]
        assert len(grid.data) == grid.info.width * grid.info.height
        assert "/scan" in client.channels
        assert client.received.keys() == {"/odom", "/bt_mission/tree", "/map"}
        it.until(lambda: client.times, client)
        assert client.times[-1] <= it.stage.now_ns
        assert it.logged == []


def test_types_of_actions_have_the_names_that_every_reader_takes():
    """As in recordings: parsers of message definitions accept no underscore."""
    with served(TURNS) as it, it.client_of("/turn/_action/feedback") as client:
        name = client.channels["/turn/_action/feedback"]["schemaName"]
        assert name == "bt_mission_interfaces/msg/TurnFeedbackMessage"
        it.until(lambda: client.received["/turn/_action/feedback"], client)
        (_, first), *_ = client.received["/turn/_action/feedback"]
        assert hasattr(first.feedback, "current_angle")


def test_a_topic_costs_nothing_until_somebody_looks():
    """There is a subscription exactly while a client has one, also of one that leaves."""
    with served() as it:
        assert list(it.server.node.subscriptions) == []
        with it.client_of("/scan") as client:
            it.until(lambda: client.received["/scan"], client)
            topics = [subscription.topic_name for subscription in it.server.node.subscriptions]
            assert topics == ["/scan"]
        it.until(lambda: not list(it.server.node.subscriptions))


def test_who_comes_late_gets_what_is_latched():
    """The map and the tree were sent once, before anybody was there, or to others."""
    latched = ("/bt_mission/tree", "/map", "/tf_static")
    with served() as it, it.client_of(*latched) as first:
        it.until(lambda: all(first.received[topic] for topic in latched), first)
        with it.client_of(*latched) as second:
            it.until(lambda: all(second.received[topic] for topic in latched), first, second)


def test_what_comes_up_later_is_offered_and_what_goes_is_taken_back():
    """A node of the graph comes and goes."""
    from std_msgs.msg import Float64  # noqa: PLC0415 - as a test of its own node

    with served() as it, FoxgloveClient(it.server.link) as client:
        other = quiet_node("other", it.stage.node.context)
        publisher = other.create_publisher(Float64, "/level", 1)
        it.until(lambda: "/level" in client.channels, client)
        client.subscribe("/level")

        def is_heard() -> bool:
            publisher.publish(Float64(data=0.25))
            return bool(client.received["/level"])

        it.until(is_heard, client)
        assert client.received["/level"][0][1].data == 0.25
        other.destroy_node()
        it.until(lambda: "/level" not in client.channels, client)
        assert it.logged == []


def test_what_cannot_be_served_is_told_once_and_left_out(monkeypatch: pytest.MonkeyPatch):
    """A topic of several types, and one whose type is not installed; the others are served."""
    with served() as it:
        node = it.server.node
        topics, publishers = node.get_topic_names_and_types, node.get_publishers_info_by_topic
        odd = {"/strange": ["no_such/msg/Thing"], "/twice": ["std_msgs/msg/Bool", "a/msg/B"]}
        monkeypatch.setattr(node, "get_topic_names_and_types", lambda: [*topics(), *odd.items()])
        look_up = lambda topic: publishers("/odom" if topic in odd else topic)  # noqa: E731
        monkeypatch.setattr(node, "get_publishers_info_by_topic", look_up)
        it.until(lambda: it.logged)
        with it.client_of("/odom") as client:
            it.until(lambda: len(client.received["/odom"]) > 40, client)
            assert client.channels.keys().isdisjoint(odd)
    strange, twice = it.logged
    assert strange.startswith("/strange is not served: ")
    assert "no_such" in strange
    assert twice == ("/twice is not served: it has several types: a/msg/B, std_msgs/msg/Bool")


BUSY = ("/camera/image_raw", "/scan", "/odom", "/tf", "/turn/_action/feedback")


def trace_of(text: str, *, look: bool) -> str:
    """The trace of a run, which two clients look at: one reads, the other does not."""
    if not look:
        with stage_of(load(text), watched=False) as stage:
            while not stage.is_done:
                stage.step()
            return stage.trace.sha256
    with served(text) as it:
        with FoxgloveClient(it.server.link) as keen, FoxgloveClient(it.server.link) as idle:
            it.until(lambda: idle.channels.keys() >= set(BUSY), keen, idle)
            idle.subscribe(*idle.channels)
            keen.subscribe(*BUSY)
            it.until(lambda: it.stage.is_done, keen)
            assert keen.received["/camera/image_raw"]
        return it.stage.trace.sha256


def test_clients_change_nothing_of_a_run():
    """Its trace is the same, whoever looks, and however slowly."""
    assert trace_of(TURNS, look=True) == trace_of(TURNS, look=False)


UPGRADE = (
    "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
    "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n"
)
COMMANDS = {"id": 1, "topic": "/cmd_vel", "encoding": "cdr", "schemaName": "x"}
NONSENSE = [
    "{",
    "[]",
    '{"op": "xyz"}',
    b"\x07\x01",
    b"",
    b"\x01\x00\x00\x00\x00hi",
    {"op": "advertise", "channels": [COMMANDS]},
    {"op": "subscribe", "subscriptions": [{"id": 9, "channelId": 4_000_000}]},
    {"op": "setParameters", "parameters": [{"name": "speed", "value": 9}]},
    {"op": "fetchAsset", "uri": "file:///etc/passwd", "requestId": 1},
]


def test_nonsense_is_answered_and_changes_nothing(capfd: pytest.CaptureFixture[str]):
    """A client can neither send nor set anything, and nothing is written for what it tries."""
    with served() as it, it.client_of("/odom") as client:
        for words in NONSENSE * 20:
            client.send(words)
        it.until(lambda: len(client.statuses) >= 20 * len(NONSENSE), client)
        for operation in ("advertise", "setParameters", "fetchAsset"):
            assert f"this server does not support '{operation}'" in client.statuses
        count = len(client.received["/odom"])
        it.until(lambda: len(client.received["/odom"]) > count, client)
        published = [publisher.topic_name for publisher in it.server.node.publishers]
        assert published == ["/parameter_events"]  # which every node of rclpy has
        assert not it.server.is_broken
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize(("size", "kept"), [(10, 256), (1 << 20, 4), (8 << 20, 1)])
def test_what_waits_for_a_slow_client_is_bounded(size: int, kept: int):
    """In number and in bytes; the newest is always kept."""
    client = Client(None, {}, lambda _: None)
    for _ in range(300):
        client.put(bytes(size))
    assert client.waiting_bytes == kept * size


def test_silent_connections_keep_no_client_out(monkeypatch: pytest.MonkeyPatch):
    """The oldest are closed for it, and the mission goes on."""
    monkeypatch.setattr(server_module, "TURN_S", 0.0)
    with served() as it, ExitStack() as silent:
        address = ("127.0.0.1", int(it.server.link.rpartition(":")[2]))
        opened = []
        for _ in range(5):
            opened += [silent.enter_context(socket.create_connection(address)) for _ in range(40)]
            for _ in range(5):
                it.stage.step()
        with it.client_of("/odom") as client:
            it.until(lambda: client.received["/odom"], client)
            first = opened[0]
            it.until(lambda: select.select([first], [], [], 0.0)[0])
            assert first.recv(1) == b""


def test_a_client_that_floods_is_sent_away(monkeypatch: pytest.MonkeyPatch):
    """With a code; the others stay."""
    monkeypatch.setattr(server_module, "FRAMES", FrameRate(long_run_s=1.0, most=20))
    with served() as it, it.client_of("/odom") as good, it.client_of("/odom") as bad:
        for _ in range(100):
            bad.send(b"")
        it.until(lambda: bad.close_code is not None, good, bad)
        assert bad.close_code == 1008
        count = len(good.received["/odom"])
        it.until(lambda: len(good.received["/odom"]) > count, good)


@pytest.mark.parametrize(("path", "headers"), [("/", ""), ("/", UPGRADE), ("/x", "")])
def test_another_protocol_is_refused(path: str, headers: str):
    """A page of the web, a WebSocket without the protocol's name."""
    with served() as it:
        address = ("127.0.0.1", int(it.server.link.rpartition(":")[2]))
        with socket.create_connection(address) as stranger:
            words = f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1\r\n{headers}\r\n"
            stranger.sendall(words.encode())
            it.until(lambda: select.select([stranger], [], [], 0.0)[0])
            assert stranger.recv(100).startswith(b"HTTP/1.1 40")


def test_a_port_that_is_taken_is_told():
    """With what to do; only this machine reaches it, since the protocol knows no password."""
    with served() as it:
        assert it.server.link.startswith("ws://127.0.0.1:")
        port = int(it.server.link.rpartition(":")[2])
        why = f"--foxglove-port {port}: the port is in use; --foxglove-port "
        with pytest.raises(BtMissionError, match=why):
            FoxgloveServer(it.server.node, port, lambda: 0, print)


def test_what_fails_in_the_server_ends_nothing_else(monkeypatch: pytest.MonkeyPatch):
    """It is told once; the mission goes on."""
    with served() as it:
        monkeypatch.setattr(it.server, "_look", lambda: 1 / 0)
        for _ in range(3):
            it.stage.step()
        (output,) = it.logged
        assert output.startswith("the server for Foxglove failed: ZeroDivisionError")
        assert it.server.is_broken
        assert not it.stage.is_done


def follow(path: str, type_name: str, definition: str) -> None:
    """Follow a path of fields through a definition; fails where there is no such field."""
    specs = parse(type_name, definition)
    current = ""
    for name in filter(None, path.split(".")):
        result = {spec.name: spec.type for spec in specs[current]}
        assert name in result, path
        current = result[name]


def paths_in(layout: Any) -> set[str]:
    """Every topic and path of a message that a layout names."""
    if isinstance(layout, dict):
        below = (paths_in(part) for part in layout.values())
        return {key for key in layout if key.startswith("/")}.union(*below)
    if isinstance(layout, list):
        return set().union(*(paths_in(part) for part in layout))
    return {layout} if isinstance(layout, str) and layout.startswith("/") else set()


def test_the_layout_shows_what_is_served(monkeypatch: pytest.MonkeyPatch):
    """Each topic that a panel names is there, and each field of it."""
    layout = json.loads(LAYOUT.read_text("utf-8"))
    paths = paths_in(layout["configById"]) - {"/rosout"}  # of graphs that have one, and recordings
    wanted = {re.sub(r"\..*", "", path) for path in paths}
    monkeypatch.chdir(ROOT)
    with served(load(Path("missions/patrol.yaml"))) as it, it.client_of(*wanted) as client:
        for path in paths:
            topic, _, fields = path.partition(".")
            channel = client.channels[topic]
            follow(fields, channel["schemaName"], channel["schema"])


def panels_in(layout: Any) -> list[str]:
    """Panels of the arrangement, those in tabs, too."""
    if isinstance(layout, str):
        return [layout]
    return [*panels_in(layout["first"]), *panels_in(layout["second"])]


def test_the_layout_arranges_each_of_its_panels_once():
    """Another makes the application show an empty place."""
    layout = json.loads(LAYOUT.read_text("utf-8"))
    panels = panels_in(layout["layout"])
    for config in layout["configById"].values():
        panels += [panel["layout"] for panel in config.get("tabs", ())]
    assert sorted(panels) == sorted(layout["configById"])
