"""Simulations of several processes at the same time, and what each finds in the ROS graph.

``python side_by_side.py 16`` prints as JSON what each of 16 simulations has found, and what two
processes have that are visible. All are of one ROS domain. The simulations stay until the two have
found each other, so that there was time to find more.
"""

from __future__ import annotations

import json
import multiprocessing
import os
import sys
from multiprocessing.connection import Connection
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor

from bt_mission.base.dds.discovery import MACHINE, RANGE
from bt_mission.base.dds.middleware import prepare_middleware
from bt_mission.scenarios.runner import prepare_process
from bt_mission.sessions.load import load
from bt_mission.sessions.stage import Stage
from bt_mission.testing.live_graph import is_in_use

MISSION = """\
mission: turns
world: empty_arena
tree: {turn: {angle: 30}}
"""
TOPICS = ("/scan", "/odom", "/cmd_vel")
SPINS = 600
"""Of a tenth of a second, in which two visible processes must find each other."""

FORK = multiprocessing.get_context("fork")


def simulate(pipe: Connection) -> None:
    """Run a mission; look at the graph before its end, and again when told to."""
    prepare_process()
    with (
        TemporaryDirectory() as folder,
        Stage(load(MISSION), image_folder=Path(folder), say=lambda _: None) as stage,
    ):
        own = sorted(known.node.get_name() for known in stage.inside())
        while stage.executive.ticks < 5:
            stage.step()
        pipe.send("up")
        pipe.recv()
        while not stage.is_done:
            stage.step()
        node = stage.node
        counts = [(node.count_publishers(topic), node.count_subscribers(topic)) for topic in TOPICS]
        seen = {
            "own": own,
            "found": sorted(node.get_node_names()),
            "counts": counts,
            "trace": stage.trace.sha256,
        }
        pipe.send(seen)


def look(pipe: Connection) -> None:
    """Be visible, until another process is found that is, too."""
    os.environ[RANGE] = MACHINE
    prepare_middleware()
    context = Context()
    rclpy.init(context=context)
    name = f"visible_{os.getpid()}"
    node = rclpy.create_node(name, context=context, enable_rosout=False)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    for _ in range(SPINS):
        executor.spin_once(timeout_sec=0.1)
        if sum(node_name.startswith("visible_") for node_name in node.get_node_names()) > 1:
            break
    topics = sorted(name for name, _ in node.get_topic_names_and_types())
    pipe.send({"found": sorted(node.get_node_names()), "topics": topics})
    pipe.recv()


def started(work: Any) -> tuple[Any, Connection]:
    """Start a process; gives it with a pipe to it."""
    ours, theirs = FORK.Pipe()
    process = FORK.Process(target=work, args=(theirs,), daemon=True)
    process.start()
    theirs.close()
    return process, ours


def main(count: int) -> None:
    """Run so many simulations at the same time."""
    stages = [started(simulate) for _ in range(count)]
    for _, pipe in stages:
        pipe.recv()
    is_taken = is_in_use(int(os.environ["ROS_DOMAIN_ID"]))
    visible = [started(look) for _ in range(2)]
    seen = [pipe.recv() for _, pipe in visible]
    for _, pipe in stages:
        pipe.send("go")
    results = [pipe.recv() for _, pipe in stages]
    for _, pipe in visible:
        pipe.send("go")
    for process, _ in (*stages, *visible):
        process.join()
    sys.stdout.write(json.dumps({"stages": results, "visible": seen, "port": is_taken}))


if __name__ == "__main__":
    main(int(sys.argv[1]))
