"""The workflows of GitHub: no commands and no versions of their own."""

from __future__ import annotations

import os
import re
import tomllib
from typing import Any

import pytest
import yaml  # type: ignore[import-untyped]

from tests.support.project import ROOT

WORKFLOWS = sorted((ROOT / ".github/workflows").glob("*.yaml"))
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
PYTHONS = re.findall(r"Python :: (3\.\d+)", " ".join(PROJECT["project"]["classifiers"]))
SAFE = 'git config --global --add safe.directory "$GITHUB_WORKSPACE"'
"""A container has another user than the checkout; nothing that `.ci/run` could do for itself."""


def jobs_of(name: str) -> dict[str, Any]:
    """The jobs of a workflow."""
    text = (ROOT / ".github/workflows" / name).read_text(encoding="utf-8")
    jobs: dict[str, Any] = yaml.safe_load(text)["jobs"]
    return jobs


@pytest.mark.parametrize("path", WORKFLOWS, ids=lambda path: path.name)
def test_commands_are_scripts_of_the_project(path):
    """What passes on a machine of one's own passes there, and the other way round."""
    steps = [step for job in jobs_of(path.name).values() for step in job.get("steps", [])]
    commands = [step["run"] for step in steps if "run" in step and step["run"] != SAFE]
    assert commands
    for command in commands:
        assert re.fullmatch(r"\.ci/\w+( thorough)?", command)
        assert os.access(ROOT / command.split()[0], os.X_OK)


def test_each_python_is_tested_and_has_a_wheel():
    """Those that the project says it supports."""
    assert jobs_of("ci.yaml")["test"]["strategy"]["matrix"]["python"] == PYTHONS
    minors = ",".join(version.removeprefix("3.1") for version in PYTHONS)
    assert PROJECT["tool"]["cibuildwheel"]["build"] == f"cp31{{{minors}}}-manylinux_x86_64"


def test_nothing_is_published_that_was_not_tested():
    """The upload waits for the wheels, they wait for the tests."""
    jobs = jobs_of("release.yaml")
    assert (jobs["publish"]["needs"], jobs["build"]["needs"]) == ("build", "test")
    assert jobs["test"]["uses"] == "./.github/workflows/ci.yaml"
