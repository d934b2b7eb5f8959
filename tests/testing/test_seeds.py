from __future__ import annotations

import pytest

from bt_mission.testing.seeds import MarkerError, asked_for, read_marker, so_many


def marked(*arguments: object, **options: object) -> pytest.Mark:
    """The marker, as a test has it."""
    return pytest.mark.scenario(*arguments, **options).mark


@pytest.mark.parametrize(
    ("given", "seeds"), [(3, (0, 1, 2)), (range(5, 8), (5, 6, 7)), ([9, 2], (9, 2)), ((4,), (4,))]
)
def test_seeds_are_a_number_a_range_or_a_list(given, seeds):
    """A number counts from 0; a list keeps its order."""
    assert read_marker(marked(seeds=given)).seeds == seeds


@pytest.mark.parametrize(("given", "share"), [(None, None), (1, 1.0), (0.9, 0.9)])
def test_at_least_is_a_share(given, share):
    """None is all of them, and nothing is reported as expected."""
    assert read_marker(marked(seeds=2, at_least=given)).at_least == share


@pytest.mark.parametrize(
    ("mark", "words"),
    [
        (marked(), "the seeds are missing: @pytest.mark.scenario(seeds=range(50)"),
        (marked(50), "seeds are given by name"),
        (marked(seed=5), "unknown argument 'seed': @pytest.mark.scenario("),
        (marked(seeds=0), "seeds=0: at least one seed is needed"),
        (marked(seeds=[]), r"seeds=\[\]: at least one seed is needed"),
        (marked(seeds=2.0), "a range or a list of seeds, not 2.0, of type float"),
        (marked(seeds="3"), "not '3', of type str"),
        (marked(seeds={1, 2}), "of type set"),
        (marked(seeds=True), "not True, of type bool"),
        (marked(seeds=[1, -1]), "a seed is an integer from 0, not -1"),
        (marked(seeds=[1, None]), "a seed is an integer from 0, not None"),
        (marked(seeds=[3, 1, 3]), "the seed 3 appears twice"),
        (
            marked(seeds=3, at_least=0),
            "the share of seeds that must pass as at_least, such as 0.9, got 0",
        ),
        (marked(seeds=3, at_least=90), "got 90"),
        (marked(seeds=3, at_least="all"), "got all"),
        (marked(seeds=3, at_least=True), "got True"),
    ],
)
def test_a_bad_marker_is_told_what_was_expected(mark, words):
    """What was expected, and what was got."""
    with pytest.raises(MarkerError, match=words.replace("(", r"\(").replace(")", r"\)")):
        read_marker(mark)


@pytest.mark.parametrize(
    ("seeds", "count", "result"),
    [
        ((0, 1, 2), 2, (0, 1)),
        ((0, 1, 2), 5, (0, 1, 2, 3, 4)),
        ((7, 3), 4, (7, 3, 8, 9)),
        ((7, 3), 2, (7, 3)),
    ],
)
def test_another_number_of_seeds_begins_as_the_test_says(seeds, count, result):
    """Fewer are the first of them, more go on after the greatest."""
    assert so_many(seeds, count) == result


def test_a_seed_may_be_asked_for_by_name():
    """Wherever the seed came from, the line that repeats it works."""
    arguments = [
        "tests/test_a.py::test_x[seed7]",
        "test_a.py::TestX::test_x[seed8-waffle]",
        "test_a.py::test_x[burger-seed9]",
        "test_a.py::test_other[seed10]",
        "test_a.py::test_x",
        "test_a.py::test_x[seed-11]",
        "tests",
    ]
    assert asked_for(arguments, "test_x") == [7, 8, 9]
