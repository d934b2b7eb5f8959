"""Plants 100 defects in the product, one at a time, and counts how many its tests catch.

Ten rooms of the product get ten defects each: flipped comparisons, dropped calls, swapped
arguments, constants off by one, negated conditions, `and` for `or`. The places are drawn once,
with a seed (`--draw`), and kept in `planted_defects.json`. If a later version of the product does
not have a place, the nearest place of the same kind in the same room replaces it, and the table
lists it.

The tests run in a clone of the last commit: those that import the changed module, those of its
room, and the contract suite of the servers; tests that start processes are left out. They must pass
without a defect first. Results are appended to a file, one JSON line each. A campaign that was
stopped continues there.

Run it as: python tools/plant_defects.py -o results.jsonl
"""

from __future__ import annotations

import argparse
import ast
import contextlib
import hashlib
import json
import os
import re
import resource
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable, Iterator
from difflib import SequenceMatcher
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from tools.check_layers import imported_names, is_in  # noqa: E402 - from the root
from tools.mutations import Place, places  # noqa: E402 - as above

CHOSEN = Path(__file__).with_name("planted_defects.json")
SEED = 27
LIMIT_S = 240
"""Processor time that a defect may add to the tests of its room, and time for one test."""

BT = "bt_mission"
ROOMS = {name: (f"{BT}/{name}",) for name in ("language", "ros", "sessions", "recording")} | {
    "goals": (f"{BT}/executive/goals",),
    "events": (f"{BT}/executive/events",),
    "executive": (f"{BT}/executive",),
    "faults": (f"{BT}/scenarios",),
    "action_servers": ("action_servers",),
    "sim": ("sim",),
}
"""The folders of each room; its tests are in the folders of the same names below tests/."""


KINDS = {
    "comparison": 2,
    "call": 2,
    "arguments": 2,
    "off by one": 2,
    "negation": 1,
    "boolean": 1,
}
"""How many defects of each kind a room gets."""


def draw(candidates: Iterable[Place], room: str, seed: int) -> list[Place]:
    """Choose the defects of a room, at most one in a function.

    The order depends on seed, room, kind, function and ordinal only: an edit elsewhere, or a module
    with another name, does not change it.
    """

    def rank(place: Place) -> str:
        key = f"{seed} {room} {place.kind} {place.function} {place.ordinal}"
        return hashlib.sha256(key.encode()).hexdigest()

    ranked = sorted(candidates, key=rank)
    drawn: list[Place] = []
    for kind, count in KINDS.items():
        for _ in range(count):
            functions = {place.function for place in drawn}
            free = (
                candidate
                for candidate in ranked
                if candidate.kind == kind and candidate.function not in functions
            )
            drawn.append(next(free))
    return drawn


def located(stored: list[dict[str, Any]], candidates: list[Place]) -> list[tuple[Place, bool]]:
    """Return the place of each stored defect of a room, and whether it is another one, the nearest.

    A place is the same if its function and its lines are the same, in whatever file of the room.
    """
    taken: dict[int, tuple[Place, bool]] = {}
    for keys in (("kind", "function", "before", "after"), ("kind",)):
        for number, entry in enumerate(stored):
            others = [place for place, _ in taken.values()]
            alike = [
                place
                for place in candidates
                if place not in others and all(entry[key] == getattr(place, key) for key in keys)
            ]
            if number not in taken and alike:
                matcher = SequenceMatcher(None, "", _words(entry), autojunk=False)
                likeness = []
                for place in alike:
                    matcher.set_seq1(_words(place.stored()))
                    likeness.append(matcher.ratio())
                taken[number] = alike[likeness.index(max(likeness))], len(keys) == 1
    return [taken[number] for number in range(len(stored))]


def _words(place: dict[str, Any]) -> str:
    return "{file} {function} {before} {ordinal}".format(**place)


def tests_of(root: Path, room: str, files: Iterable[str]) -> list[str]:
    """Return the test files that can reach changed files: importers, the room's, the contract's."""
    every = sorted((root / "tests").rglob("test_*.py"))
    modules = [
        file.removesuffix(".py").removesuffix("/__init__").replace("/", ".") for file in files
    ]
    chosen = []
    for file in every:
        names = [name for name, _ in imported_names(ast.parse(file.read_bytes()))]
        chosen += [file for module in modules if any(is_in(name, module) for name in names)]
    for folder in (*(Path(folder).name for folder in ROOMS[room]), "contract"):
        chosen += [file for file in every if file.is_relative_to(root / "tests" / folder)]
    return [str(file.relative_to(root)) for file in dict.fromkeys(chosen)]


def run_python(folder: Path, arguments: list[str]) -> subprocess.Popen[str]:
    """Start this Python with the packages of a folder, which has been cloned."""
    return subprocess.Popen(  # noqa: S603 - this Python
        [sys.executable, *arguments],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": f"{folder}{os.pathsep}{folder.parent}"},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    )


def clone(folder: Path) -> None:
    """Clone the last commit, and make sure that Python imports the packages from there."""
    subprocess.run(["git", "clone", "-q", "--shared", ROOT, folder], check=True)  # noqa: S603, S607
    # An editable installation begins with a module that leads all imports to this checkout.
    (folder.parent / "_editable_skbc_bt_mission.py").touch()
    # By their contents: a defect that changes neither the length nor the second is compiled, too.
    by_hash = ["-m", "compileall", "-q", "--invalidation-mode", "checked-hash", "."]
    run_python(folder, by_hash).communicate()
    for package in ("action_servers", "bt_mission", "sim"):
        script = f"import {package}; print({package}.__file__)"
        file = run_python(folder, ["-c", script]).communicate()[0].strip()
        if file != str(folder / package / "__init__.py"):
            raise SystemExit(f"expected {package} to be imported from {folder}, got {file}")


def run_tests(folder: Path, tests: list[str], limit_s: int) -> tuple[str, str | None]:
    """Run tests; return the verdict and the first test that failed."""
    options = ["-x", "-q", "-p", "no:cacheprovider", "-o", f"faulthandler_timeout={LIMIT_S}"]
    process = run_python(folder, ["-m", "pytest", *options, "-m", "not process", *tests])
    # Processor time: a busy machine must not change a verdict.
    resource.prlimit(process.pid, resource.RLIMIT_CPU, (limit_s, limit_s))
    try:
        output = process.communicate(timeout=5 * limit_s)[0]
    except subprocess.TimeoutExpired:
        output = "Timeout ("
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()
    if "Timeout (" in output or process.returncode in (-signal.SIGXCPU, -signal.SIGKILL):
        return "timed out", None
    if process.returncode == 0:
        return "survived", None
    failure = re.search(r"^(?:FAILED|ERROR) (\S+)", output, re.MULTILINE)
    return "caught", failure[1] if failure else "\n".join(output.splitlines()[-3:])


def campaign(output: Path, rooms: Iterable[str]) -> None:
    """Run the tests against each stored defect, and append the results to a file."""
    done = {(row["room"], row["number"]): row for row in read(output)}
    stored = json.loads(CHOSEN.read_text(encoding="utf-8"))
    with tempfile.TemporaryDirectory(prefix="plant_defects_") as scratch:
        folder = Path(scratch).resolve() / "clone"
        clone(folder)
        for room in rooms:
            defects = located(stored[room], places(folder, ROOMS[room]))
            if (room, 0) not in done:
                tests = tests_of(folder, room, [place.file for place, _ in defects])
                done[room, 0] = {"room": room, "number": 0} | timed(folder, tests, None, 1000)
                if done[room, 0]["verdict"] != "survived":
                    raise SystemExit(f"the tests fail without a defect: {done[room, 0]}")
                append(output, done[room, 0])
            limit_s = LIMIT_S + int(done[room, 0]["seconds"])
            for number, (place, is_nearest) in enumerate(defects, 1):
                if (room, number) not in done:
                    row = {"room": room, "number": number, "nearest": is_nearest}
                    row |= place.stored() | {"line": place.line}
                    tests = tests_of(folder, room, [place.file])
                    append(output, row | timed(folder, tests, place, limit_s))


def timed(folder: Path, tests: list[str], place: Place | None, limit_s: int) -> dict[str, Any]:
    """Run tests with a defect, or without; return verdict, first failure and seconds."""
    file = folder / (place.file if place else CHOSEN.relative_to(ROOT))
    source = file.read_bytes()
    began = time.perf_counter()  # noqa: TID251 - only shown
    try:
        file.write_bytes(place.planted(source) if place else source)
        verdict, failure = run_tests(folder, tests, limit_s)
    finally:
        file.write_bytes(source)
    seconds = round(time.perf_counter() - began, 1)  # noqa: TID251 - only shown
    return {"verdict": verdict, "first_failure": failure, "seconds": seconds}


def append(output: Path, row: dict[str, Any]) -> None:
    """Append a result to the file, and print it."""
    print(json.dumps(row), flush=True)
    with output.open("a", encoding="utf-8") as file:
        file.write(json.dumps(row) + "\n")


def read(output: Path) -> list[dict[str, Any]]:
    """Return the results of a campaign so far."""
    lines = output.read_text(encoding="utf-8").splitlines() if output.exists() else []
    return [json.loads(line) for line in lines]


def table(results: list[dict[str, Any]]) -> Iterator[str]:
    """Yield lines: how many defects are caught per room and kind, then those that are not."""
    results = [row for row in results if row["number"]]
    yield f"{'caught':<16}" + "".join(f"{kind:>12}" for kind in [*KINDS, "all"])
    for room in [*ROOMS, "all"]:
        line = f"{room:<16}"
        for kind in [*KINDS, "all"]:
            cell = [
                row["verdict"] != "survived"
                for row in results
                if room in (row["room"], "all") and kind in (row["kind"], "all")
            ]
            line += f"{f'{sum(cell)}/{len(cell)}':>12}"
        yield line
    for title in ("survived", "timed out", "nearest"):
        rows = [row for row in results if title == row["verdict"] or row.get(title)]
        yield f"\n{title}: {len(rows)}"
        for row in rows:
            yield f"{row['file']}:{row['line']}  {row['before']}  ->  {row['after']}"


def main() -> None:
    """Read the command line, and draw, run or print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, metavar="FILE", help="results, as JSON lines")
    parser.add_argument("--table", action="store_true", help="print the results of FILE as a table")
    parser.add_argument("--draw", action="store_true", help=f"draw places again: {CHOSEN.name}")
    parser.add_argument("--room", nargs="+", choices=ROOMS, default=list(ROOMS))
    options = parser.parse_args()
    if options.draw:
        drawn = {room: draw(places(ROOT, ROOMS[room]), room, SEED) for room in ROOMS}
        stored = {room: [place.stored() for place in drawn[room]] for room in drawn}
        CHOSEN.write_text(json.dumps(stored, indent=1) + "\n", encoding="utf-8")
    elif not options.output:
        parser.error("expected -o FILE")
    elif options.table:
        print(*table(read(options.output)), sep="\n")
    else:
        campaign(options.output, options.room)


if __name__ == "__main__":
    main()
