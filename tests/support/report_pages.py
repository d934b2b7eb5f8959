"""Pages: the data of recorded runs, as the browser unpacks them, and the text of any page."""

from __future__ import annotations

import base64
import gzip
import json
import re
from html import unescape
from pathlib import Path
from typing import Any

_RECORDING = re.compile(
    r'<script type="application/gzip" class="recording" data-robot="([^"]*)">([^<]*)</script>'
)


def data_of(page: Path | str) -> dict[str, dict[str, Any]]:
    """The data of each robot on a page."""
    text = page.read_text(encoding="utf-8") if isinstance(page, Path) else page
    return {
        robot: json.loads(gzip.decompress(base64.b64decode(packed)))
        for robot, packed in _RECORDING.findall(text)
    }


def text_of(page: Path) -> str:
    """Return what a reader sees of a page."""
    return unescape(re.sub(r"<[^>]+>", "", page.read_text("utf-8")))
