"""Errors for bad input: each message says what was expected, what was found and where."""

from __future__ import annotations

from izo_ref.base.records import Pairs


class IzoError(Exception):
    """Base of every error that this package raises on purpose."""


class ShapeError(IzoError):
    """An array has the wrong shape, or a type that cannot be converted without loss."""


class NonFiniteError(IzoError):
    """A number is NaN or infinite."""


class IndexRangeError(IzoError):
    """An index points at no vertex."""


class DegenerateFaceError(IzoError):
    """A face names the same vertex twice."""


class SizeError(IzoError):
    """A coordinate is too large or too small to compute with."""


class MassError(IzoError):
    """A mass is zero or negative, or too small beside the largest one."""


class WeightError(IzoError):
    """The weights of an impact do not sum to zero."""


class ThicknessError(IzoError):
    """A thickness is not a positive, finite number of metres, or does not fit the coordinates."""


class InitialIntersectionError(IzoError):
    """The mesh intersects itself at the start of the step.

    Attributes:
        pairs: The pairs that have to be left out, so that the rest of the start is free.
    """

    def __init__(self, message: str, pairs: Pairs) -> None:
        """Keep the message and the pairs."""
        super().__init__(message)
        self.pairs = pairs


class UncertifiedStartError(IzoError):
    """The next step cannot start where a step ended, because that end is not certified free."""


class WeldError(IzoError):
    """Vertices that are welded into one are not at one place, or cannot be welded as asked."""


class OptionError(IzoError):
    """An option has a value that is not offered."""


class DeviceUnavailableError(IzoError):
    """A device was asked for that cannot be used."""


class DeviceMemoryError(IzoError):
    """A GPU has less free memory than is needed."""


class FileFormatError(IzoError):
    """A file cannot be read or written, or does not hold what it should."""


class CacheFolderError(IzoError):
    """The folder of compiled code cannot be used, or what has to fill it failed."""


class VectorsError(IzoError):
    """Vectors of the porting kit are missing or damaged, or a generator made a wrong one."""
