"""The documentation site: the Markdown of the repository as pages, built by tools/build_site.py."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.project import ROOT
from tests.support.report_pages import text_of
from tools import build_site

FIRST = "# Robot\n\nWhat it is.\n\n- [all](docs/README.md)\n- [how](CONTRIBUTING.md#set-up)\n"
INDEX = (
    "# Pages\n\nAll of them.\n\n## Tutorials: learn\n\n| | |\n|---|---|\n| [One](one.md) | a |\n"
)
ONE = "# One\n\nIt has [a mission](../missions/a.yaml).\n\n```yaml-scenario\nmission: a\n```\n"


def built(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    """What the command comes to, as a process."""
    command = [sys.executable, str(ROOT / "tools" / "build_site.py"), *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.mark.process
@pytest.mark.parametrize("reference", ["nosuch", "--output=taken", "HEAD~999999", "..", ""])
def test_a_reference_that_git_does_not_know_is_told_before_anything_is_built(tmp_path, reference):
    """And the site that is there stays; none is taken for an option of git."""
    (tmp_path / "versions.json").write_text('["1"]')
    done = built("-o", tmp_path, "--", reference)
    assert done.returncode == 2
    assert f"git knows no {reference!r}: expected tags, branches or commits" in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["versions.json"]


@pytest.mark.process
def test_a_folder_with_something_else_than_a_site_is_kept(tmp_path):
    """It would be deleted with all that is in it: -o docs, or -o ~."""
    (tmp_path / "mine.txt").touch()
    for output in (tmp_path, tmp_path / "mine.txt"):
        done = built("-o", output)
        assert done.returncode == 2
        assert f"{output} is no folder with a site: remove it, or give another" in done.stderr
    assert (tmp_path / "mine.txt").exists()


@pytest.fixture
def source(tmp_path):
    """A small repository with every kind of page."""
    files = {
        "pyproject.toml": '[project]\nversion = "1.2.3"\n',
        "README.md": FIRST,
        "CONTRIBUTING.md": "# Contributing\n\nHow.\n\n## Set-up\n\nSo.\n",
        "CHANGELOG.md": "# Changelog\n\nWhat changed.\n",
        "docs/README.md": INDEX,
        "docs/one.md": ONE,
        "missions/a.yaml": "mission: a\n",
    }
    folder = tmp_path / "source"
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")
    return folder


@pytest.mark.thorough
def test_a_site_is_pages_navigation_files_and_search(source, tmp_path):
    """README.md opens the site; the list of pages gives the navigation; a file is shown."""
    site = tmp_path / "site" / "1.2.3"
    build_site.build(source, site, is_strict=True)
    first = (site / "index.html").read_text("utf-8")
    assert first == (site / "README.html").read_text("utf-8")
    assert re.findall(r'class="caption-text">(\w+)<', first) == ["Tutorials", "Project"]
    assert '<a class="reference internal" href="docs/one.html">One</a>' in first
    assert 'href="CONTRIBUTING.html#set-up"' in first
    assert "bt-mission 1.2.3" in text_of(site / "docs" / "one.html")
    assert 'href="../files/missions/a.yaml.html"' in (site / "docs" / "one.html").read_text("utf-8")
    assert "mission: a" in text_of(site / "files" / "missions" / "a.yaml.html")
    assert "docs/one" in (site / "searchindex.js").read_text("utf-8")


@pytest.mark.thorough
def test_what_leads_nowhere_fails_the_build(source, tmp_path, capfd):
    """A link to a page, heading, file or picture that is not there; a page without a way to it."""
    lost = "[a](two.md) [b](../README.md#gone) [c](../missions/b.yaml) ![d](gone.png)"
    (source / "docs" / "one.md").write_text(f"# One\n\n{lost}\n", encoding="utf-8")
    (source / "docs" / "orphan.md").write_text("# Orphan\n\nNobody leads here.\n", encoding="utf-8")
    with pytest.raises(subprocess.CalledProcessError):
        build_site.build(source, tmp_path / "site" / "x", is_strict=True)
    output = capfd.readouterr().err
    for warning in (
        "docs/one.md:3: WARNING: 'myst' cross-reference target not found: 'two.md'",
        "docs/one.md:3: WARNING: local id not found in doc 'README': 'gone'",
        "docs/one.md:3: WARNING: 'myst' cross-reference target not found: '../missions/b.yaml'",
        "docs/one.md:3: WARNING: image file not readable: docs/gone.png",
        "docs/orphan.md: WARNING: document isn't included in any toctree",
    ):
        assert warning in output


def test_every_page_is_in_the_navigation():
    """The sections of docs/README.md, from which it is made, are the four kinds of pages."""
    command = (
        "import runpy, sys, json; site = runpy.run_path(sys.argv[1]);"
        "print(json.dumps(list(site['navigation'](open(sys.argv[2]).read()))))"
    )
    paths = (str(ROOT / "docs" / "site" / "conf.py"), str(ROOT / "docs" / "README.md"))
    out = subprocess.run([sys.executable, "-c", command, *paths], check=True, capture_output=True)
    lines = json.loads(out.stdout)
    captions = [line.removeprefix(":caption: ") for line in lines if line.startswith(":caption")]
    assert captions == ["Tutorials", "How-to guides", "Reference", "Explanation", "Project"]
    named = {line.partition("<")[2].rstrip(">") + ".md" for line in lines if line.endswith(">")}
    pages = {page.relative_to(ROOT).as_posix() for page in (ROOT / "docs").rglob("*.md")}
    assert named == pages | {"CONTRIBUTING.md", "CHANGELOG.md"}


@pytest.mark.thorough
def test_a_version_is_a_folder(source, tmp_path, monkeypatch, capsys):
    """The working tree and each reference have a folder, and versions.json names them."""

    def git(*arguments: str) -> None:
        identity = ("-c", "user.name=a", "-c", "user.email=a@b.c", "-C", str(source))
        subprocess.run(
            ["/usr/bin/env", "git", *identity, *arguments], check=True, capture_output=True
        )

    git("init")
    git("add", ".")
    git("commit", "--message=first")
    git("tag", "v1.0")
    (source / "README.md").write_text(FIRST.replace("# Robot", "# Robots"), encoding="utf-8")
    monkeypatch.setattr(build_site, "ROOT", source)
    monkeypatch.setattr(sys, "argv", ["build_site.py", "v1.0", "--output", str(tmp_path / "site")])
    assert build_site.main() == 0
    assert capsys.readouterr().out == f"{tmp_path / 'site' / 'index.html'}\n"
    assert json.loads((tmp_path / "site" / "versions.json").read_text()) == ["1.2.3", "v1.0"]
    for name, title in {"1.2.3": "Robots", "v1.0": "Robot"}.items():
        page = (tmp_path / "site" / name / "index.html").read_text("utf-8")
        assert f"bt-mission {name}" in page
        assert f"<h1>{title}<" in page
