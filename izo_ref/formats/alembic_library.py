"""Call the library of Alembic, the package alembic3d, and walk through its archives."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from izo_ref.base.arrays import Floats
from izo_ref.base.errors import FileFormatError
from izo_ref.formats.animation import FilePath

MAX_MESSAGE = 300  # characters of a message of the library
MESHES = ("AbcGeom_PolyMesh", "AbcGeom_SubD")  # how the schemas of meshes begin
XFORM = "AbcGeom_Xform"


class Library(NamedTuple):
    """Parts of the library, which has no types that a checker can read.

    Attributes:
        Abc: Archives, objects and properties.
        AbcGeom: Transforms.
        imath: Arrays.
    """

    Abc: Any
    AbcGeom: Any
    imath: Any


@cache
def library() -> Library:
    """Import the library.

    Raises:
        FileFormatError: It is not installed.
    """
    try:
        names = ("alembic3d", "imath")
        alembic3d, imath = (import_module(name) for name in names)
    except ImportError:
        raise FileFormatError(
            "Alembic files need the package alembic3d: pip install alembic3d"
        ) from None
    return Library(alembic3d.Abc, alembic3d.AbcGeom, imath)


@contextmanager
def errors(path: FilePath) -> Iterator[None]:
    """Turn errors of the library into errors of the file.

    Args:
        path: The file that is read or written.

    Raises:
        FileFormatError: The library raised an error.
    """
    try:
        yield
    except (RuntimeError, ValueError, TypeError, IndexError, OverflowError) as error:
        message = " ".join(str(error).split())[:MAX_MESSAGE]
        raise FileFormatError(f"{path}: Alembic cannot read or write it: {message}") from None


def at(index: int) -> Any:
    """Return what selects a sample by its number."""
    # by its keyword, as a number alone is taken for a time
    return library().Abc.ISampleSelector(requestedIndex=index)


def objects(archive: Any, path: Path) -> Iterator[Any]:
    """Yield all objects of an archive, parents first, in the order of the file.

    Raises:
        FileFormatError: One is an instance of another one.
    """
    waiting = [archive.getTop()]
    while waiting:
        found = waiting.pop()
        if found.isInstanceRoot():
            raise FileFormatError(
                f"{path}: {found.getFullName()}: is an instance; make it real first"
            )
        yield found
        waiting += [found.getChild(k) for k in reversed(range(found.getNumChildren()))]


def schema(thing: Any) -> str:
    """Return the name of the schema of an object, such as AbcGeom_PolyMesh_v1."""
    return str(thing.getMetaData().get("schema"))


def properties(compound: Any) -> Iterator[Any]:
    """Yield the properties of a compound, without those inside its compounds."""
    for k in range(compound.getNumProperties()):
        yield compound.getProperty(k)


def times(sampled: Any) -> Floats:
    """Return the times of the samples of a property or a schema, (n,) f8 [s]."""
    sampling = sampled.getTimeSampling()
    return np.array([sampling.getSampleTime(k) for k in range(sampled.getNumSamples())])


class Transform:
    """The transforms between a mesh and the world.

    Attributes:
        schemas: Those that have samples, from the mesh upwards.
        is_constant: Whether none has more than one sample.
    """

    def __init__(self, mesh: Any) -> None:
        """Find the transforms above a mesh."""
        self.schemas = []
        above = mesh.getParent()
        while above.valid() and above.getFullName() != "/":
            if schema(above).startswith(XFORM):
                parent = above.getParent()
                own = library().AbcGeom.IXform(parent, above.getName()).getSchema()
                if own.getNumSamples():
                    self.schemas.append(own)
            above = above.getParent()
        self.is_constant = all(own.getNumSamples() == 1 for own in self.schemas)

    def matrix(self, number: int) -> Floats:
        """Return the transform of a frame, (4, 4) f8; a row vector times it is in the world."""
        matrix = np.eye(4)
        for own in self.schemas:
            sample = own.getValue(at(number if own.getNumSamples() > 1 else 0))
            step = sample.getMatrix()
            with np.errstate(all="ignore"):  # callers look at what is not finite
                matrix = matrix @ np.array([[step[i][j] for j in range(4)] for i in range(4)])
            if not sample.getInheritsXforms():
                break
        return matrix
