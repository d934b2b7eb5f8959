"""Loops of users that wait for nothing: each round of a ``while`` is noted.

``while self.scan is None: continue`` ends on a robot, where another thread receives the scan. On a
virtual clock no time passes in code, and nothing else runs. So the files of users are compiled with
a call at the begin of each round, by which programs take time.
"""

from __future__ import annotations

import ast
import sys
from importlib.machinery import SourceFileLoader
from types import CodeType, ModuleType
from typing import Any

from typing_extensions import override

NAME = "__bt_mission_loops__"
"""The name of this module in those that it compiles."""


def take_round() -> None:
    """Note a round of a loop; `bt_mission.programs` replaces this."""


class LoopLoader(SourceFileLoader):
    """Compiles a file whose loops are noted. Nothing is cached: Python compiles it otherwise."""

    @override
    def get_code(self, fullname: str) -> CodeType:
        path = self.get_filename(fullname)
        tree = _Rounds().visit(self.changed(ast.parse(self.get_data(path), path)))
        code: CodeType = compile(tree, path, "exec", dont_inherit=True)
        return code

    @override
    def exec_module(self, module: ModuleType) -> None:
        vars(module)[NAME] = sys.modules[__name__]
        super().exec_module(module)

    def changed(self, tree: ast.Module) -> ast.Module:
        """Return the code with what else is different."""
        return tree


class _Rounds(ast.NodeTransformer):
    """Puts a call of :func:`take_round` before the first statement of each ``while``."""

    def visit_While(self, node: ast.While) -> Any:
        """Change it, and those in it."""
        self.generic_visit(node)
        noted = ast.parse(f"{NAME}.{take_round.__name__}()").body[0]
        for part in ast.walk(noted):
            ast.copy_location(part, node.test)
        node.body.insert(0, noted)
        return node
