"""How exactly `bt-mission reproduce` repeats random faulted runs, from the topics of a robot alone.

Run it as: python benchmarks/commands/reproduce/reproduce.py [--count 50] [--folder DIR]
    [--nature PROFILE] [--rough] [--clean]

Run N follows from N: a mission, its world, one or two random faults, a seed. Runs that violate no
requirement and succeed are passed over, and so are missions that do not succeed in a world without
any fault. Every other is recorded, and stripped of all but the topics
of a robot: sensors, transforms, commands, map, log, and the topics of its actions. `reproduce` gets
this file and the requirements of the site. A run counts as

- violated again, if the requirement that was violated first is violated in the simulation, or, of a
  run that violates none, if it ends in the same outcome,
- near, by the mean distance of the recorded and the simulated path,
- named, if the kind of each fault that began is among the faults found; a fault of another kind is
  falsely named.

With `--clean`, the runs have no fault, and all of them count: each fault is falsely named. A thing
that moves in the world of a run may be named: a recording shows it as one that comes and goes.

More like a real robot: `--nature` varies sensors and wheels, and `--rough` loses messages and
records the others late.

Faults that a recording of a robot cannot show are not drawn: those that change what one receiver
gets of a topic, and those in the code of the mission.

The folder keeps the recordings and results, so an interrupted campaign continues.
"""

from __future__ import annotations

import gc
import json
import random
import statistics
import sys
from argparse import Namespace
from collections import Counter
from collections.abc import Iterator
from itertools import islice
from operator import itemgetter
from pathlib import Path
from typing import Any

import yaml

from benchmarks.measuring import arguments
from bt_mission.base.dds.middleware import prepare_middleware
from bt_mission.base.errors import BtMissionError
from bt_mission.base.files import find
from bt_mission.base.yaml.document import read_text
from bt_mission.base.yaml.dump import to_yaml
from bt_mission.cli.recorded_scenario import record_scenario
from bt_mission.commands.reproduce.session import ReproduceOptions, reproduce
from bt_mission.recording.file import McapFile
from bt_mission.recording.reading import Channel, RecordedFile
from bt_mission.scenarios.draws import SeededDraws, maybe, number, one_of
from bt_mission.scenarios.faults.drawable import Drawable
from bt_mission.scenarios.faults.drawing import can_be_drawn, drawn_fault
from bt_mission.scenarios.faults.planned import AtTime, PlannedFault
from bt_mission.scenarios.faults.values import planned_fault
from bt_mission.scenarios.loader import load_scenario
from bt_mission.scenarios.run import run_scenario
from bt_mission.scenarios.runner import silence_logs

SITE = {
    "touches nothing": "never collisions > 0",
    "keeps its distance": "always clearance > 0.08",
    "sees": 'always age("scan") < 0.5',
    "counts its wheels": 'always age("odom") < 0.5',
    "keeps its grip": 'always abs(topic("odom", "twist.twist.linear.x") - speed) < 0.12',
    "does not rush": "always abs(speed) < 0.3",
    "keeps a reserve": "always battery > 20",
}

MISSIONS = yaml.safe_load("""\
visits:
  worlds: [nav_arena]
  actions: [navigate_to_pose]
  tree:
    sequence:
      - {navigate_to_pose: {pose: [-1.5, -1.2, 0]}, timeout: 60}
      - {navigate_to_pose: {pose: [1.5, -0.8, 90]}, timeout: 60}
waypoints:
  worlds: [nav_arena]
  actions: [follow_waypoints]
  tree:
    sequence:
      - {follow_waypoints: {poses: [[1.85, -1.02, 90], [1.87, 1.5, -90]]}, timeout: 80}
square:
  worlds: [empty_arena, nav_arena, dqn_stage2]
  actions: [explore_forward, turn]
  tree:
    repeat: {count: 3}
    do:
      sequence:
        - explore_forward: {fwd_velocity: 0.2, stopping_distance: 0.3}
          cancel_when: current_distance_travelled >= 0.9
          on_cancel: success
          timeout: 15
        - {turn: {angle: 90}, timeout: 15}
explore:
  worlds: [dqn_stage4, dqn_stage2, obstacle_avoidance]
  actions: [explore_forward, turn]
  tree:
    repeat: {count: 3}
    do:
      sequence:
        - {explore_forward: {fwd_velocity: 0.24, stopping_distance: 0.4}, timeout: 20}
        - {turn: {angle: 100}, timeout: 15}
recoveries:
  worlds: [empty_arena, dqn_stage2]
  actions: [drive_on_heading, spin, back_up]
  tree:
    sequence:
      - {drive_on_heading: {target: {x: 1.2}, speed: 0.2}, timeout: 20}
      - {spin: {target_yaw: 1.57}, timeout: 20}
      - {drive_on_heading: {target: {x: 0.8}, speed: 0.15}, timeout: 20}
      - {back_up: {target: {x: 0.4}, speed: 0.1}, timeout: 20}
""")
"""Worlds, actions and tree of each."""

KINDS = (
    *("lidar_noise", "lidar_bias", "lidar_blind", "lidar_frozen", "lidar_dead"),
    *("odometry_error", "odometry_drift", "odometry_dead"),
    *("slip_wheel", "block_wheel", "motors_off", "push", "shove", "battery_charge"),
    *("reject_goals", "ignore_goals", "drop_answers", "delay_answers", "drop_results"),
    *("delay_results", "refuse_cancels", "ignore_cancels", "abort_goal", "kill_server"),
    *("spawn_box", "spawn_cylinder"),
)
"""The kinds that are drawn, all as likely."""

ROBOT_TOPICS = frozenset(
    (
        *("/scan", "/odom", "/tf", "/tf_static", "/cmd_vel", "/battery_state", "/imu"),
        *("/joint_states", "/map", "/rosout"),
    )
)
SENSOR_TOPICS = frozenset(("/scan", "/odom", "/tf", "/imu", "/joint_states", "/battery_state"))
MOVED = ("spawn_box", "spawn_cylinder", "move_box")
"""The faults that a thing looks like which moves in the world."""
LIMIT_S = 60.0
MOST_TRIES = 100_000


def drawn_scenario(
    n: int, nature: str = "", *, is_clean: bool = False
) -> tuple[dict[str, Any], list[PlannedFault]]:
    """Return scenario N as data, and its faults."""
    draws = SeededDraws(f"reproduce/{n}")
    name = one_of(draws, sorted(MISSIONS))
    mission = MISSIONS[name]
    faults = []
    for _ in range(0 if is_clean else 2 if maybe(draws, 3) else 1):
        kind = one_of(draws, KINDS)
        begins = AtTime(number(draws, 1.0, 14.0, 0.25))
        if kind.startswith("spawn_"):
            place = {
                "ahead": number(draws, 0.5, 1.2, 0.05),
                "left": number(draws, -0.3, 0.3, 0.05),
                "nearest_free": True,
            }
            faults.append(planned_fault(begins, kind, **place))
            continue
        drawable = Drawable(
            (kind,), actions=tuple(mission["actions"]), times=(1.0, 14.0), lasting=(0.5, 6.0)
        )
        if can_be_drawn(kind, drawable):
            faults += drawn_fault(draws, drawable)
    data = {
        "scenario": f"run {n}",
        "mission": {
            "mission": name,
            "world": one_of(draws, mission["worlds"]),
            "tree": mission["tree"],
        },
        "seed": n,
        "faults": [fault.text for fault in faults],
        "requirements": SITE,
        "limit": LIMIT_S,
        "expect": {"outcome": "any", "orphaned_goals": "any"},
    }
    return data | ({"nature": nature} if nature else {}), faults


LOST_SHARE, LATE_S, LATEST_S = 0.02, 0.004, 0.08
"""Of rough signals: lost messages; the usual lateness, and the largest."""


def strip(source: Path, target: Path, n: int, *, is_rough: bool) -> None:
    """Write a recording with the topics of a robot alone: no facts, no truth, no mission."""
    draws = random.Random(f"signals/{n}")
    kept: list[tuple[int, int, Channel, bytes]] = []
    for nth, (time_ns, channel, data) in enumerate(RecordedFile(source).timed_messages()):
        topic, late_ns = channel.topic, 0
        if topic not in ROBOT_TOPICS and "/_action/" not in topic:
            continue
        if is_rough and topic in SENSOR_TOPICS:
            if draws.random() < LOST_SHARE:
                continue
            late_ns = round(1e9 * min(draws.expovariate(1 / LATE_S), LATEST_S))
        kept.append((time_ns + late_ns, nth, channel, data))
    file = McapFile(target, "robot")
    channels: dict[str, int] = {}
    for time_ns, _, channel, content in sorted(kept, key=itemgetter(0, 1)):
        topic = channel.topic
        if topic not in channels:
            channels[topic] = file.channel(topic, channel.type_name, channel.definition, {})
        file.write(time_ns, [(channels[topic], content)])
    file.close()


def make(n: int, folder: Path, options: Namespace) -> None:
    """Make the recording of run N, if it counts."""
    data, faults = drawn_scenario(n, options.nature, is_clean=options.clean)
    scenario = folder / f"{n}.scenario.yaml"
    scenario.write_text(to_yaml(data), encoding="utf-8")
    whole, stripped = folder / f"{n}.whole.mcap", folder / f"{n}.mcap"
    try:
        loaded = load_scenario(read_text(to_yaml(data), str(scenario)))
        report = record_scenario(loaded, whole).report
    except BtMissionError as error:
        print(f"{n}: {error}", file=sys.stderr)
        return
    violated = sorted(
        (result.violated_at or 0.0, result.name)
        for result in report.requirements
        if result.verdict == "violated"
    )
    began = [
        fault.name
        for fault, outcome in zip(faults, report.faults, strict=True)
        if outcome.began is not None
    ]
    if options.clean or (began and (violated or report.status != "success")):
        strip(whole, stripped, n, is_rough=options.rough)
        truth = {
            "run": n,
            "faults": [outcome.fault for outcome in report.faults],
            "began": began,
            "violated": [name for _, name in violated],
            "outcome": report.status,
            "reason": report.reason,
            "virtual_s": report.virtual_s,
        }
        (folder / f"{n}.json").write_text(json.dumps(truth), encoding="utf-8")
    else:
        scenario.unlink()
    whole.unlink(missing_ok=True)


def is_good(n: int, folder: Path, known: dict[str, bool]) -> bool:
    """Return whether the mission of run N violates nothing in its world without faults."""
    data, _ = drawn_scenario(n)
    mission = data["mission"]
    key = f"{mission['mission']} in {mission['world']}"
    if key not in known:
        plain = {**data, "faults": []}
        scenario = load_scenario(read_text(to_yaml(plain), str(folder / "plain.yaml")))
        result = run_scenario(scenario)
        known[key] = result.report.status == "success" and not result.violated
        print(f"{key}: {'good' if known[key] else 'fails without a fault, so it is left out'}")
    return known[key]


def has_motion(world: str) -> bool:
    """Return whether something moves in a world."""
    return "motion:" in find("worlds", world).read_text(encoding="utf-8")


def judge(n: int, folder: Path, site: Path, budget: int) -> dict[str, Any]:
    """Reproduce run N; return the comparison with its truth."""
    truth = json.loads((folder / f"{n}.json").read_text(encoding="utf-8"))
    options = ReproduceOptions(requirements=[site], violated=truth["violated"], budget=budget)
    try:
        got = reproduce([folder / f"{n}.mcap"], folder / f"case{n}", options).as_dict()
    except Exception as error:  # noqa: BLE001 - one run must not end the campaign
        return {**truth, "error": f"{type(error).__name__}: {error}"[-600:]}
    finally:
        gc.collect()
    named = {fault["name"] for fault in got["faults"]}
    world = yaml.safe_load((folder / f"{n}.scenario.yaml").read_text())["mission"]["world"]
    there = (*truth["began"], *(MOVED if has_motion(world) else ()))
    false = [fault["name"] for fault in got["faults"] if fault["name"] not in there]
    violated = truth["violated"]
    simulated = got["verdict_simulated"]
    again = (
        violated[0] in simulated["violated"]
        if violated
        else simulated["outcome"] == truth["outcome"]
    )
    return {
        **truth,
        "again": again,
        "mean": got["path_error_m"]["mean"],
        "largest": got["path_error_m"]["largest"],
        "found": [f"{fault['name']} {fault['start']}..{fault['end']}" for fault in got["faults"]],
        "named": [kind in named for kind in truth["began"]],
        "false": false,
        "simulated": simulated,
        "unexplained": got["unexplained"],
    }


def made(folder: Path, options: Namespace) -> Iterator[int]:
    """Yield the runs that count, made where they are missing."""
    tried, plain = folder / "tried.txt", folder / "plain.json"
    done = set(map(int, tried.read_text().split())) if tried.exists() else set()
    known: dict[str, bool] = json.loads(plain.read_text()) if plain.exists() else {}
    for n in range(MOST_TRIES):
        if n not in done:
            make(n, folder, options)
            with tried.open("a") as file:
                file.write(f"{n}\n")
        if (folder / f"{n}.json").exists() and is_good(n, folder, known):
            yield n
        plain.write_text(json.dumps(known), encoding="utf-8")


def summarise(results: list[dict[str, Any]]) -> None:
    """Print the figures of a campaign."""
    ran = [result for result in results if "error" not in result]
    again = sum(result["again"] for result in ran)
    first = sum(any(result["named"]) for result in ran)
    named = sum(all(result["named"]) for result in ran)
    means = [result["mean"] for result in ran if result["mean"] is not None]
    print(f"runs: {len(results)}, errors: {len(results) - len(ran)}")
    print(f"violated again: {again}; all faults named: {named}; at least one named: {first}")
    if means:
        near = statistics.quantiles(means, n=4) if len(means) > 1 else means
        print(f"mean path difference, quartiles: {[round(value, 3) for value in near]} m")
    false = Counter(kind for result in ran for kind in result["false"])
    wrong = sum(bool(result["false"]) for result in ran)
    print(f"falsely named: {false.total()} in {wrong} runs, {dict(false)}")
    kinds, missed = Counter[str](), Counter[str]()
    for result in ran:
        for kind, is_named in zip(result["began"], result["named"], strict=True):
            kinds[kind] += 1
            missed[kind] += not is_named
    for kind, total in sorted(kinds.items()):
        print(f"  {kind}: {total - missed[kind]} of {total} named")


def main() -> None:
    """Make the runs that are missing, reproduce all, and print the figures."""
    options = arguments(
        __doc__,
        count=50,
        folder=Path("reproduced"),
        budget=(12, "simulated runs of each"),
        nature=("", "profile of the simulated runs"),
        rough=(False, "lose messages, and record the others late"),
        clean=(False, "without faults"),
    )
    folder: Path = options.folder
    folder.mkdir(parents=True, exist_ok=True)
    site = folder / "site.yaml"
    site.write_text(to_yaml({"requirements": SITE}), encoding="utf-8")
    prepare_middleware()
    silence_logs()
    results = []
    with (folder / "results.jsonl").open("w", encoding="utf-8") as lines:
        for n in islice(made(folder, options), options.count):
            result = judge(n, folder, site, options.budget)
            results.append(result)
            lines.write(json.dumps(result) + "\n")
            lines.flush()
            print(n, result.get("error", ""), result.get("again"), result.get("mean"), flush=True)
    summarise(results)


if __name__ == "__main__":
    main()
