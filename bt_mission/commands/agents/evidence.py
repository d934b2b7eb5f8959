"""The evidence for a proposal: its check, its proof, and simulated runs of the site."""

from collections.abc import Iterator
from dataclasses import asdict, dataclass, field, replace
from typing import Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from bt_mission.base.errors import BtMissionError
from bt_mission.commands.agents.folder import AgentFolder, Proposal, digest_of
from bt_mission.commands.agents.site import Site


class EvidenceError(BtMissionError):
    """A proposal without the evidence that an approval needs."""

    code = "BT-1403"


class _EvidencePart(BaseModel):
    """A part of the file of evidence, with the values that are read; it may have more."""

    model_config = ConfigDict(strict=True, allow_inf_nan=False)


class _Verdicts(_EvidencePart):
    holds: int
    excused: int = Field(0, alias="not applicable")
    least_margin: float | None = None
    unit: str = ""


class _Runs(_EvidencePart):
    scenarios: int
    succeeded: int
    errors: int
    seeds: list[int]
    requirements: dict[str, _Verdicts] = {}


class _Finding(_EvidencePart):
    text: str


class _ProvedRequirement(_EvidencePart):
    requirement: str
    verdict: str
    why: str | None = None


class _Proof(_EvidencePart):
    proved: list[str] = []
    why_not: list[str] = []
    findings: list[_Finding]
    requirements: list[_ProvedRequirement] = []


class _File(_EvidencePart):
    is_checked: bool
    warnings: list[str]
    proof: _Proof | None
    runs: _Runs | None


@dataclass(frozen=True)
class ProposalEvidence:
    """The evidence for one version of a proposal on one version of a site.

    Attributes:
        proposal: The digest of the proposal.
        site: The digest of the site.
        warnings: Of the check.
        proof: What `prove --json` prints; None without a proof.
        runs: What `sweep --json` prints of the runs of the site, with their seeds; None without
            them.
    """

    proposal: str
    site: str
    warnings: tuple[str, ...] = ()
    proof: dict[str, Any] | None = None
    runs: dict[str, Any] | None = None
    is_checked: bool = field(default=True)

    @property
    def digest(self) -> str:
        """Changes with each part of it."""
        return digest_of(asdict(self))

    def lacks(self, site: Site, proposal: Proposal) -> list[str]:
        """Return what is missing for an approval, as text; empty if it is complete."""
        if (self.proposal, self.site) != (proposal.digest, site.digest):
            return ["the evidence is that of another version"]
        return list(self._lacks(site, site.runs(proposal), list(site.seeds(proposal))))

    def _lacks(self, site: Site, expected: int, seeds: list[int]) -> Iterator[str]:
        if not self.is_checked:
            yield "no check of this version: call propose"
        if self.proof is None:
            yield "no proof of this version: call prove"
        if self.runs is None:
            yield f"no simulated runs of this version: call simulate ({expected} runs)"
            return
        runs = self.runs
        if runs.get("scenarios") != expected or runs.get("errors") != 0:
            count, errors = runs.get("scenarios", 0), runs.get("errors")
            yield f"{count} of {expected} runs, {errors} with errors"
        if runs.get("seeds") != seeds:
            yield f"the runs are not those with the seeds {', '.join(map(str, seeds))}"
        verdicts = runs.get("requirements", {})
        for each in site.requirements:
            counts = verdicts.get(each.name, {})
            holds, excused = counts.get("holds", 0), counts.get("not applicable", 0)
            if holds + excused != expected:
                yield f"requirement '{each.name}' of the site held in {holds} of {expected} runs"

    @property
    def open_points(self) -> list[str]:
        """Return what the proof leaves open, for the person who decides."""
        if self.proof is None:
            return ["not proved"]
        points = [str(why) for why in self.proof.get("why_not", ())]
        points += [
            f"requirement '{each.get('requirement')}' is not exercised: {each.get('why')}"
            for each in self.proof.get("requirements", ())
            if each.get("verdict") == "not exercised"
        ]
        return points + [str(each.get("text")) for each in self.proof.get("findings", ())]


def evidence_of(folder: AgentFolder, proposal: Proposal, site: Site) -> ProposalEvidence:
    """Return the evidence of exactly this version of a proposal.

    It is empty without a file, and with one that was not written here.
    """
    empty = ProposalEvidence(proposal.digest, site.digest, is_checked=False)
    written = folder.evidence(proposal.name)
    if written.get("proposal") != empty.proposal or written.get("site") != empty.site:
        return empty
    try:
        file = _File.model_validate(written)
    except ValidationError:
        return empty
    return replace(
        empty,
        is_checked=file.is_checked,
        warnings=tuple(file.warnings),
        proof=written["proof"],
        runs=written["runs"],
    )
