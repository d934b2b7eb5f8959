"""tools/check_prose.py: the words of the documentation are checked."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from tests.support.project import ROOT
from tools.check_prose import main, shadow_of, shadow_of_catalogue, shadow_of_output

SOURCE = '''"""Drives."""

def drive(speed):
    """Drive at ``speed``.

    Raises :class:`ValueError`.
    """
    name = "two words"
    raise ValueError(f"expected a speed above 0, got {speed}")


def _private():
    """Words of private names are not read."""
'''


def test_a_text_stands_in_its_line():
    """So a finding names the line of the Python file."""
    lines = shadow_of(SOURCE).splitlines()
    assert lines[0] == "Drives."
    assert lines[3] == "Drive at `speed`."
    assert lines[5] == "Raises `ValueError`."
    assert lines[8] == "expected a speed above 0, got `N`."


def test_lines_of_an_example_are_sentences():
    """Lines of running text are joined; a line that is indented is one sentence."""
    source = 'HELP = """\\\nruns a mission\nand shows it:\n  run square  once\n  run tour\n"""\n'
    assert shadow_of(source).splitlines()[0] == (
        "runs a mission and shows it: run square  once. run tour."
    )


def test_code_in_docstrings_is_not_read():
    """Nor are scripts of a shell."""
    source = '"""Drives::\n\n    who looks on\n\nSafely.\n"""\nSCRIPT = "run this with ${HOME}"\n'
    assert shadow_of(source).split() == ["Drives::", "Safely."]


def test_the_catalogue_of_errors():
    """Title, cause and cure are read, examples are not."""
    source = '[BT-101]\ntitle = "File cannot be read"\nwrong = "$ run who looks on"\n'
    assert shadow_of_catalogue(source).split("\n") == ["", "File cannot be read", "", ""]


def test_golden_files():
    """Messages are read; commands, excerpts of files and bare values are not."""
    source = "$ bt-mission run m.yaml\nm.yaml: error: no such file\n    who looks on\n[2]\n"
    assert shadow_of_output(source) == "\nm.yaml: error: no such file.\n\n\n"


def test_docstrings_alone():
    """Messages are left out on request."""
    lines = shadow_of(SOURCE, only_docstrings=True).splitlines()
    assert lines[3] == "Drive at `speed`."
    assert "".join(lines[6:]) == ""


def test_private_docstrings_and_names_are_not_read():
    """What users never see may be short."""
    text = shadow_of(SOURCE)
    assert "private names" not in text
    assert "two words" not in text


@pytest.mark.thorough
@pytest.mark.process
@pytest.mark.skipif(shutil.which("npm") is None, reason="npm is not installed")
def test_a_page_in_the_old_voice_fails(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    """Each phrase is a finding, with its place and a replacement."""
    page = tmp_path / "page.md"
    page.write_text("# Page\n\nA page is told what has changed, and goes on.\n", encoding="utf-8")
    assert main([str(page), "--node", str(ROOT / "build" / "prose")]) == 1
    assert capsys.readouterr().out.splitlines() == [
        f'{page}:3:11: "told": send, report, name, show, distinguish',
        f'{page}:3:38: "goes on": continues, runs',
        "2 findings",
    ]


@pytest.mark.thorough
@pytest.mark.process
@pytest.mark.skipif(shutil.which("npm") is None, reason="npm is not installed")
def test_a_page_in_plain_words_passes(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    """The same facts as subject, verb and object."""
    page = tmp_path / "page.md"
    page.write_text("# Page\n\nThe server sends changes and continues.\n", encoding="utf-8")
    assert main([str(page), "--node", str(ROOT / "build" / "prose")]) == 0
    assert capsys.readouterr().out == "no findings\n"
