"""Short missions, and defects that somebody might write into them: for the benchmark search."""

from __future__ import annotations

from dataclasses import dataclass

DRIVE = """\
mission: drive and look
world: empty_arena
inputs: {speed: 0.2}
requirements:
  touches nothing: never collisions > 0
  keeps its distance: always clearance > 0.05
  goes no farther: always distance < 1.2
  is slow enough: always abs(speed) < 0.24
tree:
  sequence:
    - fallback:
        - explore_forward: {fwd_velocity: $speed, stopping_distance: 0.4}
          name: drive
          cancel_when: current_distance_travelled > 0.6
          on_cancel: success
          timeout: 8
          feedback_timeout: 1
          outputs: {closest_obstacle: gap, closest_obstacle_angle: bearing}
        - set: {gap: 0.0, bearing: 0.0}
    - fallback:
        - sequence:
            - check: $gap > 0.3
            - turn: {angle: "copysign(40, -$bearing)"}
              name: turn away
              timeout: 6
        - turn: {angle: 90}
          name: turn round
          timeout: 9
"""

CAREFUL = """\
mission: careful
world: empty_arena
follow:
  - topic: /battery_state
    type: sensor_msgs/msg/BatteryState
    field: percentage
    as: charge
    initial: 100.0
requirements:
  touches nothing: never collisions > 0
  stands when it is empty: 'whenever historically for 1 s $charge < 15: abs(speed) < 0.05'
  keeps at most one goal: always open_goals < 2
  drives: eventually distance > 0.4
tree:
  fallback:
    - guard: $charge > 20
      do:
        retry: {attempts: 3, pause: 0.2}
        do:
          explore_forward: {fwd_velocity: 0.2, stopping_distance: 0.3}
          name: drive
          cancel_when: current_distance_travelled >= 0.5
          on_cancel: success
          timeout: 6
          acceptance_timeout: 1
          feedback_timeout: 1
    - log: not now
"""

TURNS = """\
mission: turns
world: empty_arena
requirements:
  touches nothing: never collisions > 0
  turns far enough: eventually abs(yaw) > 0.7
  turns no farther: never abs(yaw) > 1.2
tree:
  sequence:
    - retry: {attempts: 3, pause: 0.3}
      do:
        turn: {angle: 50}
        name: turn
        timeout: 6
        feedback_timeout: 0.8
        outputs: {angle_turned: turned, error_code: code}
    - fallback:
        - check: $turned > 40 and $code == 0
        - log: turned too little
    - parallel:
        - move: {secs: 2, linear_velocity: 0.1, angular_velocity: 0.0}
          name: go on
          timeout: 4
        - wait: 1
      succeed_when: all
"""

ASKS = """\
mission: asks
world: empty_arena
requirements:
  touches nothing: never collisions > 0
  drives with power alone: never running("move") and time < 0.05
tree:
  sequence:
    - retry: {attempts: 3, pause: 0.2}
      do:
        service: {name: motor_power, type: std_srvs/srv/SetBool, request: {data: true}}
        name: power
        timeout: 1
    - fallback:
        - wait_for: {topic: scan, type: sensor_msgs/msg/LaserScan, until: range_max > 3}
          name: see
          timeout: 3
        - log: blind
    - timeout: 6
      do:
        repeat: {count: 2}
        do:
          retry: {attempts: 2, pause: 0.5}
          do:
            move: {secs: 1, linear_velocity: 0.15, angular_velocity: 0.0}
            name: move
            timeout: 3
            feedback_timeout: 1
"""

BASES = {"drive": DRIVE, "careful": CAREFUL, "turns": TURNS, "asks": ASKS}
"""Missions that succeed, and stand most of what may go wrong with one part."""


@dataclass(frozen=True)
class MissionDefect:
    """A text of a good mission, and what stands there instead."""

    what: str
    base: str
    good: str
    bad: str


DEFECTS = (
    MissionDefect(
        "drives without a fallback", "drive", "        - set: {gap: 0.0, bearing: 0.0}\n", ""
    ),
    MissionDefect(
        "takes a wall on the right for one on the left",
        "drive",
        "copysign(40, -$bearing)",
        "-40 if $bearing >= 0 else 400",
    ),
    MissionDefect(
        "does not mind the silence of a drive", "drive", "          feedback_timeout: 1\n", ""
    ),
    MissionDefect(
        "comes too near to what is ahead",
        "drive",
        "stopping_distance: 0.4",
        "stopping_distance: 0.06",
    ),
    MissionDefect("counts on the condition alone", "drive", "> 0.6\n", "== 0.6\n"),
    MissionDefect(
        "turns for too long after a short gap", "drive", "turn: {angle: 90}", "turn: {angle: 900}"
    ),
    MissionDefect("has too little time to turn round", "drive", "timeout: 9", "timeout: 2"),
    MissionDefect(
        "does not look at the battery", "careful", "guard: $charge > 20", "guard: $charge > -1"
    ),
    MissionDefect(
        "fails at exactly its limit",
        "careful",
        ">= 0.5",
        "> 0.5 and current_distance_travelled < 0.52",
    ),
    MissionDefect("tries once", "careful", "attempts: 3", "attempts: 1"),
    MissionDefect(
        "waits for an answer too shortly",
        "careful",
        "acceptance_timeout: 1",
        "acceptance_timeout: 0.1",
    ),
    MissionDefect("turns once", "turns", "attempts: 3", "attempts: 1"),
    MissionDefect(
        "gives up where it has turned too little",
        "turns",
        "        - log: turned too little\n",
        "        - check: $turned > 20\n",
    ),
    MissionDefect(
        "does not try to look again", "asks", "        - log: blind\n", "        - check: 1 > 2\n"
    ),
    MissionDefect("asks once", "asks", "attempts: 3", "attempts: 1"),
    MissionDefect("moves once", "asks", "attempts: 2", "attempts: 1"),
)
"""None of them shows where nothing goes wrong."""
