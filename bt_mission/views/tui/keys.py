"""The keys of the full-screen views: their actions, and the text of their help."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Key:
    """A key, or several with the same action.

    Args:
        keys: Names as in Textual, with commas between.
        action: The method of the application, without ``action_``.
        shown: Their name in the help.
        help: Their action; empty for keys that the help omits.
    """

    keys: str
    action: str
    shown: str
    help: str


REQUESTS = (
    Key("p", "send('PAUSE')", "p", "pause; running goals are canceled, and sent again on resume"),
    Key(
        "P", "send('PAUSE_KEEPING_GOALS')", "P", "pause; running goals continue within their limits"
    ),
    Key("r", "send('RESUME')", "r", "resume"),
    Key("s", "send('STEP')", "s", "step: one tick of a paused mission"),
    Key("x", "stop", "x x", "stop the mission; its goals are canceled"),
    Key("b", "breakpoint", "b", "set or clear a breakpoint: pause before the node starts"),
)
"""Requests to a running mission."""

PLAYING = (
    Key("p", "play", "p", "play or pause; at the end, play from the start"),
    Key("r", "reverse", "r", "reverse the direction"),
    Key("plus,equals_sign", "speed(2)", "+ -", "faster, slower"),
    Key("minus", "speed(0.5)", "", ""),
    Key("s", "step(1)", "s S", "next, previous change of a status"),
    Key("S", "step(-1)", "", ""),
    Key("b", "start(1)", "b B", "next, previous start of the selected node"),
    Key("B", "start(-1)", "", ""),
    Key("greater_than_sign", "skip(10)", "> <", "ten seconds forward, back"),
    Key("less_than_sign", "skip(-10)", "", ""),
    Key("g", "go(0)", "g G", "start, end"),
    Key("G", "go(1)", "", ""),
    Key("t", "time", "t", "go to a time, in seconds"),
    Key("F", "fork", "F", "fork: run again up to here, then with a change"),
)
"""Moving in a recording."""

LOOKING = (
    Key("up,k", "move(-1)", "up down", "select a node; also k and j"),
    Key("down,j", "move(1)", "", ""),
    Key("pageup", "page(-1)", "PgUp PgDn", "one page up, down"),
    Key("pagedown", "page(1)", "", ""),
    Key("home", "move(-1000000)", "Home End", "first, last node"),
    Key("end", "move(1000000)", "", ""),
    Key("left,h", "tree('fold')", "left right", "fold, unfold; also h and l"),
    Key("right,l", "tree('unfold')", "", ""),
    Key("enter,space", "tree('toggle')", "Enter", "fold or unfold"),
    Key("asterisk", "tree('fold_all')", "*", "fold or unfold everything"),
    Key("slash", "search", "/", "search names, classes and text"),
    Key("n", "again(1)", "n N", "next, previous match"),
    Key("N", "again(-1)", "", ""),
    Key("f", "tree('follow')", "f", "follow the running node"),
    Key("tab", "next_panel(1)", "Tab", "next panel; Shift+Tab: previous panel"),
    Key("shift+tab", "next_panel(-1)", "", ""),
    Key("z", "enlarge", "z", "maximize or restore the panel"),
)
"""Selecting what is shown."""

CHOOSING = (Key("c", "choose", "c", "choose another executive"),)
LEAVING = (
    Key("question_mark,f1", "help", "?", "this help"),
    Key("q,ctrl+c,ctrl+q", "leave", "q", "leave"),
)

KEYS = (*REQUESTS, *LOOKING, *CHOOSING, *LEAVING)
"""Keys of a running mission."""

REPLAY_KEYS = (*PLAYING, *LOOKING, *LEAVING)
"""Keys of a recording."""
