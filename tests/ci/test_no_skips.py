"""Continuous integration leaves no test out."""

from __future__ import annotations

import pytest

from tests.support.no_skips import MAY_BE_SKIPPED

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
