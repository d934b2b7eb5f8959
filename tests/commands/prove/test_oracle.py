"""What is proved holds in random runs that share no code with the proof."""

from __future__ import annotations

from textwrap import dedent

import pytest

from bt_mission.sessions.load import load
from tests.commands.prove.oracle.judge import shown_by, try_mission
from tests.commands.prove.oracle.missions import random_mission
from tests.commands.prove.oracle.world import World
from tests.support.thorough import sample

RUNS = 200
"""Enough for each of the following."""

STATES = 100
"""With more, a mission is explored in part, and less is proved."""

DRIVE = "explore_forward: {fwd_velocity: 0.2, stopping_distance: 0.5}"
SWEEP = "camera_sweep: {sweep_angle: 90, image_count: 2}"
BATTERY = "topic: battery_state, type: sensor_msgs/msg/BatteryState"

SHOWN = {
    "a value between two constants": (
        0,
        "entered here",
        f"""
        tree:
          sequence:
            - {{{DRIVE}, timeout: 1, outputs: {{closest_obstacle: gap}}}}
            - {{when: gap > 0.5 and gap < 0.6, do: {{log: between, name: here}}}}
        """,
    ),
    "an output that its condition does not read": (
        0,
        "entered here",
        f"""
        tree:
          sequence:
            - wait_for: {{{BATTERY}, until: voltage < 11}}
              timeout: 1
              outputs: {{percentage: p}}
            - {{when: p > 50, do: {{log: high, name: here}}}}
        """,
    ),
    "ticks before any message": (
        0,
        "entered here",
        f"""
        follow: [{{{BATTERY}, field: percentage, as: p, initial: 10.0}}]
        tree: {{when: p == 10, do: {{log: nothing yet, name: here}}}}
        """,
    ),
    "two fields of one message": (
        0,
        "entered here",
        f"""
        follow:
          - {{{BATTERY}, field: percentage, as: p}}
          - {{{BATTERY}, field: voltage, as: v}}
        tree: {{when: p > 50 and v < 11, do: {{log: both, name: here}}}}
        """,
    ),
    "a list with several entries": (
        0,
        "entered here",
        f"""
        tree:
          sequence:
            - {{{SWEEP}, timeout: 1, outputs: {{image_paths: paths}}}}
            - {{when: len(paths) > 1, do: {{for_each: {{p: $paths}}, do: {{log: $p, name: here}}}}}}
        """,
    ),
    "a draw beyond a limit": (
        0,
        "requirement r",
        """
        requirements: {r: never failed("late")}
        tree: {timeout: 4, name: late, do: {wait: "uniform(1, 5)"}}
        """,
    ),
    "a goal that is accepted": (
        2,
        "requirement r",
        """
        requirements: {r: 'never accepted("a") and running("b")'}
        tree:
          fallback:
            - {turn: {angle: 90}, name: a, timeout: 0.5}
            - {wait: 1, name: b}
        """,
    ),
    "an acceptance after the goal was given up": (
        0,
        "one_goal_at_the_base",
        """
        tree:
          sequence:
            - parallel:
                - {turn: {angle: 90}, timeout: 1, cancel_timeout: 0.1}
                - wait: 0.2
              succeed_when: any
            - {move: {secs: 1, linear_velocity: 0.1}, timeout: 1}
        """,
    ),
    "a result in the middle": (
        0,
        "requirement r",
        """
        requirements: {r: 'never running("first") and running("second")'}
        tree:
          parallel:
            - sequence: [{turn: {angle: 90}, timeout: 10}, {wait: 0.2, name: first}]
            - sequence: [{wait: 1}, {wait: 0.2, name: second}]
        """,
    ),
    "a goal that never ends": (
        1,
        "ends",
        """
        tree: {turn: {angle: 90}, feedback_timeout: 1}
        """,
    ),
    "an unset variable": (
        1,
        "unset_variable",
        """
        tree:
          sequence:
            - fallback: [{turn: {angle: 90}, timeout: 1, outputs: {error_code: e}}, {log: no}]
            - log: $e
        """,
    ),
    "a value that cannot be sent": (
        0,
        "unhandled",
        f"""
        tree:
          sequence:
            - {{{DRIVE}, timeout: 1, outputs: {{closest_obstacle: gap}}}}
            - {{turn: {{angle: $gap}}, timeout: 1}}
        """,
    ),
}


@pytest.mark.parametrize(("faults", "shown", "text"), SHOWN.values(), ids=SHOWN)
def test_random_runs_show_what_seldom_happens(faults: int, shown: str, text: str) -> None:
    """Values, instants and latencies that an exploration may miss."""
    text = f"mission: m\n{dedent(text)}"
    mission = load(text)
    runs = (World(mission, text, seed, faults).run() for seed in range(RUNS))
    assert any(shown in dict(shown_by(world)) for world in runs if not world.void)


@pytest.mark.parametrize("seed", sample(range(200), every=21))
def test_no_random_run_breaks_what_is_proved(seed: int) -> None:
    """Of a random mission, with at most two faults."""
    _, text, mission = random_mission(seed)
    assert try_mission(mission, text, seed % 3, 20, most_states=STATES).defects == {}
