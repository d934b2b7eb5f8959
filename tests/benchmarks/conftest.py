"""Small copies of the software with benchmarks of one line, for tests of the entry point."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from benchmarks.harness.catalogue import Benchmark
from benchmarks.harness.tree import Tree

GIVES = """\
import json, os, pathlib, sys
line = {
    "figure": "cost",
    "unit": "ms",
    "values": [float(pathlib.Path("cost.txt").read_text())] * int(sys.argv[1]),
    "code": os.path.join(os.getcwd(), "bt_mission"),
}
with open(os.environ["BENCHMARK_FIGURES"], "a") as file:
    file.write(json.dumps(line) + "\\n")
print("measured")
"""
"""A script that gives what stands in a file of the folder it runs in, so many times."""

Trees = Callable[..., Tree]


@pytest.fixture
def tree(tmp_path: Path) -> Trees:
    """Make a copy: ``tree("new", 2.0)``, or with another script."""

    def make(name: str, cost: float, script: str = GIVES) -> Tree:
        root = tmp_path / name
        (root / "benchmarks").mkdir(parents=True)
        (root / "benchmarks" / "cost.py").write_text(script, encoding="utf-8")
        (root / "cost.txt").write_text(str(cost), encoding="utf-8")
        return Tree(root, name, (root,))

    return make


@pytest.fixture
def cost() -> Benchmark:
    """A benchmark that gives one figure."""
    run, smoke = "benchmarks/cost.py {rounds}", "benchmarks/cost.py 1"
    return Benchmark("cost", "what it costs", (run,), (smoke,), rounds=3)
