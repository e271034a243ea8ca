"""A scene of our own, resolved, checked and shown on a page that needs no network."""

import html
import io as text_io
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np

from izo_ref.app.files import FilePath, make_folder, replacing
from izo_ref.app.picture import draw
from izo_ref.base.arrays import AnyArray, AnyInts, Flags, Floats, Positions
from izo_ref.detection.intersections import find_intersections
from izo_ref.loop.iterate import Iteration
from izo_ref.loop.resolve import Result, resolve
from izo_ref.scene import Scene

# red, green and blue of the sphere, the sheet and the second sheet
COLORS = np.array([[150, 155, 160], [70, 125, 200], [235, 160, 60]])
CROSSING = np.array([210, 30, 45])  # color of faces that intersect
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


def write_demo(
    folder: FilePath, on_iteration: Callable[[Iteration], object] | None = None
) -> tuple[Result, Path]:
    """Resolve the scene and write the page.

    Args:
        folder: Folder to write `index.html`, two 3D views and two pictures to; it is created if
            there is none.
        on_iteration: Function that is called with the record of each iteration as it ends.

    Returns:
        The result, and the path of the page.

    Raises:
        FileFormatError: A file cannot be written.
    """
    folder = Path(folder)
    make_folder(folder)
    scene, face_body = demo_scene()
    result = resolve(scene, THICKNESS_M, on_iteration=on_iteration)
    crossing: dict[str, int] = {}
    for name, positions in (("before", scene.positions_t1), ("after", result.positions)):
        faces, crossing[name] = _crossing_faces(positions, scene)
        colors = np.where(faces[:, None], CROSSING, COLORS[face_body])
        with replacing(folder / f"{name}.png") as file:
            draw(positions, scene.faces, colors, file, frame=scene.positions_t1)
        with replacing(folder / f"{name}.html") as file:
            file.write(_view(positions, scene.faces, colors).encode())
    with replacing(folder / "index.html") as file:
        file.write(_page(scene, result, crossing).encode())
    return result, folder / "index.html"


def _crossing_faces(positions: Positions, scene: Scene) -> tuple[Flags, int]:
    """Find the faces that intersect at some positions.

    Returns:
        (m,) b1, faces in an intersection, and the number of edges that go through faces.
    """
    found = find_intersections(positions, scene.edges, scene.faces)
    hit = np.zeros(len(positions), bool)
    hit[found.pairs().nodes] = True
    return np.all(hit[scene.faces], axis=1), found.n_found


def _view(positions: Floats, faces: AnyInts, colors: AnyArray) -> str:
    """Return a page that shows the mesh in 3D, to be turned with the mouse; scripts are inside."""
    import trimesh
    from trimesh.viewer.notebook import scene_to_html

    bright = np.minimum(1.6 * colors, 255)  # because the light of the viewer is dim
    rgba = np.column_stack((bright, np.full(len(colors), 255))).astype(np.uint8)
    upright = positions[:, [0, 2, 1]] * (1.0, 1.0, -1.0)  # because y is up in the viewer
    mesh = trimesh.Trimesh(upright, faces, face_colors=rgba, process=False)
    scene = trimesh.Scene(mesh)
    rotation = trimesh.transformations.rotation_matrix
    turned = rotation(np.radians(25.0), (0, 1, 0)) @ rotation(np.radians(-28.0), (1, 0, 0))
    scene.camera_transform = scene.camera.look_at(upright, rotation=turned, distance=2.2)
    return scene_to_html(scene)


def _page(scene: Scene, result: Result, crossing: dict[str, int]) -> str:
    """Return the page with pictures, 3D views and tables."""
    c = result.certificate
    sizes = np.diff(result.zones.impact_offsets)
    gap = max((r.gap for r in result.residuals), default=0.0)
    violation = max((r.violation for r in result.residuals), default=0.0)
    done = [
        ("Triangles", f"{len(scene.faces):,}"),
        (
            "Vertices, and how many of them are pinned",
            f"{len(scene.pinned):,}, {int(scene.pinned.sum()):,}",
        ),
        ("Thickness", f"{1e3 * result.thickness:.4g} mm"),
        ("Edges through faces, before and after", f"{crossing['before']:,}, {crossing['after']:,}"),
        ("Impacts in zones", f"{len(result.impacts.toi):,}"),
        (
            "Zones, and impacts in the largest zone",
            f"{len(result.zones):,}, {sizes.max(initial=0):,}",
        ),
        ("Detections", f"{len(result.history)}"),
        ("Objective, sum m |x - y|² / sum m", f"{result.objective:.4e} m²"),
        ("Time", f"{result.timings['total']:.2f} s"),
    ]
    certified = [
        ("Status", result.status.name),
        ("Candidate pairs of the path", f"{c.candidates:,}"),
        ("Proved apart", f"{c.candidates - len(c.meeting_toi):,}"),
        ("Pairs decided by exact arithmetic", f"{c.exact:,}"),
        ("Largest relative duality gap of a zone", f"{gap:.1e}"),
        ("Largest violation, as a fraction of the thickness", f"{violation:.1e}"),
    ]
    return PAGE.format(
        meaning=html.escape(result.status.value), done=_table(done), certified=_table(certified)
    )


def _table(rows: Iterable[tuple[str, str]]) -> str:
    """Return the rows of a table in HTML."""
    out = text_io.StringIO()
    for name, value in rows:
        out.write(f"<tr><th>{html.escape(name)}</th><td>{html.escape(value)}</td></tr>\n")
    return out.getvalue()


PAGE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>izo_ref: a step, resolved and certified</title>
<style>
body {{ font: 16px/1.5 system-ui, sans-serif; color: #222; max-width: 1100px;
  margin: 0 auto; padding: 1rem; }}
.pair {{ display: grid; grid-template-columns: repeat(auto-fit, minmax(20rem, 1fr)); gap: 1rem; }}
figure {{ margin: 0; }}
figure img, iframe {{ width: 100%; border: 1px solid #ddd; box-sizing: border-box; }}
iframe {{ aspect-ratio: 3 / 2; }}
table {{ border-collapse: collapse; width: 100%; }}
th {{ text-align: left; font-weight: normal; color: #555; }}
td {{ text-align: right; font-variant-numeric: tabular-nums; }}
th, td {{ border-bottom: 1px solid #eee; padding: .25rem 0; }}
</style>
</head>
<body>
<h1>A step, resolved and certified</h1>
<p>A sheet falls onto a sphere and onto a second sheet. At the proposed end positions it goes
through both; the red faces intersect. The resolved positions are the closest ones, weighted by
mass, that the constraints of the impacts allow. The path from the start to them is proved free of
contact. {meaning}</p>
<div class="pair">
<figure><img src="before.png" alt="Proposed positions: the sheets and the sphere cross">
<figcaption>Proposed end positions</figcaption></figure>
<figure><img src="after.png" alt="Resolved positions: nothing crosses">
<figcaption>Resolved</figcaption></figure>
</div>
<h2>In 3D</h2>
<p>Turn the views with the mouse, and zoom with the wheel.</p>
<div class="pair">
<figure><iframe src="before.html" title="Proposed, in 3D"></iframe>
<figcaption>Proposed</figcaption></figure>
<figure><iframe src="after.html" title="Resolved, in 3D"></iframe>
<figcaption>Resolved</figcaption></figure>
</div>
<div class="pair">
<section><h2>What was done</h2><table>
{done}</table></section>
<section><h2>What is certified</h2><table>
{certified}</table></section>
</div>
<p>Made by <code>izo demo</code>.</p>
</body>
</html>
"""
