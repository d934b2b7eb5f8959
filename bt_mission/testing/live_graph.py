"""Sim, servers and executive as processes of their own: for the few tests that need them so."""

from __future__ import annotations

import fcntl
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from bt_mission.testing.errors import ScenarioError
from bt_mission.testing.processes import LOCAL, Process, command

DOMAINS = range(1, 102)
"""DDS domain ids. Those above reach into Linux' range of ephemeral ports."""

READY = "ready: scan and odometry have come"


class LiveGraph:
    """A ROS graph on this machine, which only those see who are told its domain.

    What is started here is killed at the end of the test, and what it said is shown when the test
    fails. Times are those of the wall: use the fixture ``stage`` where it will do.

    Args:
        folder: For output and missions.
        domain_id: Of DDS.
    """

    def __init__(self, folder: Path, domain_id: int) -> None:
        self.folder = folder
        self.domain_id = domain_id
        self.environment = {"ROS_DOMAIN_ID": str(domain_id), **LOCAL}
        self.processes: list[Process] = []

    def start(self, *arguments: str) -> Process:
        """Start ``bt-mission`` with these arguments, such as ``"topics", "list"``."""
        return self.start_program(arguments[0], *command(*arguments))

    def start_program(self, name: str, *arguments: str) -> Process:
        """Start any program in this graph.

        Args:
            name: For people; a number is put behind it where it is taken.
        """
        same = sum(one.name.split(" ")[0] == name for one in self.processes)
        full = f"{name} {same + 1}" if same else name
        file = self.folder / f"{full.replace(' ', '_')}.log"
        self.processes.append(Process(full, list(arguments), self.environment, file))
        return self.processes[-1]

    def robot(
        self, world: str | Path = "empty_arena", robot: str = "waffle", *sim: str
    ) -> tuple[Process, Process]:
        """Start a robot in a world, and its action servers; gives both when they are ready.

        Args:
            world: A world's name or file.
            robot: A robot's name or file.
            sim: More options of ``bt-mission sim``, such as ``"--speed", "5"``.
        """
        simulator = self.start("sim", "--world", str(world), "--robot", str(robot), *sim)
        servers = self.start("servers", "--robot", str(robot))
        servers.until(READY)
        return simulator, servers

    def run(self, mission: str | Path, *options: str) -> Process:
        """Start a mission on the robots that are there.

        Args:
            mission: A file, the name of a shipped mission, or a mission as text (of several lines).
            options: More options of ``bt-mission run --attach``.
        """
        text = str(mission)
        if "\n" in text:
            number = sum(1 for _ in self.folder.glob("mission_*.yaml")) + 1
            path = self.folder / f"mission_{number}.yaml"
            path.write_text(text, encoding="utf-8")
            text = str(path)
        return self.start("run", text, "--attach", "--plain", *options)

    def close(self) -> None:
        """Kill what still runs."""
        for process in reversed(self.processes):
            process.kill()


@contextmanager
def own_domain(folder: Path | None = None) -> Iterator[int]:
    """A DDS domain id that no other test on this machine has, as long as this is open.

    It is claimed by a lock on a file, which the system takes back however a process ends.

    Args:
        folder: Where the locks are; None is that for temporary files.

    Raises:
        ScenarioError: When all are taken.
    """
    parent = folder or Path(tempfile.gettempdir())
    first = os.getpid() % len(DOMAINS)
    for domain_id in (*DOMAINS[first:], *DOMAINS[:first]):
        try:
            lock = (parent / f"bt_mission_domain_{domain_id}.lock").open("a")
        except OSError:  # another user's
            continue
        with lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                continue
            yield domain_id
            return
    raise ScenarioError(f"all {len(DOMAINS)} DDS domains are taken by other tests of this machine")
