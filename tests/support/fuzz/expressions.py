"""Expressions for mutated missions: most of them sound, some hostile."""

from __future__ import annotations

from random import Random

HOSTILE = (
    *("1/0", "0 ** -1", "2 ** 64", "2 ** 2 ** 2 ** 2 ** 2", "-1 ** 0.5", "(-8) ** 0.5"),
    *("10 ** 308 * 10.0", "1e308 * 10", "1e999", "round(5, -1000000000)", "round(1.5, 400)"),
    *("round(2, 1e300)", "levy(1, 2)", "places[0]", "places[-1][legs]", "[1, 2][0]"),
    *("1 if legs > 2 else 'a'", "1 / 0 if false else legs", "1 if 2", "${legs:.2f}"),
    *("${speed:d} ${legs:+05d} ${speed:e}", "${legs:99.99f}", "${who:x}", "levy(2, 1)"),
    *("uniform(-1e308, 1e308)", "choice()", "choice(1, 'a')", "choice(1, 'a') + 1", "len(1)"),
    *("sqrt(-1)", "floor(1e300)", "clamp(1, 3, 2)", "sin", "x.y.z", "$", "$$", "${", "${1/0}"),
    *("$nobody", "${$nobody + }", "not not true", "1 < 2 < 3 == true", "'", "true + 1"),
    *("'a' < 'b'", "'a' == 1", "atan2(0, 0) / tan(0)", "9" * 400, "(" * 40 + "1" + ")" * 40),
    *("-" * 400 + "1", "not " * 200 + "true", "1" + " + 1" * 240, "1" + " + 1" * 20),
    *("2" + " ** 2" * 30, "abs(" * 31 + "1" + ")" * 31),
)
_NUMBERS = ("0", "1", "2", "3.5", "90", "0.1", "1e3", "pi", "2 ** 62", "1e-300", "1e300")
_FIELDS = (
    *("current_angle", "current_image", "data", "percentage", "closest_obstacle"),
    *("pose.pose.position.x", "feedback", "share"),
)
_ONE = ("abs", "ceil", "cos", "degrees", "floor", "radians", "round", "sign", "sin", "sqrt", "tan")
_TWO = ("atan2", "copysign", "hypot", "levy", "max", "min", "round", "uniform", "choice")


def expression(rng: Random, names: tuple[str, ...], depth: int = 0) -> str:
    """Return an expression; its names are mostly of these."""
    if rng.random() < 0.12:
        return rng.choice(HOSTILE)
    return _bool(rng, names, depth) if rng.random() < 0.4 else _number(rng, names, depth)


def _name(rng: Random, names: tuple[str, ...]) -> str:
    name = rng.choice(names) if names and rng.random() < 0.85 else rng.choice(_FIELDS)
    return f"${name}" if rng.random() < 0.5 else name


def _number(rng: Random, names: tuple[str, ...], depth: int) -> str:
    if depth > 3 or rng.random() < 0.3:
        return _name(rng, names) if rng.random() < 0.55 else rng.choice(_NUMBERS)
    parts = [_number(rng, names, depth + 1) for _ in range(3)]
    match rng.randrange(7):
        case 0 | 1 | 2:
            symbol = rng.choice(("+", "-", "*", "/", "//", "%", "**"))
            return f"({parts[0]} {symbol} {parts[1]})"
        case 3:
            return f"{rng.choice(_ONE)}({parts[0]})"
        case 4:
            return f"{rng.choice(_TWO)}({parts[0]}, {parts[1]})"
        case 5:
            return f"clamp({', '.join(parts)})"
    return f"-{parts[0]}"


def _bool(rng: Random, names: tuple[str, ...], depth: int) -> str:
    if depth > 3:
        return rng.choice(("true", "false", _name(rng, names)))
    match rng.randrange(5):
        case 0 | 1:
            symbol = rng.choice(("<", "<=", ">", ">=", "==", "!="))
            left, right = (_number(rng, names, depth + 1) for _ in range(2))
            return f"{left} {symbol} {right}"
        case 2 | 3:
            left, right = (_bool(rng, names, depth + 1) for _ in range(2))
            return f"({left} {rng.choice(('and', 'or'))} {right})"
    return f"not {_bool(rng, names, depth + 1)}"
