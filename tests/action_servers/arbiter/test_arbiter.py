"""Facts about who may drive: the rules alone, and the node over real rclpy on the virtual clock."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import pytest
from geometry_msgs.msg import Twist, TwistStamped

from action_servers.arbiter.arbiter import SOURCES, Arbiter, CommandAge
from action_servers.arbiter.node import ArbiterNode, ArbiterOptions
from action_servers.core.maneuver import ZERO
from bt_mission.base.geometry import Twist2D
from bt_mission.base.stamps import set_ns, to_ns
from tests.support.rig import Rig

STOP, JOY, MISSION = (source.topic for source in SOURCES)
SLOW, FAST = Twist2D(0.1, 0.0), Twist2D(0.2, 0.5)
MS = 1_000_000
START_NS = 10_000_000_000


@pytest.fixture
def arbiter() -> Arbiter:
    """The arbiter with its usual sources."""
    return Arbiter()


def test_the_joystick_gives_way_exactly_half_a_second_after_its_last_word(arbiter):
    """Not a nanosecond earlier."""
    arbiter.take(JOY, SLOW, 0)
    assert arbiter.take(MISSION, FAST, 500 * MS - 1) is None
    assert arbiter.take(MISSION, FAST, 500 * MS) == FAST


def test_a_base_is_told_to_stand_when_everybody_is_silent(arbiter):
    """A mission counts for 0.15 s, and then zero is commanded until somebody speaks."""
    assert arbiter.step(0) == ZERO
    arbiter.take(MISSION, FAST, 0)
    assert arbiter.step(150 * MS - 1) is None
    assert arbiter.step(150 * MS) == ZERO
    assert arbiter.step(170 * MS) == ZERO


def test_whatever_stop_says_means_zero(arbiter):
    """A stop that names a speed by mistake still stops."""
    arbiter.take(JOY, FAST, 0)
    assert arbiter.take(STOP, FAST, 1) == ZERO
    assert arbiter.take(JOY, FAST, 2) is None
    assert arbiter.take(MISSION, FAST, 3) is None


@pytest.mark.parametrize(
    "twist", [Twist2D(math.nan, 0.0), Twist2D(0.0, math.inf), Twist2D(0.1, 0.0, math.nan)]
)
def test_a_command_that_is_no_number_counts_as_silence(arbiter, twist):
    """The source falls silent with it, and a base that it drove is told to stand."""
    arbiter.take(MISSION, FAST, 0)
    with pytest.raises(ValueError, match="cmd_vel_mission commanded"):
        arbiter.take(MISSION, twist, 100 * MS)
    assert arbiter.step(150 * MS) == ZERO


def test_a_clock_that_is_set_back_ends_what_was_heard_before(arbiter):
    """As when a simulation begins anew."""
    arbiter.take(JOY, SLOW, 10_000 * MS)
    assert arbiter.step(0) == ZERO
    assert arbiter.take(MISSION, FAST, 0) == FAST


def test_a_command_counts_from_when_it_was_sent(arbiter):
    """One that was under way for a while is given as much less time; too late, it counts not."""
    assert arbiter.take(MISSION, FAST, 1000 * MS, age_ns=100 * MS) == FAST
    assert arbiter.step(1050 * MS - 1) is None
    assert arbiter.step(1050 * MS) == ZERO
    assert arbiter.take(MISSION, FAST, 1100 * MS, age_ns=150 * MS) is None
    assert arbiter.step(1100 * MS) == ZERO


def test_a_stop_counts_however_late_it_comes(arbiter):
    """From when it is heard."""
    assert arbiter.take(STOP, ZERO, 1000 * MS, age_ns=5000 * MS) == ZERO
    assert arbiter.take(JOY, SLOW, 1500 * MS - 1) is None


MEASURED = [(10_000, 10_010), (10_050, 10_055), (10_100, 10_290), (10_150, 10_295)]
SET_BACK = [(100_000, 100_000), *((at, 100_000 + at) for at in range(50, 2200, 50))]


@pytest.mark.parametrize(
    ("sent_and_received", "ages"),
    [
        (MEASURED, [0, 0, 185, 140]),
        ([(sent - 3_600_000, received) for sent, received in MEASURED], [0, 0, 185, 140]),
        ([(sent + 400, received) for sent, received in MEASURED], [0, 0, 185, 140]),
        (SET_BACK, [0] + [100_000] * 39 + [0] * 4),
        ([(1000, 1000), (1050, 61_000)], [0, 59_950]),
        ([(0, 5)], [0]),
    ],
    ids=["clocks agree", "an hour behind", "ahead", "set back", "a long silence", "no stamp"],
)
def test_an_age_is_how_much_longer_a_command_took_than_the_fastest_of_the_last_two_seconds(
    sent_and_received, ages
):
    """It does not depend on how clocks are set; ROS takes a stamp of zero for none."""
    age = CommandAge()
    assert [age.of(sent * MS, received * MS) // MS for sent, received in sent_and_received] == ages


class Desk(Rig):
    """The arbiter between three sources and a base, all played by the test."""

    def __init__(self, **options: Any) -> None:
        super().__init__(start_ns=START_NS)
        self.people = self.node("people")
        self.arbiter = self.add(
            ArbiterNode(ArbiterOptions(lean=True, context=self.context, **options))
        )
        self.sent: list[tuple[int, float]] = []
        self.stamps: list[int] = []
        self.people.create_subscription(TwistStamped, "cmd_vel", self._hear, 10)
        self.sources = {
            name: self.people.create_publisher(TwistStamped, f"cmd_vel_{name}", 10)
            for name in ("stop", "joy", "mission")
        }

    def _hear(self, message: Any) -> None:
        self.sent.append((self.clock.now_ns - START_NS, message.twist.linear.x))
        self.stamps.append(to_ns(message.header.stamp) - START_NS)

    def say(self, source: str, *speeds: float, sent_ms: int | None = None) -> None:
        """Command speeds, one after the other, heard now; they may have been sent earlier."""
        for speed in speeds:
            message = TwistStamped()
            message.twist.linear.x = speed
            if sent_ms is not None:
                set_ns(message.header.stamp, START_NS + sent_ms * MS)
            self.sources[source].publish(message)
        self.clock.run_until_quiet()

    def wait_until(self, ms: int) -> None:
        """Let time pass until so many milliseconds after the start."""
        self.steps_until(START_NS + ms * MS)

    @property
    def moving(self) -> list[tuple[int, float]]:
        """Times and speeds of the commands that move."""
        return [(time // MS, speed) for time, speed in self.sent if speed]

    def first_zero_after(self, ms: int) -> int:
        """The time of the first command to stand after so many milliseconds."""
        return next(time for time, speed in self.sent if not speed and time > ms * MS) // MS


@pytest.fixture
def desk() -> Iterator[Desk]:
    """An arbiter with its usual settings."""
    made = Desk()
    yield made
    made.close()


def test_the_base_is_told_to_stand_when_a_mission_falls_silent(desk):
    """At the first look 0.15 s after its last word: the servers have died."""
    desk.wait_until(100)
    desk.say("mission", 0.2)
    desk.wait_until(1000)
    assert desk.moving == [(100, 0.2)]
    assert desk.first_zero_after(100) == 260


def test_the_joystick_takes_over_and_hands_back(desk):
    """It drives until half a second after its last word, whatever the mission says meanwhile."""
    for ms in range(0, 1200, 100):
        desk.wait_until(ms)
        desk.say("mission", 0.2)
        if 200 <= ms <= 300:
            desk.say("joy", -0.1)
    reverse = [time for time, speed in desk.moving if speed < 0]
    forward = [time for time, speed in desk.moving if speed > 0]
    assert reverse == [200, 300]
    assert [time for time in forward if 200 < time < 800] == []
    assert forward[-3:] == [900, 1000, 1100]


def test_stop_holds_the_base_against_all_others(desk):
    """Also against a stop that names a speed."""
    desk.say("mission", 0.2)
    desk.wait_until(40)
    desk.say("stop", 0.3)
    desk.say("joy", 0.1)
    desk.say("mission", 0.2)
    desk.wait_until(400)
    assert desk.moving == [(0, 0.2)]
    assert desk.first_zero_after(0) == 40


def test_a_command_is_passed_on_with_the_time_at_which_it_was_sent(desk):
    """So the timeout of the base does not start again on the way."""
    desk.wait_until(100)
    desk.say("mission", 0.2, sent_ms=100)
    desk.wait_until(240)
    desk.say("mission", 0.2, sent_ms=150)
    assert desk.moving == [(100, 0.2), (240, 0.2)]
    moved = [stamp // MS for stamp, (_, speed) in zip(desk.stamps, desk.sent, strict=True) if speed]
    assert moved == [100, 150]
    desk.wait_until(1000)
    assert desk.first_zero_after(240) == 300


def test_of_commands_that_have_waited_none_moves_the_base(desk):
    """An arbiter that was held up, while the servers died, hears the newest alone, as old."""
    desk.wait_until(100)
    desk.say("mission", 0.2, sent_ms=100)
    desk.wait_until(1000)
    before = len(desk.moving)
    desk.say("mission", *[0.2] * 8, sent_ms=150)
    desk.wait_until(2000)
    assert len(desk.moving) == before


def test_timeouts_are_parameters():
    """Within their range."""
    desk = Desk(parameters={"timeouts.mission": 1.0})
    desk.say("mission", 0.2)
    desk.wait_until(1500)
    assert desk.first_zero_after(0) == 1000
    desk.close()


def test_sources_are_listened_to_only_while_the_base_would_hear():
    """So servers that send to the arbiter can tell that nobody drives the wheels."""
    desk = Desk(command_type="auto")
    assert list(desk.arbiter.subscriptions) == []
    desk.wait_until(520)
    names = [subscription.topic_name for subscription in desk.arbiter.subscriptions]
    assert "/cmd_vel_mission" in names
    for subscription in tuple(desk.people.subscriptions):
        desk.people.destroy_subscription(subscription)
    desk.wait_until(1020)
    names = [subscription.topic_name for subscription in desk.arbiter.subscriptions]
    assert "/cmd_vel_mission" not in names
    desk.people.create_subscription(TwistStamped, "cmd_vel", desk._hear, 10)
    desk.wait_until(1520)
    desk.say("mission", 0.2)
    assert [speed for _, speed in desk.moving] == [0.2]
    desk.close()


def test_a_robot_that_takes_plain_commands_gets_them(rig):
    """The sources stay stamped."""
    messages: list[Any] = []
    rig.node("robot").create_subscription(Twist, "cmd_vel", messages.append, 10)
    rig.add(ArbiterNode(ArbiterOptions(lean=True, context=rig.context, command_type="auto")))
    while not messages:
        rig.step()
    assert rig.now_s == 0.5
    assert messages == [Twist()]


def test_a_stop_with_a_stamp_beyond_reason_stops(desk: Desk) -> None:
    """One that lies a lifetime after the one before it, or before it."""
    for second in (2**31 - 1, -(2**31)):
        message = TwistStamped()
        message.header.stamp.sec, message.twist.linear.x = second, 0.2
        desk.sources["stop"].publish(message)
        desk.clock.run_until_quiet()
    assert [speed for _, speed in desk.sent] == [0.0, 0.0]


def test_of_many_velocities_at_once_the_newest_is_heard(desk: Desk) -> None:
    """What waits is one message a source, however many come."""
    desk.say("joy", *[0.001 * number for number in range(1000)])
    ((heard_ms, speed),) = desk.moving
    assert (heard_ms, speed) == (0, 0.999)
    desk.wait_until(1000)
    assert not desk.sent[-1][1]
