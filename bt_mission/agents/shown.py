"""The lines about a proposal that a person reads before the decision."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from bt_mission.agents.door import diff, margins
from bt_mission.agents.evidence import Evidence
from bt_mission.agents.folder import AgentFolder, Proposal
from bt_mission.agents.site import Site
from bt_mission.events.watched_mission import targets
from bt_mission.recording.replay.player import TimelineSeeker
from bt_mission.recording.replay.timeline import read_timeline
from bt_mission.views.terminal.chart import MapChart
from bt_mission.views.terminal.marks import marks_for, text_of

COLUMNS, ROWS = 72, 22


def shown(
    folder: AgentFolder, site: Site, proposal: Proposal, evidence: Evidence, encoding: str | None
) -> Iterator[str]:
    """Yield the lines: mission, difference, evidence, map of the worst simulated run."""
    written = site.written
    yield f"proposal '{proposal.name}' for site '{site.name}'"
    yield f"robot {written.robot}, world {written.world}, digest {proposal.digest[:16]}"
    yield from ("", "the mission:", *proposal.text.splitlines())
    for name, value in proposal.inputs.items():
        yield f"input {name} = {value}"
    before = folder.approved_text(proposal.name)
    if before:
        changes = diff(before, proposal.text).splitlines() or ["no difference"]
        yield from ("", "changes since the last approval:", *changes)
    yield from ("", "evidence:", *(f"  warning: {each}" for each in evidence.warnings))
    if evidence.proof is not None:
        yield f"  proof: {', '.join(evidence.proof.get('proved', ())) or 'nothing proved'}"
    yield from (f"  open: {point}" for point in evidence.open_points)
    if evidence.runs is not None:
        runs = evidence.runs
        yield f"  {runs.get('succeeded')} of {runs.get('scenarios')} runs succeeded"
    for row in margins(evidence):
        margin = row["least_margin"]
        by = "" if margin is None else f", smallest margin {margin:g} {row['unit']}"
        name = row["requirement"]
        note = "; only simulated, halts nothing on the robot" if name in site.only_simulated else ""
        yield f"  {name}: held in {row['held']} of {row['runs']} runs{by}{note}"
    results = folder.path("proposals", proposal.name, "results")
    for recording in sorted(results.glob("recordings/*.mcap"))[:1]:
        yield from ("", f"the worst run ({recording.with_suffix('.html')}):")
        yield from _map(recording, encoding)


def _map(recording: Path, encoding: str | None) -> Iterator[str]:
    timeline = read_timeline(recording)
    state = TimelineSeeker(timeline).seek(timeline.end_ns)
    chart = MapChart(marks_for(encoding))
    for spans in chart.draw(state.robot, targets(state), COLUMNS, ROWS):
        yield text_of(spans).rstrip()
