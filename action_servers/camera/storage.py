"""Where pictures go: a new folder for every goal, and PNG files in it."""

from __future__ import annotations

import io
from contextlib import suppress
from pathlib import Path

from PIL import Image as Picture

from action_servers.core.maneuver import Image

# The lowest level that compresses at all: seven times faster than Pillow's default for files a
# fifth larger, and a picture is written between two control steps.
COMPRESS_LEVEL = 1


class ImageFolder:
    """The folder of one goal, `root`/`name`; `name` may be set until it is opened.

    Where that name is taken, a number is added: the pictures of an earlier goal are never touched.
    """

    def __init__(self, root: Path, name: str = "images") -> None:
        self.name = name
        self._root = root
        self._path: Path | None = None

    @property
    def folder(self) -> str:
        """Full path of the folder; empty until it is opened."""
        return str(self._path or "")

    def open(self) -> None:
        """Make the folder, and those above it. Raises OSError."""
        root = self._root.expanduser().resolve()
        root.mkdir(parents=True, exist_ok=True)
        path, number = root / self.name, 1
        while True:
            try:
                path.mkdir()
            except FileExistsError:
                number += 1
                path = root / f"{self.name}_{number}"
            else:
                self._path = path
                return

    def save(self, number: int, image: Image) -> str:
        """Write `image_NN.png` and return its full path; no part of it is left on OSError."""
        if self._path is None:
            raise FileNotFoundError("the folder has not been opened")
        encoded = io.BytesIO()
        Picture.fromarray(image.rgb).save(encoded, "PNG", compress_level=COMPRESS_LEVEL)
        path = self._path / f"image_{number:02d}.png"
        try:
            path.write_bytes(encoded.getbuffer())
        except OSError:
            with suppress(OSError):
                path.unlink(missing_ok=True)
            raise
        return str(path)
