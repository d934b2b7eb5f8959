"""The executive of a running graph that the options name."""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from bt_mission.executive.events.source import ExecutiveSource, ListedExecutive
    from bt_mission.ros.discovery import ExecutiveDirectory

WAIT_S = 0.1
LEARN_S = 0.6
"""Wall time to wait for the names of missions."""

SAY_S = 1.8
"""Wall time after which a line reports that no executive is there."""


def look_for(observer: ExecutiveDirectory, options: argparse.Namespace) -> ExecutiveSource | None:
    """Return the executive that the options name, once it is there; None if it is late."""
    from bt_mission.base.wall_clock import Stopwatch
    from bt_mission.executive.events.source import choose, nobody, wanted_name

    wanted = wanted_name(options.executive)
    since = Stopwatch()
    missions: dict[str, str] = {}
    has_said = False
    while True:
        observer.serve(WAIT_S)
        is_over = observer.is_over()
        executives = observer.find()
        is_late = options.wait is not None and since.elapsed_s > options.wait
        is_named = any(executive.name == wanted for executive in executives)
        if is_named or (executives and (is_over or is_late)):
            if wanted is not None and not is_named:
                _learn_missions(observer, executives, missions)
                named = [name for name, mission in missions.items() if mission == options.executive]
                wanted = named[0] if len(named) == 1 else wanted
            chosen = choose(executives, wanted)
            if chosen is not None:
                if chosen.problem:
                    print(f"{chosen.name}: {chosen.problem}", file=sys.stderr)
                return observer.attach(chosen.name, with_robot=False)
        if is_late:
            print(nobody(wanted, executives, observer.where), file=sys.stderr)
            return None
        if not has_said and since.elapsed_s > SAY_S and (is_over or not executives):
            print(f"{nobody(wanted, executives, observer.where)}\nlooking ...", file=sys.stderr)
            has_said = True


def _learn_missions(
    observer: ExecutiveDirectory, executives: Sequence[ListedExecutive], missions: dict[str, str]
) -> None:
    """Note the name of the mission that each executive runs, as far as they say it in time."""
    from bt_mission.base.wall_clock import Stopwatch
    from bt_mission.executive.events.feed import MissionFeed
    from bt_mission.executive.events.mission_state import MissionState

    new = [each.name for each in executives if each.name not in missions and not each.is_foreign]
    links = {name: observer.attach(name, with_robot=False) for name in new}
    feeds = {name: MissionFeed(MissionState()) for name in new}
    since = Stopwatch()
    while links.keys() - missions.keys() and since.elapsed_s < LEARN_S:
        observer.serve(WAIT_S)
        for name, link in links.items():
            for batch in link.take(needs_statuses=False).messages:
                feeds[name].take(batch)
            if tree := feeds[name].mission.tree:
                missions[name] = tree.mission
    for link in links.values():
        link.close()
