"""The forks that run the tests: every report arrives, and a fork that dies is replaced."""

from __future__ import annotations

import pytest

from tests.support.project import ROOT

pytestmark = pytest.mark.process

FIRST = """
import os, pytest

@pytest.fixture(scope="module")
def once(tmp_path_factory):
    yield tmp_path_factory.getbasetemp().name
    print("torn down")

def test_folder(once):
    assert once == "process0"

@pytest.mark.parametrize("number", range(3))
def test_number(once, number):
    print("said by", number)
    assert number != 1

@pytest.mark.skip(reason="not here")
def test_skipped(): ...
"""
DIES = """
import os, signal

def test_before(): ...
def test_dies():
    print("in the middle", flush=True)
    os.kill(os.getpid(), signal.SIGKILL)
def test_after(): ...
"""
ENDS = """
class Full:
    def pytest_runtest_logreport(self, report):
        raise OSError("no space left")

def test_before(): ...
def test_ends(request):
    request.config.pluginmanager.register(Full())
"""
HANGS = """
import threading

def test_hangs():
    threading.Event().wait()
"""
DOMAIN = """
import os

def test_domain():
    assert os.environ["ROS_DOMAIN_ID"] != "0"
"""


@pytest.fixture
def session(pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> pytest.Pytester:
    """A folder where sessions of pytest run in forks."""
    monkeypatch.delenv("CI", raising=False)
    monkeypatch.setenv("ROS_DOMAIN_ID", "0")  # no fork gets it
    return pytester


def run(session: pytest.Pytester, *words: str, **files: str) -> pytest.RunResult:
    """Run files in two forks."""
    session.makepyfile(**files)
    session.syspathinsert(ROOT)
    plugins = ("-p", "tests.support.forked", "-p", "no:cacheprovider")
    return session.runpytest_subprocess(*plugins, "--processes", "2", *words)


def test_reports_are_those_of_one_process(session: pytest.Pytester) -> None:
    """With the output of a test, its failure and its reason to be skipped."""
    result = run(session, "-rs", test_a=FIRST, test_b=DOMAIN)
    result.assert_outcomes(passed=4, failed=1, skipped=1)
    result.stdout.fnmatch_lines(["*assert 1 != 1*", "said by 1", "*not here*"])
    result.stdout.no_fnmatch_line("said by 2")


@pytest.mark.process(always=True)
def test_where_a_fork_dies_its_test_fails_and_the_others_run(session: pytest.Pytester) -> None:
    """In another fork, with the number of the signal and the last that was printed."""
    result = run(session, test_a=DIES, test_b=DOMAIN)
    result.assert_outcomes(passed=3, failed=1)
    result.stdout.fnmatch_lines(["*test_dies*", "its process ended with -9", "in the middle"])


@pytest.mark.thorough
def test_a_fork_that_ends_by_an_error_tells_it(session: pytest.Pytester) -> None:
    """With the traceback, beside the number of its end."""
    result = run(session, test_a=ENDS)
    result.assert_outcomes(passed=1, failed=1)
    result.stdout.fnmatch_lines(["*test_ends*", "its process ended with 1", "*no space left*"])


def test_a_fork_that_hangs_tells_where(session: pytest.Pytester) -> None:
    """With the stacks of its threads, which a log of many tests would otherwise hide."""
    options = ("faulthandler_timeout=0.5", "faulthandler_exit_on_timeout=true")
    result = run(session, "-o", options[0], "-o", options[1], test_a=HANGS, test_b=DOMAIN)
    result.assert_outcomes(passed=1, failed=1)
    result.stdout.fnmatch_lines(["*test_hangs*", "*ended with 1", "Timeout*", "*in test_hangs*"])


@pytest.mark.thorough
def test_each_fork_has_its_folder(session: pytest.Pytester) -> None:
    """A folder that is given is emptied once, before the forks begin."""
    run(session, "--basetemp", "given", test_a=FIRST, test_b=DOMAIN)
    assert {path.name for path in (session.path / "given").iterdir()} >= {"process0", "process1"}


@pytest.mark.thorough
def test_after_the_first_failure_no_other_test_begins(session: pytest.Pytester) -> None:
    """Apart from those that the forks have already."""
    texts = {f"test_{name}": "def test_it(): assert 0" for name in "abcdefgh"}
    result = run(session, "-x", **texts)
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    assert 1 <= result.parseoutcomes()["failed"] <= 4
