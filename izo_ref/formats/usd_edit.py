"""Change the points of meshes in a copy of a USD stage."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from izo_ref.base.arrays import AnyArray, Floats
from izo_ref.formats.usd_library import pxr


class Edit:
    """A copy of a stage in one layer, of which nothing is on disk yet.

    Values come from the original; a mesh has samples of its own only once it changes.
    """

    def __init__(self, stage: Any, names: Sequence[str], times: Floats) -> None:
        """Copy a stage.

        Args:
            stage: The original.
            names: Paths of the meshes.
            times: (n,) f8, time codes; one NaN for the default time.
        """
        layers = [layer for layer in stage.GetUsedLayers() if layer != stage.GetSessionLayer()]
        is_composed = any(prim.GetPrimIndex().rootNode.children for prim in stage.Traverse())
        if len(layers) == 1 and not is_composed:
            layer = pxr().Sdf.Layer.CreateAnonymous(".usda")
            layer.TransferContent(stage.GetRootLayer())
        else:
            layer = stage.Flatten(addSourceFileComment=False)
        self._stage = pxr().Usd.Stage.Open(layer)
        self._meshes = [pxr().UsdGeom.Mesh(self._stage.GetPrimAtPath(name)) for name in names]
        self._times = times
        self._changed: set[int] = set()

    def begin(self, k: int, number: int, old: Callable[[int], AnyArray]) -> None:
        """Give a mesh samples of its own in all frames before one, unless it has them.

        Args:
            k: Number of the mesh.
            number: Number of the frame in which it changes.
            old: Returns the points of a frame before, (n, 3) f4.
        """
        if k in self._changed:
            return
        self._changed.add(k)
        for before in range(number):
            self.put(k, before, old(before))
        self._forget_hints(k)

    def put(self, k: int, number: int, points: AnyArray) -> None:
        """Set the points of a mesh that has changed; leave any other one as it is.

        Args:
            k: Number of the mesh.
            number: Number of the frame.
            points: (n, 3) f4, in the space of the mesh.
        """
        if k not in self._changed:
            return
        mesh, time = self._meshes[k], self._time(number)
        value = pxr().Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(points))
        mesh.GetPointsAttr().Set(value, time)
        if mesh.GetExtentAttr().HasAuthoredValue():
            mesh.GetExtentAttr().Set(pxr().UsdGeom.PointBased.ComputeExtent(value), time)

    def end_at(self, last: int) -> None:
        """Delete the samples of points and transforms after a frame, and let the stage end there.

        Args:
            last: Number of the last frame that stays.
        """
        if last == len(self._times) - 1:
            return
        end = self._times[last]
        for mesh in self._meshes:
            self._cut(mesh.GetPointsAttr(), end)
            self._cut(mesh.GetExtentAttr(), end)
            prim = mesh.GetPrim()
            while not prim.IsPseudoRoot():
                if pxr().UsdGeom.Xformable(prim):
                    for step in pxr().UsdGeom.Xformable(prim).GetOrderedXformOps():
                        self._cut(step.GetAttr(), end)
                prim = prim.GetParent()
        if self._stage.HasAuthoredTimeCodeRange() and self._stage.GetEndTimeCode() > end:
            self._stage.SetEndTimeCode(end)

    def export(self, path: str, encoding: str) -> None:
        """Write the copy.

        Args:
            path: The file.
            encoding: `usda` or `usdc`; only a .usd file can be either.

        Raises:
            OSError: It cannot be written.
        """
        arguments = {"format": encoding} if path.endswith(".usd") else {}
        if not self._stage.GetRootLayer().Export(path, "", arguments):
            raise OSError("USD failed to write it")

    def _time(self, number: int) -> Any:
        time = self._times[number]
        return pxr().Usd.TimeCode.Default() if np.isnan(time) else pxr().Usd.TimeCode(time)

    def _cut(self, attribute: Any, end: float) -> None:
        times = attribute.GetTimeSamples()
        if times and times[-1] > end and end not in times:  # what it was between two samples
            attribute.Set(attribute.Get(end), end)
        for time in times:
            if time > end:
                attribute.ClearAtTime(time)

    def _forget_hints(self, k: int) -> None:
        prim = self._meshes[k].GetPrim()
        while not prim.IsPseudoRoot():
            if prim.GetAttribute("extentsHint").HasAuthoredValue():
                prim.RemoveProperty("extentsHint")
            prim = prim.GetParent()
