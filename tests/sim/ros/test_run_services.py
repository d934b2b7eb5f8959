"""The standard services for the run of a simulation, to the step of the physics."""

from typing import Any

import pytest
from rclpy.action import ActionClient
from simulation_interfaces import srv
from simulation_interfaces.action import SimulateSteps
from simulation_interfaces.msg import Result, SimulationState, SimulatorFeatures

from sim.ros.requests import Code, Feature
from sim.ros.run_control import RunState
from sim.ros.run_services import MOST_STEPS, Scope, Transition
from tests.sim.ros.conftest import result_of

MS = 1_000_000
STOPPED, PLAYING, PAUSED, QUITTING = range(4)
OK = (Code.OK, "")


@pytest.fixture
def sim(make_simulator):
    """A simulation that has run for half a second."""
    sim = make_simulator("/clock", "scan", "odom")
    sim.wait(0.5)
    return sim


def clocks(sim) -> list[int]:
    """What has come on /clock, ms."""
    stamps = [message.clock for message in sim.stage.messages("/clock")]
    return [stamp.sec * 1000 + stamp.nanosec // MS for stamp in stamps]


@pytest.mark.parametrize(
    ("ours", "theirs", "prefix"),
    [
        (Code, Result, "RESULT_"),
        (Feature, SimulatorFeatures, ""),
        (RunState, SimulationState, "STATE_"),
        (Scope, srv.ResetSimulation.Request, "SCOPE_"),
        (Transition, srv.SetSimulationState.Response, ""),
    ],
)
def test_codes_are_those_of_the_standard(ours, theirs, prefix):
    """They are written down here, so that older releases with fewer names do, too."""
    assert {member.name: member.value for member in ours} == {
        member.name: getattr(theirs, f"{prefix}{member.name}") for member in ours
    }


def test_the_features_are_told_in_every_state(sim):
    """Each once, and none for worlds, which are chosen at the start."""
    output = sim.ask("GetSimulatorFeatures").features
    assert list(output.features) == [feature.value for feature in Feature]
    assert list(output.spawn_formats) == ["yaml"]
    sim.set_state(QUITTING)
    assert sim.ask("GetSimulatorFeatures").features == output


def test_paused_time_stands_and_is_not_made_up_for(sim):
    """It plays from the start. In a pause nothing is published; then it goes on from there."""
    assert (sim.state, clocks(sim)[-1]) == (PLAYING, 1500)
    assert sim.set_state(PAUSED) == OK
    assert sim.state == PAUSED
    received = len(sim.stage.received)
    sim.wait(100.0)
    assert (sim.node.clock_ns, len(sim.stage.received)) == (1500 * MS, received)
    assert sim.set_state(PLAYING) == OK
    sim.wait(0.25)
    assert clocks(sim)[-5:] == [1550, 1600, 1650, 1700, 1750]


def test_stopped_it_is_as_at_the_start(sim):
    """Time and everything else is put back at once; what follows repeats the start."""
    scans = [message.ranges for message in sim.stage.messages("scan")]
    assert sim.set_state(STOPPED) == OK
    assert (sim.state, sim.node.clock_ns, clocks(sim)[-1]) == (STOPPED, 1000 * MS, 1000)
    sim.stage.received.clear()
    sim.wait(5.0)
    assert sim.stage.received == []
    sim.set_state(PLAYING)
    sim.wait(0.5)
    assert [message.ranges for message in sim.stage.messages("scan")] == scans
    assert clocks(sim) == list(range(1000, 1501, 50))


def test_from_stopped_it_may_be_paused(sim):
    """Which starts it without a step; a request of steps that says no number is for one."""
    sim.set_state(STOPPED)
    assert sim.set_state(PAUSED) == OK
    answer = sim.begin("StepSimulation")
    sim.wait(0.1)
    assert (result_of(answer.result()), sim.node.clock_ns) == (OK, 1005 * MS)


@pytest.mark.parametrize(
    ("state", "code", "words"),
    [
        (PLAYING, Transition.ALREADY_IN_TARGET_STATE, "the simulation is playing already"),
        (4, Transition.INCORRECT_TRANSITION, "there is always a world here"),
        (5, Transition.INCORRECT_TRANSITION, "worlds are loaded at the start only"),
        (77, Code.FEATURE_UNSUPPORTED, "expected a state from 0 (stopped) to 3 (quitting), got 77"),
    ],
)
def test_a_state_that_cannot_be_entered_is_refused(sim, state, code, words):
    """With the standard's own code, and why; it goes on as it did."""
    result, text = sim.set_state(state)
    assert (result, sim.state) == (code, PLAYING)
    assert words in text


def test_while_it_quits_everything_is_refused(sim):
    """Also what would wait."""
    sim.set_state(QUITTING)
    assert sim.state == QUITTING
    for kind in ("ResetSimulation", "StepSimulation", "GetEntities", "SpawnEntity", "LoadWorld"):
        assert result_of(sim.ask(kind)) == (Code.INCORRECT_STATE, "the simulator is ending")


# ---- steps -------------------------------------------------------------------------------


def test_steps_are_done_at_the_pace_of_the_simulation(sim):
    """Ten of 5 ms take 50 ms; the answer comes with the last, and then it is paused.

    Another request is refused meanwhile.
    """
    sim.set_state(PAUSED)
    answer = sim.begin("StepSimulation", steps=10)
    assert not answer.done()
    assert sim.state == PLAYING
    assert result_of(sim.ask("StepSimulation", steps=10))[0] == Code.OPERATION_FAILED
    sim.wait(0.045)
    assert (answer.done(), sim.node.clock_ns) == (False, 1545 * MS)
    sim.wait(0.005)
    assert result_of(answer.result()) == OK
    sim.wait(3.0)
    assert (sim.node.clock_ns, sim.state) == (1550 * MS, PAUSED)


@pytest.mark.parametrize(
    ("steps", "state", "words"),
    [
        (5, PLAYING, "steps are for a paused simulation, and this one is playing"),
        (5, STOPPED, "steps are for a paused simulation, and this one is stopped"),
        (0, PAUSED, "expected 1 step or more, got 0"),
        (10**9, PAUSED, f"expected at most {MOST_STEPS} steps of 5 ms, got 1000000000"),
        (2**64 - 1, PAUSED, "the action simulate_steps takes any number"),
    ],
)
def test_steps_that_cannot_be_are_refused(sim, steps, state, words):
    """At once, and nothing moves."""
    if state != PLAYING:
        sim.set_state(state)
    before_ns = sim.node.clock_ns
    result, text = result_of(sim.ask("StepSimulation", steps=steps))
    assert (result, sim.node.clock_ns) == (Code.OPERATION_FAILED, before_ns)
    assert words in text


@pytest.mark.parametrize(
    ("state", "name"), [(PAUSED, "paused"), (STOPPED, "stopped"), (QUITTING, "quitting")]
)
def test_another_state_ends_steps_under_way(sim, state, name):
    """Whoever waits for them learns how many there were."""
    sim.set_state(PAUSED)
    answer = sim.begin("StepSimulation", steps=100)
    sim.wait(0.02)
    assert sim.set_state(state)[0] == Code.OK
    words = f"given up after 4 of 100 steps: the simulation is {name} now"
    assert result_of(answer.result()) == (Code.OPERATION_FAILED, words)
    assert sim.state == state


def send_steps(sim, steps: int):
    """Send a goal, and return its handle and the feedback that comes."""
    client = ActionClient(sim.stage.ear, SimulateSteps, "/bt_mission_sim/simulate_steps")
    told_so_far: list[tuple[int, int]] = []
    sent = client.send_goal_async(
        SimulateSteps.Goal(steps=steps),
        feedback_callback=lambda message: told_so_far.append(
            (message.feedback.completed_steps, message.feedback.remaining_steps)
        ),
    )
    sim.stage.clock.run_until_quiet()
    result = sent.result().get_result_async()
    sim.stage.clock.run_until_quiet()
    return sent.result(), result, told_so_far


def test_the_action_tells_each_step(sim):
    """How many are done, and how many are still to come."""
    sim.set_state(PAUSED)
    _, result, progress = send_steps(sim, 3)
    sim.wait(0.5)
    assert (result.result().status, result_of(result.result().result)) == (4, OK)
    assert progress == [(1, 2), (2, 1), (3, 0)]
    assert (sim.node.clock_ns, sim.state) == (1515 * MS, PAUSED)


def test_the_action_takes_any_number_and_can_be_canceled(sim):
    """2^64 - 1 steps are three billion years; after 20 ms four are done."""
    sim.set_state(PAUSED)
    goal, result, progress = send_steps(sim, 2**64 - 1)
    sim.wait(0.02)
    goal.cancel_goal_async()
    sim.stage.clock.run_until_quiet()
    words = f"given up after 4 of {2**64 - 1} steps: canceled"
    assert result.result().status == 5
    assert result_of(result.result().result) == (Code.OPERATION_FAILED, words)
    assert progress[-1] == (4, 2**64 - 5)
    assert (sim.node.clock_ns, sim.state) == (1520 * MS, PAUSED)


def test_the_action_is_aborted_where_it_cannot_be(sim):
    """The result says why."""
    _, result, progress = send_steps(sim, 3)
    code, text = result_of(result.result().result)
    assert (result.result().status, code, progress) == (6, Code.OPERATION_FAILED, [])
    assert "steps are for a paused simulation" in text


# ---- reset -------------------------------------------------------------------------------


def drive(sim) -> None:
    """Drive ahead for half a second."""
    for _ in range(10):
        sim.stage.command(0.2)
        sim.wait(0.05)


def crate_in(sim, x: float = 3.0, edge: float = 0.2) -> Any:
    """A crate that is put into the world."""
    return sim.node.physics.props.place("crate", x, 0.0, size=(edge, edge, edge))


@pytest.mark.parametrize("scope", [0, 255, 7])
def test_all_is_reset_and_it_plays_on(sim, scope):
    """Time, poses and what was spawned; the clock is told at once."""
    crate_in(sim)
    drive(sim)
    assert result_of(sim.ask("ResetSimulation", scope=scope)) == OK
    assert (sim.node.clock_ns, clocks(sim)[-1], sim.state) == (1000 * MS, 1000, PLAYING)
    assert sim.node.robots[0].pose == pytest.approx((0, 0, 0), abs=1e-6)
    assert len(sim.node.physics.props) == 0
    sim.wait(0.1)
    assert clocks(sim)[-3:] == [1000, 1050, 1100]


def test_time_alone_is_reset(sim):
    """The robot drives on, and its commands count from their stamps, on the new clock."""
    drive(sim)
    x = sim.node.robots[0].pose[0]
    assert result_of(sim.ask("ResetSimulation", scope=Scope.TIME)) == OK
    assert (sim.node.clock_ns, sim.node.robots[0].pose[0]) == (1000 * MS, x)
    assert sim.node.robots[0].velocity[0] == pytest.approx(0.2, abs=0.01)
    sim.wait(0.1)
    (*_, last) = sim.stage.messages("odom")
    assert last.header.stamp.sec * 1000 + last.header.stamp.nanosec // MS == 1100


def test_the_state_alone_is_reset(sim):
    """Time goes on; what was spawned stands where it was put."""
    crate = crate_in(sim)
    crate.move_at(0.0, 0.5)
    drive(sim)
    assert crate.position == pytest.approx((3.0, 0.25))
    assert result_of(sim.ask("ResetSimulation", scope=Scope.STATE)) == OK
    assert sim.node.clock_ns == 2000 * MS
    assert sim.node.robots[0].pose == pytest.approx((0, 0, 0), abs=1e-6)
    assert (crate.is_placed, crate.position, crate.velocity) == (True, (3.0, 0.0), (0.0, 0.0))


def test_what_stands_where_a_robot_starts_is_deleted_and_told(sim):
    """Else the robot would be inside of it."""
    drive(sim)
    drive(sim)
    crate_in(sim, -0.15, 0.1)
    answer = sim.ask("ResetSimulation", scope=Scope.STATE)
    assert result_of(answer) == (Code.OK, "no room any more, so deleted: crate")
    assert len(sim.node.physics.props) == 0


def test_what_was_spawned_alone_is_deleted(sim):
    """Nothing else changes."""
    crate_in(sim)
    drive(sim)
    pose = sim.node.robots[0].pose
    assert result_of(sim.ask("ResetSimulation", scope=Scope.SPAWNED)) == OK
    assert (sim.node.clock_ns, sim.node.robots[0].pose) == (2000 * MS, pose)
    assert len(sim.node.physics.props) == 0


@pytest.mark.parametrize("scope", [8, 9, 128])
def test_a_scope_that_nobody_knows_is_refused(sim, scope):
    """And nothing is reset."""
    result, text = result_of(sim.ask("ResetSimulation", scope=scope))
    assert (result, sim.node.clock_ns) == (Code.FEATURE_UNSUPPORTED, 1500 * MS)
    assert text.endswith(f"got {scope}")


def test_a_reset_ends_steps_under_way(sim):
    """It stays paused, at the start."""
    sim.set_state(PAUSED)
    answer = sim.begin("StepSimulation", steps=100)
    sim.wait(0.02)
    sim.ask("ResetSimulation")
    words = "given up after 4 of 100 steps: the simulation was reset"
    assert result_of(answer.result()) == (Code.OPERATION_FAILED, words)
    assert (sim.state, sim.node.clock_ns) == (PAUSED, 1000 * MS)
