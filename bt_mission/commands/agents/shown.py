"""A proposal as a person reads it before the decision: in a terminal, and on the page.

What comes from the proposal stands apart: on separate lines, each behind a mark, escaped and cut
to the width, so that nothing in it can look like a line of this program.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Self

from rich.cells import chop_cells

from bt_mission.base.errors import BtMissionError
from bt_mission.base.text import escape_control
from bt_mission.base.yaml.composer import split_lines
from bt_mission.commands.agents.call_log import read_log
from bt_mission.commands.agents.evidence import ProposalEvidence, evidence_of
from bt_mission.commands.agents.folder import AgentFolder, Proposal
from bt_mission.commands.agents.gateway import diff, margins
from bt_mission.commands.agents.names import shown_name
from bt_mission.commands.agents.site import Site
from bt_mission.executive.events.watched_mission import targets
from bt_mission.recording.replay.player import TimelineSeeker
from bt_mission.recording.replay.timeline import Timeline, read_timeline
from bt_mission.views.terminal.map_chart import MapChart
from bt_mission.views.terminal.marks import marks_for, text_of

COLUMNS, ROWS = 72, 22
MOST_LINES = 200
"""Of a part that is not the mission itself."""
THEIRS, CONTINUED = "  | ", "  + "
"""Before a line of the proposal, and before the rest of one that is too long."""
NARROWEST = 24


@dataclass(frozen=True)
class Part:
    """Some lines with a title.

    Attributes:
        is_theirs: Whether words of the proposal are in them. They are escaped already.
    """

    title: str
    lines: Sequence[str]
    is_theirs: bool = False


@dataclass(frozen=True)
class Shown:
    """A proposal with its evidence, as a person decides on it.

    Attributes:
        parts: What is shown of it, in this order.
        missing: What is missing for an approval.
        recording: That of the worst simulated run.
        timeline: Read from it; None without one.
        log: A line about the log of calls.
    """

    site: Site
    proposal: Proposal
    evidence: ProposalEvidence
    parts: Sequence[Part]
    missing: Sequence[str]
    recording: Path | None
    timeline: Timeline | None
    log: str

    @classmethod
    def of(cls, folder: AgentFolder, site: Site, name: str) -> Self:
        """Read a proposal. Raises BtMissionError if it is damaged."""
        proposal = folder.proposal(name)
        evidence = evidence_of(folder, proposal, site)
        before = folder.approved(name)
        missing, recording = evidence.lacks(site, proposal), folder.recording(name)
        timeline: Timeline | None = None
        if recording is not None:
            try:
                timeline = read_timeline(recording)
            except BtMissionError as error:
                missing.append(f"the worst run cannot be shown: {error.headline}; simulate again")
        return cls(
            site,
            proposal,
            evidence,
            [
                *_mission(proposal, before),
                *_checks(evidence),
                *_runs(site, proposal, evidence),
            ],
            missing,
            recording,
            timeline,
            str(read_log(folder.log)),
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

    def lines(self, encoding: str | None, width: int = COLUMNS) -> Iterator[str]:
        """Yield the lines for a terminal of this width."""
        yield from self.head
        for part in self.parts:
            yield from ("", f"{part.title}:")
            yield from _marked(part.lines, width) if part.is_theirs else map(_indented, part.lines)
        if self.recording is not None and self.timeline is not None:
            page = self.recording.with_suffix(".html")
            yield from ("", f"The worst run ({page}):")
            yield from (f"{THEIRS}{line}" for line in _map(self.timeline, encoding))
        yield from ("", self.log)


def states(folder: AgentFolder, site: Site) -> Iterator[tuple[str, str]]:
    """Yield each proposal with what is missing for an approval, or why it cannot be read."""
    for name in folder.names():
        try:
            proposal = folder.proposal(name)
            missing = evidence_of(folder, proposal, site).lacks(site, proposal)
            yield name, "; ".join(missing) or "can be approved"
        except BtMissionError as error:
            yield name, error.headline


def _theirs(title: str, lines: Iterable[str], most: int | None = MOST_LINES) -> Part:
    """Return lines with words of the proposal: each is one line, whatever is in it."""
    escaped = [escape_control(line) for line in lines]
    if most is not None and len(escaped) > most:
        title = f"{title} (the first {most} of {len(escaped)} lines)"
    return Part(title, escaped[:most], is_theirs=True)


def _mission(proposal: Proposal, before: Proposal | None) -> Iterator[Part]:
    yield _theirs("The mission, in the words of the proposal", split_lines(proposal.text), None)
    if proposal.inputs:
        yield _theirs("Its inputs, in the words of the proposal", _inputs(proposal), None)
    if before is not None:
        changes = diff(_decided(before), _decided(proposal)) or "no difference"
        yield _theirs("Changes since the last approval", split_lines(changes), None)


def _inputs(proposal: Proposal) -> list[str]:
    return [escape_control(f"{name} = {value}") for name, value in proposal.inputs.items()]


def _decided(proposal: Proposal) -> str:
    """Return all that a person decides on as one text: the mission, its inputs and its seed."""
    lines = [proposal.text, "its inputs:", *_inputs(proposal), f"its seed: {proposal.seed}"]
    return "\n".join(lines)


def _checks(evidence: ProposalEvidence) -> Iterator[Part]:
    if evidence.warnings:
        yield _theirs("Warnings of the check, with names of the proposal", evidence.warnings)
    points = [f"open: {point}" for point in evidence.open_points]
    if evidence.proof is not None:
        points.insert(0, f"proved: {', '.join(evidence.proof.get('proved', ())) or 'nothing'}")
    yield _theirs("The proof, with names of the proposal", points)


def _runs(site: Site, proposal: Proposal, evidence: ProposalEvidence) -> Iterator[Part]:
    if evidence.runs is None:
        return
    runs = evidence.runs
    known = {each.name for each in site.requirements}
    ends = f"{runs.get('succeeded')} of {runs.get('scenarios')} runs succeeded"
    seeds = f"seeds 0 to {site.written.seeds - 1}"
    if proposal.seed >= site.written.seeds:
        seeds += f", and {proposal.seed}"
    rows: dict[bool, list[str]] = {True: [], False: []}
    for row in margins(evidence):
        name, margin = str(row["requirement"]), row["least_margin"]
        by = "" if margin is None else f", smallest margin {margin:g} {row['unit']}"
        note = "; only simulated, halts nothing on the robot" if name in site.only_simulated else ""
        shown = name if name in known else shown_name(name)
        idle = f", not exercised in {count}" if (count := row["not_exercised"]) else ""
        held = f"held in {row['held']} of {row['runs']} runs{idle}"
        rows[name in known].append(f"{shown}: {held}{by}{note}")
    yield Part("Evidence", [f"{ends} ({seeds})", *rows[True]])
    if rows[False]:
        yield _theirs("Requirements of the proposal itself, with its names", rows[False])


def _indented(line: str) -> str:
    return f"  {line}"


def _marked(lines: Iterable[str], width: int) -> Iterator[str]:
    """Yield lines of a proposal behind marks, cut so that a terminal breaks none of them."""
    for line in lines:
        # A terminal may show a letter of another script wider than it is said to be.
        most = max(width, NARROWEST) - len(THEIRS) - 1
        pieces = chop_cells(line, most if line.isascii() else most // 2) or [""]
        yield from (f"{CONTINUED if at else THEIRS}{each}" for at, each in enumerate(pieces))


def _map(timeline: Timeline, encoding: str | None) -> Iterator[str]:
    state = TimelineSeeker(timeline).seek(timeline.end_ns)
    chart = MapChart(marks_for(encoding))
    for spans in chart.draw(state.robot, targets(state), COLUMNS, ROWS):
        yield text_of(spans).rstrip()
