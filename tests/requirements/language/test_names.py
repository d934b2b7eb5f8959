"""Names of nodes in requirements are those that the nodes of the run have."""

from __future__ import annotations

import pytest

from bt_mission.base.diagnostics import InputError
from bt_mission.executive.behaviours.builder import build_tree
from bt_mission.executive.behaviours.runtime import Scope
from bt_mission.scenarios.coverage.places import places
from bt_mission.sessions.load import load
from bt_mission.views.drawing.nodes import drawn

MISSION = """\
mission: plain
requirements:
  it: {formula}
trees:
  spare:
    do: {{wait: 1, name: nowhere}}
  used:
    do:
      sequence: [{{wait: 1, name: inner}}]
tree:
  sequence:
    - wait: 1
    - tree: used
"""


def refusal(formula: str) -> str:
    """Return what is said of a formula that names a node."""
    with pytest.raises(InputError) as refused:
        load(MISSION.format(formula=formula))
    (fault,) = refused.value.diagnostics
    assert fault.line == 3
    return f"{fault.message}; {fault.hint}"


def test_a_root_without_a_name_has_that_of_the_mission_everywhere() -> None:
    """In the tree that runs, its picture, coverage and requirements."""
    mission = load(MISSION.format(formula='eventually succeeded("plain")'))
    names = {
        build_tree(mission, Scope({}, 0)).name,
        drawn(mission).name,
        next(iter(places(mission)))[2].name,
        mission.root.label,
    }
    assert names == {"plain"}


@pytest.mark.parametrize(
    ("formula", "words"),
    [
        ('eventually succeeded("plian")', "did you mean 'plain'?"),
        ('never failed("nowhere")', "unknown node: 'nowhere' (known: "),
        ('never failed("0.2")', "unknown node: '0.2'"),
        ('never failed("0.1.0.0.1")', "unknown node: '0.1.0.0.1'"),
        ('never failed("1")', "unknown node: '1'"),
        ('always feedback("inner", "x") > 0', "unknown node with a goal: 'inner'"),
        ('always feedback("0.0", "x") > 0', "unknown node with a goal: '0.0'"),
    ],
)
def test_a_name_that_no_node_of_the_run_has_is_an_error(formula: str, words: str) -> None:
    """Also that of a tree that is not used, and a place at which nothing stands."""
    assert words in refusal(formula)


@pytest.mark.parametrize("node", ["plain", "inner", "0", "0.1", "0.1.0.0"])
def test_names_and_places_of_the_run_are_valid(node: str) -> None:
    """Those of used trees included."""
    load(MISSION.format(formula=f'never failed("{node}")'))


def test_the_error_for_the_kind_of_an_unnamed_root_says_its_name() -> None:
    """The root is called as the mission is."""
    with pytest.raises(InputError) as refused:
        load(
            "mission: plain\nrequirements:\n  it: never failed('sequence')\n"
            "tree:\n  sequence: [{wait: 1}]\n"
        )
    assert refused.value.diagnostics[0].hint == "the root has the mission's name: 'plain'"
