"""Damaged copies of a file, as transfers, full disks and hostile senders make them."""

import re

import numpy as np

NUMBER = re.compile(rb"\d+(?:\.\d+)?")
NUMBERS = (b"0", b"-1", b"1", b"3", b"1e39", b"nan", b"inf", b"2147483648", b"99999999999999999999")


def damaged(content, rng):
    """Return a copy of bytes with one to four damages.

    Args:
        content: Bytes of a file that can be read.
        rng: Source of random numbers.
    """
    content = bytearray(content)
    for _ in range(rng.integers(1, 5)):
        rng.choice([_flip_bits, _cut, _swap, _overwrite, _change_number])(content, rng)
    return bytes(content)


def _place(content, rng):
    return int(rng.integers(max(1, len(content))))


def _flip_bits(content, rng):
    for _ in range(rng.integers(1, 4)):
        if content:
            content[_place(content, rng)] ^= 1 << int(rng.integers(8))


def _cut(content, rng):
    begin = _place(content, rng)
    length = len(content) if rng.integers(3) == 0 else int(rng.integers(1, 40))
    del content[begin : begin + length]


def _swap(content, rng):
    width = int(rng.choice([1, 4, 8]))
    first, second = _place(content, rng), _place(content, rng)
    one, other = bytes(content[first : first + width]), bytes(content[second : second + width])
    if len(one) == len(other):
        content[first : first + width], content[second : second + width] = other, one


def _overwrite(content, rng):
    values = np.array([0, -1, 1, 2**31 - 1, 2**62, np.nan, np.inf])
    kind = rng.choice(["<u1", "<i4", "<i8", "<f4"])
    with np.errstate(all="ignore"):
        new = values.astype("f8")[rng.integers(len(values))].astype(kind).tobytes()
    begin = _place(content, rng)
    content[begin : begin + len(new)] = new


def _change_number(content, rng):
    found = list(NUMBER.finditer(content))
    if found:
        match = found[rng.integers(len(found))]
        content[match.start() : match.end()] = NUMBERS[rng.integers(len(NUMBERS))]
