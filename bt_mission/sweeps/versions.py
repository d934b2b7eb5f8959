"""Versions of what carries scenarios out: of two versions in one sweep, traces would differ."""

from __future__ import annotations

import hashlib
import json
from functools import cache
from pathlib import Path

import action_servers
import bt_mission
import sim
from bt_mission.core.files import folders
from bt_mission.recording.contents import versions

DIGITS = 12
VERSIONS_KEY = "versions"
"""Under it and a fingerprint the results keep all versions in full."""


@cache
def fingerprint() -> str:
    """Return the first digits of a SHA-256 of all versions, of our sources and shipped missions.

    Versions alone say too little where a worker runs a checkout of its own.
    """
    digest = hashlib.sha256(json.dumps(versions(), sort_keys=True).encode())
    for package in (bt_mission, action_servers, sim):
        root = Path(str(package.__file__)).parent
        for path in sorted(root.rglob("*.py")):
            digest.update(f"{root.name}/{path.relative_to(root).as_posix()}\n".encode())
            digest.update(path.read_bytes())
    # A mission may include trees of the shipped ones; worlds and robots come with each sweep.
    shipped = {
        path.name: path for folder in folders("missions")[1:] for path in folder.glob("*.y*ml")
    }
    for name, path in sorted(shipped.items()):
        digest.update(f"{name}\n".encode() + path.read_bytes())
    return digest.hexdigest()[:DIGITS]


def told() -> str:
    """Return all versions in a line for people."""
    return ", ".join(f"{name} {version}" for name, version in versions().items())
