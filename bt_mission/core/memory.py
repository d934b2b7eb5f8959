"""How often Python looks for garbage: seldom while a command loads, and never in what it loaded."""

from __future__ import annotations

import gc

WHILE_LOADING = 50_000
"""New objects after which to look, instead of Python's 700: what is imported is no garbage."""

_USUAL = gc.get_threshold()


def spare_collections() -> None:
    """Look seldom, until :func:`settle_memory` is called. For a process that is all ours."""
    gc.set_threshold(WHILE_LOADING)


def settle_memory() -> None:
    """Take what is there by now for permanent, and look as often as usual from now on.

    To look through all of it takes a tenth of a second each time. Call it when all is set up. In a
    process of others, where collections were not spared, it does nothing.
    """
    if gc.get_threshold()[0] == WHILE_LOADING:
        gc.freeze()
        gc.set_threshold(*_USUAL)
