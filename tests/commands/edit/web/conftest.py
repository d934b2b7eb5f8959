"""An editor of a folder, which needs the extra ``web``."""

from __future__ import annotations

from importlib.util import find_spec

from tests.views.web.conftest import NEEDED

collect_ignore_glob = [] if all(find_spec(name) for name in NEEDED) else ["test_*.py"]
