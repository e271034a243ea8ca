"""Views to make pages of: small meshes, steps with known pairs, animations with known crossings."""

import json
import re

import numpy as np

from izo_ref.app.view.model import Side, View, no_pairs
from izo_ref.app.view.pack import unpack
from izo_ref.app.view.page import view_page

TRIANGLE = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])


def view_of(sides, **changes):
    """Return a view of positions of frames; `sides` is a list for each side."""
    n = len(sides[0][0])
    names = "Proposed", "Resolved"
    made = [
        Side(
            name=name,
            positions=[np.asarray(positions, float) for positions in frames],
            pairs=[no_pairs() for _ in frames],
            n_pairs=[0] * len(frames),
        )
        for name, frames in zip(names, sides, strict=False)
    ]
    fields = {
        "title": "a view",
        "verdict": "It is free.",
        "passed": True,
        "is_step": False,
        "faces": np.arange(n - n % 3, dtype=np.int32).reshape(-1, 3),
        "parts": ["all"],
        "part_of": np.zeros(n, np.int32),
        "pinned": np.zeros(n, bool),
        "zone_of": None,
        "frames": list(range(len(sides[0]))),
        "sides": made,
    }
    return View(**fields | changes)


def content_of(page):
    """Return the JSON that a page holds."""
    pattern = r'<script type="application/json" id="data">(.*?)</script>'
    return json.loads(re.search(pattern, page, re.DOTALL)[1])


def positions_of(content, centre):
    """Unpack the positions of each frame of each side, in the unit of the file.

    Args:
        content: What `content_of` returned.
        centre: (3,), middle of the box about all positions, to which they are relative.
    """
    sides, other = [], None
    for side in content["sides"]:
        whole = []
        for i, text in enumerate(side["positions"]):
            base = (whole[i - 1] if i else None) if other is None else other[i]
            whole.append(unpack(text, 3, base))
        other = whole
        scale = content["radius"] / content["steps"]
        sides.append([centre + scale * numbers for numbers in whole])
    return sides


def dipping_sheet(n_frames=6):
    """Return frames and faces: a triangle goes down through a larger one and stays below it.

    It is above in frames 0 to 2, and its corner is below the larger one from frame 3 on.
    """
    floor = np.array([[-4.0, -4, 0], [5, -4, 0], [0, 6, 0]])
    above = np.array([[0.0, 0, 1], [1, 0, 2], [0, 1, 2]])
    frames = [np.concatenate((floor, above - (0, 0, 0.35 * number))) for number in range(n_frames)]
    return np.array(frames), np.array([[0, 1, 2], [3, 4, 5]], np.int32)


def write_page(folder, view):
    """Write the page of a view, and return the file."""
    page = folder / "page.html"
    page.write_text(view_page(view), encoding="utf-8")
    return page
