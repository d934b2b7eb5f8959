"""What a failed test of a mission shows: errors, the mission's section, the short summary."""

from __future__ import annotations

import pytest
import yaml  # type: ignore[import-untyped]

from tests.support.hostile import HOSTILE, MARK, escape_nothing, leaks

SAID = HOSTILE.replace("$", "").replace("\0", "")
MISSION = yaml.safe_dump({"mission": "m", "tree": {"sequence": [{"log": SAID}, {"wait": 1}]}})
TESTS = f"""
MISSION = {MISSION!a}

def test_says(stage):
    run = stage.run(MISSION).until_done()
    raise ValueError({SAID!a})

def test_compares(stage):
    stage.run(MISSION)
    assert {SAID!a} == ""
"""


@pytest.fixture(params=["CI", "no CI"])
def shown(request: pytest.FixtureRequest, pytester: pytest.Pytester, monkeypatch):
    """Run the tests above; gives what they print. Under CI pytest shortens nothing."""
    monkeypatch.delenv("BUILD_NUMBER", raising=False)
    monkeypatch.delenv("CI", raising=False)
    if request.param == "CI":
        monkeypatch.setenv("CI", "1")

    def run() -> str:
        pytester.makepyfile(test_a=TESTS)
        result = pytester.runpytest("--color=no", "--tb=short")
        result.assert_outcomes(failed=2)
        return str(result.stdout)

    return run


def test_output_of_failed_tests(shown):
    """Escaped, like every other output."""
    output = shown()
    assert "- mission -" in output
    assert output.count(MARK) > 4
    assert leaks(output) == []


def test_output_of_failed_tests_can_leak(shown, monkeypatch):
    """Where nothing is escaped, it is noticed."""
    escape_nothing(monkeypatch)
    assert leaks(shown())
