"""A proposal as a person reads it before the decision: in a terminal, and on the page."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Self

from bt_mission.agents.call_log import verified
from bt_mission.agents.door import diff, margins
from bt_mission.agents.evidence import Evidence, evidence_of
from bt_mission.agents.folder import AgentFolder, Proposal
from bt_mission.agents.site import Site
from bt_mission.events.watched_mission import targets
from bt_mission.recording.replay.player import TimelineSeeker
from bt_mission.recording.replay.timeline import read_timeline
from bt_mission.views.terminal.chart import MapChart
from bt_mission.views.terminal.marks import marks_for, text_of

COLUMNS, ROWS = 72, 22


@dataclass(frozen=True)
class Shown:
    """A proposal with its evidence, as a person decides on it.

    Attributes:
        changes: Lines of the difference to the text that was approved last; empty without one.
        findings: Lines about the evidence.
        missing: What is missing for an approval.
        recording: That of the worst simulated run.
        calls: The number of calls in the log, which is whole.
    """

    site: Site
    proposal: Proposal
    evidence: Evidence
    changes: Sequence[str]
    findings: Sequence[str]
    missing: Sequence[str]
    recording: Path | None
    calls: int

    @classmethod
    def of(cls, folder: AgentFolder, site: Site, name: str) -> Self:
        """Read a proposal. Raises BtMissionError if it, or the log of calls, is damaged."""
        proposal = folder.proposal(name)
        evidence = evidence_of(folder, proposal, site)
        before = folder.approved_text(name)
        return cls(
            site,
            proposal,
            evidence,
            (diff(before, proposal.text).splitlines() or ["no difference"]) if before else (),
            tuple(_findings(site, evidence)),
            evidence.lacks(site, proposal),
            folder.recording(name),
            verified(folder.log)[0],
        )

    @property
    def head(self) -> Sequence[str]:
        """The proposal, its robot and its world."""
        written = self.site.written
        return (
            f"proposal '{self.proposal.name}' for site '{self.site.name}'",
            f"robot {written.robot}, world {written.world}, digest {self.proposal.digest[:16]}",
            f"it drives with seed {self.proposal.seed}, which is simulated",
        )

    @property
    def inputs(self) -> Sequence[str]:
        """The inputs of the mission that the proposal sets."""
        return [f"input {name} = {value}" for name, value in self.proposal.inputs.items()]

    def lines(self, encoding: str | None) -> Iterator[str]:
        """Yield the lines for a terminal."""
        yield from (*self.head, "", "the mission:", *self.proposal.text.splitlines(), *self.inputs)
        if self.changes:
            yield from ("", "changes since the last approval:", *self.changes)
        yield from ("", "evidence:", *(f"  {line}" for line in self.findings))
        if self.recording is not None:
            page = self.recording.with_suffix(".html")
            yield from ("", f"the worst run ({page}):", *_map(self.recording, encoding))
        yield from ("", f"the log of calls is whole: {self.calls:,} calls")


def _findings(site: Site, evidence: Evidence) -> Iterator[str]:
    yield from (f"warning: {each}" for each in evidence.warnings)
    if evidence.proof is not None:
        yield f"proof: {', '.join(evidence.proof.get('proved', ())) or 'nothing proved'}"
    yield from (f"open: {point}" for point in evidence.open_points)
    if evidence.runs is not None:
        runs = evidence.runs
        yield f"{runs.get('succeeded')} of {runs.get('scenarios')} runs succeeded"
    for row in margins(evidence):
        margin = row["least_margin"]
        by = "" if margin is None else f", smallest margin {margin:g} {row['unit']}"
        name = row["requirement"]
        note = "; only simulated, halts nothing on the robot" if name in site.only_simulated else ""
        yield f"{name}: held in {row['held']} of {row['runs']} runs{by}{note}"


def _map(recording: Path, encoding: str | None) -> Iterator[str]:
    timeline = read_timeline(recording)
    state = TimelineSeeker(timeline).seek(timeline.end_ns)
    chart = MapChart(marks_for(encoding))
    for spans in chart.draw(state.robot, targets(state), COLUMNS, ROWS):
        yield text_of(spans).rstrip()
