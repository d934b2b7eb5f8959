"""The grammar of requirements: expressions over signals, and the words of temporal logic.

whole     = ("may" "not" "apply" ":")? formula
formula   = joint ("implies" formula)?
joint     = either ("until" either within? | "since" either (within sofar?)?)?
either    as in expressions, down to an atom, which can also be
temporal  = word (window sofar?)? ":"? formula   as far to the right as it goes
whenever  = "whenever" formula (":" | "then") formula within?
edge      = ("starts" | "ends") "(" formula ")"
measure   = "count" "(" edge ")" (within sofar?)? | "mean" "(" formula ")" "over" time sofar?
          | "rate" "(" formula ")" | "value" "(" formula ")" "at" "last" edge
outcome   = "outcome" "(" text ")" ("=" | "==" | "!=") (name | text)
signal    = name | name "(" text ("," text)* ")"
word      = "always" | "never" | "eventually" | "previously" | "historically"
window    = within | "for" time | "between" time "and" time
within    = "within" time
sofar     = "so" "far"                           of windows that look back
time      = number ("s" | "ms" | "min")?
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

from typing_extensions import override

from bt_mission.base.diagnostics import did_you_mean, listed, quoted
from bt_mission.base.stamps import MOST_SECONDS
from bt_mission.base.units import COMPUTED, SECONDS, in_base
from bt_mission.language.expressions.functions import FUNCTIONS
from bt_mission.language.expressions.parser import ExpressionParser, Token, tokenized
from bt_mission.language.expressions.syntax import Name, Not, SyntaxNode
from bt_mission.language.expressions.values import ExpressionError
from bt_mission.requirements.language.signals import OUTCOME, OUTCOMES, SIGNALS
from bt_mission.requirements.language.syntax import (
    EDGES,
    EVERYTHING,
    Implies,
    Measure,
    SignalValue,
    Temporal,
    TimeWindow,
)

WORDS = ("always", "never", "eventually", "previously", "historically")
MEASURES = ("count", "mean", "rate", "value")
LOOKING_BACK = frozenset(("previously", "historically", "since", "count", "mean"))
JOINING = frozenset(
    ("until", "since", "implies", "within", "then", "for", "between", "so", "over", "at")
)
INSTEAD = {
    "globally": "always",
    "finally": "eventually",
    "once": "previously",
    "if": "whenever",
    "when": "whenever",
    "while": "whenever",
    "sometime": "eventually",
    "begins": "starts",
    "rises": "starts",
    "falls": "ends",
    "average": "mean",
    "derivative": "rate",
}
TIMES = tuple(name for name, unit in COMPUTED.items() if unit == SECONDS)


@lru_cache(maxsize=1024)
def parse_requirement(text: str) -> SyntaxNode:
    """Return a requirement's parts. Raises ExpressionError, with the column."""
    parser = RequirementParser(tokenized(text, symbols=":="))
    parser.may_not_apply()
    node = parser.either()
    parser.end()
    return node


@dataclass
class RequirementParser(ExpressionParser):
    """Reads what stands around and inside expressions."""

    takes_equals: bool = False
    """Is this the place for a single '='?"""

    def may_not_apply(self) -> None:
        """Take `may not apply:`, if the formula begins with it."""
        if self.takes("may"):
            for word in ("not", "apply", ":"):
                self.expect(word, "the formula: may not apply: whenever ...")

    def text_of(self, first: int, after: int) -> str:
        """Return the text of the tokens from one on, up to another."""
        text, end = "", 0
        for token in self.tokens[first:after]:
            text += " " * (bool(text) and token.column > end) + token.text
            end = token.end
        return text

    @override
    def either(self) -> SyntaxNode:
        first = self.at
        node = super().either()
        if token := self.takes("until", "since"):
            self.deeper()
            right = super().either()
            window = self.so_far(token, self.within() or EVERYTHING)
            node = Temporal(token.column, token.text, (node, right), window)
            self.depth -= 1
        after = self.at
        if self.takes("implies"):
            self.deeper()
            node = Implies.of(node, self.either(), self.text_of(first, after))
            self.depth -= 1
        return node

    @override
    def atom(self) -> SyntaxNode:
        token = self.next
        if token.kind == "name" and token.text in WORDS:
            return self.temporal()
        if token.kind == "name" and token.text == "whenever":
            return self.whenever()
        if token.kind == "name" and token.text in JOINING:
            message = f"expected a signal or a number, got {quoted(token.text)}"
            raise ExpressionError("BT-601", message, token.column)
        return super().atom()

    def temporal(self) -> SyntaxNode:
        """Take a word of temporal logic with its window and what it speaks of."""
        token = self.take()
        window = self.so_far(token, self.window(token))
        self.takes(":")
        operand = self.either()
        if token.text == "never":
            return Temporal(token.column, "always", (Not(operand.column, operand),), window)
        return Temporal(token.column, token.text, (operand,), window)

    def whenever(self) -> SyntaxNode:
        """Take a trigger and what must follow it within a window.

        Without a window it must hold at the same instant.
        """
        token = self.take()
        first = self.at
        trigger = self.either()
        premise = self.text_of(first, self.at)
        if not self.takes(":", "then"):
            message = f"expected ':' or 'then' after 'whenever ...', got {self.got}"
            raise ExpressionError("BT-601", message, self.next.column)
        then, window = self.either(), self.within()
        if window is not None:
            then = Temporal(then.column, "eventually", (then,), window)
        return Temporal(token.column, "always", (Implies.of(trigger, then, premise),))

    @property
    def got(self) -> str:
        """The next token, for an error."""
        return quoted(self.next.text) if self.next.text else "the end"

    @override
    def take(self) -> Token:
        token = super().take()
        if token.text == "=" and not self.takes_equals:
            raise ExpressionError("BT-601", "unexpected token '='", token.column, "write '=='")
        return token

    @override
    def close(self, opened: Token, closing: str = ")") -> None:
        if self.next.text == "=":
            self.take()
        super().close(opened, closing)

    @override
    def end(self) -> None:
        token = self.next
        if token.text == "=":
            self.take()
        if token.kind != "end" and token.text == ":":
            raise ExpressionError(
                "BT-601", "unexpected ':'", token.column, "write it after 'whenever ...'"
            )
        super().end()

    # ---- time ----------------------------------------------------------------------------

    def window(self, word: Token) -> TimeWindow:
        """Take the window of a word, if it has one."""
        some = word.text in ("eventually", "previously")
        if token := self.takes("between"):
            start = self.time()
            if not self.takes("and"):
                raise ExpressionError(
                    "BT-605", "expected 'and' and a second time", self.next.column
                )
            end = self.time()
            if not start < end:
                raise ExpressionError("BT-605", "the window ends before it begins", token.column)
            return TimeWindow(start, end)
        token = self.takes("within", "for")
        if token is None:
            return EVERYTHING
        if (token.text == "within") is not some:
            right = "within" if some else "for"
            message = f"expected '{word.text} {right} ...', got '{word.text} {token.text}'"
            raise ExpressionError("BT-605", message, token.column)
        return TimeWindow(0.0, self.time())

    def within(self) -> TimeWindow | None:
        """Take `within 5 s`, if it stands here."""
        return TimeWindow(0.0, self.time()) if self.takes("within") else None

    def so_far(self, word: Token, window: TimeWindow) -> TimeWindow:
        """Take `so far` behind the window of a word that looks back, if it stands here."""
        token = self.takes("so")
        if token is None:
            return window
        if not self.takes("far"):
            raise ExpressionError(
                "BT-605", f"expected 'far' after 'so', got {self.got}", self.next.column
            )
        if word.text not in LOOKING_BACK or not window.is_bounded:
            message = "'so far' is allowed only after a window that looks back"
            hint = "such as 'historically for 5 s so far'"
            raise ExpressionError("BT-605", message, token.column, hint)
        return replace(window, so_far=True)

    def time(self) -> float:
        """Take a time, s."""
        column = self.next.column
        time_s = self._time()
        if time_s > MOST_SECONDS:
            message = f"expected a time of at most {MOST_SECONDS:,} s, got {time_s:g} s"
            raise ExpressionError("BT-605", message, column)
        return time_s

    def _time(self) -> float:
        token = self.take()
        if token.kind != "number":
            got = quoted(token.text) if token.text else "the end"
            raise ExpressionError(
                "BT-605", f"expected a time such as '0.5 s', got {got}", token.column
            )
        if self.next.kind != "name" or self.next.text not in COMPUTED:
            return float(token.text)
        unit = self.take()
        if unit.text not in TIMES:
            message = f"expected a time ({', '.join(TIMES)}), got {quoted(unit.text)}"
            raise ExpressionError("BT-605", message, unit.column)
        return in_base(float(token.text), unit.text)

    # ---- signals -------------------------------------------------------------------------

    @override
    def name(self, node: Name) -> SyntaxNode:
        if node.variable:
            return SignalValue(node.column, "$", (node.name,))
        signal = SIGNALS.get(node.name)
        if signal is None and self.tokens[max(self.at - 2, 0)].text in ("==", "!="):
            message = f"unknown signal {quoted(node.name)}"
            raise ExpressionError(
                "BT-602", message, node.column, f"put the text in quotes: '{node.name}'"
            )
        if signal is None:
            raise _unknown(node.name, node.column)
        if signal.arguments:
            message = f"expected {_usage(node.name)}, got only '{node.name}'"
            raise ExpressionError("BT-602", message, node.column)
        return SignalValue(node.column, node.name)

    @override
    def call(self, token: Token) -> SyntaxNode:
        if token.text in EDGES or token.text in MEASURES:
            return self.edge(token) if token.text in EDGES else self.measure(token)
        if token.text in FUNCTIONS:
            read_signal = super().call(token)
            if self.draws:
                raise ExpressionError(
                    "BT-604", "a requirement cannot draw random numbers", token.column
                )
            return read_signal
        signal = SIGNALS.get(token.text)
        if signal is None:
            raise _unknown(token.text, token.column)
        arguments = self.names_in(token)
        if len(arguments) != len(signal.arguments):
            message = f"expected {_usage(token.text)}, got {len(arguments)} arguments"
            raise ExpressionError("BT-602", message, token.column)
        if token.text == OUTCOME:
            return self.outcome(token, arguments[0])
        return SignalValue(token.column, token.text, tuple(arguments))

    def names_in(self, token: Token) -> list[str]:
        """Take the names between the parentheses of a signal."""
        arguments = []
        while not self.takes(")"):
            argument = self.take()
            if argument.kind != "text":
                got = quoted(argument.text) if argument.text else "the end"
                message = f"expected {_usage(token.text)}, got {got}"
                name = argument.text if argument.kind == "name" else "scan"
                raise ExpressionError("BT-601", message, argument.column, f"quote names: '{name}'")
            arguments.append(argument.text[1:-1])
            if self.next.text != ")" and not self.takes(","):
                raise ExpressionError("BT-601", "expected ',' or ')'", self.next.column)
        return arguments

    def outcome(self, token: Token, node: str) -> SyntaxNode:
        """Take what the outcome of a node's goal is compared with."""
        self.takes_equals = True
        symbol, named = self.takes("=", "==", "!="), self.take()
        self.takes_equals = False
        name = named.text.strip("'\"")
        if symbol is None or named.kind not in ("name", "text"):
            message = f"expected {_usage(OUTCOME)} = and an outcome, such as 'canceled'"
            raise ExpressionError("BT-602", message, token.column)
        if name not in OUTCOMES:
            message = f"unknown outcome {quoted(name)} (known: {listed(OUTCOMES)})"
            raise ExpressionError("BT-303", message, named.column, did_you_mean(name, OUTCOMES))
        outcome = SignalValue(token.column, OUTCOME, (node, name))
        return Not(token.column, outcome) if symbol.text == "!=" else outcome

    # ---- what was so far -----------------------------------------------------------------

    def edge(self, token: Token) -> Temporal:
        """Take the condition of `starts` or `ends`."""
        return Temporal(token.column, token.text, (self.enclosed(),))

    def measure(self, token: Token) -> Measure:
        """Take what is measured, and over which time."""
        inner: SyntaxNode | None = self.enclosed()
        edge, window = None, EVERYTHING
        match token.text:
            case "count":
                edge, inner = _expect_edge(inner, "count(...)", token.column), None
                window = self.so_far(token, self.within() or EVERYTHING)
            case "mean":
                self.expect("over", "a time: mean(speed) over 10 s")
                window = self.so_far(token, TimeWindow(0.0, self.time()))
            case "value":
                self.expect("at", "an edge: value(yaw) at last starts(...)")
                self.expect("last", "an edge: value(yaw) at last starts(...)")
                edge = _expect_edge(self.atom(), "'at last'", token.column)
        return Measure(token.column, token.text, inner, edge, window)

    def enclosed(self) -> SyntaxNode:
        """Take a formula up to the parenthesis that closes it."""
        opened = self.tokens[self.at - 1]
        inner = self.either()
        self.close(opened)
        return inner

    def expect(self, word: str, what: str) -> None:
        """Take a word."""
        if not self.takes(word):
            message = f"expected '{word}' and {what}, got {self.got}"
            raise ExpressionError("BT-601", message, self.next.column)


def _expect_edge(node: SyntaxNode | None, where: str, column: int) -> Temporal:
    if isinstance(node, Temporal) and node.word in EDGES:
        return node
    message = f"expected starts(...) or ends(...) in {where}"
    raise ExpressionError("BT-604", message, node.column if node is not None else column)


def _usage(name: str) -> str:
    arguments = ", ".join(f'"{argument}"' for argument in SIGNALS[name].arguments)
    return f"{name}({arguments})" if arguments else f"'{name}' without parentheses"


def _unknown(name: str, column: int) -> ExpressionError:
    if name in INSTEAD:
        return ExpressionError(
            "BT-602", f"unknown word {quoted(name)}", column, f"write '{INSTEAD[name]}'"
        )
    words = (*SIGNALS, *WORDS, *EDGES, *MEASURES, "whenever")
    hint = did_you_mean(name, words)
    message = f"unknown signal {quoted(name)} (known: {listed(SIGNALS)})"
    return ExpressionError("BT-602", message, column, hint)
