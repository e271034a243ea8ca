"""An animation and the obstacle that moves in it, as commands read them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from izo_ref.base.arrays import Faces, Flags, Positions
from izo_ref.base.errors import OptionError, ShapeError
from izo_ref.formats.animation import Animation, open_animation, triangles


class AnimationInput:
    """The frames of an animation, with those of an obstacle behind them.

    Attributes:
        own: The animation.
        obstacle: The obstacle, or None. Its vertices come behind those of the animation.
        n_own: Number of vertices of the animation.
        first: Number of the first frame that is asked for.
        last: Number of the last one.
    """

    def __init__(
        self,
        own: Animation,
        obstacle: str | None = None,
        pins: Sequence[str] = (),
        start: int | None = None,
        stop: int | None = None,
    ) -> None:
        """Open the obstacle, and check that everything fits together.

        Args:
            own: The animation.
            obstacle: Path of an animation or a mesh that moves as it is; None if there is none.
            pins: Names of meshes of the animation that move as they are.
            start: Number of the first frame that is asked for; None for the first one.
            stop: Number of the last one; None for the last one.

        Raises:
            FileFormatError: The obstacle cannot be read.
            OptionError: A mesh to pin or a frame does not exist.
            ShapeError: The obstacle has another number of frames.
        """
        self.own, self._pins = own, tuple(pins)
        self.obstacle = None if obstacle is None else open_animation(obstacle)
        self.n_own = sum(mesh.n_vertices for mesh in own.meshes)
        self.first, self.last = self._range(start, stop)
        self._check_pins()

    def _range(self, start: int | None, stop: int | None) -> tuple[int, int]:
        n = self.own.n_frames
        first, last = 0 if start is None else start, n - 1 if stop is None else stop
        if not 0 <= first <= last < n:
            raise OptionError(
                f"expected --start and --stop from 0 to {n - 1}, the first no larger than the "
                f"second; found {first} and {last}"
            )
        obstacle = self.obstacle
        if obstacle is not None and obstacle.n_frames not in (1, n):
            raise ShapeError(
                f"{obstacle.path}: expected one frame or {n}, as many as {self.own.path} has; "
                f"found {obstacle.n_frames}"
            )
        return first, last

    def _check_pins(self) -> None:
        names = {mesh.name for mesh in self.own.meshes}
        unknown = sorted({*self._pins} - names)
        if unknown:
            raise OptionError(
                f"--pin: expected names of meshes, which are {', '.join(sorted(names))}; found "
                f"{unknown[0]}"
            )

    def faces(self) -> Faces:
        """Return the triangles of the animation and of the obstacle, (m, 3) i4."""
        own = triangles(self.own.meshes)
        if self.obstacle is None:
            return own
        return np.concatenate((own, triangles(self.obstacle.meshes) + np.int32(self.n_own)))

    def pinned(self) -> Flags:
        """Return which vertices move as they are, (n,) b1: of named meshes and of the obstacle."""
        pinned = np.zeros(self.n_own, bool)
        for mesh in self.own.meshes:
            if mesh.name in self._pins:
                pinned[mesh.first : mesh.first + mesh.n_vertices] = True
        if self.obstacle is None:
            return pinned
        n = sum(mesh.n_vertices for mesh in self.obstacle.meshes)
        return np.concatenate((pinned, np.ones(n, bool)))

    def frame(self, number: int) -> Positions:
        """Read a frame, with the obstacle, (n, 3) [m].

        Args:
            number: From 0 on.
        """
        own: Any = self.own.frame(number)
        if self.obstacle is None:
            return own
        other = self.obstacle.frame(min(number, self.obstacle.n_frames - 1))
        return np.concatenate((own, other))

    def frames(self, first: int | None = None) -> Iterator[Positions]:
        """Read the frames that are asked for, one after the other.

        Args:
            first: Number of the first one, if it is not that of the input.
        """
        return map(self.frame, range(self.first if first is None else first, self.last + 1))
