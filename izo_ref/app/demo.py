"""A scene of our own, resolved, checked and shown on a page that needs no network."""

import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from izo_ref.app.files import FilePath, make_folder, save_text
from izo_ref.app.view.model import Table, View
from izo_ref.app.view.of_result import history_table, zones_table
from izo_ref.app.view.of_step import (
    certificate_table,
    path_side,
    proposed_side,
    result_rows,
    scene_rows,
    view_of_sides,
)
from izo_ref.app.view.page import view_page
from izo_ref.base.arrays import AnyInts, Positions
from izo_ref.base.compile import anything_compiled
from izo_ref.detection.find import find_impacts
from izo_ref.detection.intersections import find_intersections
from izo_ref.loop.iterate import Iteration
from izo_ref.loop.resolve import Result, resolve
from izo_ref.scene import Scene

PARTS = ("sphere", "sheet", "second sheet")
CLOTH_KG_PER_M2 = 0.2
THICKNESS_M = 4e-3  # the thickness of a towel, so that the gap can be seen


def demo_scene() -> tuple[Scene, AnyInts]:
    """Make a scene: a sheet falls onto a pinned sphere and, beside it, onto a second sheet.

    Returns:
        A scene of 15,650 triangles, and (m,) i8, the body that each face belongs to: 0 is the
        sphere, 1 the sheet, 2 the second sheet.
    """
    sphere, sphere_faces = _sphere(0.3, 33, 64)
    sheet, sheet_faces = _sheet((-0.6, 0.6), (-0.6, 0.6), 0.31, 65)
    second, second_faces = _sheet((0.36, 1.06), (-0.35, 0.35), 0.265, 42)
    count = len(sphere), len(sheet), len(second)
    body = np.repeat([0, 1, 2], count)
    start = np.concatenate((sphere, sheet, second))
    faces = np.concatenate(
        (sphere_faces, sheet_faces + count[0], second_faces + count[0] + count[1])
    ).astype(np.int32)

    end = start.copy()
    x, y = sheet[:, 0], sheet[:, 1]
    # the sheet falls, faster toward its corners, and ripples
    end[body == 1, 2] -= 0.05 + 0.06 * (x**2 + y**2) + 0.006 * np.sin(17.0 * x + 5.0 * y)
    end[body == 2, 2] += 0.006 * np.cos(9.0 * second[:, 1])

    masses = np.full(len(start), 1.0)
    for number, area in ((1, 1.44), (2, 0.49)):
        masses[body == number] = CLOTH_KG_PER_M2 * area / count[number]
    face_body = body[faces[:, 0]]
    return Scene(start, end, faces, masses, body == 0), face_body


def _sheet(
    x_range: tuple[float, float], y_range: tuple[float, float], height: float, n: int
) -> tuple[Positions, AnyInts]:
    """Return n x n vertices, and faces that split each cell along alternating diagonals."""
    x, y = np.meshgrid(
        np.linspace(x_range[0], x_range[1], n),
        np.linspace(y_range[0], y_range[1], n),
        indexing="ij",
    )
    # half a millimetre of unevenness, as in cloth that was handled
    z = height + 5e-4 * np.sin(31.0 * x) * np.cos(27.0 * y)
    positions = np.column_stack((x.ravel(), y.ravel(), z.ravel()))
    i, j = np.divmod(np.arange((n - 1) ** 2), n - 1)
    a, b, c, d = i * n + j, (i + 1) * n + j, (i + 1) * n + j + 1, i * n + j + 1
    even = (i + j) % 2 == 0
    first = np.where(even[:, None], np.column_stack((a, b, c)), np.column_stack((a, b, d)))
    other = np.where(even[:, None], np.column_stack((a, c, d)), np.column_stack((b, c, d)))
    return positions, np.concatenate((first, other))


def _sphere(radius: float, rings: int, columns: int) -> tuple[Positions, AnyInts]:
    """Return rings of vertices between two poles, and the faces between them."""
    polar = np.linspace(0.0, np.pi, rings + 1)[1:-1, None]
    around = np.linspace(0.0, 2.0 * np.pi, columns, endpoint=False)[None, :]
    x, y = np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around)
    z = np.broadcast_to(np.cos(polar), x.shape)
    body = np.column_stack((x.ravel(), y.ravel(), z.ravel()))
    positions = radius * np.concatenate((body, [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]))
    i, j = np.divmod(np.arange((rings - 2) * columns), columns)
    a, b = i * columns + j, i * columns + (j + 1) % columns
    c, d = a + columns, b + columns
    j = np.arange(columns)
    k = (j + 1) % columns
    last = (rings - 2) * columns
    top = np.column_stack((np.full(columns, len(body)), j, k))
    bottom = np.column_stack((np.full(columns, len(body) + 1), last + k, last + j))
    bands = (np.column_stack((a, c, b)), np.column_stack((b, c, d)))
    return positions, np.concatenate((*bands, top, bottom))


class Demo(NamedTuple):
    """What the demo did.

    Attributes:
        result: The result.
        page: The page.
        was_compiled: Whether compiled code was there already, and had to be loaded only.
        preparing_s: Time for compiling, or for loading what was compiled [s].
        resolving_s: Time for resolving the step, once everything is compiled and loaded [s].
    """

    result: Result
    page: Path
    was_compiled: bool
    preparing_s: float
    resolving_s: float

    @property
    def preparing(self) -> str:
        """What was done before the step was resolved."""
        return "loading compiled code" if self.was_compiled else "compiling, only the first time"

    def lines(self) -> list[str]:
        """Return what the command says."""
        result = self.result
        return [
            f"{self.preparing}: {self.preparing_s:.1f} s",
            f"resolving: {self.resolving_s:.2f} s",
            f"{result.status.name}: {result.status.value}",
            f"page: {self.page}",
        ]


def write_demo(
    folder: FilePath,
    on_iteration: Callable[[Iteration], object] | None = None,
    prepare: Callable[[], object] = lambda: None,
) -> Demo:
    """Resolve the scene and write the page.

    The step is resolved twice: the first run compiles or loads what it calls, the second one is
    measured. So the page says what a step takes in a program that has run one before.

    Args:
        folder: Folder to write `index.html` to; it is created if there is none.
        on_iteration: Function that is called with the record of each iteration as it ends.
        prepare: Function that compiles, before the first run.

    Returns:
        What was done.

    Raises:
        FileFormatError: The file cannot be written.
    """
    folder = Path(folder)
    make_folder(folder)
    was_compiled, begin = anything_compiled(), time.perf_counter()
    prepare()  # before anything is compiled, so that it can be compiled by two processes
    scene, _ = demo_scene()
    resolve(scene, THICKNESS_M)
    preparing = time.perf_counter() - begin
    begin = time.perf_counter()
    result = resolve(scene, THICKNESS_M, on_iteration=on_iteration)
    done = Demo(result, folder / "index.html", was_compiled, preparing, time.perf_counter() - begin)
    save_text(done.page, view_page(_view(scene, done)))
    return done


def _view(scene: Scene, done: Demo) -> View:
    """Return what the page shows."""
    result, impacts = done.result, find_impacts(scene)
    sides = [
        proposed_side(scene, impacts),
        path_side("Resolved", scene, result.positions, result.certificate),
    ]
    crossing = [
        find_intersections(positions, scene.edges, scene.faces).n_found
        for positions in (scene.positions_t1, result.positions)
    ]
    step = [
        *scene_rows(scene, impacts),
        ("Edges through faces, before and after", f"{crossing[0]:,}, {crossing[1]:,}"),
        *result_rows(scene, result.positions, result.thickness),
        (f"Time for {done.preparing}", f"{done.preparing_s:.1f} s"),
        ("Time for resolving", f"{done.resolving_s:.2f} s"),
    ]
    tables = [
        Table("The step", (), step),
        certificate_table(result.certificate),
        zones_table(result),
        history_table(result),
    ]
    return view_of_sides(
        title="A sheet falls onto a sphere and onto a second sheet",
        scene=scene,
        sides=sides,
        in_zones=result.impacts,
        verdict=f"{result.status.name}: {result.status.value}",
        passed=result.certificate.free,
        tables=tables,
        parts=PARTS,
    )
