"""Damage files at random, and check that a reader refuses them or reads them whole."""

import os
import random
import re
import time
import warnings

import numpy as np

from izo_ref.base.errors import FileFormatError

SEED = int(os.environ.get("IZO_FORMATS_SEED", "20261129"))
COUNT = int(os.environ.get("IZO_FORMATS_COUNT", "300"))
MOST_SECONDS = 5.0
NUMBERS = (b"0", b"-1", b"1e999", b"nan", b"99999999999", b"2147483648", b"1_0", b"0x10", b"")


def mutated(content, dice):
    """Return damaged bytes: flipped, cut, doubled, exchanged, or with another number in a text."""
    content = bytearray(content)
    for _ in range(dice.choice((1, 1, 1, 2, 5))):
        # the beginning of a file, where the counts are, is hit as often as all the rest
        reach = dice.choice((40, 400, len(content))) or 1
        at = min(dice.randrange(reach), max(0, len(content) - 1))
        way = dice.randrange(7)
        if way == 0 and content:
            content[at] ^= 1 << dice.randrange(8)
        elif way == 1 and content:
            content[at] = dice.choice((0, 1, 9, 10, 13, 32, 45, 127, 128, 255))
        elif way == 2:
            del content[dice.randrange(len(content) + 1) :]
        elif way == 3:
            del content[at : at + dice.choice((1, 4, 12, 100))]
        elif way == 4:
            content[at:at] = content[at : at + dice.choice((1, 4, 12, 100))]
        elif way == 5:
            content[at : at + 4] = dice.randbytes(4)
        else:
            found = [match.span() for match in re.finditer(rb"-?\d[\d.]*", bytes(content))]
            if found:
                begin, end = dice.choice(found)
                content[begin:end] = dice.choice(NUMBERS)
    return bytes(content)


def read_all(read, path):
    """Open an animation and read all its frames; return the error that refused it, or None."""
    try:
        animation = read(path)
        assert animation.n_frames >= 1
        n_vertices = sum(mesh.n_vertices for mesh in animation.meshes)
        for mesh in animation.meshes:
            assert mesh.counts.sum() == len(mesh.corners)
            assert ((mesh.corners >= 0) & (mesh.corners < mesh.n_vertices)).all()
        for number in range(animation.n_frames):
            positions = animation.frame(number)
            assert positions.dtype == np.float64
            assert positions.shape == (n_vertices, 3)
            assert np.isfinite(positions).all()
    except FileFormatError as error:
        return error
    return None


def check_copy(read, path):
    """Write a file with the positions that were read, and compare all bytes."""
    animation, copy = read(path), path.with_stem("copy")
    animation.write(copy, map(animation.frame, range(animation.n_frames)))
    assert copy.read_bytes() == path.read_bytes()


def check_mutations(contents, path, read, n_copies=0, count=COUNT, seed=SEED):
    """Damage files, one after the other, and read each.

    Args:
        contents: The bytes of whole files.
        path: Where to write the damaged ones.
        read: Opens an animation.
        n_copies: How many of those that are read are also written, to the same bytes.
        count: Number of damaged files.
        seed: Of the random damage.

    Returns:
        How many were refused, how many were read, and the longest time in seconds.
    """
    print(f"IZO_FORMATS_SEED={seed} IZO_FORMATS_COUNT={count}")
    dice, refused, longest = random.Random(seed), 0, 0.0
    for number in range(count):
        damaged = mutated(dice.choice(contents), dice)
        path.write_bytes(damaged)
        begin = time.perf_counter()
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            try:
                error = read_all(read, path)
            except BaseException:
                print(f"file {number}: {damaged[:2000]!r}")
                raise
        longest = max(longest, time.perf_counter() - begin)
        refused += error is not None
        assert error is None or str(path.parent) in str(error), error
        if error is None and n_copies > 0:
            n_copies -= 1
            check_copy(read, path)
    assert longest < MOST_SECONDS
    print(f"{refused} refused, {count - refused} read, the longest took {longest:.3f} s")
    return refused, count - refused, longest
