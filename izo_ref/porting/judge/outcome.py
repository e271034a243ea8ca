"""What a judge says: the outcome of a case, and each place in which a reply is wrong."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from izo_ref.porting.cases import Case
from izo_ref.porting.reference.rounded import EPS

PASSED, FAILED, NOT_SUPPORTED, NOT_RUN = "passed", "failed", "not supported", "not run"

# Causes of a difference: a wrong number or decision, a reply of the wrong form (a missing output, a
# wrong length, null), or what went wrong in the exchange. The first alone points at the method.
WRONG, MALFORMED, INCIDENT = "wrong", "malformed", "incident"


class Difference(NamedTuple):
    """One place in which a reply is not what the case asks for.

    Attributes:
        output: Name of the output, `status`, or the kind of an incident (`crash`, `hang`, ...).
        sentence: What is wrong, for a person.
        element: Index of the element, (row, column) for an array of two dimensions, (index,) for
            one dimension, () for a single value; None if this is not about an element.
        expected: The expected number or text; None if there is no single one.
        got: The number or text in the reply; None if there is none.
        ulps: Error in units of the last place of the expected value in the port's type of floats;
            None if this has no meaning.
        tolerances: Error in multiples of the tolerance; None if this has no meaning.
        cause: WRONG, MALFORMED or INCIDENT.
        quantity: What the numbers are, if they are not the element itself, such as "the gap at
            the start, at least"; empty otherwise.
        error_output: The last lines that a port wrote to its error output, for an incident.
    """

    output: str
    sentence: str
    element: tuple[int, ...] | None = None
    expected: Any = None
    got: Any = None
    ulps: float | None = None
    tolerances: float | None = None
    cause: str = WRONG
    quantity: str = ""
    error_output: str = ""


class Outcome(NamedTuple):
    """The outcome of one case with one type of floats.

    Attributes:
        result: PASSED, FAILED, NOT_SUPPORTED or NOT_RUN.
        differences: What is wrong; empty unless the result is FAILED or NOT_RUN.
        early: Whether a time was accepted that is earlier than the exact one.
    """

    result: str
    differences: tuple[Difference, ...] = ()
    early: bool = False


class Question(NamedTuple):
    """What a judge of one output gets.

    Attributes:
        case: The case.
        output: Name of the output.
        columns: Length of a row; 0 for a single value.
        expected: What the case says about this output.
        got: The values in the reply, a flat list of finite numbers or of texts.
        replies: All outputs of the reply that could be read, in the same way.
        dtype: `f8` or `f4`.
    """

    case: Case
    output: str
    columns: int
    expected: Mapping[str, Any]
    got: Sequence[Any]
    replies: Mapping[str, Sequence[Any]]
    dtype: str

    @property
    def eps(self) -> float:
        """The machine epsilon of the port's type of floats."""
        return EPS[self.dtype]

    def element(self, i: int) -> tuple[int, ...]:
        """Return the index of a flat position as a person writes it."""
        return element_of(i, self.columns)

    def difference(
        self, sentence: str, i: int | None = None, expected: Any = None, got: Any = None
    ) -> Difference:
        """Return a difference in this output."""
        element = None if i is None else self.element(i)
        return Difference(self.output, sentence, element, expected, got)

    def needs(self, name: str) -> Difference:
        """Return the difference for another output that this one needs and that is unreadable."""
        text = f"{self.output} cannot be judged without {name}, which the reply does not have in a "
        return Difference(self.output, f"{text}readable form", cause=MALFORMED)


def element_of(i: int, columns: int) -> tuple[int, ...]:
    """Return the index of a flat position; `columns` is 0 for a single value."""
    if columns == 0:
        return ()
    return (i,) if columns == 1 else divmod(i, columns)


def place(difference: Difference) -> str:
    """Return the output and the element of a difference as text, such as `gradient (2, 1)`."""
    if not difference.element:
        return difference.output
    return f"{difference.output} ({', '.join(str(index) for index in difference.element)})"
