#!/usr/bin/env python3
"""Print figures of the product's form: lines, modules, shared class names, constructors, packages.

``product_figures.py [ROOT]`` reads another checkout, such as an older one, in the same way. With
``--follow`` it also runs a mission and prints the packages that its ``fwd_velocity`` passes on the
way from the YAML file to the wheels.
"""

from __future__ import annotations

import argparse
import ast
import sys
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from types import FrameType
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
TOPS = ("bt_mission", "action_servers", "sim")
MOST_PARAMETERS = 6

VALUE = 0.181640625
"""m/s: a number that nothing else has, and that a float32 holds exactly."""
WHEELS, OLD_WHEELS = "sim.robot", "sim.drive"
"""Where velocities become speeds of the wheels."""
MISSION = f"""\
mission: follow one number
world: empty_arena
tree:
  explore_forward: {{fwd_velocity: {VALUE}, stopping_distance: 0.5}}
  cancel_when: current_distance_travelled > 0.2
  on_cancel: success
"""


def sources(root: Path) -> dict[Path, str]:
    """Return the text of every module of the product, by its path below the root."""
    return {
        path.relative_to(root): path.read_text(encoding="utf-8")
        for top in TOPS
        for path in sorted((root / top).rglob("*.py"))
    }


def shared_class_names(texts: dict[Path, str]) -> dict[str, list[Path]]:
    """Return the names that two or more classes have, with the modules that define them."""
    found: dict[str, list[Path]] = defaultdict(list)
    for path, text in texts.items():
        for node in ast.parse(text).body:
            if isinstance(node, ast.ClassDef):
                found[node.name].append(path)
    return {name: paths for name, paths in sorted(found.items()) if len(paths) > 1}


def long_constructors(texts: dict[Path, str]) -> Iterator[str]:
    """Yield the classes whose ``__init__`` takes more than six parameters."""
    for path, text in texts.items():
        for node in ast.walk(ast.parse(text)):
            if not isinstance(node, ast.ClassDef):
                continue
            for part in node.body:
                if isinstance(part, ast.FunctionDef) and part.name == "__init__":
                    arguments = part.args
                    count = len(arguments.posonlyargs + arguments.args + arguments.kwonlyargs) - 1
                    if count > MOST_PARAMETERS:
                        yield f"{path}: {node.name} ({count})"


def _holds(value: Any, depth: int = 2) -> bool:
    """Return whether a value is the number, or holds it."""
    if isinstance(value, float):
        return abs(value - VALUE) < 1e-9
    if depth == 0 or isinstance(value, str | bytes):
        return False
    if isinstance(value, dict):
        return any(_holds(one, depth - 1) for one in value.values())
    if isinstance(value, list | tuple):
        return len(value) < 20 and any(_holds(one, depth - 1) for one in value)
    for name in ("fwd_velocity", "linear"):
        inner = getattr(value, name, None)
        if inner is not None and not callable(inner) and _holds(inner, depth - 1):
            return True
    return False


def packages_passed(root: Path) -> list[str]:
    """Run a mission on the stage; return the packages whose functions were handed the number."""
    sys.path.insert(0, str(root))
    import tempfile  # noqa: PLC0415 - only with --follow

    try:
        from bt_mission.language.loader import load_text  # noqa: PLC0415 - the checkout's own
        from bt_mission.sessions.stage import Stage  # noqa: PLC0415
    except ImportError:  # as the packages were before they were sorted into rooms
        from bt_mission.mission import load_text  # noqa: PLC0415
        from bt_mission.stage import Stage  # noqa: PLC0415

    passed: dict[str, None] = {}

    def watch(frame: FrameType, event: str, _: object) -> None:
        module = frame.f_globals.get("__name__", "")
        if event != "call" or module.partition(".")[0] not in TOPS:
            return
        if passed and list(passed)[-1] in (WHEELS, OLD_WHEELS):
            return  # what comes after is what sensors measure
        package = ".".join(module.split(".")[:2])
        if package not in passed and any(_holds(one) for one in frame.f_locals.values()):
            passed[package] = None

    with tempfile.TemporaryDirectory() as folder:
        sys.setprofile(watch)
        with Stage(load_text(MISSION), image_folder=Path(folder)) as stage:
            while not stage.is_done:
                stage.step()
        sys.setprofile(None)
    return list(passed)


def main() -> int:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("root", nargs="?", type=Path, default=ROOT)
    parser.add_argument("--follow", action="store_true", help="run a mission, too (some seconds)")
    options = parser.parse_args()
    root = options.root.resolve()
    texts = sources(root)
    loose = [path for path in texts if path.parent == Path("bt_mission")]
    lines = {top: sum(t.count("\n") for p, t in texts.items() if p.parts[0] == top) for top in TOPS}
    print(f"product lines: {sum(lines.values())} {lines}")
    print(f"modules: {len(texts)}, of them directly in bt_mission/: {len(loose)}")
    shared = shared_class_names(texts)
    print(f"class names that several classes share: {len(shared)} {', '.join(shared)[:300]}")
    long = list(long_constructors(texts))
    print(f"constructors with more than {MOST_PARAMETERS} parameters: {len(long)}")
    for line in long:
        print(f"  {line}")
    if options.follow:
        passed = packages_passed(root)
        print(f"packages that fwd_velocity passes: {len(passed)}: {', '.join(passed)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
