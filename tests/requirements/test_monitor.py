"""One requirement while a run goes on: verdicts, margins, and the instants that decide."""

from __future__ import annotations

import re
from collections.abc import Sequence

import pytest

from bt_mission.base.verdicts import RequirementResult
from bt_mission.language.mission import Requirement
from bt_mission.requirements.monitor import Monitor, Monitors
from tests.support.played_signals import Played, PlayedSignals

STEP_NS = 50_000_000


def rows_of(**columns: Sequence[Played]) -> list[dict[str, Played]]:
    """Return the values of signals at each instant; `age_of_scan` is the signal `age('scan')`."""
    names = [re.sub("(.*)_of_(.*)", r"\1('\2')", name) for name in columns]
    return [dict(zip(names, row, strict=True)) for row in zip(*columns.values(), strict=True)]


def watched(
    text: str, *, is_complete: bool = True, **columns: Sequence[Played]
) -> RequirementResult:
    """Return what a requirement comes to over signals, a control step each."""
    rows = rows_of(**columns)
    signals = PlayedSignals(rows[0])
    monitor = Monitor(Requirement("it", text), signals)
    for step, signals.values in enumerate(rows):
        monitor.step(step * STEP_NS)
    monitor.finish(is_complete=is_complete)
    return monitor.result


def test_the_margin_is_the_least_room_and_its_instant() -> None:
    """`always` holds by what was left at its worst."""
    result = watched("always clearance > 0.1", clearance=[0.5, 0.3, 0.12, 0.4])
    assert (result.verdict, result.margin, result.unit, result.at) == ("holds", 0.02, "m", 0.1)


def test_a_violation_is_told_when_it_happens_and_measured_at_its_worst() -> None:
    """When it was first seen, and where it was worst, are two instants."""
    result = watched("always clearance > 0.1", clearance=[0.5, 0.09, 0.02, 0.4])
    assert (result.verdict, result.margin) == ("violated", -0.08)
    assert (result.violated_at, result.at) == (0.05, 0.1)


def test_a_limit_that_is_met_exactly() -> None:
    """`>` is violated by nothing, `>=` holds by nothing."""
    assert watched("always speed > 0.1", speed=[0.1]).verdict == "violated"
    assert watched("always speed >= 0.1", speed=[0.1]).verdict == "holds"
    assert watched("never speed > 0.1", speed=[0.1]).margin == 0.0


def test_truth_has_no_measure() -> None:
    """The margin of a node that runs is none."""
    result = watched("always running('a')", running_of_a=[True, False])
    assert (result.verdict, result.margin, result.violated_at) == ("violated", None, 0.05)


def test_an_answer_in_time_and_one_that_is_late() -> None:
    """The violation is told when the window is over, at its last instant."""
    blind = [0.0, 0.6, 0.6, 0.6, 0.6]
    text = "whenever age('scan') > 0.5: speed < 0.01 within 0.1"
    held = watched(text, age_of_scan=blind, speed=[0.2, 0.2, 0.1, 0.0, 0.0])
    assert (held.verdict, held.margin, held.unit) == ("holds", 0.01, "m/s")
    late = watched(text, age_of_scan=blind, speed=[0.2, 0.2, 0.1, 0.1, 0.0])
    assert (late.verdict, late.violated_at) == ("violated", 0.15)


def test_a_window_ahead_is_violated_when_it_happens_and_not_at_its_end() -> None:
    """`whenever p: always for 10 s: q` need not wait ten seconds for its verdict."""
    text = "whenever speed > 1: always for 10 s: clearance > 0.3"
    speed = [0.0, 2.0, 0.0, 0.0, 0.0]
    result = watched(text, speed=speed, clearance=[0.5, 0.5, 0.5, 0.2, 0.5])
    assert (result.verdict, result.margin, result.violated_at) == ("violated", -0.1, 0.15)


def test_what_the_robot_might_still_have_done_is_open() -> None:
    """The run was over before the deadline."""
    text = "whenever age('scan') > 0.5: speed < 0.01 within 0.6"
    result = watched(text, age_of_scan=[0.0, 0.6], speed=[0.2, 0.2])
    assert (result.verdict, result.why) == ("open", "the run ended before it could be decided")


def test_what_the_mission_can_no_longer_do_is_violated() -> None:
    """A mission that has ended visits nothing any more, whatever the window; a cut run might."""
    text = "eventually within 60 s: succeeded('a')"
    assert watched(text, succeeded_of_a=[False, False]).verdict == "violated"
    assert watched(text, succeeded_of_a=[False], is_complete=False).verdict == "open"
    assert watched(text, succeeded_of_a=[False, True], is_complete=False).verdict == "holds"


def test_a_run_that_was_cut_does_not_prove_always() -> None:
    """Nothing was violated so far; that is all that can be said."""
    assert watched("always speed < 1", speed=[0.0], is_complete=False).verdict == "open"


def test_a_signal_that_nobody_knows_is_said_and_never_guessed() -> None:
    """Unknown, with the signal and the reason."""
    result = watched("always clearance > 0.1 or speed < 0.1", speed=[0.0])
    assert (result.verdict, result.why) == ("unknown", "clearance: only a simulation provides it")


def test_a_signal_without_a_value_decides_nothing() -> None:
    """It is left out until it has one; if it never has, the verdict is unknown."""
    assert watched("always battery > 20", battery=[None, None, 50.0]).margin == 30.0
    result = watched("always battery > 20", battery=[None, None])
    assert (result.verdict, result.why) == ("unknown", "its signals never had a value")


def test_a_condition_that_cannot_be_computed_says_why() -> None:
    """A division by zero is no verdict."""
    result = watched("always 1 / speed > 2", speed=[0.0])
    assert (result.verdict, result.why) == ("unknown", "division by zero")


@pytest.mark.parametrize(
    "text",
    [
        "always previously within 1 s speed > 0",
        "whenever speed > 0: eventually within 1 s: speed < 0",
        "always (speed > 0 since clearance > 0)",
        "always (speed > 0 since clearance > 0 within 1 s)",
        "always ((speed > 0) until (clearance > 0) within 1 s)",
    ],
)
def test_memory_is_bounded_by_the_windows(text: str) -> None:
    """A run of any length keeps no more samples than a window holds."""
    rows = rows_of(speed=[1.0, -1.0], clearance=[-1.0, 1.0])
    signals = PlayedSignals(rows[0])
    monitor = Monitor(Requirement("it", text), signals)
    kept = []
    for step in range(2_000):
        signals.values = rows[step % 2]
        monitor.step(step * STEP_NS)
        kept.append(_samples_in(monitor.root))
    assert max(kept[1_000:]) <= max(kept[:1_000])


def _samples_in(part: object) -> int:
    """Count what the queues of a formula hold."""
    result = 0
    for value in vars(part).values() if hasattr(part, "__dict__") else ():
        for item in value if isinstance(value, list | tuple) else [value]:
            if type(item).__name__ == "deque":
                result += len(item)
            elif type(item).__module__.startswith("bt_mission.requirements"):
                result += _samples_in(item)
    return result


@pytest.mark.parametrize("text", ["eventually x >= 2", "eventually 2 <= x * 1"])
def test_what_is_met_exactly_holds_by_nothing(text: str) -> None:
    """However the comparison is written."""
    result = watched(text, x=[0, 1, 2])
    assert (result.verdict, result.margin) == ("holds", 0.0)


def test_all_requirements_see_the_same_instant() -> None:
    """Whatever is done about a violation of the first."""
    signals = PlayedSignals({"speed": 0.5, "clearance": 1.0})

    def stop(*_: object) -> None:
        signals.values = {"speed": 0.5, "clearance": 0.0}

    texts = ("always speed < 0.1", "always clearance > 0.5")
    monitors = Monitors([Requirement(text, text) for text in texts], signals, stop)
    monitors.step(0)
    assert monitors.results[1].margin == 0.5


def test_the_value_of_an_instant_by_itself() -> None:
    """Neither better nor worse than what was before; the requirement goes on as it was."""
    rows = rows_of(clearance=[0.5, 0.3, 0.4])
    signals = PlayedSignals(rows[0])
    text = "always clearance > 0.1"
    monitor = Monitor(Requirement("it", text), signals)
    alone = []
    for step, signals.values in enumerate(rows):
        monitor.step(step * STEP_NS)
        alone.append(monitor.value_of_instant())
    assert [round(rated[0], 9) for rated in alone if rated] == [0.4, 0.2, 0.3]
    assert monitor.now is not None
    assert round(monitor.now[0], 9) == 0.2


@pytest.mark.parametrize(
    "text",
    [
        "never historically for 8 s (speed > 0)",
        "always previously within 8 s speed > 1",
        "always (speed > 0 since speed > 1 within 8 s)",
        "never historically for 1 s (previously within 7.5 s speed > 0)",
    ],
)
def test_a_window_that_looks_back_decides_nothing_until_it_is_full(text: str) -> None:
    """A run that ends before leaves it open, and says when the window would have been full."""
    result = watched(text, speed=[0.5] * 60)
    assert (result.verdict, result.margin, result.violated_at) == ("open", None, None)
    assert "before its window that looks back was full, at 8" in result.why


def test_a_full_window_decides() -> None:
    """From the first instant at which it lies within the run."""
    result = watched("never historically for 0.2 s (speed > 0)", speed=[0.5] * 60)
    assert (result.verdict, result.margin, result.violated_at) == ("violated", -0.5, 0.2)


def test_so_far_counts_from_the_start_on() -> None:
    """Then a window is what of it lies within the run."""
    result = watched("never historically for 8 s so far (speed > 0)", speed=[0.5] * 60)
    assert (result.verdict, result.violated_at) == ("violated", 0.0)
    text = "always (speed > 0 since speed > 1 within 8 s so far)"
    assert watched(text, speed=[2, 0.5, 0.5]).verdict == "holds"


@pytest.mark.parametrize(
    ("text", "verdict"),
    [
        ("eventually not (always for 1 s: x <= 2)", "holds"),
        ("eventually (eventually within 1 s: x > 2)", "holds"),
        ("eventually (always for 1 s: x > 2)", "open"),
        ("eventually not ((x > 0) until (x < 0) within 1 s)", "open"),
        ("eventually not ((x < 0) until (x < 2) within 1 s)", "holds"),
        ("always (always for 1 s: x <= 2)", "violated"),
        ("always for 0.1 s (eventually within 1 s: x > 2)", "holds"),
        ("always for 0.1 s (eventually within 1 s: x > 3)", "open"),
        ("always for 1 s x > 2", "open"),
    ],
)
def test_a_run_that_was_cut_tells_what_nothing_later_can_change(text: str, verdict: str) -> None:
    """A window that is not over yet decides as soon as its rest cannot change it."""
    assert watched(text, x=[3, 3, 3], is_complete=False).verdict == verdict


@pytest.mark.parametrize(
    ("text", "verdict", "why"),
    [
        ("always for 100 s: x < 5", "open", "the run ended before it could be decided"),
        ("never for 100 s: x > 5", "open", "the run ended before it could be decided"),
        ("always for 100 s: x < 2", "violated", ""),
        ("always for 0.1 s: x < 5", "holds", ""),
        ("always for 100 s: running('a')", "holds", ""),
        ("not ((x < 5) until (x < 0) within 100 s)", "open", "the run ended before it could"),
        ("always (always for 1 s: x < 5)", "open", "the run ended before it could be decided"),
        ("whenever x > 0: always for 1 s: x < 5", "open", "the run ended before it could"),
        ("whenever x > 0: always for 1 s: running('a')", "holds", ""),
        ("whenever x > 3: x < 5 and (always for 1 s: x < 5)", "not exercised", "'x > 3'"),
        ("always between 0.1 s and 60 s: x < 5", "open", "the run ended before it could"),
        ("always between 50 s and 60 s: x < 5", "not exercised", "the run ended before its window"),
        ("never between 50 s and 60 s: x < 5", "not exercised", "the run ended before its window"),
        ("eventually between 50 s and 60 s: x > 5", "open", "the run ended before it could"),
    ],
)
def test_a_window_that_the_end_of_the_run_cuts_is_open(text: str, verdict: str, why: str) -> None:
    """Unless its part within the run decides it, or a node does, which changes no more."""
    result = watched(text, x=[3, 3, 3], running_of_a=[True, True, True])
    assert result.verdict == verdict
    assert why in result.why


def test_what_a_node_did_lately_is_open_after_the_mission() -> None:
    """A window that moves on can still change, though the node cannot."""
    text = "eventually within 60 s: historically for 5 s so far: not running('a')"
    assert watched(text, running_of_a=[True, True, False]).verdict == "open"


@pytest.mark.parametrize(
    ("text", "margin", "at"),
    [
        ("never count(starts(x > 2)) > 1", -1.0, 0.2),
        ("always count(ends(x > 2)) <= 2", 1.0, 0.15),
        ("always count(starts(x > 2)) within 0.1 s so far <= 1", -1.0, 0.2),
        ("always mean(x) over 0.1 s < 3", 0.666666667, 0.1),
        ("always rate(x) <= 70", 10.0, 0.2),
        ("eventually rate(x) < -70", 10.0, 0.15),
        ("always x - value(x) at last starts(x > 2) >= -4", 0.0, 0.15),
        ("eventually ends(x > 2)", 2.0, 0.15),
    ],
)
def test_what_was_so_far_has_a_margin(text: str, margin: float, at: float) -> None:
    """Counts of edges, means, rates and values at an edge, of the same numbers."""
    result = watched(text, x=[1.0, 2.0, 4.0, 0.0, 3.0])
    assert (result.margin, result.at) == (margin, at), result


def test_a_measure_has_the_unit_of_what_is_measured() -> None:
    """A rate by the second, a count none."""
    speed = [0.0, 0.1, 0.1]
    assert watched("always mean(speed) over 0.1 s < 1", speed=speed).unit == "m/s"
    assert watched("always rate(speed) < 5", speed=speed).unit == "m/s^2"
    assert watched("always count(starts(speed > 1)) < 5", speed=speed).unit == ""


def test_what_is_true_at_the_start_has_started_there() -> None:
    """Before the first instant nothing is true, so nothing can end there either."""
    assert watched("eventually starts(running('a'))", running_of_a=[True, True]).at == 0.0
    assert watched("eventually ends(running('a'))", running_of_a=[False]).verdict == "violated"


def test_a_signal_is_read_only_where_its_lower_bound_may_be_the_worst() -> None:
    """A clearance costs more than its bound."""
    signals = PlayedSignals({"clearance": 0.5}, clearance=0.4)
    text = "always clearance > 0.1"
    monitor = Monitor(Requirement("it", text), signals)
    reads = []
    for step, (bound, value) in enumerate([(0.4, 0.5), (0.6, 0.7), (0.3, 0.45), (0.5, 0.6)]):
        signals.values, signals.bounds = {"clearance": value}, {"clearance": bound}
        monitor.step(step * STEP_NS)
        reads.append(signals.reads)
    assert reads == [1, 1, 2, 2]
    assert (monitor.result.margin, monitor.result.at) == (0.35, 0.1)


NEVER = "'x > 100' never came true"
X = "x > 100"


@pytest.mark.parametrize(
    ("text", "verdict", "why"),
    [
        (f"whenever {X}: speed < 1", "not exercised", NEVER),
        (f"whenever {X}: speed < 1 within 3 s", "not exercised", NEVER),
        (f"may not apply: whenever {X}: speed < 1", "not applicable", NEVER),
        (f"always ({X} implies speed < 1) and x < 50", "not exercised", NEVER),
        (f"eventually ({X} implies speed < 1)", "not exercised", NEVER),
        (
            f"whenever speed < 1: ({X} implies x < 50)",
            "not exercised",
            f"{NEVER} under 'speed < 1'",
        ),
        (
            f"(always {X}) implies (always speed < 1)",
            "not exercised",
            f"'(always {X})' never came true",
        ),
        (
            "always between 20 s and 30 s: speed < 1",
            "not exercised",
            "the run ended before its window, which begins at 20 s",
        ),
        (
            "whenever speed < 1: always between 20 s and 30 s: speed < 1",
            "not exercised",
            "the run ended before its window, which begins 20 s later under 'speed < 1'",
        ),
        (
            "eventually between 20 s and 30 s: speed < 1",
            "open",
            "the run ended before it could be decided",
        ),
        (f"never ({X} implies speed < 1)", "violated", ""),
        (f"whenever ({X} implies speed < 1): speed < 1", "holds", ""),
        ("whenever x < 50: speed < 1", "holds", ""),
        ("always x < 50 or speed < 1", "holds", ""),
        (f"whenever {X}: age('scan') < 1", "not exercised", NEVER),
    ],
)
def test_a_premise_that_never_comes_true(text: str, verdict: str, why: str) -> None:
    """The left side of an implication that is asked for, and the beginning of a window ahead."""
    result = watched(text, x=[0.0, 1.0, 0.0], speed=[0.0, 0.0, 0.0], age_of_scan=[0.0, 0.0, 0.0])
    assert (result.verdict, result.why) == (verdict, why)


def test_a_premise_may_still_come_true_while_the_run_goes_on() -> None:
    """`eventually (a implies b)` is true at once; it is decided when `a` has come true."""
    signals = PlayedSignals({"x": 0.0, "speed": 0.0})
    text = f"eventually ({X} implies speed < 1)"
    monitor = Monitor(Requirement("it", text), signals)
    verdicts = []
    for step, x in enumerate((0.0, 0.0, 101.0, 0.0)):
        signals.values = {"x": x, "speed": 0.0}
        monitor.step(step * STEP_NS)
        verdicts.append(monitor.result.verdict)
    assert verdicts == ["open", "open", "holds", "holds"]
