"""The test session leaves nothing behind in the checkout: what looks for it, seen at work."""

from __future__ import annotations

import pytest

from tests.support.project import ROOT
from tests.support.thorough import sample

LEAVES = "def test_leaves():\n    open('stray.txt', 'w').close()\n"
LEAVES_NOTHING = "def test_leaves_nothing():\n    pass\n"
PLUGIN = ("-p", "tests.support.checkout")


@pytest.fixture
def checkout(pytester: pytest.Pytester) -> pytest.Pytester:
    """A checkout with a file that was there before."""
    pytester.syspathinsert(ROOT)
    pytester.run("git", "init", "-q")
    pytester.path.joinpath(".gitignore").write_text("__pycache__/\n.pytest_cache/\nignored/\n")
    pytester.path.joinpath("before.txt").write_text("")
    return pytester


@pytest.mark.parametrize(
    "workers",
    sample([pytest.param((), id="alone"), pytest.param(("-n", "2"), id="xdist")], 2),
)
def test_a_file_that_is_left_fails_the_session(
    checkout: pytest.Pytester, workers: tuple[str, ...]
) -> None:
    """By its name, and without those that were there before."""
    checkout.makepyfile(LEAVES)
    result = checkout.runpytest(*PLUGIN, *workers)
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    result.stdout.fnmatch_lines(["*left in the checkout by this session*", "stray.txt"])
    result.stdout.no_fnmatch_line("before.txt")


def test_a_session_that_leaves_nothing_passes(checkout: pytest.Pytester) -> None:
    """Ignored files are none that git shows."""
    checkout.makepyfile(LEAVES_NOTHING + "    import os\n    os.mkdir('ignored')\n")
    assert checkout.runpytest(*PLUGIN).ret == pytest.ExitCode.OK


def test_without_a_checkout_nothing_is_looked_at(
    pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Sources of an archive are tested, too, also where there is no git."""
    pytester.syspathinsert(ROOT)
    pytester.makepyfile(LEAVES)
    assert pytester.runpytest(*PLUGIN).ret == pytest.ExitCode.OK
    monkeypatch.setenv("PATH", str(pytester.path))
    assert pytester.runpytest(*PLUGIN).ret == pytest.ExitCode.OK
