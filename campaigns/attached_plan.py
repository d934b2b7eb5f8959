"""The disturbances of a trial of `campaigns/attached_campaign.py`; they derive from a number."""

from __future__ import annotations

from dataclasses import dataclass

import yaml

from bt_mission.scenarios.draws import SeededDraws, maybe, number, one_of
from bt_mission.testing.generators.missions import drawn_mission

LEGS = """\
mission: legs
tree:
  repeat: {count: 3}
  do:
    retry: {attempts: 3, pause: 1}
    do:
      sequence:
        - explore_forward: {fwd_velocity: 0.26, stopping_distance: 0.4}
          name: drive
          cancel_when: current_distance_travelled > 1.5
          on_cancel: success
          timeout: 30
        - turn: {angle: 120, angular_velocity: 1.5}
          timeout: 30
"""
DRIVE = """\
mission: drive
tree:
  repeat: {count: 20}
  do:
    sequence:
      - {explore_forward: {fwd_velocity: 0.26, stopping_distance: 0.3}, timeout: 100}
      - {turn: {angle: 150}, timeout: 30}
"""
TEXTS = {"legs": LEGS, "drive": DRIVE}
MISSIONS = ("legs", "drive", "square", "explore_random", "patrol", "drawn")
WORLDS = {"patrol": "nav_arena", "explore_random": "dqn_stage4", "drawn": "dqn_stage4"}
PROCESSES = ("executive", "servers", "arbiter", "sim")


@dataclass(frozen=True)
class Disturbance:
    """A disturbance of a process: `kill` (for good), `stop` (and continued) or `restart`."""

    process: str
    what: str
    after_s: float
    """Seconds of the wall clock since the one before, or since the first goal was accepted."""
    lasts_s: float
    """Seconds until it is continued or started again."""

    def __str__(self) -> str:
        return f"{self.what} {self.process} after {self.after_s:g} s ({self.lasts_s:g} s)"


@dataclass(frozen=True)
class Plan:
    """Everything that derives from the number of a trial."""

    mission: str
    text: str
    """The mission's text; empty for a shipped one."""
    world: str
    with_arbiter: bool
    serves: bool
    """Whether the executive is `serve`, given the mission as a goal."""
    is_early: bool
    """Whether the first instant counts from the start of the executive."""
    awaits_end: bool
    """Whether the mission runs to its end, instead of Ctrl-C."""
    disturbances: tuple[Disturbance, ...]

    def __str__(self) -> str:
        done = ", ".join(map(str, self.disturbances))
        way = "serve" if self.serves else "run"
        arbiter = ", arbiter" if self.with_arbiter else ""
        early = ", from its start" if self.is_early else ""
        return f"{way} {self.mission}{arbiter}{early}: {done}"


def plan(trial: int) -> Plan:
    """Draw a trial."""
    draws = SeededDraws(f"attached/{trial}")
    mission = one_of(draws, MISSIONS)
    text = TEXTS.get(mission, "")
    if mission == "drawn":
        text = yaml.safe_dump(drawn_mission(draws), sort_keys=False)
    with_arbiter = maybe(draws, 2)
    chosen = (
        PROCESSES
        if with_arbiter
        else tuple(process for process in PROCESSES if process != "arbiter")
    )
    disturbances = tuple(
        Disturbance(
            one_of(draws, chosen),
            one_of(draws, ("kill", "stop", "restart")),
            number(draws, 0.0, 8.0, 0.001),
            number(draws, 0.1, 4.0, 0.001),
        )
        for _ in range(1 + maybe(draws, 3))
    )
    return Plan(
        mission,
        text,
        WORLDS.get(mission, "empty_arena"),
        with_arbiter,
        serves=maybe(draws, 4),
        is_early=maybe(draws, 4),
        awaits_end=mission == "legs" and maybe(draws, 2),
        disturbances=disturbances,
    )
