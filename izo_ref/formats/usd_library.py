"""Call the library of USD, the package usd-core, and keep its messages off the screen."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from izo_ref.base.arrays import AnyArray
from izo_ref.base.errors import FileFormatError
from izo_ref.formats.animation import FilePath
from izo_ref.formats.trial import raise_limit

MAX_MESSAGE = 300  # characters of a message of the library


class Pxr(NamedTuple):
    """Parts of the library, which has no types that a checker can read.

    Attributes:
        Sdf: Layers.
        Tf: Errors.
        Usd: Stages and prims.
        UsdGeom: Meshes and transforms.
        UsdUtils: Listeners for messages.
        Vt: Arrays.
    """

    Sdf: Any
    Tf: Any
    Usd: Any
    UsdGeom: Any
    UsdUtils: Any
    Vt: Any


@cache
def pxr() -> Pxr:
    """Import the library.

    Raises:
        FileFormatError: It is not installed.
    """
    try:
        return Pxr(*(import_module(f"pxr.{name}") for name in Pxr._fields))
    except ImportError:
        raise FileFormatError("USD files need the package usd-core: pip install usd-core") from None


@contextmanager
def errors(path: FilePath) -> Iterator[None]:
    """Turn errors of the library into errors of the file, and drop its warnings.

    Args:
        path: The file that is read or written.

    Raises:
        FileFormatError: The library raised an error.
    """
    listener = pxr().UsdUtils.CoalescingDiagnosticDelegate()
    kinds = (pxr().Tf.ErrorException, RuntimeError, ValueError, TypeError, OverflowError)
    try:
        yield
    except kinds as error:
        message = _text(error.__str__)
        raise FileFormatError(f"{path}: USD cannot read or write it: {message}") from None
    finally:
        listener.TakeUncoalescedDiagnostics()


def open_stage(path: Path) -> Any:
    """Open a stage as it is on disk now.

    Args:
        path: Its root layer.

    Raises:
        FileFormatError: The library warns, for example of a layer that is missing.
    """
    listener = pxr().UsdUtils.CoalescingDiagnosticDelegate()
    known = pxr().Sdf.Layer.Find(str(path))
    if known:  # the library keeps layers; the file may have changed since
        known.Reload(True)
    layer = pxr().Sdf.Layer.FindOrOpen(str(path))
    if layer and layer.GetCompositionAssetDependencies():
        raise_limit()
    stage = pxr().Usd.Stage.Open(str(path))
    found = listener.TakeUncoalescedDiagnostics()
    if found:
        raise FileFormatError(f"{path}: USD warns: {_text(lambda: found[0].commentary)}")
    return stage


def _text(read: Callable[[], str]) -> str:
    try:
        return " ".join(read().split())[:MAX_MESSAGE]
    except UnicodeDecodeError:  # it quotes the damaged bytes
        return "expected UTF-8, found other bytes"


def points_at(prim: Any, time: Any, where: str) -> AnyArray:
    """Return the points of a mesh, (n, 3) f4.

    Args:
        prim: The mesh.
        time: Time code.
        where: Path, frame and mesh, for the message.

    Raises:
        FileFormatError: They are missing, or of another type.
    """
    value = pxr().UsdGeom.Mesh(prim).GetPointsAttr().Get(time)
    if not isinstance(value, pxr().Vt.Vec3fArray):
        raise FileFormatError(f"{where}: expected points of float32, found {type(value).__name__}")
    return np.array(value, np.float32).reshape(-1, 3)


def topology(prim: Any, time: Any) -> tuple[AnyArray, AnyArray]:
    """Return the corners of each polygon, (k,) i4, and their vertices, (n,) i4.

    Args:
        prim: The mesh.
        time: Time code.
    """
    mesh = pxr().UsdGeom.Mesh(prim)
    counts = mesh.GetFaceVertexCountsAttr().Get(time)
    corners = mesh.GetFaceVertexIndicesAttr().Get(time)
    return (
        np.array([] if counts is None else counts, np.int32),
        np.array([] if corners is None else corners, np.int32),
    )


def topology_might_change(prim: Any) -> bool:
    """Return whether the polygons of a mesh have samples at several times."""
    mesh = pxr().UsdGeom.Mesh(prim)
    return any(
        attribute.ValueMightBeTimeVarying()
        for attribute in (mesh.GetFaceVertexCountsAttr(), mesh.GetFaceVertexIndicesAttr())
    )
