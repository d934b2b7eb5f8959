"""What of the tree all runs together have reached."""

from __future__ import annotations

from bt_mission.coverage.record import CoverageRecord, coverage_places
from bt_mission.sessions.load import load
from bt_mission.sweeps.report.coverage import reached_nodes
from tests.sweeps.conftest import PLACES


def test_bitmaps_are_added_up():
    """Each as often as it came out."""
    nodes = reached_nodes(PLACES, {"b": 3, "5": 2, "": 4})
    assert [(one.place, one.name, one.runs) for one in nodes] == [("0", "go", 5), ("0.0", "log", 3)]
    assert nodes[0].ways == {"outcome success": 3, "outcome failure": 2}
    assert [one.depth for one in nodes] == [0, 1]


def test_names_of_trees_and_nodes_may_be_anything():
    """Blanks, colons and digits too."""
    places = ("0.1 a: b 0.2 c: reached", "way out:0.1.2 d: reached", "way out:0.1.2 d: branch 1 x")
    nodes = reached_nodes(places, {"7": 1})
    assert [(one.place, one.name) for one in nodes] == [
        ("0.1", "a: b 0.2 c"),
        ("way out:0.1.2", "d"),
    ]
    assert nodes[1].ways == {"branch 1 x": 1}
    assert nodes[1].depth == 2


def test_places_of_a_shipped_mission_are_understood():
    """Every place of it is a node, or a way of the node before it."""
    places = coverage_places(load("missions/explore.yaml"))
    everything = CoverageRecord(places, (1 << len(places)) - 1).as_hex()
    nodes = reached_nodes(places, {everything: 1})
    assert [one.name for one in nodes][:3] == ["explore", "look around", "repeat"]
    assert all(one.runs == 1 and all(one.ways.values()) for one in nodes)
    assert len(nodes) + sum(len(one.ways) for one in nodes) == len(places)
    ways = {way.partition(" ")[0] for one in nodes for way in one.ways}
    assert ways == {"outcome", "branch"}
