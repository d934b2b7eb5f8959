#!/usr/bin/env python
"""Run exported missions in BehaviorTree.CPP and here, with the same stub leaves, and compare.

    compare_btcpp.py [--prefix /opt/ros/jazzy] [--seeds 20] [MISSION.yaml ...]

BehaviorTree.CPP 4.10 has to be installed below the prefix, with its headers; a C++ compiler builds
`run_stubs.cpp` against it, in a temporary folder. Without missions all shipped ones and one with
ports that change are tried. Each is exported with its palette, whose leaves are registered with the
ports and types that the palette gives.

A stub leaf ends after 0 to 39 further ticks. By a hash of the seed, its name and how often it has
run, it fails or succeeds, and gives numbers to its outputs; with seed 0 no leaf fails. The two
runs are the same where the same leaves end and are halted in the same order with the same
outcomes, and the trees end alike. The exit code is 0 if all are.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from xml.etree import ElementTree as ET

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from bt_mission.commands.convert.document import document_of
from bt_mission.commands.convert.table import OUT, leaf_kinds, leaf_row
from bt_mission.executive.behaviours import builder
from bt_mission.executive.behaviours.evaluator import Evaluator
from bt_mission.executive.behaviours.hooks import Hooked
from bt_mission.executive.behaviours.runtime import Scope
from bt_mission.language.loader import required
from bt_mission.language.mission import Mission
from bt_mission.language.nodes.registry import KINDS
from bt_mission.requirements.mission_file import read_mission
from bt_mission.sessions.load import convert

ROOT = Path(__file__).resolve().parents[3]
MOST_TICKS = 20_000
SHIPPED = [
    path
    for path in sorted((ROOT / "missions").rglob("*.yaml"))
    if "scenario" not in path.name and "fleet" not in path.name
]
MISSIONS = [*SHIPPED, ROOT / "tests/commands/convert/live_ports.yaml"]
NEVER_FAIL = ("log ", "set ", "wait ")


@dataclass(frozen=True)
class Rule:
    """What a leaf does the nth time: the same rule as in `run_stubs.cpp`."""

    fails: bool
    ticks: int
    number: float

    @classmethod
    def of(cls, seed: int, leaf: str, count: int) -> Rule:
        """Return it, by a hash (FNV-1a of 64 bits)."""
        value = 14695981039346656037
        for byte in f"{seed}/{leaf}/{count}".encode():
            value = (value ^ byte) * 1099511628211 % 2**64
        never = seed == 0 or leaf.startswith(NEVER_FAIL)
        fails = not never and (value >> 8) % 100 < 25
        return cls(fails, (value >> 20) % 40, (value >> 32) % 181 - 90.0)


class Play:
    """The run of a mission with stub leaves.

    Args:
        mission: Its leaves are replaced.
        types: The type of each output, by leaf and attribute.
    """

    def __init__(self, mission: Mission, types: dict[tuple[str, str], str], seed: int) -> None:
        self.types = types
        self.seed = seed
        self.counts: Counter[str] = Counter()
        self.lines: list[str] = []
        self.scope = Scope(dict(mission.inputs), mission.seed)
        self._former = dict(builder.BEHAVIOURS)
        builder.BEHAVIOURS.update({KINDS[kind]: self._stub for kind in leaf_kinds()})
        try:
            self.tree = builder.build_tree(mission, self.scope)
        finally:
            builder.BEHAVIOURS.update(self._former)

    def run(self) -> list[str]:
        """Tick it to its end; gives a line for each leaf that ended, and the tree's status."""
        for _ in range(MOST_TICKS):
            self.tree.tick_once()
            if self.tree.status is not Status.RUNNING:
                break
        return [*self.lines, f"tree {self.tree.status.name}"]

    def _stub(self, node: Any, values: Evaluator) -> Behaviour:
        line, column = (int(number) for number in values.place.rsplit(":", 2)[1:])
        document = values.mission.document
        tag = re.split(r"[\s/>]", document.lines[line - 1][column - 1 :], maxsplit=1)[0]
        if leaf_row(tag):
            return _Stub(self, tag, node, values)
        # An element of BehaviorTree.CPP, which runs there as it is: a script, or a Sleep.
        return _Ended(node.label) if node.kind == "wait" else self._former[type(node)](node, values)


class _Ended(Hooked):
    """A `Sleep`, which is not waited for."""

    def update(self) -> Status:
        return Status.SUCCESS


class _Stub(Hooked):
    def __init__(self, play: Play, tag: str, node: Any, values: Evaluator) -> None:
        super().__init__(node.label)
        self._play, self._tag, self._leaf_node, self._scope = play, tag, node, values.scope
        self._leaf = f"{tag} {node.name or tag}"

    def initialise(self) -> None:
        play = self._play
        self._rule = Rule.of(play.seed, self._leaf, play.counts[self._leaf])
        self._left = self._rule.ticks
        play.counts[self._leaf] += 1
        if self._leaf_node.kind == "set":
            scope = self._scope.values
            scope.update(dict.fromkeys(self._leaf_node.values, 1.0))

        tag, number = self._tag, self._rule.number
        given = {"int": int(number), "bool": number > 0, "std::string": "text"}
        for field, variable in getattr(self._leaf_node, "outputs", {}).items():
            label = play.types.get((tag, OUT + field.replace(".", "__")), "")
            self._scope.values[variable] = given.get(label, number)

    def update(self) -> Status:
        if self._left > 0:
            self._left -= 1
            return Status.RUNNING
        status = Status.FAILURE if self._rule.fails else Status.SUCCESS
        self._play.lines.append(f"{self._leaf} {status.name}")
        return status

    def terminate(self, new_status: Status) -> None:
        if new_status is Status.INVALID and self.status is Status.RUNNING:
            self._play.lines.append(f"{self._leaf} HALTED")


def model_of(xml: str) -> tuple[str, dict[tuple[str, str], str]]:
    """Return the leaves of a file for `run_stubs.cpp`, and the type of each port."""
    root = ET.fromstring(xml)  # noqa: S314 - what the product has written
    lines, types = [], {}
    for model in root.iterfind("TreeNodesModel/*"):
        name = model.attrib["ID"]
        if model.tag == "SubTree":
            for port in model.iterfind("input_port"):
                if name == root.get("main_tree_to_execute"):
                    columns = port.attrib["name"], port.attrib["type"], port.attrib["default"]
                    lines.append("\t".join(("input", *columns)))
            continue
        lines.append(f"leaf\t{name}")
        for port in model:
            label = port.get("type", "")
            direction = "out" if port.tag == "output_port" else "in"
            types[name, port.attrib["name"]] = label
            lines.append("\t".join(("port", name, port.attrib["name"], direction, label)))
    return "\n".join(lines), types


def compared(program: Path, path: Path, seeds: int, folder: Path) -> Iterator[str]:
    """Yield each difference of a mission's runs."""
    xml = convert(path)
    model, types = model_of(xml)
    main = str(ET.fromstring(xml).get("main_tree_to_execute"))  # noqa: S314 - the same
    (folder / "model.tsv").write_text(model + "\n", encoding="utf-8")
    (folder / "tree.xml").write_text(re.sub(r'<Sleep (.*)msec="\d+"', r'<Sleep \1msec="0"', xml))
    mission = required(read_mission(document_of(xml, "tree.xml")))
    for seed in range(seeds):
        done = subprocess.run(  # noqa: S603 - what was built above
            [program, folder / "tree.xml", folder / "model.tsv", main, str(seed)],
            capture_output=True,
            text=True,
            timeout=120,
            check=False,
        )
        if done.returncode:
            yield f"seed {seed}: BehaviorTree.CPP: {done.stderr.strip()}"
            return
        there, here = done.stdout.splitlines(), Play(mission, types, seed).run()
        # BehaviorTree.CPP's Parallel decides after each child, and leaves the rest unticked.
        compare = slice(-1, None) if "<Parallel" in xml else slice(None)
        if there[compare] != here[compare]:
            pairs = enumerate(zip(there, here, strict=False))
            at = next((n for n, pair in pairs if pair[0] != pair[1]), -1)
            ends = f"{there[-1]!r} there, {here[-1]!r} here"
            yield f"seed {seed}: {ends}; event {at}: {there[at]!r} there, {here[at]!r} here"


def build(prefix: Path, folder: Path) -> Path:
    """Build the program with the stub leaves."""
    program = folder / "run_stubs"
    library = next(prefix.glob("lib*/**/libbehaviortree_cpp.so"), None)
    if library is None:
        sys.exit(f"no libbehaviortree_cpp.so below {prefix}; install BehaviorTree.CPP 4.10 there")
    command = [
        "c++",
        "-std=c++17",
        Path(__file__).with_name("run_stubs.cpp"),
        f"-I{prefix}/include",
    ]
    command += [library, f"-Wl,-rpath,{library.parent}", "-o", program]
    subprocess.run(command, check=True)  # noqa: S603 - a compiler on our own source
    return program


def main() -> int:
    """Compare the missions of the command line; gives the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("missions", nargs="*", type=Path)
    parser.add_argument("--prefix", type=Path, default=Path("/usr/local"))
    parser.add_argument("--seeds", type=int, default=20)
    options = parser.parse_args()
    wrong = 0
    with TemporaryDirectory() as name:
        program = build(options.prefix, Path(name))
        for path in options.missions or MISSIONS:
            differences = list(compared(program, path, options.seeds, Path(name)))
            print(f"{path.relative_to(ROOT) if path.is_relative_to(ROOT) else path}: ", end="")
            print("; ".join(differences[:3]) or f"the same in {options.seeds} runs")
            wrong += bool(differences)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
