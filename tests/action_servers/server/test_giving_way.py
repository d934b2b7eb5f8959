"""Facts about servers whose base gives way to what moves, as a client sees them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from bt_mission_interfaces.action import ExploreForward
from rclpy.parameter import Parameter

from action_servers.core.maneuver import ZERO
from sim.world.motion import Drifting
from tests.support.moving_robot import Mover


def meet(bench: Any) -> Any:
    """Send it ahead, while a cylinder comes at it; return the goal 6 s later."""
    mover, start_s = Mover(Drifting((2.0, 0.0), (-0.3, 0.0))), bench.robot.fake.time_s
    wall = [(3.0, -3.0, 3.0, 3.0)]
    sent = bench.send(
        "explore_forward", ExploreForward.Goal(fwd_velocity=0.2, stopping_distance=0.3)
    )
    for _ in range(120):
        walls = [*wall, *mover.walls(bench.robot.fake.time_s - start_s)]
        bench.robot.fake.walls = np.array(walls)
        bench.steps(1)
    return sent


def test_the_result_says_that_it_gave_way(bench):
    """Also of a goal that is canceled; and the base backed off, or turned aside."""
    sent = meet(bench)
    assert any(twist.linear < 0.0 or twist.angular for twist in bench.commands)
    bench.cancel("explore_forward")
    bench.until(lambda: sent.result is not None)
    assert sent.result.error_msg.startswith("gave way ")
    assert bench.commands[-1] == ZERO


@pytest.mark.parametrize("name", ["give_way_time", "give_way_distance"])
def test_a_parameter_turns_it_off(bench, name):
    """From the next goal on."""
    (set_it,) = bench.servers.set_parameters([Parameter(name, value=0.0)])
    assert set_it.successful
    sent = meet(bench)
    assert all(twist.linear >= 0.0 and not twist.angular for twist in bench.commands)
    bench.until(lambda: sent.result is not None)
    assert "gave way" not in sent.result.error_msg
