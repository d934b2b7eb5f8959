"""The folder of a site's agents: files that others may have changed are read with care."""

from __future__ import annotations

import fcntl
import hashlib
import json
import os
import re
import shutil
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from operator import index
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from bt_mission.base.diagnostics import quoted
from bt_mission.base.errors import BtMissionError
from bt_mission.base.output import cannot_write, make_folder_of, within, write_file
from bt_mission.base.text import category

MOST_TEXT = 20_000
"""Characters of a mission."""
MOST_FILE = 1_000_000
MOST_PROPOSALS = 100
_WORK = ".work-"
"""The beginning of the name of a job's folder."""
_NOT_TEXT = ("Cc", "Cs")
"""The categories of control characters, and of halves of characters."""
_NAME = re.compile(r"[a-z][a-z0-9_-]{0,39}")


class ProposalError(BtMissionError):
    """A proposal that does not exist, or whose name, size or file is refused."""

    code = "BT-1401"


@dataclass(frozen=True)
class Proposal:
    """A mission that an agent has written.

    Attributes:
        inputs: Values for inputs of the mission, as texts.
        seed: That of the drive. It is simulated, too.
    """

    name: str
    text: str
    inputs: dict[str, str] = field(default_factory=dict)
    seed: int = 0

    @property
    def digests(self) -> dict[str, str]:
        """A digest of each part of it, by the words for it in messages."""
        return {
            "its name": self.name,
            "its mission": digest_of(self.text),
            "its inputs": digest_of(self.inputs),
            "its seed": str(self.seed),
        }

    @property
    def digest(self) -> str:
        """Changes with each byte of the mission, its inputs and its seed."""
        return digest_of(self.digests)


def digest_of(value: Any) -> str:
    """Return SHA-256 of a JSON value."""
    return hashlib.sha256(canonical(value)).hexdigest()


def canonical(value: Any) -> bytes:
    """Return the only form of a JSON value, for digests and signatures."""
    return json.dumps(value, sort_keys=True, separators=(",", ":"), allow_nan=False).encode()


class AgentFolder:
    """Proposals, their evidence, and permits.

    The server of agents writes below ``proposals`` only, `approve` writes ``permits`` and
    ``approved``, and the server of the robot ``used``.

    Args:
        root: The folder; it may be a link itself, and no link below it is followed.
    """

    def __init__(self, root: Path) -> None:
        self.root = root
        for name in ("proposals", "permits", "used", "approved"):
            try:
                self.path(name).mkdir(parents=True, exist_ok=True)
            except OSError as error:
                raise cannot_write(root / name, error) from error

    def path(self, *parts: str) -> Path:
        """Return a path below the root. Raises BtMissionError if a part of it is a link."""
        return within(self.root, "/".join(parts))

    @property
    def log(self) -> Path:
        """The file of the log of calls."""
        return self.path("proposals", "calls.jsonl")

    def names(self) -> list[str]:
        """Return the names of the proposals, sorted."""
        folder = self.path("proposals")
        return sorted(entry.name for entry in os.scandir(folder) if _NAME.fullmatch(entry.name))

    def proposal(self, name: str) -> Proposal:
        """Return a proposal. Raises ProposalError if it is missing or damaged."""
        proposal = self._proposal(name, "proposals", checked_name(name), "proposal.json")
        if proposal is None:
            known = ", ".join(self.names()) or "none"
            raise ProposalError(f"no proposal {quoted(name)} (known: {known})")
        return proposal

    def save(self, proposal: Proposal) -> None:
        """Write a proposal, and drop what belongs to its earlier version."""
        name = checked_name(proposal.name)
        refuse_unfit(proposal)
        if name not in self.names() and len(self.names()) >= MOST_PROPOSALS:
            raise ProposalError(f"there are {MOST_PROPOSALS} proposals already")
        path = self.path("proposals", name, "proposal.json")
        make_folder_of(path)
        for old in ("evidence.json", "results"):
            self.remove("proposals", name, old)
        _write(path, proposal)

    def evidence(self, name: str) -> dict[str, Any]:
        """Return the evidence of a proposal as it is written; empty without any."""
        return self._json("proposals", checked_name(name), "evidence.json") or {}

    def save_evidence(self, name: str, evidence: dict[str, Any]) -> None:
        """Replace the evidence of a proposal."""
        path = self.path("proposals", checked_name(name), "evidence.json")
        write_file(path, json.dumps(evidence, indent=1))

    def permit(self, name: str) -> dict[str, Any] | None:
        """Return the newest permit of a proposal; None without one."""
        return self._json("permits", f"{checked_name(name)}.json")

    def approved(self, name: str) -> Proposal | None:
        """Return the version that was approved last; None without one."""
        return self._proposal(name, "approved", f"{checked_name(name)}.json")

    def save_approved(self, proposal: Proposal) -> None:
        """Keep the version that was approved last."""
        _write(self.path("approved", f"{checked_name(proposal.name)}.json"), proposal)

    def recording(self, name: str) -> Path | None:
        """Return the recording of the worst simulated run; None without one."""
        folder = self.path("proposals", checked_name(name), "results", "recordings")
        names = sorted(path.name for path in folder.glob("*.mcap"))
        return self.path(*folder.relative_to(self.root).parts, names[0]) if names else None

    def picture(self, name: str) -> bytes | None:
        """Return the picture of that run; None without one."""
        recording = self.recording(name)
        if recording is None:
            return None
        return self._bytes(*recording.with_suffix(".png").relative_to(self.root).parts)

    @contextmanager
    def work_folder(self) -> Iterator[Path]:
        """Make a folder for a job, locked while it runs, and remove it."""
        with TemporaryDirectory(dir=self.path("proposals"), prefix=_WORK) as name:
            number = os.open(name, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
            try:
                fcntl.flock(number, fcntl.LOCK_EX)
                yield Path(name)
            finally:
                os.close(number)

    def remove_old_work(self) -> None:
        """Remove the folders of jobs whose process was killed."""
        for path in self.path("proposals").glob(f"{_WORK}*"):
            try:
                flags = os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC
                number = os.open(path, flags)
            except OSError:  # it is no folder, or has just been removed
                continue
            try:
                fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:  # its job runs
                continue
            else:
                shutil.rmtree(path, ignore_errors=True)
            finally:
                os.close(number)

    def remove(self, *parts: str) -> None:
        """Remove a file or a folder, if it is there."""
        path = self.path(*parts)
        if path.is_dir():
            shutil.rmtree(path, ignore_errors=True)
        else:
            with suppress(FileNotFoundError):
                path.unlink()

    def _proposal(self, name: str, *parts: str) -> Proposal | None:
        data = self._json(*parts)
        if data is None:
            return None
        try:
            inputs = {str(key): str(value) for key, value in data["inputs"].items()}
            proposal = Proposal(name, str(data["text"]), inputs, index(data["seed"]))
            refuse_unfit(proposal)
        except (KeyError, TypeError, ValueError, AttributeError):
            raise ProposalError(f"{name}: the file of the proposal is damaged") from None
        return proposal

    def _json(self, *parts: str) -> dict[str, Any] | None:
        content = self._bytes(*parts)
        if content is None:
            return None
        try:
            data = json.loads(content, parse_constant=_refuse_constant)
        except (ValueError, RecursionError):
            data = None
        if not isinstance(data, dict):
            raise ProposalError(f"{'/'.join(parts)}: expected a JSON object")
        return data

    def _bytes(self, *parts: str) -> bytes | None:
        """Return a regular file as a whole, read once; None if there is none."""
        path = self.path(*parts)
        try:
            number = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
        except FileNotFoundError:
            return None
        except OSError as error:
            raise ProposalError(f"{path}: cannot be read ({error.strerror})") from None
        with os.fdopen(number, "rb") as stream:
            if not stat.S_ISREG(os.fstat(number).st_mode):
                raise ProposalError(f"{path}: expected a file")
            content = stream.read(MOST_FILE + 1)
        if len(content) > MOST_FILE:
            raise ProposalError(f"{path}: more than {MOST_FILE:,} bytes")
        return content


def _write(path: Path, proposal: Proposal) -> None:
    data = {"text": proposal.text, "inputs": proposal.inputs, "seed": proposal.seed}
    write_file(path, json.dumps(data, indent=1))


def _refuse_constant(name: str) -> Any:
    raise ValueError(f"{name} is not JSON, and has no digest")


def checked_name(name: str) -> str:
    """Return the name of a proposal. Raises ProposalError if it is not a plain word."""
    if not _NAME.fullmatch(name):
        raise ProposalError(
            f"{quoted(name)}: expected a name of at most 40 small letters, digits, '-' and '_'"
        )
    return name


def refuse_unfit(proposal: Proposal) -> None:
    """Raise ProposalError for what is too large, or for inputs that no command can be given."""
    if len(proposal.text) > MOST_TEXT:
        raise ProposalError(f"a mission has at most {MOST_TEXT:,} characters")
    sizes = [len(part) for pair in proposal.inputs.items() for part in pair]
    if len(sizes) > 100 or sum(sizes) > MOST_TEXT:
        raise ProposalError("a proposal has at most 50 inputs, with short values")
    for name, value in proposal.inputs.items():
        if any(category(character) in _NOT_TEXT for character in name + value):
            raise ProposalError(
                f"inputs: expected text without control characters, got {quoted(name)}: "
                f"{quoted(value)}"
            )
    if not 0 <= proposal.seed < 2**63:
        raise ProposalError("seed: expected an integer from 0")
