"""Build the documentation site with Sphinx: the same Markdown as on GitHub, as pages.

The root of the repository is the source folder, so that a link leads to the same place here and
there: README.md is the first page, and docs/README.md, the list of all pages, gives the navigation.
`tools/build_site.py` calls Sphinx.
"""

from __future__ import annotations

import shutil
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from docutils import nodes
from pygments import highlight
from pygments.formatters import HtmlFormatter
from pygments.lexers import TextLexer, YamlLexer, get_lexer_for_filename
from sphinx import addnodes
from sphinx.application import Sphinx
from sphinx.search.en import SearchEnglish
from sphinx.transforms import SphinxTransform
from sphinx.util.osutil import relative_uri

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
sys.path.insert(0, str(ROOT))

from bt_mission.views.manual import INDEX, Manual, index_of  # noqa: E402 - of this checkout
from tools import site_search  # noqa: E402 - likewise

project = "bt-mission"
author = "the authors of bt-mission"
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
version = release = PROJECT["version"]

root_doc = "README"
include_patterns = ["README.md", "CONTRIBUTING.md", "CHANGELOG.md", "docs/**.md"]
exclude_patterns = [".*", "build", "runs", "found", "missions", "tests", "interfaces"]
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
autodoc_typehints_format = "short"
autodoc_member_order = "bysource"
python_maximum_signature_line_length = 88
myst_heading_anchors = 6
nitpicky = True
nitpick_ignore_regex = [("py:.*", ".*")]  # docstrings name what has no page, too
highlight_language = "text"  # of blocks that name none: what terminals show
show_warning_types = True

html_theme = "furo"
html_title = f"bt-mission {release}"
html_copy_source = html_show_sourcelink = False
html_static_path = ["static"]
html_css_files = ["site.css"]
html_js_files = ["versions.js"]
templates_path = ["templates"]
pygments_style, pygments_dark_style = "friendly", "github-dark"

KNOWN_AS = {".ipynb": ".json"}
"""Endings for which Pygments has a lexer, by those for which it has none."""

# Tests know by these names what an example is.
LEXERS = {
    "faults": TextLexer,
    "requirements": TextLexer,
    "yaml-faults": YamlLexer,
    "yaml-file": YamlLexer,
    "yaml-requirement": YamlLexer,
    "yaml-scenario": YamlLexer,
}

shown_files: dict[str, Path] = {}
"""Files of the repository that a page links to, by the name of the page that shows each."""


def navigation(index: str) -> Iterator[str]:
    """Yield the navigation as hidden toctrees: a section of docs/README.md each, in its order."""
    yield from ("", "```{toctree}", ":hidden:", "All pages <docs/README>", "```")
    for heading, pages in index_of(index).items():
        caption = heading.partition(":")[0]
        entries = (f"{page.title} <docs/{page.path}>" for page in pages)
        yield from ("", "```{toctree}", ":hidden:", f":caption: {caption}", *entries, "```")
    project_pages = ("Contributing <CONTRIBUTING>", "Changelog <CHANGELOG>")
    yield from ("", "```{toctree}", ":hidden:", ":caption: Project", *project_pages, "```", "")


def add_navigation(app: Sphinx, docname: str, source: list[str]) -> None:
    """Give the first page the navigation, which Markdown has no words for."""
    if docname == root_doc:
        index = (Path(app.srcdir) / "docs" / "README.md").read_text("utf-8")
        source[0] += "\n".join(navigation(index))


def add_commands(_app: Sphinx, docname: str, source: list[str]) -> None:
    """Give the page of commands the help of each."""
    if docname == "docs/reference/commands":
        from tools.command_reference import command_reference  # noqa: PLC0415 - of this page alone

        source[0] += command_reference()


class SearchLanguage(SearchEnglish):
    """English, with the words of names in code."""

    def split(self, text: str) -> list[str]:
        """Return the words of a text that a search finds."""
        return site_search.split(text)


def rank_results(app: Sphinx) -> None:
    """Have the site's search rank pages as `bt-mission docs` does."""
    scorer = Path(app.doctreedir) / "scorer.js"
    data = site_search.data(Manual(Path(app.srcdir) / "docs"), SearchLanguage({}).stem)
    scorer.write_text(data + (HERE / "scorer.js").read_text("utf-8"), encoding="utf-8")
    app.config.html_search_scorer = str(scorer)


def add_keywords(app: Sphinx, document: nodes.document) -> None:
    """Give a page the words of its line in the index, which a search then finds."""
    index = index_of((Path(app.srcdir) / "docs" / INDEX).read_text("utf-8"))
    for page in (page for pages in index.values() for page in pages):
        if f"docs/{page.path}" == app.env.docname:
            words = site_search.split(f"{page.path} {page.title} {page.about}")
            keywords = ", ".join(words)
            document.insert(0, nodes.meta(name="keywords", content=keywords))


class FileLinks(SphinxTransform):
    """Links to files that are no page, such as missions, lead to a page that shows the file."""

    default_priority = 500

    def apply(self, **_kwargs: Any) -> None:
        """Replace the links of one page."""
        here = self.env.docname
        for node in list(self.document.findall(addnodes.download_reference)):
            name, path = self.env.relfn2path(node["reftarget"], here)
            page = f"files/{name}"
            shown_files[page] = Path(path)
            uri = relative_uri(f"{here}.html", f"{page}.html")
            node.replace_self(nodes.reference("", "", *node.children, refuri=uri, internal=True))


def show_files(_app: Sphinx) -> Iterator[tuple[str, dict[str, Any], str]]:
    """Yield a page for each file that is linked to."""
    for page, path in shown_files.items():
        name = page.removeprefix("files/")
        text = path.read_text("utf-8")
        known = path.with_suffix(KNOWN_AS.get(path.suffix, path.suffix))
        code = highlight(text, get_lexer_for_filename(known.name), HtmlFormatter())
        body = f"<h1>{path.name}</h1><p>The file <code>{name}</code> of the repository.</p>{code}"
        yield page, {"title": name, "body": body}, "page.html"


def make_index(app: Sphinx, exception: Exception | None) -> None:
    """Let the folder of the site open with its first page."""
    if exception is None:
        shutil.copyfile(Path(app.outdir) / f"{root_doc}.html", Path(app.outdir) / "index.html")


def setup(app: Sphinx) -> None:
    """Connect what is above to Sphinx."""
    for name, lexer in LEXERS.items():
        app.add_lexer(name, lexer)
    app.add_transform(FileLinks)
    app.add_search_language(SearchLanguage)
    app.connect("source-read", add_navigation)
    app.connect("source-read", add_commands)
    app.connect("doctree-read", add_keywords)
    app.connect("builder-inited", rank_results)
    app.connect("html-collect-pages", show_files)
    app.connect("build-finished", make_index)
