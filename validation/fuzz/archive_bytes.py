"""Archives and arrays in bytes, with whatever their records and headers declare."""

import io
import struct
import zlib
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np


class Member(NamedTuple):
    """An array in a zip archive, with whatever its records declare.

    Attributes:
        name: Name of the file.
        data: Its bytes.
        method: 0 stored, 8 deflated; others are declared only.
        flags: Flags of its records.
        size: Declared size; the true one if None.
        packed: Declared compressed size; the true one if None.
        crc: Declared checksum; the true one if None.
        local: Name in the local record; the same if None.
    """

    name: str
    data: bytes
    method: int = 8
    flags: int = 0
    size: int | None = None
    packed: int | None = None
    crc: int | None = None
    local: str | None = None


@lru_cache(64)
def _packed(data: bytes) -> tuple[bytes, int]:
    """Return bytes compressed as in an archive, and their checksum."""
    packer = zlib.compressobj(6, zlib.DEFLATED, -15)
    return packer.compress(data) + packer.flush(), zlib.crc32(data)


def zip_bytes(members: list[Member], shared: bool = False) -> bytes:
    """Return an archive; with `shared`, all members point at the bytes of the first one."""
    out, central, first = bytearray(), bytearray(), None
    for member in members:
        deflated, true_crc = _packed(member.data)
        data = deflated if member.method == 8 else member.data
        size = len(member.data) if member.size is None else member.size
        packed = len(data) if member.packed is None else member.packed
        crc = true_crc if member.crc is None else member.crc
        name = member.name.encode()
        local = name if member.local is None else member.local.encode()
        offset = len(out) if first is None or not shared else first
        extra = b""
        if max(size, packed) >= 2**32 - 1:
            extra = struct.pack("<HHQQ", 1, 16, size, packed)
            size = packed = 2**32 - 1
        head = struct.pack(
            "<HHHHHIIIHH",
            45,
            member.flags,
            member.method,
            0,
            33,
            crc,
            packed,
            size,
            len(local),
            len(extra),
        )
        if first is None or not shared:
            first = offset
            out += b"PK\x03\x04" + head + local + extra + data
        head = head[:22] + struct.pack("<HH", len(name), len(extra))
        central += b"PK\x01\x02" + struct.pack("<H", 45) + head
        central += struct.pack("<HHHII", 0, 0, 0, 0, offset) + name + extra
    end = struct.pack("<HHHHIIH", 0, 0, *(2 * [len(members) % 2**16]), len(central), len(out), 0)
    return bytes(out + central) + b"PK\x05\x06" + end


def npy(
    descr: str, shape: str, data: bytes, order: str = "False", version: tuple[int, int] = (1, 0)
) -> bytes:
    """Return a file of numpy with any texts in its header."""
    text = f"{{'descr': {descr}, 'fortran_order': {order}, 'shape': {shape}, }}\n".encode()
    length = struct.pack("<H" if version[0] == 1 else "<I", len(text))
    return b"\x93NUMPY" + bytes(version) + length + text + data


def array_bytes(array: Any) -> bytes:
    """Return an array as numpy writes it."""
    out = io.BytesIO()
    np.lib.format.write_array(out, np.asarray(array), allow_pickle=False)
    return out.getvalue()


def members_of(arrays: dict[str, Any], method: int = 8) -> dict[str, Member]:
    """Return arrays as members of an archive."""
    return {n: Member(f"{n}.npy", array_bytes(a), method) for n, a in arrays.items()}
