"""Missions written to break what reads them: refused at once, at the place, for little memory."""

from pathlib import Path

import pytest

from bt_mission.sessions.check import examine
from tests.support.fuzz.limits import judge_within
from tests.support.thorough import sample

DEEP = 10_000
DIGITS = 1_000_000
MOMENT_S = 2.0
"""What a refusal may take of the processor; most take some milliseconds."""


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """A folder `here` to work in, and one beside it that is none of the mission's business."""
    library = "trees:\n  t: {do: {wait: 1}}\n"
    for name in ("here", "here/below", "elsewhere"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "library.yaml").write_text(library, encoding="utf-8")
    monkeypatch.chdir(tmp_path / "here")


def refusal(text):
    """Return the first line of what is said of a mission, and judge what saying it took."""
    path = Path("m.yaml")
    path.write_text(text, encoding="utf-8")
    mission, faults = examine(path)
    assert mission is None
    assert all(len(line) < 400 for fault in faults for line in str(fault).splitlines())
    assert judge_within(path, cpu_s=MOMENT_S).finding is None
    return str(faults[0]).splitlines()[0]


def bomb():
    """Twenty lists, each of nine times the one before: 9**20 values."""
    lists = ["a: &a0 [x]"]
    lists += [f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 9)}]" for n in range(1, 20)]
    return "\n".join(lists)


@pytest.mark.parametrize(
    ("node", "output"),
    [
        (f"wait: {'(' * DEEP}1{')' * DEEP}", "9: error: the expression has 20,001 characters"),
        (f"wait: '{'-' * DEEP}1'", "10: error: the expression has 10,001 characters"),
        (f"wait: {'abs(' * DEEP}1{')' * DEEP}", "9: error: the expression has 50,001 characters"),
        (f"check: {'not ' * DEEP}true", "10: error: the expression has 40,004 characters"),
        (f"wait: 1{'**1' * DEEP}", "9: error: the expression has 30,001 characters"),
        (f"wait: {'(' * 300}1{')' * 300}", "41: error: the expression is nested too deeply"),
        (f"wait: {'-' * 900}x", "41: error: the expression is nested too deeply"),
        (f"log: a ${{{'(' * DEEP}1}}", "8: error: a text with '$' has 10,006 characters"),
        (f"log: a ${{{'(' * 9000}1}}", "12: error: the expression has 9,001 characters"),
    ],
    ids=["parentheses", "signs", "calls", "nots", "powers", "300", "900", "template", "hole"],
)
def test_expressions_of_any_depth_are_refused(node, output):
    """Too long to be read at all, or too deep where that begins."""
    assert refusal(f"mission: m\ntree:\n  {node}\n").startswith(f"m.yaml:3:{output}")


@pytest.mark.parametrize(
    ("text", "output"),
    sample(
        [
            ("mission: m\ntree: {wait: NUMBER}", "2:14: error: the number '999"),
            ("mission: m\ntree: {wait: -NUMBER}", "2:14: error: the number '-999"),
            ("mission: m\ntree: {wait: 0xNUMBER}", "2:14: error: the number '0x999"),
            ("mission: m\ntree: {wait: 'NUMBER'}", "2:15: error: the expression has "),
            ("mission: m\ntree: {wait: '1eNUMBER'}", "2:15: error: the expression has "),
            ("mission: m\ntree: {wait: 1eNUMBER}", "2:14: error: the number '1e999"),
            ("mission: m\ninputs: {n: NUMBER}\ntree: {wait: n}", "2:13: error: the number '999"),
            ("mission: m\ntree: {log: '${NUMBER}'}", "2:14: error: a text with '$' has "),
            (
                "mission: m\n? NUMBER\n: 1\ntree: {wait: 1}",
                "2:3: error: the number '999",
            ),
            ("mission: NUMBER\ntree: {wait: 1}", "1:10: error: the number '999"),
        ],
        3,
    ),
)
def test_numbers_of_almost_a_million_digits_are_refused(text, output):
    """As many as a file can hold; Python itself gives up at 4,300."""
    digits = "9" * (DIGITS - len(text))
    assert refusal(text.replace("NUMBER", digits)).startswith(f"m.yaml:{output}")


def test_a_number_of_a_million_digits_makes_the_file_too_large():
    """It is refused unread, so that there is no line to tell."""
    output = refusal(f"mission: m\ntree: {{wait: {'9' * DIGITS}}}")
    assert output.startswith("m.yaml: error: the file is too large: 1,000,025 bytes")


def test_an_input_of_a_million_digits_is_refused():
    """On the command line, where no file's limit holds."""
    path = Path("m.yaml")
    path.write_text("mission: m\ninputs: {n: 1}\ntree: {wait: n}\n", encoding="utf-8")
    mission, faults = examine(path, set={"n": "9" * DIGITS})
    assert mission is None
    assert str(faults[0]).startswith(
        "--set:1:3: error: input 'n' expects a number, got string '999"
    )
    assert all(len(line) < 400 for line in str(faults[0]).splitlines())


@pytest.mark.parametrize(
    ("text", "output"),
    [
        (f"{bomb()}\nmission: m\ntree: {{wait: 1}}", "6:40: error: with aliases expanded, "),
        ("mission: m\ntree: &a {sequence: [*a, *a]}", "2:22: error: the alias '*a' contains itse"),
        (
            f"mission: m\ninputs: {{t: &a {'x' * 9_000}}}\ntree:\n  sequence:\n"
            + "    - log: *a\n" * 500,
            "115:12: error: with aliases expanded, ",
        ),
        (
            "mission: m\ntree: " + "{sequence: [" * DEEP + "{wait: 1}" + "]}" * DEEP,
            "2:1206: error: nested too deeply; the limit is 200 levels",
        ),
    ],
    ids=["bomb", "ring", "texts", "levels"],
)
def test_files_that_grow_when_they_are_read_are_refused(text, output):
    """Before they have grown."""
    assert refusal(text).startswith(f"m.yaml:{output}")


def many(form, count):
    """Return a text so many times, one in a line, with a number in it."""
    return ",\n".join(form.format(number) for number in range(count))


SETS = f"tree: {{sequence: [{many('set: {{x{}: 1}}', 9_000)}]}}"
CHILDREN = (
    f"tree: {{parallel: [{many('{{wait: 1, name: a{}}}', 7_000)}],"
    f" succeed_when: [{many('b{}a', 3_000)}]}}"
)
INPUTS = (
    f"trees: {{t: {{inputs: {{{many('a{}: 1', 600)}}}, do: {{wait: 1}}}}}}\n"
    f"tree: {{tree: {{name: t, inputs: {{{many('b{}a: 1', 9_000)}}}}}}}"
)
NUMBERS = f"tree: {{parallel: [wait: 1], succeed_when: [{many('{}', 30_000)}]}}"
NOTHINGS = f"inputs: {{{many('a{}: ~', 15_000)}}}\ntree: {{wait: 1}}"
INCLUDES = f"include: [{many('a{}.yaml', 30_000)}]\ntree: {{wait: 1}}"
DRAWN = "log: '{} of ${{uniform(0, 1)}}'"
DRAWS = (
    f"trees: {{t: {{do: {{parallel: [{many(DRAWN, 295)}]}}}}}}\n"
    f"tree: {{parallel: [{many('tree: t', 100)}]}}"
)
GOALS = (
    f"trees: {{t: {{do: {{parallel: [{many('{{turn: {{angle: {}}}, timeout: 9}}', 300)}]}}}}}}\n"
    f"tree: {{parallel: [{many('tree: t', 30)}]}}"
)


@pytest.mark.parametrize(
    ("text", "accepted"),
    sample(
        [
            pytest.param(SETS, True, id="sets", marks=pytest.mark.thorough),
            pytest.param(CHILDREN, False, id="children", marks=pytest.mark.thorough),
            pytest.param(INPUTS, False, id="inputs"),
            pytest.param(NUMBERS, False, id="numbers"),
            pytest.param(NOTHINGS, False, id="nothings", marks=pytest.mark.thorough),
            pytest.param(INCLUDES, False, id="includes"),
            pytest.param(DRAWS, True, id="draws", marks=pytest.mark.thorough),
            pytest.param(GOALS, True, id="goals", marks=pytest.mark.thorough),
        ],
        9,
    ),
)
def test_very_many_parts_take_no_more_than_a_mission_may(text, accepted):
    """Refused, or run: their time does not grow with the square of their number."""
    path = Path("m.yaml")
    path.write_text(f"mission: m\n{text}\n", encoding="utf-8")
    verdict = judge_within(path)
    assert (verdict.accepted, verdict.finding) == (accepted, None)


@pytest.mark.parametrize(
    ("link", "target", "included", "output"),
    [
        ("a.yaml", "a.yaml", "a.yaml", "the symbolic links of 'a.yaml' do not lead to a file"),
        ("a.yaml", "b.yaml", "a.yaml", "the symbolic links of 'a.yaml' do not lead to a file"),
        ("ring", "ring", "ring/library.yaml", "no such file 'ring/library.yaml'"),
        ("out.yaml", "../elsewhere/library.yaml", "out.yaml", "'out.yaml' is outside"),
        ("out", "../elsewhere", "out/library.yaml", "'out/library.yaml' is outside"),
        ("b.yaml", "a.yaml", "../elsewhere/library.yaml", "'../elsewhere/library.yaml' is outside"),
        ("b.yaml", "a.yaml", "below/../../elsewhere/library.yaml", "'below/../../elsewhere/libr"),
        ("b.yaml", "a.yaml", "/etc/passwd", "'/etc/passwd' is outside the folder"),
        ("b.yaml", "a.yaml", "below", "no such file 'below'"),
        ("b.yaml", "a.yaml", "..", "no such file '..'"),
        ("b.yaml", "a.yaml", '"a\\0b"', "expected characters that can be shown, got"),
        ("b.yaml", "a.yaml", "x" * 190, "no such file 'xxx"),
        ("b.yaml", "a.yaml", "m.yaml", "the files include each other: m.yaml -> m.yaml"),
    ],
)
def test_included_files_lead_nowhere_else(link, target, included, output):
    """Neither round and round nor out of the folder, whichever way they are written."""
    Path(link).symlink_to(target)
    if target == "b.yaml":
        Path("b.yaml").symlink_to("a.yaml")
    result = refusal(f"mission: m\ninclude: [{included}]\ntree: {{wait: 1}}\n")
    assert result.startswith(f"m.yaml:2:11: error: {output}")


def test_a_folder_that_contains_itself_is_no_way_out():
    """However often it is gone through, the file is the same, and its trees are read once."""
    Path("below/again").symlink_to("..")
    again = "below/again/" * 15
    path = Path("m.yaml")
    text = f"mission: m\ninclude: [library.yaml, {again}library.yaml]\ntree: {{tree: t}}\n"
    path.write_text(text, encoding="utf-8")
    mission, faults = examine(path)
    assert mission is not None
    assert faults == ()
