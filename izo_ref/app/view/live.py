"""The view in a window of polyscope, where that is installed."""

from __future__ import annotations

from importlib import import_module
from typing import Any

import numpy as np

from izo_ref.app.view.model import View
from izo_ref.base.errors import OptionError

GAP = 1.1  # distance of the two meshes over the width of one


def show_live(view: View) -> None:
    """Show a view in a window until it is closed; a slider chooses the frame.

    Args:
        view: What to show.

    Raises:
        OptionError: polyscope is not installed.
    """
    polyscope = _polyscope()
    polyscope.init()
    polyscope.set_up_dir(f"{view.up}_up")
    width = float(np.ptp(view.sides[0].positions[0][:, 0], axis=0)) if len(view.pinned) else 0.0
    meshes = []
    for i, side in enumerate(view.sides):
        mesh = polyscope.register_surface_mesh(side.name, side.positions[-1], view.faces)
        mesh.translate((GAP * width * i, 0.0, 0.0))
        mesh.add_scalar_quantity("part", view.part_of, datatype="categorical", enabled=True)
        mesh.add_scalar_quantity("pinned", view.pinned.astype(float))
        if view.zone_of is not None:
            mesh.add_scalar_quantity("zone", view.zone_of, datatype="categorical")
        meshes.append(mesh)
    chosen = len(view.frames) - 1

    def choose() -> None:
        nonlocal chosen
        changed, chosen = polyscope.imgui.SliderInt("frame", chosen, 0, len(view.frames) - 1)
        if changed:
            for side, mesh in zip(view.sides, meshes, strict=True):
                mesh.update_vertex_positions(side.positions[chosen])

    polyscope.set_user_callback(choose)
    polyscope.show()


def _polyscope() -> Any:
    try:
        return import_module("polyscope")
    except ImportError:
        raise OptionError(
            "--live needs the package polyscope: pip install polyscope; without it, open the page "
            "that `izo view` writes in a browser"
        ) from None
