"""What one run reaches, as a bitmap; the servers are played, there is no ROS."""

from __future__ import annotations

import pytest

from bt_mission.coverage.places import places
from bt_mission.coverage.record import CoverageRecord, coverage_places
from bt_mission.language.loader import load_text
from bt_mission.sessions.load import load
from tests.support.play import Play
from tests.support.project import MISSIONS

TEXT = """\
mission: m
inputs: {x: 1}
trees: {half: {needs: {x: number}, do: {check: x > 1}}}
tree:
  fallback: [check: x > 1, log: a]
  name: way out
"""
PLACES = (
    "0 way out: reached",
    "0 way out: outcome success",
    "0 way out: branch 1 check x > 1",
    "0 way out: branch 2 log",
    "0.0 check x > 1: reached",
    "0.0 check x > 1: outcome true",
    "0.0 check x > 1: outcome false",
    "0.1 log: reached",
    "0.1 log: outcome success",
    "half:0 check x > 1: reached",
    "half:0 check x > 1: outcome true",
    "half:0 check x > 1: outcome false",
)


def record_of(text: str, server: object) -> CoverageRecord:
    """What a run of a few ticks reaches."""
    play = Play(text, type(server))
    record = CoverageRecord.attach(load_text(text), play.executive)
    play.tick(3)
    return record


def test_places_are_named_by_node_and_what_there_is_to_reach():
    """In the order of the file; those of a named tree with its name."""
    assert coverage_places(load_text(TEXT)) == PLACES


def test_places_do_not_depend_on_inputs_and_seed():
    """So the records of a sweep over them can be united."""
    other = load_text(TEXT.replace("inputs: {x: 1}", "inputs: {x: 7}\nseed: 5"))
    assert coverage_places(other) == PLACES


@pytest.mark.parametrize("path", MISSIONS, ids=lambda path: path.name)
def test_every_name_is_one_place(path):
    """As many as the table of ``--mission-cov`` counts."""
    mission = load(path)
    names = coverage_places(mission)
    counted = [1 + len(one.outcomes) + len(one.branches) for one in places(mission)]
    assert len(set(names)) == len(names) == sum(counted)


def test_a_run_sets_what_it_reaches(server):
    """Each place once, in the order of all; the rest is missing."""
    record = record_of(TEXT, server)
    assert record.reached == (*PLACES[:2], PLACES[2], PLACES[3], PLACES[4], PLACES[6], *PLACES[7:9])
    assert record.missing == (PLACES[5], *PLACES[9:])
    assert record.percent == pytest.approx(100 * 8 / 12)


def test_records_are_written_in_a_digit_for_four_places(server):
    """And read again; the first place is in the last digit."""
    record = record_of(TEXT, server)
    assert record.as_hex() == "1df"
    again = CoverageRecord.from_hex(PLACES, "1df")
    assert (again.places, again.bits) == (record.places, record.bits)
    assert CoverageRecord(PLACES).as_hex() == "000"
    assert CoverageRecord.from_hex((), "").as_hex() == ""


@pytest.mark.parametrize("text", ["", "1d", "01df", "g00", "fff0"])
def test_what_is_no_record_of_so_many_places_is_an_error(text):
    """A record of another mission is not taken for one of this."""
    with pytest.raises(ValueError, match=r"hexadecimal digits|invalid literal"):
        CoverageRecord.from_hex(PLACES, text)


def test_records_of_the_same_places_are_united(server):
    """Each keeps what it had."""
    low = record_of(TEXT, server)
    high = record_of(TEXT.replace("x: 1", "x: 2"), server)
    both = low | high
    assert both.missing == PLACES[9:]
    assert low.missing == (PLACES[5], *PLACES[9:])
    with pytest.raises(ValueError, match="different places"):
        low | CoverageRecord(PLACES[:3])
