"""The text of a robot's MuJoCo model, looked through before MuJoCo reads it.

MuJoCo's parser and compiler end the process for some files. So the XML is read by SAX first,
without entities, within limits of size, depth and numbers. All files that it names lie in its
folder.
"""

from __future__ import annotations

import re
import xml.sax
import xml.sax.handler
from collections.abc import Sequence
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import Any

from bt_mission.base.errors import BtMissionError
from bt_mission.base.files import contents_of

Path_ = tuple[str, ...]

MOST_XML_BYTES = 2_000_000
MOST_ASSET_BYTES = 50_000_000
MOST_ELEMENTS = 5_000
MOST_DEPTH = 60
MOST_FILES = 200
LARGEST_NUMBER = 1e10

_REFUSED = {
    **dict.fromkeys(("plugin", "extension"), "plugins are programs, which are not loaded"),
    **dict.fromkeys(
        ("composite", "flexcomp", "flex", "skin", "replicate", "attach", "model", "hfield"),
        "this element is not supported in a robot's model",
    ),
}
_FOLDERS = {"mesh": "meshdir", "texture": "texturedir"}
_FILE_ATTRIBUTE = re.compile(r"^file(up|down|left|right|front|back)?$")
_NUMBERS = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?$")


class MjcfError(BtMissionError):
    """A robot's MuJoCo model cannot be used.

    Args:
        problems: Each with its key in the robot's file.
    """

    code = "BT-813"

    def __init__(self, problems: Sequence[tuple[Path_, str]]) -> None:
        super().__init__("; ".join(text for _, text in problems))
        self.problems = tuple(problems)


def fail(text: str, *path: str) -> MjcfError:
    """Return an error at a key of `model`."""
    return MjcfError([(("model", *path), text)])


def look_through(path: Path) -> tuple[Path, ...]:
    """Look through a model and all that it includes; return their files and those of their assets.

    Raises:
        MjcfError: MuJoCo should not see it.
    """
    written = _Written(path.parent)
    _look_through(written, path, path.parent.resolve())
    return _look_at_assets(written)


@dataclass
class _Written:
    """What the XML of a model holds, with its includes."""

    folder: Path
    elements: int = 0
    depth: int = 0
    files: list[Path] = field(default_factory=list)
    assets: list[tuple[str, str]] = field(default_factory=list)
    """The kind and the name of each file of an asset."""
    folders: dict[str, str] = field(default_factory=dict)

    def begin(self, tag: str) -> str | None:
        """Count an element that begins; return why it is refused, or None."""
        self.elements += 1
        self.depth += 1
        if self.elements > MOST_ELEMENTS:
            return f"more than {MOST_ELEMENTS:,} elements"
        if self.depth > MOST_DEPTH:
            return f"elements are nested more than {MOST_DEPTH} deep"
        return f"<{tag}>: {_REFUSED[tag]}" if tag in _REFUSED else None


def _look_through(
    written: _Written, path: Path, folder: Path, names: tuple[Path, ...] = ()
) -> None:
    """Read an XML file and those that it includes, before MuJoCo does."""
    name = path.name
    if ".." in path.parts:
        raise fail(f"{name} must lie in the folder of the robot's file, or below it", "file")
    try:
        real = path.resolve(strict=True)
        size = real.stat().st_size
        if not real.is_relative_to(folder):
            raise fail(f"{name} lies outside of the folder of the robot's file", "file")
        if size > MOST_XML_BYTES:
            raise fail(f"{name} has {size:,} bytes, the limit is {MOST_XML_BYTES:,}", "file")
        data = contents_of(real)
    except (OSError, ValueError, RuntimeError) as error:
        reason = getattr(error, "strerror", None) or error
        raise fail(f"cannot read {name}: {reason}", "file") from error
    if real in names:
        raise fail(f"{name} includes itself", "file")
    written.files.append(real)
    if len(written.files) > MOST_FILES:
        raise fail(f"{name}: more than {MOST_FILES} files are included", "file")
    for other in _parse(written, name, data):
        _look_through(written, _inside(written.folder, other, name), folder, (*names, real))


class _Handler(xml.sax.handler.ContentHandler, xml.sax.handler.LexicalHandler):
    """Notes the files that an XML text names; refuses what MuJoCo should not see."""

    def __init__(self, written: _Written, name: str) -> None:
        super().__init__()
        self._written, self._name = written, name
        self._locator: Any = None
        self.included: list[str] = []

    def setDocumentLocator(self, locator: Any) -> None:  # noqa: N802 - SAX's name
        """Keep what knows the line."""
        self._locator = locator

    def startElement(self, name: str, attrs: Any) -> None:  # noqa: N802 - SAX's name
        """Count and check an element."""
        wrong = self._written.begin(name)
        if wrong is not None:
            self._refuse(wrong)
        for key, value in attrs.items():
            _check_value(name, key, value, self._refuse)
            if name == "include" and key == "file":
                self.included.append(value)
            else:
                _note_file(self._written, name, key, value)

    def endElement(self, name: str) -> None:  # noqa: N802, ARG002 - SAX's name
        """Count an element."""
        self._written.depth -= 1

    def startDTD(self, *_: Any) -> None:  # noqa: N802 - SAX's name
        """Refuse entities."""
        self._refuse("a DOCTYPE is not supported")

    def _refuse(self, text: str) -> None:
        raise fail(f"{self._name}, line {self._locator.getLineNumber()}: {text}", "file")


def _parse(written: _Written, name: str, data: bytes) -> list[str]:
    """Look through an XML text; return the files that it includes."""
    handler = _Handler(written, name)
    parser = xml.sax.make_parser()  # noqa: S317 - entities and sizes are limited
    parser.setContentHandler(handler)
    parser.setProperty(xml.sax.handler.property_lexical_handler, handler)
    try:
        parser.parse(BytesIO(data))
    except xml.sax.SAXParseException as error:
        text = f"line {error.getLineNumber()}: {error.getMessage()}"
        raise fail(f"{name}, {text}", "file") from error
    except (xml.sax.SAXException, ValueError, LookupError) as error:
        raise fail(f"{name}: {error}", "file") from error
    return handler.included


def _note_file(written: _Written, tag: str, key: str, value: str) -> None:
    """Note an attribute that names a file, or the folder of files."""
    if key == "assetdir":
        written.folders.update(meshdir=value, texturedir=value)
    elif key in ("meshdir", "texturedir"):
        written.folders[key] = value
    elif _FILE_ATTRIBUTE.match(key):
        written.assets.append((tag, value))


def _check_value(tag: str, key: str, value: str, refuse: Any) -> None:
    """Refuse numbers beyond any robot's, and texts that are too long."""
    if len(value) > 100_000:
        refuse(f"{tag}.{key} has {len(value):,} characters")
    for word in value.split():
        if word.lower().lstrip("+-") in ("nan", "inf", "infinity"):
            refuse(f"{tag}.{key}: expected finite numbers, got {word}")
        if _NUMBERS.match(word) and not abs(float(word)) <= LARGEST_NUMBER:
            refuse(f"{tag}.{key}: {word} is larger than {LARGEST_NUMBER:g}")


def _inside(folder: Path, name: str, where: str) -> Path:
    """Return a file that a model names. It must lie in its folder."""
    plain = Path(name)
    if plain.is_absolute() or ".." in plain.parts or "\0" in name:
        raise fail(f"{where} names {name}, which is outside of its folder", "file")
    return folder / plain


def _look_at_assets(written: _Written) -> tuple[Path, ...]:
    total = 0
    assets: list[Path] = []
    folder = written.folder.resolve()
    for tag, name in written.assets:
        below = written.folders.get(_FOLDERS.get(tag, ""), "")
        path = _inside(_inside(written.folder, below, "the model"), name, "the model")
        try:
            real = path.resolve(strict=True)
            total += real.stat().st_size
        except (OSError, ValueError, RuntimeError) as error:
            reason = getattr(error, "strerror", None) or error
            raise fail(f"cannot read {name}: {reason}", "file") from error
        if not real.is_relative_to(folder):
            raise fail(f"{name} lies outside of the folder of the robot's file", "file")
        if total > MOST_ASSET_BYTES:
            raise fail(f"meshes and textures have more than {MOST_ASSET_BYTES:,} bytes", "file")
        assets.append(real)
    return (*written.files, *assets)
