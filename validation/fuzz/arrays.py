"""Strange values, and arrays that are changed into strange ones."""

import decimal
import fractions
from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np

Rng: TypeAlias = np.random.Generator


class Angry:
    """An object that raises whatever is asked of it."""

    def __repr__(self) -> str:  # noqa: D105
        raise RuntimeError("no repr")

    def __float__(self) -> float:  # noqa: D105
        raise RuntimeError("no number")


class Unarray:
    """An object whose conversion to an array fails."""

    def __array__(self, *args: Any, **named: Any) -> Any:  # noqa: D105
        raise RuntimeError("no array")


def _itself() -> list[Any]:
    """Return a list that holds itself."""
    inner: list[Any] = []
    inner.append(inner)
    return inner


# Values in the place of one argument. Each is made anew, because some can be read once only.
VALUES: tuple[Callable[[], Any], ...] = (
    lambda: None,
    lambda: True,
    lambda: np.bool_(False),
    lambda: 0,
    lambda: -1,
    lambda: 1,
    lambda: 0.5,
    lambda: -0.0,
    lambda: float("nan"),
    lambda: float("inf"),
    lambda: -float("inf"),
    lambda: 5e-324,
    lambda: 1.7976931348623157e308,
    lambda: 10**400,
    lambda: -(10**5000),
    lambda: 2**53,
    lambda: 2**63,
    lambda: 1j,
    lambda: np.complex128(1.0),
    lambda: "",
    lambda: "0.5",
    lambda: b"1",
    lambda: "raise",
    lambda: "auto",
    lambda: "x" * 10_000,
    lambda: [],
    lambda: [[]],
    lambda: (),
    lambda: {},
    lambda: {1, 2},
    lambda: {"a": 1},
    lambda: range(4),
    lambda: (x for x in "ab"),
    lambda: object(),
    lambda: Angry(),
    lambda: Unarray(),
    lambda: [Angry()],
    _itself,
    lambda: [1, [2, 3]],
    lambda: np.float32(0.25),
    lambda: np.float16(0.25),
    lambda: np.longdouble("1e4000"),
    lambda: np.int8(-3),
    lambda: np.uint64(2**64 - 1),
    lambda: np.datetime64("2020-01-01"),
    lambda: np.timedelta64(3, "s"),
    lambda: np.array(0.5),
    lambda: np.array([0.5]),
    lambda: np.array("auto"),
    lambda: np.array(["raise", "x"]),
    lambda: np.ma.masked,
    lambda: decimal.Decimal("0.125"),
    lambda: decimal.Decimal("sNaN"),
    lambda: fractions.Fraction(1, 3),
    lambda: np.zeros((2, 3), "V5"),
    lambda: np.zeros(3, [("a", "f8")]),
    lambda: memoryview(b"abc"),
    lambda: np.zeros((0, 3)),
    lambda: np.zeros((4, 0)),
    lambda: np.zeros((0, 4), int),
    lambda: int,
    lambda: np.float64,
)
ENTRIES = (
    float("nan"),
    float("inf"),
    -float("inf"),
    0.0,
    -1.0,
    -0.0,
    5e-324,
    1e-300,
    1e300,
    1.7976931348623157e308,
    0.5,
    1e9,
    2.0**31,
    2.0**63,
)
OBJECTS = ("1", None, True, 1j, 10**400, [1], Angry(), fractions.Fraction(1, 7), "nan", b"2")
TYPES = (
    "f2",
    "f4",
    ">f8",
    "g",
    "i1",
    "i4",
    ">i8",
    "u2",
    "u8",
    "?",
    "O",
    "c16",
    "U8",
    "S8",
    "M8[s]",
)


def strange_value(rng: Rng) -> Any:
    """Return any value at all."""
    return VALUES[rng.integers(len(VALUES))]()


def changed(rng: Rng, array: Any) -> Any:
    """Return an array with another entry, type, shape, layout or container."""
    changes = (_entry, _entry, _object, _type, _shape, _layout, _mask, _ragged, _rows)
    change = changes[rng.integers(len(changes))]
    with np.errstate(all="ignore"):
        try:
            return change(rng, np.asarray(array))
        except Exception:  # numpy makes no such array, or an object in it is angry
            return strange_value(rng)


def _place(rng: Rng, array: Any) -> tuple[int, ...]:
    return tuple(int(rng.integers(size)) for size in array.shape)


def _entry(rng: Rng, array: Any) -> Any:
    if array.size == 0:
        return array
    out = array.astype(float)
    out[_place(rng, array)] = ENTRIES[rng.integers(len(ENTRIES))]
    return out


def _object(rng: Rng, array: Any) -> Any:
    out = array.astype(object)
    if array.size:
        out[_place(rng, array)] = OBJECTS[rng.integers(len(OBJECTS))]
    return out if rng.random() < 0.5 else out.tolist()


def _type(rng: Rng, array: Any) -> Any:
    kind = TYPES[rng.integers(len(TYPES))]
    return array.astype("i8").astype(kind) if kind.startswith("M") else array.astype(kind)


def _shape(rng: Rng, array: Any) -> Any:
    shapes = (array.ravel(), array[None], array.T, array[..., None], array[:, :1], array[..., :-1])
    return shapes[rng.integers(len(shapes))]


def _layout(rng: Rng, array: Any) -> Any:
    padded = np.zeros((*array.shape, 2), array.dtype)
    padded[..., 0] = array
    locked = array.copy()
    locked.setflags(write=False)
    layouts = (np.asfortranarray(array), padded[..., 0], array[::-1][::-1], locked, array.tolist())
    return layouts[rng.integers(len(layouts))]


def _mask(rng: Rng, array: Any) -> Any:
    return np.ma.masked_array(array, rng.random(array.shape) < rng.choice((0.0, 0.2)))


def _ragged(rng: Rng, array: Any) -> Any:
    rows = array.tolist()
    if rows:
        i = int(rng.integers(len(rows)))
        rows[i] = rows[i][:-1] if isinstance(rows[i], list) else [rows[i]]
    return rows


def _rows(rng: Rng, array: Any) -> Any:
    few = array[: rng.integers(len(array) + 1)]
    return few if rng.random() < 0.5 else np.concatenate((array, few))
