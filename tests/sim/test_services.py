"""The services of the simulated robot: motor power, odometry, and the start once more."""

from typing import Any

import pytest
from geometry_msgs.msg import TwistStamped
from std_srvs.srv import SetBool, Trigger

from bt_mission.base.stamps import set_ns
from bt_mission.robots.model import BatteryModel, SensorsModel
from sim.world.loader import load_world

S, MS = 1_000_000_000, 1_000_000


@pytest.fixture
def call():
    """Calls a service of a stage, and gives its response."""

    def call(here, kind: Any, name: str, **fields: Any):
        client = here.ear.create_client(kind, name)
        answer = client.call_async(kind.Request(**fields))
        here.clock.run_until_quiet()
        assert answer.done()
        return answer.result()

    return call


def drive(here, from_ns: int, seconds: float, linear: float, angular: float = 0.0) -> None:
    """Command at 20 Hz, from an instant on that is now."""
    for step in range(round(seconds * 20)):
        here.command(linear, angular)
        here.run(from_ns + (step + 1) * 50 * MS)


def test_without_power_the_base_rolls_to_rest_and_commands_are_ignored(
    make_stage, make_world, call
):
    """It needs some millimetres: the gears hold it back. With power, it waits for a new command."""
    here = make_stage(make_world(), "motors_on")
    here.run(1 * S)
    drive(here, 1 * S, 1.0, 0.2)
    simulation = here.sim.robots[0]
    before = simulation.pose[0]
    answer = call(here, SetBool, "motor_power", data=False)
    assert (answer.success, answer.message) == (True, "motors are off")
    drive(here, 2 * S, 1.0, 0.2)
    assert simulation.velocity[0] == pytest.approx(0, abs=1e-4)
    assert 0.001 < simulation.pose[0] - before < 0.02
    assert simulation.commanded == (0.0, 0.0)
    here.command(0.2)
    call(here, SetBool, "motor_power", data=True)
    here.run(3 * S + 150 * MS)
    assert simulation.commanded == (0.0, 0.0)
    drive(here, 3 * S + 150 * MS, 0.5, 0.2)
    assert simulation.velocity[0] == pytest.approx(0.2, abs=1e-3)
    assert [message.data for message in here.messages("motors_on")] == [True, False, True]


def test_off_and_on_at_one_instant_a_command_is_forgotten(make_stage, make_world, call):
    """It waits for a new one."""
    here = make_stage(make_world())
    here.run(1 * S)
    drive(here, 1 * S, 0.5, 0.2)
    for on in (False, True):
        call(here, SetBool, "motor_power", data=on)
    assert here.sim.robots[0].commanded == (0.0, 0.0)
    here.run(1 * S + 650 * MS)
    assert here.sim.robots[0].commanded == (0.0, 0.0)


def test_an_empty_battery_takes_the_motors_power(make_stage, make_world, waffle, call):
    """They go off by themselves, and cannot be switched on."""
    # A few joules: they last for less than a second.
    weak = BatteryModel(start_charge=5 / (1.8 * 3600 * 11.1))
    robot = waffle.model_copy(update={"battery": weak})
    here = make_stage(make_world(), "motors_on", "battery_state", robot=robot)
    here.run(1 * S)
    drive(here, 1 * S, 1.5, 0.2)
    assert here.sim.robots[0].velocity[0] == pytest.approx(0, abs=1e-4)
    assert [message.data for message in here.messages("motors_on")] == [True, False]
    assert here.messages("battery_state")[-1].percentage == 0.0
    answer = call(here, SetBool, "motor_power", data=True)
    assert (answer.success, answer.message) == (False, "motors are off: no charge left")


def test_the_battery_is_told_as_a_turtlebot3_tells_it(make_stage, make_world):
    """12.3 V and 100 % at first, less when it has driven; percentages, not shares."""
    here = make_stage(make_world(), "battery_state")
    here.run(1 * S)
    drive(here, 1 * S, 5.0, 0.26)
    first, last = here.messages("battery_state")[0], here.messages("battery_state")[-1]
    assert len(here.messages("battery_state")) == 101
    assert (first.voltage, first.percentage) == pytest.approx((12.3, 100.0))
    # 7 W and nearly 3 W, of 20 Wh.
    assert last.percentage == pytest.approx(100 - 100 * 10 * 5 / 71928, abs=0.001)
    assert last.current == pytest.approx(-10 / 11.1, abs=0.02)
    assert (last.present, last.design_capacity) == (True, pytest.approx(1.8))


def test_reset_odometry_reckons_from_here(make_stage, make_world, call):
    """Odometry is zero where the robot stands; map to odom follows, the truth stays."""
    here = make_stage(make_world(), "odom", "tf", "ground_truth/odom")
    here.run(1 * S)
    drive(here, 1 * S, 2.0, 0.2, 0.5)
    x, y, _ = here.sim.robots[0].pose
    assert call(here, Trigger, "reset_odometry").success
    here.run(3 * S + 50 * MS)
    for topic, place in (("odom", (0, 0)), ("ground_truth/odom", (x, y))):
        position = here.messages(topic)[-1].pose.pose.position
        assert (position.x, position.y) == pytest.approx(place, abs=0.02)
    to_odom = here.messages("tf")[-1].transforms[0].transform.translation
    assert (to_odom.x, to_odom.y) == pytest.approx((x, y), abs=1e-3)


TOLD = ("odom", "ground_truth/odom", "imu", "scan", "joint_states", "battery_state", "collisions")


def as_text(message: Any) -> str:
    """A message in words, without its time."""
    message.header.stamp.sec = message.header.stamp.nanosec = 0
    return repr(message)


@pytest.mark.thorough
def test_after_reset_simulation_a_run_repeats(make_stage, waffle, call):
    """Every message, bit for bit: what moves, noise, slip, battery; only the clock goes on."""
    options = {"lidar": {"model": "LDS-02"}, "odometry": {"slip": 0.05}}
    robot = waffle.with_sensors(SensorsModel.model_validate(options))
    here = make_stage(load_world("dqn_stage3"), *TOLD, "/clock", robot=robot, seed=3)

    def run(from_ns: int) -> list[tuple[str, str]]:
        here.run(from_ns)
        drive(here, from_ns, 4.0, 0.0, 0.35)
        drive(here, from_ns + 4 * S, 5.0, 0.26)
        messages = [
            (topic, as_text(message)) for topic, message in here.received if topic != "/clock"
        ]
        here.received.clear()
        return messages

    first = run(1 * S)
    answer = call(here, Trigger, "reset_simulation")
    assert (answer.success, answer.message) == (True, "everything is as it was at the start")
    assert here.sim.robots[0].pose == pytest.approx((0, 0, 0), abs=1e-5)
    assert here.clock.now_ns == 10 * S
    assert run(10 * S) == first
    assert "collisions" in dict(first)


def test_reset_simulation_gives_power_back(make_stage, make_world, call):
    """Motors on, battery as at the start; what was counted stays counted."""
    here = make_stage(make_world(), "motors_on")
    here.run(1 * S)
    drive(here, 1 * S, 1.0, 0.2)
    travelled = here.sim.robots[0].distance_travelled
    call(here, SetBool, "motor_power", data=False)
    call(here, Trigger, "reset_simulation")
    here.run(2 * S + 50 * MS)
    assert here.sim.robots[0].motors_on
    assert here.sim.robots[0].battery.charge == pytest.approx(1.0, abs=1e-5)
    assert here.sim.robots[0].distance_travelled == pytest.approx(travelled, abs=0.01)
    assert [message.data for message in here.messages("motors_on")] == [True, False, True]


@pytest.mark.parametrize(("sent_ms", "held_ms"), [(0, 200), (-50, 150), (-200, 0), (50_000, 200)])
def test_a_command_holds_from_when_it_was_sent(make_stage, make_world, sent_ms, held_ms):
    """Not from when it arrives; a stamp of the future is another clock's, and says nothing."""
    here = make_stage(make_world())
    here.run(1 * S)
    drive(here, 1 * S, 1.0, 0.2)
    message = TwistStamped()
    message.twist.linear.x = 0.2
    set_ns(message.header.stamp, 2 * S + sent_ms * MS)
    here.commands.publish(message)
    here.clock.run_until_quiet()
    here.sim.physics.advance_to(2 * S + held_ms * MS)
    assert here.sim.robots[0].commanded[0] == pytest.approx(0.2)
    here.sim.physics.advance_to(2 * S + (held_ms + 5) * MS)
    assert here.sim.robots[0].commanded[0] == pytest.approx(0.195)


def test_each_of_many_calls_is_answered(make_stage, make_world):
    """None is lost, and the robot is as the last one says."""
    here = make_stage(make_world())
    here.run(1 * S)
    client = here.ear.create_client(SetBool, "motor_power")
    answers = [client.call_async(SetBool.Request(data=bool(number % 2))) for number in range(300)]
    here.clock.run_until_quiet()
    assert all(answer.done() for answer in answers)
    assert here.sim.robots[0].motors_on


def test_of_many_velocities_at_once_the_newest_holds(make_stage, make_world):
    """Ten wait at most; those that are none are passed over."""
    here = make_stage(make_world())
    here.run(1 * S)
    for number in range(1000):
        here.command(0.0001 * number, 0.0)
    for wrong in (float("nan"), float("inf"), float("-inf")):
        here.command(wrong, 0.1)
        here.command(0.1, wrong)
    before = here.clock.callbacks_served
    here.clock.run_until_quiet()
    assert here.clock.callbacks_served - before <= 10
    here.run(1 * S + 150 * MS)
    assert here.sim.robots[0].commanded[0] == pytest.approx(0.0999)
