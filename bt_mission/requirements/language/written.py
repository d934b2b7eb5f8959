"""Requirements as written in a file: a formula, or a mapping with `whenever` and `then`."""

from collections.abc import Mapping
from typing import Annotated, Any, Self

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Discriminator,
    PlainValidator,
    StrictBool,
    Tag,
    WithJsonSchema,
    model_validator,
)

from bt_mission.base.diagnostics import describe
from bt_mission.base.verdicts import OnViolation
from bt_mission.language.expressions.values import ExpressionError
from bt_mission.language.mission import Requirement
from bt_mission.language.nodes.base import Written
from bt_mission.language.nodes.fields import FixedLimit, Line, parsed, refusal
from bt_mission.requirements.language.formula import (
    MAY_NOT_APPLY,
    Clause,
    Formula,
    check_formula,
    may_not_apply,
    walk,
)
from bt_mission.requirements.language.parser import parse_requirement
from bt_mission.requirements.language.syntax import Measure, Temporal

EXAMPLE = "always clearance > 0.1"


def _formula(value: Any) -> Formula:
    if not isinstance(value, str):
        message = f"expected a requirement such as '{EXAMPLE}', got {describe(value)}"
        raise refusal(message, code="BT-601")
    return parsed(Formula, value)


def _clause(value: Any) -> Clause:
    if not isinstance(value, str):
        message = f"expected a condition such as 'speed < 0.01', got {describe(value)}"
        raise refusal(message, code="BT-601")
    if may_not_apply(value):
        message = f"'{MAY_NOT_APPLY}' is allowed only at the start of a formula"
        raise refusal(message, "write 'may_not_apply: true' beside 'whenever'", code="BT-601")
    return parsed(Clause, value)


_TEXT = WithJsonSchema({"type": "string"})
WrittenFormula = Annotated[Formula, PlainValidator(_formula), _TEXT]
WrittenClause = Annotated[Clause, PlainValidator(_clause), _TEXT]


class RequirementForm(Written):
    """A requirement, whether its premise may never come true, and the reaction to its violation."""

    formula: WrittenFormula | None = None
    whenever: WrittenClause | None = None
    then: WrittenClause | None = None
    within: FixedLimit | None = None
    may_not_apply: StrictBool = False
    on_violation: OnViolation = "report"

    @model_validator(mode="after")
    def _is_whole(self) -> Self:
        if self.formula is not None and (self.whenever or self.then or self.within):
            raise refusal("expected 'formula', or 'whenever' and 'then', got both", code="BT-601")
        if self.formula is None and (self.whenever is None or self.then is None):
            raise refusal("expected 'formula', or 'whenever' and 'then'", code="BT-601")
        if self.formula is None:
            try:
                check_formula(parse_requirement(self.text))
            except ExpressionError as error:
                raise refusal(error.message, error.hint, code=error.code) from None
        return self

    @property
    def text(self) -> str:
        """The same as one formula."""
        is_said = self.formula is not None and may_not_apply(self.formula.text)
        return f"{MAY_NOT_APPLY} {self._claim}" if self.may_not_apply > is_said else self._claim

    @property
    def _claim(self) -> str:
        if self.formula is not None:
            return self.formula.text
        assert self.whenever is not None
        assert self.then is not None
        then = self.then.text
        if self.within is None:
            return f"whenever {self.whenever.text}: {then}"
        parts = [
            operator
            for operator in walk(self.then.root)
            if isinstance(operator, Temporal | Measure)
        ]
        if any(
            isinstance(operator, Measure) or operator.word in ("until", "since")
            for operator in parts
        ):
            then = f"({then})"  # its own 'until' or 'count' would take the 'within'
        return f"whenever {self.whenever.text}: {then} within {self.within:g} s"


def _known_form(value: Any) -> Any:
    if not isinstance(value, str | Mapping | Formula | RequirementForm):
        message = f"expected a requirement such as '{EXAMPLE}', got {describe(value)}"
        raise refusal(message, code="BT-601")
    return value


def _kind(value: Any) -> str:
    return "text" if isinstance(value, str | Formula) else "form"


WrittenRequirement = Annotated[
    Annotated[WrittenFormula, Tag("text")] | Annotated[RequirementForm, Tag("form")],
    Discriminator(_kind),
    BeforeValidator(_known_form),
]
Requirements = Annotated[dict[Line, WrittenRequirement], AfterValidator(dict)]


class RequirementsFile(Written):
    """A file of requirements, for missions of other files."""

    description: str = ""
    requirements: Requirements


def requirements_of(written: Mapping[str, Formula | RequirementForm]) -> tuple[Requirement, ...]:
    """Return requirements as their file has them, in its order."""
    requirements = []
    for name, form in written.items():
        action: OnViolation = form.on_violation if isinstance(form, RequirementForm) else "report"
        requirements.append(Requirement(name, form.text, action))
    return tuple(requirements)
