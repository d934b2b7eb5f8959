"""Permits: a person's signature under one drive of one proposal."""

from __future__ import annotations

import base64
import json
import os
import secrets
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from cryptography.exceptions import InvalidSignature, UnsupportedAlgorithm
from cryptography.hazmat.primitives import serialization
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey, Ed25519PublicKey

from bt_mission.base.errors import BtMissionError
from bt_mission.base.output import make_folder_of, write_file
from bt_mission.base.wall_clock import unix_s
from bt_mission.commands.agents.evidence import EvidenceError, ProposalEvidence, evidence_of
from bt_mission.commands.agents.folder import AgentFolder, Proposal, canonical, digest_of
from bt_mission.commands.agents.site import Site
from bt_mission.commands.agents.site_files import differing

CLOCK_S = 60.0
"""A permit that was issued this much in the future is refused: a clock has been set back."""


class PermitError(BtMissionError):
    """A drive without a valid permit."""

    code = "BT-1404"


class ApprovalError(BtMissionError):
    """An approval that no person with a key has given."""

    code = "BT-1406"


@dataclass(frozen=True)
class Permit:
    """The statement that a person has signed.

    Attributes:
        id: Random; a permit is used once.
        proposal: The name of the proposal.
        mission: Digests of the mission, its inputs and its seed.
        site: Digests of the site, its robot and its world.
        evidence: The digest of the evidence that was shown.
        issued_s: Seconds since 1970.
        expires_s: The end of its validity, in the same unit.
        approver: The public key of the person.
    """

    id: str
    proposal: str
    mission: dict[str, str]
    site: dict[str, str]
    evidence: str
    issued_s: float
    expires_s: float
    approver: str


# ---- the key of a person ----------------------------------------------------------------------


def new_key(path: Path, passphrase: str) -> str:
    """Write a private key that only its owner may read; return the public key.

    Raises:
        ApprovalError: The file exists, or cannot be written.
    """
    key = Ed25519PrivateKey.generate()
    encryption: serialization.KeySerializationEncryption = serialization.NoEncryption()
    if passphrase:
        encryption = serialization.BestAvailableEncryption(passphrase.encode())
    content = key.private_bytes(
        serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, encryption
    )
    make_folder_of(path)
    try:
        number = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW, 0o600)
    except OSError as error:
        raise ApprovalError(f"{path}: cannot write the key ({error.strerror})") from None
    with os.fdopen(number, "wb") as stream:
        stream.write(content)
    return public_text(key)


def read_key(path: Path, passphrase: str) -> Ed25519PrivateKey:
    """Return a private key. Raises ApprovalError, also for a wrong passphrase."""
    try:
        content = path.read_bytes()
    except OSError as error:
        raise ApprovalError(
            f"{path}: cannot read the key ({error.strerror}); make one with "
            "'bt-mission approve --new-key'"
        ) from None
    try:
        key = serialization.load_pem_private_key(content, passphrase.encode() or None)
    except (ValueError, TypeError, UnsupportedAlgorithm):
        raise ApprovalError(f"{path}: not a key, or a wrong passphrase") from None
    if not isinstance(key, Ed25519PrivateKey):
        raise ApprovalError(f"{path}: expected an Ed25519 key")
    return key


def has_passphrase(path: Path) -> bool:
    """Return whether a key is encrypted."""
    try:
        return b"ENCRYPTED" in path.read_bytes()
    except OSError:
        return False


def public_text(key: Ed25519PrivateKey) -> str:
    """Return the public key as a site names it."""
    return base64.b64encode(key.public_key().public_bytes_raw()).decode()


# ---- granting ---------------------------------------------------------------------------------


def grant(
    folder: AgentFolder,
    site: Site,
    shown: Proposal,
    evidence: ProposalEvidence,
    key: Ed25519PrivateKey,
) -> Permit:
    """Sign a permit for what was shown to the person, and write it.

    Raises:
        EvidenceError: The evidence is not complete.
        ApprovalError: The key is not one of the site's.
        PermitError: The proposal or its evidence has changed since it was shown.
    """
    if missing := evidence.lacks(site, shown):
        raise EvidenceError("; ".join(missing))
    approver = public_text(key)
    if approver not in site.written.approvers:
        raise ApprovalError(f"{site.file}: 'approvers' does not list this key: {approver}")
    now = folder.proposal(shown.name)
    if now != shown or evidence_of(folder, now, site).digest != evidence.digest:
        raise PermitError(f"'{shown.name}' has changed while it was shown")
    issued_s = unix_s()
    permit = Permit(
        secrets.token_hex(16),
        shown.name,
        shown.digests,
        dict(site.files.digests),
        evidence.digest,
        issued_s,
        issued_s + site.written.expires,
        approver,
    )
    signature = base64.b64encode(key.sign(canonical(asdict(permit)))).decode()
    written = json.dumps({**asdict(permit), "signature": signature}, indent=1)
    write_file(folder.path("permits", f"{shown.name}.json"), written)
    folder.save_approved(shown)
    return permit


# ---- using ------------------------------------------------------------------------------------


def valid_permit(folder: AgentFolder, site: Site, name: str) -> tuple[Permit, Proposal]:
    """Return the permit of a proposal, and the proposal as it was read for it.

    Raises:
        PermitError: It is missing, forged, expired or used, or something has changed since.
        SiteChangedError: A file of the site has changed since it was read.
        EvidenceError: The evidence is not complete.
    """
    written = folder.permit(name)
    if written is None:
        raise PermitError(f"'{name}' has no permit: a person approves with 'bt-mission approve'")
    permit = _signed(written, site)
    now_s = unix_s()
    if permit.proposal != name:
        raise PermitError(f"the permit is for '{permit.proposal}', not for '{name}'")
    if now_s > permit.expires_s or permit.expires_s - permit.issued_s > site.written.expires + 1:
        raise PermitError(f"the permit of '{name}' has expired; it must be approved again")
    if permit.issued_s > now_s + CLOCK_S:
        raise PermitError(f"the permit of '{name}' was issued in the future: check the clock")
    if folder.path("used", permit.id).exists():
        raise PermitError(f"the permit of '{name}' was used; each drive needs an approval")
    if changed := differing(permit.site, site.files.digests):
        raise PermitError(f"{changed} has changed since the approval")
    proposal = folder.proposal(name)
    if changed := differing(permit.mission, proposal.digests):
        raise PermitError(f"'{name}' has changed since the approval: {changed}")
    evidence = evidence_of(folder, proposal, site)
    if permit.evidence != evidence.digest:
        raise PermitError(f"the evidence of '{name}' has changed since the approval")
    if missing := evidence.lacks(site, proposal):
        raise EvidenceError("; ".join(missing))
    site.refuse_changed()
    return permit, proposal


def spend(folder: AgentFolder, permit: Permit) -> None:
    """Mark a permit as used, before the robot moves. Raises PermitError if it was used already."""
    path = folder.path("used", permit.id)
    try:
        number = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW, 0o600)
        with os.fdopen(number, "w") as stream:
            stream.write(f"{permit.proposal} {digest_of(asdict(permit))}\n")
            stream.flush()
            os.fsync(number)
    except FileExistsError:
        raise PermitError(f"the permit of '{permit.proposal}' was used") from None
    except OSError as error:
        raise PermitError(f"{path}: cannot note the use ({error.strerror})") from None


def _signed(written: dict[str, Any], site: Site) -> Permit:
    """Return a permit whose signature is that of an approver of the site."""
    data = dict(written)
    try:
        signature = base64.b64decode(data.pop("signature"), validate=True)
        permit = Permit(**data)
        if permit.approver not in site.written.approvers:
            raise PermitError("the permit is not signed by an approver of the site")
        key = Ed25519PublicKey.from_public_bytes(base64.b64decode(permit.approver, validate=True))
        key.verify(signature, canonical(asdict(permit)))
    except (KeyError, TypeError, ValueError, InvalidSignature):
        raise PermitError("the permit is damaged or forged") from None
    return permit
