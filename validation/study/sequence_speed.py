"""How many frames a second a sequence takes, by triangles and by how much of it is in contact."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np

from izo_ref import resolve_sequence
from validation.rows import Row, Rows
from validation.scenes.moving_garment import FIRST_CONTACT, moving_garment
from validation.study.parts import Say
from validation.study.timing import spread, thread_counts, threads

KEYS = ("triangles", "contact", "threads")
SEED = 22
SIZES = (5_000, 20_000, 80_000)
# Layers of cloth, and the part of the way around the body that goes in.
CONTACTS = {"light": (1, 0.1), "heavy": (3, 1.0)}
TIMED = 6  # frames; the first one in contact is not timed, since all impacts of the garment begin
WARM_UP = 1_500  # triangles of a garment that is resolved before, which compiles


def speed(folder: Path, say: Say) -> None:
    """Add the missing rows: a row for each size and contact, and one for compiling."""
    rows = Rows(folder, "speed", KEYS)
    count = thread_counts()[-1]
    missing = [
        (size, contact)
        for size in SIZES
        for contact in CONTACTS
        if not rows.has(triangles=size, contact=contact, threads=count)
    ]
    if not missing:
        return
    begin = time.perf_counter()
    for contact in CONTACTS:
        speed_row(WARM_UP, contact, count, 1)
    first_s = time.perf_counter() - begin
    for size, contact in missing:
        row = speed_row(size, contact, count, TIMED)
        rows.add(triangles=size, contact=contact, threads=count, first_s=first_s, **row)
        say(f"speed: {size} triangles, {contact}: {row['frames_per_s']:.3g} frames a second")


def speed_row(n_triangles: int, contact: str, n_threads: int, n_timed: int) -> Row:
    """Time the frames of a garment that is in contact.

    Args:
        n_triangles: Triangles of the garment and the body, about.
        contact: One of CONTACTS.
        n_threads: Number of threads.
        n_timed: Number of frames whose times are taken.
    """
    layers, pressed = CONTACTS[contact]
    n_frames = FIRST_CONTACT + 1 + n_timed
    rng = np.random.default_rng([SEED, n_triangles])
    moving = moving_garment(rng, n_frames, n_triangles, layers, pressed)
    frames = iter(moving.positions[FIRST_CONTACT - 1 :])
    seconds, impacts, statuses = [], [], []
    with threads(n_threads):
        resolved = resolve_sequence(frames, moving.faces, None, moving.pinned_vertices)
        next(resolved)  # the start
        next(resolved)  # where contact begins
        for _ in range(n_timed):
            begin = time.perf_counter()
            frame = next(resolved)
            seconds.append(time.perf_counter() - begin)
            impacts.append(frame.impacts)
            statuses.append(frame.status.name)
    return {
        "own_triangles": len(moving.faces),
        "impacts": float(np.median(impacts)),
        "statuses": " ".join(sorted(set(statuses))),
        "frames_per_s": 1.0 / float(np.median(seconds)),
        **spread(seconds),
    }
