#!/usr/bin/env python3
"""Make docs/images/demo.webp: a run of explore.yaml as a short animated picture.

Runs the mission with ``--video`` and keeps every twelfth frame, at half the size (a minute).
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import av
from PIL import Image

ROOT = Path(__file__).resolve().parent.parent
PICTURE = ROOT / "docs" / "images" / "demo.webp"
EVERY, SIZE, SHOWN_MS = 12, (800, 450), 80


def frames(path: Path) -> Iterator[Image.Image]:
    """Yield the frames that are kept."""
    with av.open(str(path)) as video:
        for number, frame in enumerate(video.decode(video=0)):
            if number % EVERY == 0:
                yield frame.to_image().resize(SIZE, Image.Resampling.LANCZOS)


def main() -> int:
    """Run the mission, and write the picture."""
    with TemporaryDirectory() as folder:
        video = Path(folder) / "run.mp4"
        mission = str(ROOT / "missions" / "explore.yaml")
        command = [sys.executable, "-m", "bt_mission", "run", mission, "--video", str(video)]
        subprocess.run(command, check=True, cwd=folder)  # noqa: S603 - ourselves
        first, *others = frames(video)
    first.save(
        PICTURE,
        save_all=True,
        append_images=others,
        duration=SHOWN_MS,
        loop=0,
        quality=60,
        method=6,
    )
    print(PICTURE, f"{PICTURE.stat().st_size / 1e6:.2f} MB, {len(others) + 1} frames")
    return 0


if __name__ == "__main__":
    sys.exit(main())
