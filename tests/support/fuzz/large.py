"""Missions that are large in one way or another: what grows faster than its file."""

from __future__ import annotations

from collections.abc import Callable
from random import Random

from tests.support.fuzz.expressions import expression

HEAD = "mission: large\ninputs: {a: 1, b: [1, 2], c: text}\n"


def large(rng: Random) -> str:
    """Return a file of up to a megabyte."""
    return rng.choice(SHAPES)(rng, rng.choice((10, 100, 1_000, 10_000)))


def _wide(rng: Random, count: int) -> str:
    node = rng.choice(
        (
            "{log: at $a}",
            "{turn: {angle: a * 2}, timeout: 9, outputs: {angle_turned: x}}",
            f"{{check: '{expression(rng, ('a', 'b'))}'}}".replace("''", "'"),
            "{nobody: 1}",
            "{log: $nobody}",
            "{wait: {}}",
            "{}",
        )
    )
    kind = rng.choice(("sequence", "fallback", "parallel", "choose"))
    return f"{HEAD}tree:\n  {kind}:\n" + f"    - {node}\n" * min(count, 20_000)


def _deep(rng: Random, count: int) -> str:
    opening, closing = rng.choice((("{invert: ", "}"), ("{sequence: [", "]}"), ("[", "]")))
    depth = rng.choice((60, 95, 99, 190, 198, count))
    return f"{HEAD}tree: {opening * depth}{{wait: 1}}{closing * depth}\n"


def _chain(rng: Random, count: int) -> str:
    """Return trees that each use the next."""
    count = min(count, 5_000)
    depth = rng.choice((1, 1, 5, 30))
    use = "{{invert: " * depth + "{{tree: t{0}}}" + "}}" * depth
    trees = "".join(f"  t{i}: {{do: {use.format(i + 1)}}}\n" for i in range(count))
    return f"{HEAD}trees:\n{trees}  t{count}: {{do: {{wait: 1}}}}\ntree: {{tree: t0}}\n"


def _doubling(rng: Random, _count: int) -> str:
    """Return trees that each use the next several times."""
    depth, width = rng.randint(2, 24), rng.randint(2, 9)
    trees = "".join(
        f"  t{i}: {{do: {{sequence: [{', '.join([f'{{tree: t{i + 1}}}'] * width)}]}}}}\n"
        for i in range(depth)
    )
    return f"{HEAD}trees:\n{trees}  t{depth}: {{do: {{wait: 1}}}}\ntree: {{tree: t0}}\n"


def _long_text(rng: Random, count: int) -> str:
    """Return a long text that many nodes share."""
    piece = rng.choice(
        ("$a", "${a + 1}", "$$", "x", "a + ", "(", "-", "not ", "1 + a * ", "'", "${")
    )
    text = piece * rng.choice((10, 100, count, 5 * count))
    key = rng.choice(("log: ", "check: ", "wait: ", "find_colour: {colour: ", "turn: {angle: "))
    end = "}" if key.endswith(": ") and "{" in key else ""
    nodes = f"    - {{{key}*t{end}}}\n" * min(rng.choice((1, 10, count)), 20_000)
    return f'{HEAD}description: &t "{text[:400_000]}"\ntree:\n  sequence:\n{nodes}'


def _aliases(rng: Random, count: int) -> str:
    """Return aliases of aliases."""
    width = rng.choice((2, 5, 10))
    levels = rng.randint(2, 16)
    rows = ["  - &a0 {wait: 1}"]
    rows += [
        f"  - &a{i + 1} {{sequence: [{', '.join([f'*a{i}'] * width)}]}}" for i in range(levels)
    ]
    inputs = "".join(f"  i{i}: {i}\n" for i in range(min(count, 3)))
    return f"mission: m\ninputs:\n  a: 1\n{inputs}tree:\n  sequence:\n" + "\n".join(rows) + "\n"


def _inputs(rng: Random, count: int) -> str:
    value = rng.choice(("1", "text", "[1, 2]", "[[[[[[1]]]]]]", "true"))
    inputs = "".join(f"  i{i}: {value}\n" for i in range(count))
    node = rng.choice(("{log: $i0}", "{log: $i}", "{check: i0 == i1}", "{set: {i0: 1}}"))
    nodes = f"    - {node}\n" * rng.choice((1, 10, count))
    return f"mission: m\ninputs:\n{inputs}tree:\n  sequence:\n{nodes}"


def _outputs(rng: Random, count: int) -> str:
    """Return many variables, each read by everybody behind it."""
    count = min(count, 5_000)
    reads = rng.choice(("1", "a", "x0", "x{0}"))
    nodes = "".join(f"    - set: {{x{i + 1}: {reads.format(i)}}}\n" for i in range(count))
    return f"{HEAD}tree:\n  sequence:\n    - set: {{x0: 1}}\n{nodes}"


def _names(rng: Random, count: int) -> str:
    name = rng.choice(("a" * count, "é" * count, "n"))
    children = f"    - {{wait: 1, name: {name}}}\n" * rng.choice((1, 3, 100))
    return f"{HEAD}tree:\n  parallel:\n{children}  succeed_when: [{', '.join([name] * 3)}]\n"


def _keys(rng: Random, count: int) -> str:
    """Return mappings with many keys: a goal, a node, a head."""
    pairs = ", ".join(f"k{i}: 1" for i in range(count))
    return rng.choice(
        (
            f"{HEAD}tree: {{turn: {{{pairs}}}, timeout: 9}}\n",
            f"{HEAD}tree: {{wait: 1, {pairs}}}\n",
            f"mission: m\n{pairs.replace(', ', chr(10))}\ntree: {{wait: 1}}\n",
            f"{HEAD}tree: {{set: {{{pairs}}}}}\n",
            f"{HEAD}include: [{', '.join(['parts.yaml'] * count)}]\ntree: {{wait: 1}}\n",
        )
    )


def _lists(rng: Random, count: int) -> str:
    """Return long lists of numbers, as an input and in a goal."""
    numbers = ", ".join(rng.choice(("1", "0.5", "[1, 2, 3]")) for _ in range(count))
    loop = "tree: {for_each: {x: $a}, do: {log: $x}}\n"
    return rng.choice(
        (
            f"mission: m\ninputs: {{a: [{numbers}]}}\n{loop}",
            f"{HEAD}tree: {{follow_waypoints: {{poses: [{numbers}]}}, timeout: 9}}\n",
            f"{HEAD}tree: {{choose: [{{wait: 1}}, {{wait: 2}}], weights: [{numbers}]}}\n",
        )
    )


SHAPES: tuple[Callable[[Random, int], str], ...] = (
    *(_wide, _deep, _chain, _doubling, _long_text, _aliases),
    *(_inputs, _outputs, _names, _keys, _lists),
)
