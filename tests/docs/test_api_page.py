"""The Python API: its page, and what the documentation imports."""

import ast
import importlib
import re
import textwrap

import pytest

from tests.support.project import ROOT

PAGES = sorted({ROOT / "README.md", *(ROOT / "docs").rglob("*.md")})
MODULES = [
    module
    for page in PAGES
    for module in re.findall(r"^\.\. automodule:: (\S+)$", page.read_text("utf-8"), re.MULTILINE)
]
"""Those of a command are on a page of it, the others on that of the API."""
SITE = ROOT / "docs" / "site"
CODE = sorted(path for path in (ROOT / "docs").rglob("*.py") if not path.is_relative_to(SITE))
BLOCK = re.compile(r"^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)
OURS = ("bt_mission", "action_servers", "sim")


@pytest.mark.parametrize("module", MODULES)
def test_every_public_name_is_described(module):
    """Each has a docstring of its own."""
    public = importlib.import_module(module)
    bare = [name for name in public.__all__ if not getattr(public, name).__doc__]
    assert bare == []


def test_the_page_names_the_public_packages():
    """The site takes their names and docstrings from the code."""
    assert {"bt_mission", "bt_mission.testing", "action_servers"} <= set(MODULES)


def imports(text: str) -> list[str]:
    """The names of ours that a piece of Python imports."""
    results = []
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            results += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            results += [f"{node.module}.{alias.name}" for alias in node.names]
    return [name for name in results if name.partition(".")[0] in OURS]


@pytest.mark.parametrize(
    "path", [*PAGES, *CODE], ids=lambda path: path.relative_to(ROOT).as_posix()
)
def test_the_documentation_imports_public_names_only(path):
    """Whatever a reader copies goes on working when modules move."""
    text = path.read_text(encoding="utf-8")
    blocks = [text] if path.suffix == ".py" else [textwrap.dedent(b) for b in BLOCK.findall(text)]
    deeper = []
    for name in (name for block in blocks for name in imports(block)):
        module, _, last = name.rpartition(".")
        is_public = name in MODULES or (
            module in MODULES and last in importlib.import_module(module).__all__
        )
        if not is_public:
            deeper.append(name)
    assert deeper == []
