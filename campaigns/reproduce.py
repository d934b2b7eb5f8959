"""How exactly `bt-mission reproduce` repeats random faulted runs, from the topics of a robot alone.

Run it as: python campaigns/reproduce.py [--count 50] [--folder DIR] [--first N] [--make-only]
    [--nature PROFILE] [--without-map] [--rough] [--without-faults]

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

More like a real robot: `--nature` varies sensors and wheels, `--without-map` leaves out the map and
the place of the robot on it, `--rough` loses messages and records the others late. With
`--without-faults` runs without any fault count, so each fault that is named is named falsely.

Faults that a recording of a robot cannot show are not drawn: those that change what one receiver
gets of a topic, and those in the code of the mission.

The folder keeps the recordings and results, so an interrupted campaign continues.
"""

from __future__ import annotations

import argparse
import gc
import json
import random
import statistics
import sys
from collections import Counter
from dataclasses import dataclass
from itertools import count
from operator import itemgetter
from pathlib import Path
from typing import Any

from rclpy.serialization import deserialize_message, serialize_message
from tf2_msgs.msg import TFMessage

from bt_mission.core.dds.middleware import prepare_middleware
from bt_mission.core.draws import SeededDraws, maybe, number, one_of
from bt_mission.core.errors import BtMissionError
from bt_mission.core.yaml.document import read_text
from bt_mission.core.yaml.dump import to_yaml
from bt_mission.faults.drawable import Drawable
from bt_mission.faults.drawing import can_be_drawn, drawn_fault
from bt_mission.faults.planned import AtTime, PlannedFault
from bt_mission.faults.values import planned_fault
from bt_mission.recording.file import McapFile
from bt_mission.recording.reading import Channel, RecordedFile
from bt_mission.reproducing.session import ReproduceOptions, reproduce
from bt_mission.scenarios.loader import load_scenario
from bt_mission.scenarios.run import run_scenario
from bt_mission.scenarios.runner import silence_logs
from bt_mission.sweeps.work import record_scenario

SITE = {
    "touches nothing": "never collisions > 0",
    "keeps its distance": "always clearance > 0.08",
    "sees": 'always age("scan") < 0.5',
    "counts its wheels": 'always age("odom") < 0.5',
    "keeps its grip": 'always abs(topic("odom", "twist.twist.linear.x") - speed) < 0.12',
    "does not rush": "always abs(speed) < 0.3",
    "keeps a reserve": "always battery > 20",
}

MISSIONS: dict[str, tuple[tuple[str, ...], Any]] = {
    "visits": (
        ("nav_arena",),
        {
            "sequence": [
                {"navigate_to_pose": {"pose": [-1.5, -1.2, 0]}, "timeout": 60},
                {"navigate_to_pose": {"pose": [1.5, -0.8, 90]}, "timeout": 60},
            ]
        },
    ),
    "waypoints": (
        ("nav_arena",),
        {
            "sequence": [
                {
                    "follow_waypoints": {"poses": [[1.85, -1.02, 90], [1.87, 1.5, -90]]},
                    "timeout": 80,
                }
            ]
        },
    ),
    "square": (
        ("empty_arena", "nav_arena", "dqn_stage2"),
        {
            "repeat": {"count": 3},
            "do": {
                "sequence": [
                    {
                        "explore_forward": {"fwd_velocity": 0.2, "stopping_distance": 0.3},
                        "cancel_when": "current_distance_travelled >= 0.9",
                        "on_cancel": "success",
                        "timeout": 15,
                    },
                    {"turn": {"angle": 90}, "timeout": 15},
                ]
            },
        },
    ),
    "explore": (
        ("dqn_stage4", "dqn_stage2", "obstacle_avoidance"),
        {
            "repeat": {"count": 3},
            "do": {
                "sequence": [
                    {
                        "explore_forward": {"fwd_velocity": 0.24, "stopping_distance": 0.4},
                        "timeout": 20,
                    },
                    {"turn": {"angle": 100}, "timeout": 15},
                ]
            },
        },
    ),
    "recoveries": (
        ("empty_arena", "dqn_stage2"),
        {
            "sequence": [
                {"drive_on_heading": {"target": {"x": 1.2}, "speed": 0.2}, "timeout": 20},
                {"spin": {"target_yaw": 1.57}, "timeout": 20},
                {"drive_on_heading": {"target": {"x": 0.8}, "speed": 0.15}, "timeout": 20},
                {"back_up": {"target": {"x": 0.4}, "speed": 0.1}, "timeout": 20},
            ]
        },
    ),
}
"""Worlds and tree of each."""

ACTIONS = {
    "visits": ("navigate_to_pose",),
    "waypoints": ("follow_waypoints",),
    "square": ("explore_forward", "turn"),
    "explore": ("explore_forward", "turn"),
    "recoveries": ("drive_on_heading", "spin", "back_up"),
}

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
LIMIT_S = 60.0
MOST_TRIES = 100_000


def drawn_scenario(n: int) -> tuple[str, dict[str, Any], list[PlannedFault]]:
    """Return scenario N as data, the name of its mission, and its faults."""
    draws = SeededDraws(f"reproduce/{n}")
    name = one_of(draws, sorted(MISSIONS))
    worlds, tree = MISSIONS[name]
    faults = []
    for _ in range(2 if maybe(draws, 3) else 1):
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
        drawable = Drawable((kind,), actions=ACTIONS[name], times=(1.0, 14.0), lasting=(0.5, 6.0))
        if can_be_drawn(kind, drawable):
            faults += drawn_fault(draws, drawable)
    data = {
        "scenario": f"run {n}",
        "mission": {"mission": name, "world": one_of(draws, worlds), "tree": tree},
        "seed": n,
        "faults": [fault.text for fault in faults],
        "requirements": SITE,
        "limit": LIMIT_S,
        "expect": {"outcome": "any", "orphaned_goals": "any"},
    }
    return name, data, faults


@dataclass(frozen=True)
class Signals:
    """How a robot is recorded.

    Attributes:
        nature: The profile of the simulated run.
        has_map: Whether something places the robot on a map.
        is_rough: Whether messages are lost, and recorded late.
        has_faults: Whether the drawn faults are injected.
    """

    nature: str | None = None
    has_map: bool = True
    is_rough: bool = False
    has_faults: bool = True

    def head(self, n: int) -> tuple[dict[str, Any], list[PlannedFault]]:
        """Return scenario N as data, and its faults."""
        _, data, faults = drawn_scenario(n)
        if not self.has_faults:
            data, faults = {**data, "faults": []}, []
        return data if self.nature is None else {**data, "nature": self.nature}, faults


LOST_SHARE, LATE_S, LATEST_S = 0.02, 0.004, 0.08
"""Of rough signals: lost messages; the usual lateness, and the largest."""


def strip(source: Path, target: Path, signals: Signals, n: int) -> None:
    """Write a recording with the topics of a robot alone: no facts, no truth, no mission."""
    draws = random.Random(f"signals/{n}")
    kept: list[tuple[int, int, Channel, bytes]] = []
    for nth, (time_ns, channel, data) in enumerate(RecordedFile(source).timed_messages()):
        topic, content, late_ns = channel.topic, data, 0
        if topic not in ROBOT_TOPICS and "/_action/" not in topic:
            continue
        if not signals.has_map and topic == "/map":
            continue
        if not signals.has_map and topic == "/tf":
            content = _without_map(data)
        if signals.is_rough and topic in SENSOR_TOPICS:
            if draws.random() < LOST_SHARE:
                continue
            late_ns = round(1e9 * min(draws.expovariate(1 / LATE_S), LATEST_S))
        kept.append((time_ns + late_ns, nth, channel, content))
    file = McapFile(target, "robot")
    channels: dict[str, int] = {}
    for time_ns, _, channel, content in sorted(kept, key=itemgetter(0, 1)):
        topic = channel.topic
        if topic not in channels:
            channels[topic] = file.channel(topic, channel.type_name, channel.definition, {})
        file.write(time_ns, [(channels[topic], content)])
    file.close()


def _without_map(data: bytes) -> bytes:
    """Return transforms without those of the map."""
    message = deserialize_message(data, TFMessage)
    message.transforms = [each for each in message.transforms if each.header.frame_id != "map"]
    content: bytes = serialize_message(message)
    return content


def make(n: int, folder: Path, signals: Signals) -> bool:
    """Make the recording of run N; return whether it counts."""
    data, faults = signals.head(n)
    scenario = folder / f"{n}.scenario.yaml"
    scenario.write_text(to_yaml(data), encoding="utf-8")
    whole, stripped = folder / f"{n}.whole.mcap", folder / f"{n}.mcap"
    try:
        report = record_scenario(load_scenario(read_text(to_yaml(data), str(scenario))), whole)
    except BtMissionError as error:
        print(f"{n}: {error}", file=sys.stderr)
        return False
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
    counts = bool(began) and bool(violated or report.status != "success")
    if not signals.has_faults:
        counts = not violated and report.status == "success"
    if counts:
        strip(whole, stripped, signals, n)
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
    return counts


def is_good(n: int, folder: Path, known: dict[str, bool]) -> bool:
    """Return whether the mission of run N violates nothing in its world without faults."""
    _, data, _ = drawn_scenario(n)
    mission = data["mission"]
    key = f"{mission['mission']} in {mission['world']}"
    if key not in known:
        plain = {**data, "faults": []}
        scenario = load_scenario(read_text(to_yaml(plain), str(folder / "plain.yaml")))
        result = run_scenario(scenario)
        known[key] = result.report.status == "success" and not result.violated
        print(f"{key}: {'good' if known[key] else 'fails without a fault, so it is left out'}")
    return known[key]


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
    false = [fault["name"] for fault in got["faults"] if fault["name"] not in truth["began"]]
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


def main() -> None:
    """Make the runs that are missing, reproduce all, and print the figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--count", type=int, default=50)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--folder", type=Path, default=Path("reproduced"))
    parser.add_argument("--make-only", action="store_true")
    parser.add_argument("--budget", type=int, default=12)
    parser.add_argument("--nature")
    parser.add_argument("--without-map", action="store_true")
    parser.add_argument("--rough", action="store_true")
    parser.add_argument("--without-faults", action="store_true")
    options = parser.parse_args()
    signals = Signals(
        options.nature, not options.without_map, options.rough, not options.without_faults
    )
    folder: Path = options.folder
    folder.mkdir(parents=True, exist_ok=True)
    site = folder / "site.yaml"
    site.write_text(to_yaml({"requirements": SITE}), encoding="utf-8")
    runs = _made(folder, options.first, options.count, signals)
    if options.make_only:
        return
    results = []
    with (folder / "results.jsonl").open("w", encoding="utf-8") as lines:
        for n in runs:
            result = judge(n, folder, site, options.budget)
            results.append(result)
            lines.write(json.dumps(result) + "\n")
            lines.flush()
            print(n, result.get("error", ""), result.get("again"), result.get("mean"), flush=True)
    _tell(results)


def _made(folder: Path, first: int, wanted: int, signals: Signals) -> list[int]:
    tried = folder / "tried.txt"
    done = set(map(int, tried.read_text().split())) if tried.exists() else set()
    prepare_middleware()
    silence_logs()
    runs: list[int] = []
    plain = folder / "plain.json"
    known: dict[str, bool] = json.loads(plain.read_text()) if plain.exists() else {}
    for n in count(first):
        if len(runs) == wanted or n > MOST_TRIES:
            return runs
        if n not in done:
            make(n, folder, signals)
            with tried.open("a") as file:
                file.write(f"{n}\n")
        if (folder / f"{n}.json").exists() and is_good(n, folder, known):
            runs.append(n)
        plain.write_text(json.dumps(known), encoding="utf-8")
    return runs


def _tell(results: list[dict[str, Any]]) -> None:
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


if __name__ == "__main__":
    main()
