"""Models from documents, with every complaint in our words."""

from typing import Literal

import pytest
from pydantic import BaseModel, ConfigDict, Field

from bt_mission.base.diagnostics import InputError
from bt_mission.base.yaml.document import read_text
from bt_mission.base.yaml.models import validate


class Wheel(BaseModel):
    """A part."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    radius: float = Field(gt=0)
    colour: Literal["black", "white"] = "black"


class Car(BaseModel):
    """A thing with parts, lists and choices."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    name: str = Field(min_length=1, max_length=8)
    doors: int = Field(default=4, ge=2, le=5)
    electric: bool = False
    wheels: tuple[Wheel, ...] = ()
    place: tuple[float, float] = (0.0, 0.0)
    spare: Wheel | None = None
    size: float | Literal["small"] = 1.0
    parts: dict[str, Wheel] = {}


def messages(text):
    """Return every fault with its place and hint."""
    with pytest.raises(InputError) as caught:
        validate(read_text(text, "car.yaml"), Car)
    return [
        f"{fault.line}:{fault.column} {'; '.join(filter(None, (fault.message, fault.hint)))}"
        for fault in caught.value.diagnostics
    ]


def test_a_sound_document_becomes_a_model():
    """Lists become tuples, whole numbers do for floats."""
    text = "name: a\nwheels: [{radius: 1}]\nplace: [1, 2.5]\nspare: {radius: 0.3, colour: white}"
    car = validate(read_text(text), Car)
    assert car.wheels == (Wheel(radius=1.0),)
    assert car.place == (1.0, 2.5)
    assert car.spare == Wheel(radius=0.3, colour="white")


def test_a_part_of_a_document_can_be_taken():
    """The path leads to the part; faults keep the places of the whole."""
    document = read_text("cars:\n  - {name: 1}\n")
    with pytest.raises(InputError) as caught:
        validate(document, Car, ("cars", 0))
    assert (caught.value.diagnostics[0].line, caught.value.diagnostics[0].column) == (2, 12)


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("doors: 4", "1:1 'name' is missing"),
        (
            "name: a\ndors: 4",
            (
                "2:1 unknown key 'dors' (valid: doors, electric, name, parts, place, size, spare, "
                "wheels); did you mean 'doors'?"
            ),
        ),
        ("name: 3", "1:7 expected a string, got the number 3"),
        ("name: a\ndoors: 4.5", "2:8 expected an integer, got the number 4.5"),
        ("name: a\ndoors: '4'", "2:8 expected an integer, got string '4'"),
        ("name: a\ndoors: true", "2:8 expected an integer, got true"),
        ("name: a\ndoors: 7", "2:8 expected at most 5, got the number 7"),
        ("name: a\ndoors: 1", "2:8 expected at least 2, got the number 1"),
        (
            "name: a\nelectric: yes",
            "2:11 expected a boolean, got string 'yes'; in YAML 1.2 a boolean is written 'true'",
        ),
        ("name: a\nwheels: 4", "2:9 expected a list, got the number 4"),
        ("name: a\nwheels: [4]", "2:10 expected a mapping, got the number 4"),
        ("name: a\nwheels: [{}]", "2:10 'radius' is missing"),
        (
            "name: a\nwheels:\n  - {radius: 1, colur: black}",
            "3:17 unknown key 'colur' (valid: colour, radius); did you mean 'colour'?",
        ),
        ("name: a\nwheels: [{radius: 0}]", "2:19 expected more than 0.0, got the number 0"),
        (
            "name: a\nspare: {radius: 1, colour: blck}",
            "2:28 expected one of black, white, got string 'blck'; did you mean 'black'?",
        ),
        (
            "name: a\nspare: {radios: 1, radius: 2}",
            "2:9 unknown key 'radios' (valid: colour, radius); did you mean 'radius'?",
        ),
        (
            "name: a\nparts: {left: {radius: 2, colr: white}}",
            "2:27 unknown key 'colr' (valid: colour, radius); did you mean 'colour'?",
        ),
        ("name: a\nplace: [1]", "2:8 '1' is missing"),
        ("name: ''", "1:7 expected at least 1 characters, got string ''"),
        ("name: a long name", "1:7 expected at most 8 characters, got string 'a long name'"),
        ("name: a\nsize: big", "2:7 expected a number or one of small, got string 'big'"),
        ("- a", "1:1 expected a mapping, got a list of 1"),
        ("name: a\nspare: 3", "2:8 expected a mapping, got the number 3"),
    ],
)
def test_each_complaint_is_plain_and_stands_where_it_belongs(text, fault):
    """Types, limits, choices and names; never a word of pydantic's."""
    assert messages(text) == [fault]


def test_all_faults_come_at_once_in_the_order_of_the_file():
    """One look is enough."""
    results = messages("doors: 9\nname: 3\nwheels: [{radius: -1}, {radius: x}]\nfoo: 1")
    assert [result.partition(":")[0] for result in results] == ["1", "2", "3", "3", "4"]
