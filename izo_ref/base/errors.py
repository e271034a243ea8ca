"""What bad input raises. Each message says what was expected, what was found and where."""


class IzoError(Exception):
    """Base of every error this package raises on purpose."""


class ShapeError(IzoError):
    """An array has the wrong shape or a type that does not convert without loss."""


class NonFiniteError(IzoError):
    """A number is NaN or infinite."""


class IndexRangeError(IzoError):
    """An index points at no vertex."""


class DegenerateFaceError(IzoError):
    """A face names the same vertex twice."""


class MassError(IzoError):
    """A mass is zero or negative."""


class ThicknessError(IzoError):
    """A thickness is not a positive number of metres."""


class InitialIntersectionError(IzoError):
    """The mesh intersects itself at the start of the step.

    Attributes:
        pairs: `Pairs`, every pair that has to be left out for the rest to be free.
    """

    def __init__(self, message, pairs):
        super().__init__(message)
        self.pairs = pairs


class OptionError(IzoError):
    """An option has a value that is not offered."""


class DeviceUnavailableError(IzoError):
    """The device asked for cannot be used."""


class DeviceMemoryError(IzoError):
    """A GPU has less memory free than is needed."""


class FileFormatError(IzoError):
    """A file does not hold what its kind has to hold."""
