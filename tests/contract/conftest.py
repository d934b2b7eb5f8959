"""What every action server keeps to: each statement is run against every server.

A test that takes `name` is run once for each action, `driving` once for each that drives, `beside`
once for each that does not. Without `--thorough` it is a fifth of them, others for each test.
"""

from __future__ import annotations

import zlib

import pytest

from bt_mission.base.files import names
from bt_mission.robots.model import load_robot
from tests.support.bench import Bench
from tests.support.fake_robot import FakeRobot
from tests.support.served import BESIDE, DRIVING, SERVED
from tests.support.thorough import sample

ROBOTS = sorted(names("robots"), key=lambda name: (name != "waffle", name))
"""The Waffle first: without `--thorough` it is the only one."""

ARGUMENTS = {"name": SERVED, "driving": DRIVING, "beside": BESIDE}
"""The arguments that stand for an action, and the actions."""


@pytest.fixture(params=sample(ROBOTS, every=len(ROBOTS)))
def robot(request):
    """Every shipped robot; one without a camera has that of the Waffle, which actions need.

    Actions of arm and gripper are those of the robot that has them.
    """
    name = request.node.callspec.params.get("name", "")
    is_of_arm = name in SERVED and SERVED[name].action.part
    model = load_robot("waffle_arm" if is_of_arm else request.param)
    return (
        model if model.camera else model.model_copy(update={"camera": load_robot("waffle").camera})
    )


BESIDES = {"turn", "find_colour"}
"""Actions that tests of another one use besides."""


@pytest.fixture
def others(request):
    """Actions that a test of one action does not need: each server takes a while to make."""
    params = request.node.callspec.params if hasattr(request.node, "callspec") else {}
    tested = {params.get(argument) for argument in ARGUMENTS} & {*SERVED}
    return {*SERVED} - tested - BESIDES if tested else set()


@pytest.fixture
def make_bench(tmp_path, robot, others):
    """Make a bench: `make_bench(**parameters)`; the robot has not been heard of."""
    made: list[Bench] = []

    def make(**parameters):
        fake = FakeRobot(robot)
        made.append(Bench(fake, tmp_path / "images", parameters, without=others))
        return made[-1]

    yield make
    for bench in made:
        bench.close()


@pytest.fixture
def bench(make_bench):
    """A bench whose robot has been heard of."""
    bench = make_bench()
    bench.steps(2)
    return bench


def pytest_generate_tests(metafunc):
    """Repeat a test for the actions that it asks for."""
    given = {
        argument
        for mark in metafunc.definition.iter_markers("parametrize")
        for argument in (mark.args[0].split(",") if isinstance(mark.args[0], str) else mark.args[0])
    }
    first = zlib.crc32(metafunc.function.__name__.encode())
    for argument, actions in ARGUMENTS.items():
        if argument in metafunc.fixturenames and argument not in given:
            metafunc.parametrize(argument, sample(actions, every=5, first=first))
