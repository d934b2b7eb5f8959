"""Goals, sensor messages and interruptions that our action servers get, from whomever.

A case is a program of bytes. Sensor messages are taken as they come by DDS, serialized, so they may
also have the wrong length.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import nullcontext
from functools import cache
from pathlib import Path
from random import Random
from types import SimpleNamespace
from typing import Any

from nav_msgs.msg import OccupancyGrid, Odometry
from rclpy.serialization import serialize_message
from sensor_msgs.msg import Image, JointState, LaserScan
from tf2_msgs.msg import TFMessage

from action_servers.core.action import ServerContext, action
from action_servers.core.governor import Governor
from action_servers.core.maneuver import Refusal
from action_servers.core.pilot import ManeuverOutcome, ManeuverRun, Pilot
from action_servers.robot_io.messages import fill, generated_type
from action_servers.robot_io.sensors import SensorSubscriptions, SensorWiring
from bt_mission.base.actions import declared
from bt_mission.base.errors import BtMissionError
from bt_mission.base.geometry import Twist2D
from bt_mission.base.stamps import set_ns
from bt_mission.language.message_types import ListOf, MessageShape, Scalar, Shape
from bt_mission.robots.model import load_robot
from bt_mission.ros import interface_types
from tests.support.fuzz.finding import Case, Verdict
from tests.support.fuzz.program import ProgramPlay
from tests.support.fuzz.targets import Target

S = 1_000_000_000
STEPS_NS = (S // 20, S // 20, S // 20, S // 10, 0, S, 10 * S, -S // 20, -S)
SANE = (0.0, 1.0, 0.2, 0.3, -0.5, 2.0, 90.0, -45.0, 0.1, 5.0, 0.05, 30.0)
HOSTILE = (math.nan, math.inf, -math.inf, 1e30, -1e30, 1e-30, 5e-324, 1.7e308, -1.7e308, 3.4e38)
INTEGERS = (0, 1, 2, 5, 30, -1, 2**31 - 1, -(2**31), 2**32 - 1, 255, 127)
TEXTS = ("", "map", "odom", "base_link", "lidar", "red", "rgb8", "x" * 300, "é", "../../x", "\x00")
USUAL = {"behavior_tree": "", "frame_id": "map", "colour": "red", "angular_velocity": 0.5}
"""Of some fields, without which no goal is accepted."""

UPRIGHT = ({"w": 1.0, "z": 0.0}, {"w": 0.0, "z": 1.0}, {"w": 0.6, "z": 0.8})
MOST_ELEMENTS = 5
LONGEST = 150

_CLEAR = ("image encoding must be", "an image of")
"""How errors begin that are meant for people, and are not of our own class."""


class _Clock(nullcontext[None]):
    def __init__(self) -> None:
        super().__init__()
        self.now_ns = 10 * S
        self.handle, self.get_now = self, self.now

    def now(self) -> Any:
        return SimpleNamespace(nanoseconds=self.now_ns)


class _Node:
    """As much of a node as listens to topics."""

    def __init__(self) -> None:
        self.clock = _Clock()
        self.topics: dict[str, tuple[Any, Callable[[Any], None]]] = {}

    def create_subscription(self, kind: Any, topic: str, take: Any, *_: Any, **__: Any) -> Any:
        self.topics[topic] = kind, take
        return topic

    def destroy_subscription(self, topic: str) -> None:
        self.topics.pop(topic, None)

    def resolve_topic_name(self, topic: str) -> str:
        return f"/{topic}"

    def count_publishers(self, _: str) -> int:
        return 1

    def get_clock(self) -> _Clock:
        return self.clock

    def get_logger(self) -> Any:
        """Return a logger that says nothing."""
        return SimpleNamespace(warning=lambda *_, **__: False)


SENSED = (Odometry, LaserScan, OccupancyGrid, TFMessage, Image, JointState)
"""The messages of sensors."""


@cache
def _robot() -> Any:
    return load_robot("waffle_arm")


@cache
def _shape(kind: Any) -> MessageShape:
    return interface_types.shape_of(kind)


def _check_positions(_names: Any, positions: Any, *_: Any) -> None:
    assert all(map(math.isfinite, positions)), "a position that is no number"


class Play(ProgramPlay):
    """The servers of one robot, and what happens to them."""

    def __init__(self, contents: bytes) -> None:
        super().__init__(contents)
        self.node = _Node()
        robot: Any = _robot()
        self.sensors = SensorSubscriptions(self.node, SensorWiring(), robot)  # type: ignore[arg-type]
        self.context = ServerContext(
            robot=robot,
            tuning=lambda defaults: defaults,
            camera=self.sensors.camera,
            image_folder=Path("images"),
            publish=lambda *_: None,
            joints=SimpleNamespace(send=_check_positions),
        )
        self.pilot = Pilot(
            self.sensors.observe, self._command, Governor(robot), replaces=self.program.chance(0.8)
        )
        self.actions = tuple(action(name) for name in declared())
        self.running: list[ManeuverRun] = []
        for kind in (Odometry, LaserScan, OccupancyGrid, TFMessage, JointState):
            self._deliver(kind, serialize_message(self._sane(kind)))

    def is_clear(self, error: Exception) -> bool:
        return isinstance(error, BtMissionError) or str(error).startswith(_CLEAR)

    def run(self) -> None:
        acts = (
            *(self._goal, self._step, self._step, self._step, self._sense, self._sense),
            *(self._sense_sane, self._sense_sane, self._interrupt),
        )
        self.log.append(self._goal())
        while self.program:
            self.log.append(self.program.pick(acts)())
        self.pilot.stop("enough")
        assert self.pilot.idle, "a maneuver goes on after a stop"

    # ---- what can happen -----------------------------------------------------------------

    def _goal(self) -> str:
        action = self.program.pick(self.actions)
        kind = generated_type(action.type)
        goal = interface_types.fill(kind.Goal(), self._value(_shape(kind.Goal)))
        now = self.sensors.observe(on_map="map" in action.needs)
        planned = action.planned(goal, now, self.context)
        if isinstance(planned, Refusal):
            assert planned.reason, "a goal is refused without a reason"
            return f"{action.name} refused: {planned.reason[:200]}"
        why = self.pilot.refusal(needs_base=planned.needs_base, part=action.part)
        if why is not None:
            return f"{action.name} refused: {why}"
        self._start(action, kind, planned)
        return f"{action.name} began: {goal}"[:500]

    def _start(self, action: Any, kind: Any, planned: Any) -> None:
        if hasattr(planned, "store"):
            planned.store.save = lambda *_: None  # no pictures on the disk

        def on_feedback(fields: Any) -> None:
            serialize_message(self._filled(kind.Feedback(), fields))

        def on_end(outcome: ManeuverOutcome) -> None:
            self.running.remove(run)
            self.log.append(f"{action.name} {outcome.status}: {outcome.reason[:200]}")
            serialize_message(self._filled(kind.Result(), outcome.result or {}))
            cause = outcome.cause
            if cause is not None and not self.is_clear(cause):
                raise cause

        run = ManeuverRun(planned, on_feedback, on_end, part=action.part)
        self.running.append(run)
        self.pilot.start(run)

    def _filled(self, message: Any, fields: Any) -> Any:
        return fill(message, fields, lambda: set_ns(Odometry().header.stamp, 0))

    def _step(self) -> str:
        self.node.clock.now_ns = max(self.node.clock.now_ns + self.program.pick(STEPS_NS), 0)
        self.pilot.step()
        return f"step at {self.node.clock.now_ns / S} s"

    def _interrupt(self) -> str:
        match self.program.byte() % 6:
            case 0 if self.running:
                self.pilot.cancel(self.program.pick(self.running))
                return "cancel"
            case 1:
                self.pilot.hold()
                return "hold"
            case 2:
                self.pilot.release()
                return "release"
            case 3:
                self.pilot.stop("stopped")
                return "stop"
        return "nothing"

    def _sense(self) -> str:
        kind = self.program.pick(SENSED)
        message = interface_types.fill(kind(), self._value(_shape(kind)))
        if self.program.chance(0.5):
            message = self._sane(kind)
            self._spoil(message)
        data = bytearray(serialize_message(message))
        if self.program.chance(0.2):
            at = self.program.byte() * 256 + self.program.byte()
            if self.program.chance(0.5):
                del data[at % (len(data) + 1) :]
            else:
                data[at % len(data)] ^= 1 << self.program.byte() % 8
        self._deliver(kind, bytes(data))
        return f"{kind.__name__} of {len(data)} bytes"

    def _sense_sane(self) -> str:
        kind = self.program.pick(SENSED)
        self._deliver(kind, serialize_message(self._sane(kind)))
        return f"sane {kind.__name__}"

    def _deliver(self, kind: Any, data: bytes) -> None:
        for wanted, take in tuple(self.node.topics.values()):
            if wanted is kind:
                take(data)

    # ---- messages ------------------------------------------------------------------------

    def _value(self, shape: Shape) -> Any:
        match shape:
            case MessageShape():
                if tuple(shape.fields) == tuple("xyzw") and self.program.chance(0.8):
                    return dict(self.program.pick(UPRIGHT))
                return {name: self._field(name, part) for name, part in shape.fields.items()}
            case ListOf():
                size = shape.size
                count = self.program.byte() % MOST_ELEMENTS if size is None else size
                if size is not None and size > MOST_ELEMENTS:
                    return [self._value(shape.item)] * size
                return [self._value(shape.item) for _ in range(min(count, shape.most or count))]
        return self._scalar(shape)

    def _field(self, name: str, part: Shape) -> Any:
        value = self._value(part)
        return USUAL[name] if name in USUAL and self.program.chance(0.8) else value

    def _scalar(self, shape: Scalar) -> Any:
        match shape.type:
            case "bool":
                return self.program.chance(0.5)
            case "text":
                return self.program.pick(TEXTS)[: int(min(shape.most, 1000))]
            case "integer":
                whole = self.program.pick(INTEGERS)
                return max(int(shape.least), min(whole, int(shape.most)))
        number = self.program.pick((*SANE * 8, *HOSTILE))
        is_single = shape.name == "float32" and math.isfinite(number)
        return max(min(number, 3.4e38), -3.4e38) if is_single else number

    def _sane(self, kind: Any) -> Any:
        message = kind()
        if hasattr(message, "header"):
            set_ns(message.header.stamp, self.node.clock.now_ns)
        if kind is Odometry:
            message.header.frame_id, message.child_frame_id = "odom", "base_footprint"
            message.pose.pose.orientation.w = 1.0
            message.pose.pose.position.x = self.program.byte() / 100
        elif kind is LaserScan:
            message.angle_increment, message.range_min, message.range_max = 0.1, 0.12, 3.5
            message.ranges = [0.3 + self.program.byte() / 50] * 63
        elif kind is OccupancyGrid:
            message.info.width = message.info.height = 20
            message.info.resolution, message.data = 0.1, [0] * 380 + [-1] * 10 + [100] * 10
            message.info.origin.position.x = message.info.origin.position.y = -1.0
        elif kind is TFMessage:
            transform = interface_types.fill(
                kind(), {"transforms": [{"child_frame_id": "odom", "header": {"frame_id": "map"}}]}
            )
            transform.transforms[0].transform.rotation.w = 1.0
            return transform
        elif kind is JointState:
            message.name = list(_robot().moved_joints)
            message.position = [self.program.byte() / 1000] * len(message.name)
        elif kind is Image:
            message.width = message.height = 8
            message.encoding, message.step, message.data = "rgb8", 24, bytes(192)
            message.header.frame_id = "camera"
        return message

    def _spoil(self, message: Any) -> None:
        """Give one field of a message, at any depth, a value that nobody expects."""
        kind: Any = type(message)
        shape = _shape(kind)
        while True:
            name = self.program.pick(tuple(shape.fields))
            part = shape.fields[name]
            if not isinstance(part, MessageShape):
                interface_types.fill(message, {name: self._value(part)})
                return
            message, shape = getattr(message, name), part

    def _command(self, twist: Twist2D) -> None:
        robot = _robot()
        assert math.isfinite(twist.linear + twist.angular), "a command that is no number"
        assert abs(twist.linear) <= robot.max_linear_velocity, "a command that is too fast"
        assert abs(twist.angular) <= robot.max_angular_velocity, "a turn that is too fast"


def judge(path: Path) -> Verdict:
    """Play a program: no exception but for what people can understand, and no wrong command."""
    play = Play(path.read_bytes())
    finding = play.finding()
    is_accepted = not (finding or play.is_refused) and any(" began" in line for line in play.log)
    return Verdict(is_accepted, finding=finding, inputs=len(play.log) + play.is_refused)


def samples(_: None) -> Iterator[Case]:
    """Yield programs that begin with a goal of each action, with numbers that are sane."""
    for number in range(20):
        yield Case("m.servers", bytes((0, 50, 100, number, *[number % 3 + 1] * 60)))


def case(_: None, seed: int, number: int) -> Case:
    """Return a program."""
    rng = Random(f"{seed}/{number}")
    return Case("m.servers", rng.randbytes(rng.randint(20, LONGEST)))


TARGET = Target(lambda: None, samples, case, judge)
