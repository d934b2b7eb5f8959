"""Every command of every page, typed in its order, in an empty folder, from the wheel."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
from collections.abc import Mapping
from fnmatch import fnmatchcase
from importlib.util import find_spec
from pathlib import Path

import pytest

from bt_mission.base.commands import rows
from bt_mission.testing.live_graph import own_domain
from tests.support.command_cases import named_cases
from tests.support.page_commands import Saved, Typed, steps_of, unmarked
from tests.support.processes import PATIENCE_S
from tests.support.project import ROOT

RUNNER = ROOT / "tests" / "support" / "page_runner.py"
PAGES = {
    path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8")
    for path in (ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md")))
}
ELSEWHERE = {
    "docs/reference/errors/": "tests/commands/test_explain.py, with the files of the catalogue",
}
"""Pages whose commands another test types."""
NOT_RUN = {
    "asks a package registry, or builds for minutes": (
        r"(python -m )?pip install|uv |pipx |python -m build|source .*activate|python3 -m venv",
    ),
    "changes the machine": (r"sudo |docker |/opt/bt-mission",),
    "needs an installed ROS": (r"ros2 |source (/opt|install/)|colcon |rosdep |cd ~/ws|git clone",),
    "of a checkout": (r"make |python campaigns/|python -m benchmarks",),
    "opens a window": (r".* --(open|window|view|tui)\b",),
    "needs a real robot": (
        r".* --real\b",
        r".*--attach --(editable|wall-clock)",
        r"export .*TURTLEBOT3_MODEL",
    ),
    "needs certificates of SROS 2": (r".*ROS_SECURITY",),
    "needs a mission that crashed": (r".* --resume",),
    **named_cases("NOT_RUN_ON_PAGES"),
}
"""Why a command is not run, and its beginning. Each still stands for a command."""
STAYS = {
    r"bt-mission (sim|arbiter|mapper)\b": "\n",
    r"bt-mission servers\b": "ready: scan and odometry have come",
    r"bt-mission serve\b": "\n",
    r"bt-mission .*--(web|foxglove|speed 1)\b": "\n",
    r"bt-mission watch\b[^|]*$": "",
    r"python \S*_server\.py": "",
    **named_cases("STAYS_ON_PAGES"),
}
"""What stays until it is interrupted, and what it says when the next command may be typed."""
SHORTER: Mapping[str, str] = named_cases("SHORTER_ON_PAGES")
"""What takes hours: many runs, long runs."""
VALUES_VARY = ("docs/how-to/command-line-tools.md",)
"""Pages whose output is that of a live graph: numbers and ids are compared as such."""


def planned(page: str) -> list[dict[str, str | None]]:
    """Return the steps of a page for the runner."""
    text = PAGES[page]
    plan: list[dict[str, str | None]] = [
        {"file": step.file, "text": step.text} if isinstance(step, Saved) else as_run(step)
        for step in steps_of(text)
        if isinstance(step, Saved) or not reason_of(step.command)
    ]
    return plan


def as_run(step: Typed) -> dict[str, str | None]:
    """Return a command as it is run."""
    command = step.command
    for long, short in SHORTER.items():
        command = command.replace(long, short)
    until = next((words for stays, words in STAYS.items() if re.match(stays, command)), None)
    return {"command": command, "until": until, "expected": step.expected}


def reason_of(command: str) -> str | None:
    """Return why a command is not run."""
    return next(
        (
            why
            for why, beginnings in NOT_RUN.items()
            if any(re.match(beginning, command) for beginning in beginnings)
        ),
        None,
    )


RUN = [
    page
    for page in PAGES
    if not page.startswith(tuple(ELSEWHERE)) and any("command" in step for step in planned(page))
]
QUICK = ["docs/tutorials/first-mission.md"]
"""Pages whose commands are typed in each run of the tests; the others in thorough ones."""


@pytest.mark.process
@pytest.mark.skipif(
    find_spec("scikit_build_core") is None or shutil.which("cmake") is None,
    reason="scikit-build-core or cmake is not installed",
)
@pytest.mark.parametrize(
    "page",
    [pytest.param(page, marks=() if page in QUICK else pytest.mark.thorough) for page in RUN],
)
def test_every_command_gives_what_stands_below_it(
    page: str, installed: Path, tmp_path: Path
) -> None:
    """``...`` is anything. A command without output below it succeeds."""
    plan = planned(page)
    folder, steps, results = tmp_path / "empty", tmp_path / "steps.json", tmp_path / "results.json"
    folder.mkdir()
    steps.write_text(json.dumps(plan), encoding="utf-8")
    with own_domain() as domain:
        environment = os.environ | {
            "PATH": f"{installed / 'bin'}:{os.environ['PATH']}",
            "HOME": str(tmp_path),
            "ROS_DOMAIN_ID": str(domain),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
            "ROS_LOG_DIR": str(tmp_path / "log"),
        }
        done = subprocess.run(
            [installed / "bin" / "python", "-P", RUNNER, steps, results, f"{PATIENCE_S - 40}"],
            env=environment,
            cwd=folder,
            capture_output=True,
            text=True,
            check=False,
            timeout=PATIENCE_S,
        )
    assert done.returncode == 0, done.stderr
    typed = [step for step in plan if "command" in step]
    wrong = []
    for step, result in zip(typed, json.loads(results.read_text(encoding="utf-8")), strict=True):
        expected = step["expected"]
        code, output = result["code"], result["output"]
        if expected is None:
            is_right = code == (None if step["until"] is not None else 0)
        else:
            if page in VALUES_VARY:
                expected, output = _NUMBER.sub("0", expected), _NUMBER.sub("0", output)
            pattern = re.sub(r"[\[*?]", "[\\g<0>]", expected).replace("...", "*")
            is_right = fnmatchcase(_clean(output), _clean(pattern))
        if not is_right:
            wrong.append(f"$ {step['command']}\n{output}\nexit code {code}")
    assert not wrong, "\n\n".join(wrong)


_NUMBER = re.compile(r"-?\b[0-9a-f]{8}\b|-?[0-9.]*[0-9](e-[0-9]+)?")


def _clean(text: str) -> str:
    return "\n".join(line.rstrip() for line in text.strip().splitlines())


@pytest.mark.parametrize("page", PAGES)
def test_commands_are_marked_as_such(page: str) -> None:
    """By ``sh`` or ``console``, so that they are run."""
    assert unmarked(PAGES[page]) == []


CODE = re.compile(r"^```.*?^```|`[^`\n]+`", re.MULTILINE | re.DOTALL)
CALLED = re.compile(r"(?:^\s*(?:\$ )?(?:\w+=\S+ )*|`|\| )bt-mission ([a-z][a-z-]*)")


@pytest.mark.parametrize("page", PAGES)
def test_a_page_names_commands_that_are_there(page: str) -> None:
    """What is left of a command that was taken away is named."""
    known = {name for name, row in rows().items() if row.help}
    lines = [line for block in CODE.findall(PAGES[page]) for line in block.splitlines()]
    named = [(line, name) for line in lines for name in CALLED.findall(line)]
    assert [line for line, name in named if name not in known] == []


def test_every_reason_stands_for_a_command() -> None:
    """And every number that is replaced is on a page."""
    commands = [
        step.command
        for text in PAGES.values()
        for step in steps_of(text)
        if isinstance(step, Typed)
    ]
    assert set(map(reason_of, commands)) - {None} == set(NOT_RUN)
    assert [long for long in SHORTER if not any(long in command for command in commands)] == []
    for stays in STAYS:
        assert any(re.match(stays, command) for command in commands), stays
