"""Take the picture of docs/tutorials/prove.md: what `bt-mission prove` prints of its mission."""

from __future__ import annotations

import os
import re
import subprocess
import tempfile
from pathlib import Path

from rich.console import Console
from rich.text import Text

from tools.capture_screens import PICTURE, PROGRAM, ROOT, save

TUTORIAL = ROOT / "docs" / "tutorials" / "prove.md"
PROOF = PICTURE.with_name("prove.svg")


def draw_proof() -> None:
    """Save a picture of the first proof of the tutorial, in colours."""
    mission = re.search(r"```yaml survey.yaml\n(.*?)```", TUTORIAL.read_text("utf-8"), re.DOTALL)
    assert mission is not None, "the tutorial begins with its mission"
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "survey.yaml").write_text(mission[1], encoding="utf-8")
        command = [*PROGRAM, "prove", "survey.yaml", "--tree"]
        done = subprocess.run(  # noqa: S603 - our own program
            command, check=False, capture_output=True, text=True, cwd=folder
        )
    text = Text(f"$ bt-mission {' '.join(command[-3:])}\n{done.stdout}")
    for pattern, style in (
        (r"^\$.*", "bold"),
        (r"✓|^  proved:", "green"),
        (r"^  unset_variable:", "bold red"),
        (r"^  ends the mission:", "yellow"),
    ):
        for match in re.finditer(pattern, text.plain, re.MULTILINE):
            text.stylize(style, *match.span())
    with Path(os.devnull).open("w", encoding="utf-8") as nowhere:
        console = Console(record=True, width=110, file=nowhere)
        console.print(text)
        save(console.export_svg(title="bt-mission prove"), PROOF)


if __name__ == "__main__":
    draw_proof()
