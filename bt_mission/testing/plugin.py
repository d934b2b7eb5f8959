"""The pytest plugin: fixtures for tests of missions. Active wherever the package is installed.

This module is imported in every pytest session of its environment: whatever needs ROS or MuJoCo
is imported when a fixture is asked for.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from bt_mission.base.commands import loaded, points
from bt_mission.testing.results import DEFAULT, GRAPHS, RECORD, STAGES, Results, what_to_record
from bt_mission.testing.seed_hooks import SeedHooks

if TYPE_CHECKING:
    from bt_mission.language.mission import Mission
    from bt_mission.sessions.scripted_server import ScriptedServer
    from bt_mission.testing.live_graph import LiveGraph
    from bt_mission.testing.stages import Stages


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add our options."""
    group = parser.getgroup("bt-mission", "tests of missions")
    group.addoption(
        "--scenario-seeds",
        type=_count,
        metavar="N",
        help="run each test marked 'scenario' with N seeds, instead of the number in its marker",
    )
    group.addoption(
        "--scenario-results",
        metavar="DIR",
        help=f"folder for the traces, recordings and reports of failed tests (default: {DEFAULT} "
        f"in pytest's rootdir)",
    )
    group.addoption(
        "--mission-record",
        choices=RECORD,
        help="record the missions of failed tests, of all tests, or of none (default: the ini "
        "option mission_record, else failed)",
    )
    parser.addini("mission_record", "the default of --mission-record", default="failed")
    group.addoption(
        "--mission-cov",
        action="store_true",
        help="report nodes, outcomes and branches of missions that no test reached",
    )
    group.addoption(
        "--mission-cov-source",
        action="append",
        default=[],
        metavar="PATH",
        help="include the missions of this file or folder even if no test runs them; may be "
        "repeated",
    )
    group.addoption(
        "--mission-cov-report",
        action="append",
        default=[],
        metavar="FILE",
        help="write the coverage to FILE.txt, FILE.json or FILE.html; may be repeated",
    )
    group.addoption(
        "--mission-cov-fail-under",
        type=_percent,
        metavar="PERCENT",
        help="fail if the total coverage is below this",
    )


def _count(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"expected a number of seeds from 1, got '{text}'")
    return int(text)


def _percent(text: str) -> float:
    try:
        percent = float(text)
    except ValueError:
        percent = -1.0
    if not 0 <= percent <= 100:
        raise argparse.ArgumentTypeError(f"expected a number from 0 to 100, got '{text}'")
    return percent


LARK = "ignore:module 'sre_(parse|constants|compile)' is deprecated:DeprecationWarning"
"""lark, which the message generators of the ROS wheels import, names modules of Python 3.10."""


MARKERS = "pytest."
"""The extension point of commands that add a marker of tests."""


def pytest_configure(config: pytest.Config) -> None:
    """Put the parts together."""
    config.addinivalue_line("filterwarnings", LARK)  # nothing that its reader could mend
    for marker, target in points(MARKERS).items():
        config.addinivalue_line(
            "markers", f"{marker}(...): before the test, calls {target} with the same arguments"
        )
    config.pluginmanager.register(Results(config), "bt_mission_results")
    config.pluginmanager.register(SeedHooks(config), "bt_mission_seeds")
    asked = ("", "_source", "_report", "_fail_under")
    if any(config.getoption(f"mission_cov{option}") not in (False, None, []) for option in asked):
        from bt_mission.testing.coverage_hooks import CoverageHooks

        config.pluginmanager.register(CoverageHooks(config), "bt_mission_coverage")


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> pytest.Collector | None:
    """Collect scenarios and fleets: each is a test."""
    if not file_path.name.endswith((".scenario.yaml", ".fleet.yaml")):
        return None
    from bt_mission.testing.file_items import FileItems

    return FileItems.from_parent(parent, path=file_path)


EDITABLE = "Module already imported so cannot be rewritten; _editable_skbc_bt_mission"
"""pytest warns of the module through which an editable install is found: it has no assertions."""


@pytest.hookimpl(trylast=True)
def pytest_sessionstart(session: pytest.Session) -> None:
    """Remove a warning that precedes all plugins, and that no user can fix."""
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    if reporter is not None and "warnings" in reporter.stats:
        kept = [
            warning for warning in reporter.stats["warnings"] if EDITABLE not in warning.message
        ]
        reporter.stats["warnings"] = kept


@pytest.fixture
def stage(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Stages]:
    """A stage for missions: real ROS and physics, on one virtual clock, heard by nobody else.

    ``run = stage.run("missions/explore.yaml", world="empty_arena", seed=3)``
    """
    os.environ.setdefault("ROS_LOG_DIR", str(tmp_path / "log"))
    from bt_mission.base.nature import NO_NATURE, USUAL
    from bt_mission.testing.seeds import seeded
    from bt_mission.testing.stages import Stages

    test_seed = seeded(request.node)
    records = what_to_record(request.config) != "off"
    results = request.config.pluginmanager.get_plugin("bt_mission_results")
    assert isinstance(results, Results), "pytest_configure has registered it"
    made = Stages(
        tmp_path,
        seed=None if test_seed is None else test_seed.seed,
        nature=NO_NATURE if test_seed is None or test_seed.at_least is None else USUAL,
        records=records,
        replay=partial(results.replay_command, request.node),
    )
    request.node.stash.setdefault(STAGES, []).append(made)
    yield made
    made.close()


@pytest.hookimpl(wrapper=True)
def pytest_pyfunc_call(pyfuncitem: pytest.Function) -> Iterator[None]:
    """Do what its markers ask for before a test; end its missions as its last step.

    That step fails where they left something wrong.
    """
    for name, target in points(MARKERS).items():
        for marker in pyfuncitem.iter_markers(name):
            loaded(target)(*marker.args, **marker.kwargs)
    result = yield
    stages = pyfuncitem.stash.get(STAGES, [])
    for made in stages:
        made.close()
    for what, lines in (
        ("orphaned goals", [line for made in stages for line in made.left_behind]),
        ("requirements failed", [line for made in stages for line in made.failing]),
        (
            "expected violations are missing",
            [line for made in stages for line in made.not_violated],
        ),
        ("not asserted", [line for made in stages for line in made.unread]),
        ("not tested", [line for made in stages for line in made.untested]),
    ):
        if lines:
            pytest.fail(f"{what}: {'; '.join(lines)}", pytrace=False)
    return result


@pytest.fixture
def mission(stage: Stages) -> Callable[..., Mission]:
    """Valid missions of a file, of the name of a shipped one, or of a text."""
    return stage.mission


@pytest.fixture
def world(stage: Stages) -> Callable[[str], str | Path]:
    """Worlds of a text, as files: ``stage.run(..., world=world(text))``."""
    return stage.world


@pytest.fixture
def scripted_server(stage: Stages) -> Callable[..., ScriptedServer]:
    """Action servers that the test plays step by step, in place of the shipped ones.

    ``turn = scripted_server("turn", accepts=None)``
    """
    return stage.scripted_server


@pytest.fixture
def live_graph(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[LiveGraph]:
    """Sim, servers and executive as separate processes, in their own graph.

    ``sim, servers = live_graph.robot("empty_arena")``
    ``assert live_graph.run("missions/square.yaml").wait(within=120) == 0``
    """
    from bt_mission.testing.live_graph import LiveGraph, own_domain

    with own_domain() as domain_id:
        graph = LiveGraph(tmp_path, domain_id)
        request.node.stash.setdefault(GRAPHS, []).append(graph)
        yield graph
        graph.close()
