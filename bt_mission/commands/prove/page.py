"""A proof as one HTML file, which needs no server."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from bt_mission.commands.prove.claims import PROPERTIES
from bt_mission.commands.prove.proof import Finding, Proof
from bt_mission.language.nodes.registry import KINDS
from bt_mission.scenarios.coverage.places import CoveragePlace
from bt_mission.views.html.pages import render


class _Node(NamedTuple):
    """A row of the tree."""

    tree: str
    depth: int
    glyph: str
    name: str
    outcomes: tuple[tuple[str, bool], ...]
    findings: tuple[int, ...]


def page_of(proof: Proof, runs: Mapping[int, str]) -> str:
    """Return the page.

    Args:
        proof: With the outcomes of nodes.
        runs: The pages of the runs of findings on the stage, by the number of the finding from 1;
            relative to this page.
    """
    numbered = list(enumerate(proof.findings, 1))
    verdicts = {
        **dict.fromkeys(proof.proved, "proved"),
        **dict.fromkeys(proof.not_violated, "not violated"),
        **{finding.property: "violated" for finding in proof.findings},
    }
    return render(
        "commands/prove/proof.html",
        proof=proof,
        verdicts=[
            (name, verdicts.get(name, "open"), text)
            for name, text in PROPERTIES.items()
            if name in verdicts or not proof.exhaustive
        ],
        nodes=[_node(place, numbered) for place in proof.outcomes],
        findings=[(number, finding, runs.get(number)) for number, finding in numbered],
    )


def page_alone(proof: Proof) -> str:
    """Return the page of a proof without runs of its findings, as a notebook shows it."""
    return page_of(proof, {})


def _node(place: CoveragePlace, findings: list[tuple[int, Finding]]) -> _Node:
    return _Node(
        tree=place.tree,
        depth=place.depth,
        glyph=KINDS[place.kind].sign.glyph,
        name=place.name,
        outcomes=tuple(
            (name, runs > 0)
            for marks in (place.outcomes, place.branches)
            for name, runs in marks.items()
        ),
        findings=tuple(number for number, finding in findings if finding.node == place.name),
    )
