"""A mission that is sound, with hostile texts wherever one may be."""

from __future__ import annotations

from typing import Any

import yaml  # type: ignore[import-untyped]

from tests.support.hostile import HOSTILE, MARK, MARKUP

PRINTABLE = f"{MARK}{MARKUP}\u3164\u115f"
"""What names may hold: everything in it is printable by Python's measure."""

WITHOUT_HOLES = HOSTILE.replace("$", "")
FOR_XML = "".join(character for character in HOSTILE if character >= " " or character in "\t\r\n")
"""Inputs with the rest have no counterpart in XML."""

SOUND = {
    "mission": "m " + PRINTABLE,
    "description": PRINTABLE,
    "inputs": {"text": FOR_XML, "words": [PRINTABLE]},
    "trees": {
        "t": {
            "inputs": {"said": FOR_XML},
            "do": {"log": WITHOUT_HOLES, "name": "n " + PRINTABLE},
        }
    },
    "tree": {
        "sequence": [
            {"log": WITHOUT_HOLES},
            {"set": {"x": "'" + PRINTABLE.replace("'", "") + "'"}},
            {"tree": "t", "name": "t " + PRINTABLE},
            {
                "publish": {
                    "topic": "/said",
                    "type": "std_msgs/msg/String",
                    "message": {"data": WITHOUT_HOLES},
                }
            },
        ]
    },
}
"""A mission that is sound, with hostile texts wherever one may be."""


def yaml_of(mission: Any) -> str:
    """A mission as YAML, each character beyond ASCII as an escape, so that it is read as it is."""
    return str(yaml.safe_dump(mission, allow_unicode=False, width=10**6, sort_keys=False))
