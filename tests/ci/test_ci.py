"""Continuous integration leaves no test out."""

from __future__ import annotations

import os
import re
import tomllib
from typing import Any

import pytest
import yaml  # type: ignore[import-untyped]

from tests.support.no_skips import MAY_BE_SKIPPED
from tests.support.project import ROOT

SKIPS = f"""\
import pytest

@pytest.mark.skipif(True, reason="no Chromium is installed")
def test_of_a_page(): ...

def test_that_finds_out(): pytest.skip("there is no EGL")

def test_that_may(): pytest.skip({MAY_BE_SKIPPED[0]!r})

@pytest.mark.xfail(strict=True)
def test_that_fails_as_expected(): assert False

def test_that_runs(): ...
"""
MODULE = "import pytest\npytest.skip('the extra is missing', allow_module_level=True)\n"


@pytest.fixture
def skipping(pytester: pytest.Pytester) -> pytest.Pytester:
    """A folder with tests that are skipped."""
    pytester.makeconftest("pytest_plugins = ['tests.support.no_skips']\n")
    pytester.makepyfile(test_skips=SKIPS)
    return pytester


@pytest.mark.parametrize("value", ["1", "true"])
def test_a_skipped_test_fails_with_its_reason(skipping, monkeypatch, value):
    """But for those that are listed; an expected failure is none."""
    monkeypatch.setenv("CI", value)
    result = skipping.runpytest_inprocess("-p", "no:cacheprovider")
    result.assert_outcomes(errors=1, failed=1, skipped=1, xfailed=1, passed=1)
    result.stdout.fnmatch_lines(["*a skipped test fails: Skipped: there is no EGL"])


def test_a_skipped_module_fails_too(skipping, monkeypatch):
    """None of its tests is there to fail."""
    monkeypatch.setenv("CI", "1")
    skipping.makepyfile(test_module=MODULE)
    result = skipping.runpytest_inprocess("-p", "no:cacheprovider", "test_module.py")
    result.assert_outcomes(errors=1)
    result.stdout.fnmatch_lines(["*a skipped test fails: Skipped: the extra is missing"])


@pytest.mark.parametrize("value", [None, "", "0", "false"])
def test_elsewhere_tests_are_skipped(skipping, monkeypatch, value):
    """A machine of one's own need not have everything."""
    monkeypatch.delenv("CI", raising=False)
    if value is not None:
        monkeypatch.setenv("CI", value)
    result = skipping.runpytest_inprocess("-p", "no:cacheprovider")
    result.assert_outcomes(skipped=3, xfailed=1, passed=1)


# ---- workflows of GitHub: no commands and no versions of their own -----------------------------


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
