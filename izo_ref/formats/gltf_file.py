"""Read the JSON and the bytes of .gltf and .glb files, and write them with other bytes."""

from __future__ import annotations

import base64
import hashlib
import json
import os
import shutil
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple
from urllib.parse import quote, unquote

from izo_ref.base.errors import FileFormatError
from izo_ref.base.input_files import LARGEST_TEXT, open_input, read_bytes
from izo_ref.formats.gltf_json import item, many, whole

MAGIC, JSON_CHUNK, BINARY_CHUNK = b"glTF", b"JSON", b"BIN\0"
DATA = "data:"
PIECE = 1 << 20  # bytes that are copied at once


class Buffer(NamedTuple):
    """Bytes that accessors lie in.

    Attributes:
        path: The file that they are in; None if the JSON holds them.
        begin: Where they begin in the file.
        size: Number of bytes.
        content: The bytes, if the JSON holds them.
    """

    path: Path | None
    begin: int
    size: int
    content: bytes


class GltfFile:
    """A .gltf or .glb file with its buffers.

    Bytes are read when they are asked for, unless the JSON holds them.

    Attributes:
        path: The file.
        document: Its JSON.
        buffers: Its buffers.
        paths: All files that are read.
    """

    def __init__(self, path: Path) -> None:
        """Read the JSON, and find the buffers.

        Args:
            path: The file.

        Raises:
            FileFormatError: It cannot be read, or declares more bytes than there are.
        """
        self.path = path
        self._is_binary = path.suffix.lower() == ".glb"
        self._binary = Buffer(path, 0, 0, b"")  # the chunk of a .glb file
        self._text = self._read_chunks() if self._is_binary else read_bytes(path)
        self.document = self._parse()
        self.buffers = [self._buffer(k) for k in range(len(many(self.document, "buffers")))]
        named = {buffer.path for buffer in self.buffers if buffer.path is not None}
        self.paths = sorted({path, *named})

    def read(self, buffer: int, begin: int, size: int) -> bytes:
        """Return bytes of a buffer.

        Args:
            buffer: Its number.
            begin: Where they begin.
            size: How many; `begin + size` is within the buffer.

        Raises:
            FileFormatError: The file is shorter than it was.
        """
        own = self.buffers[buffer]
        if own.path is None:
            return own.content[begin : begin + size]
        with open_input(own.path) as file:
            file.seek(own.begin + begin)
            content = file.read(size)
        if len(content) != size:
            raise FileFormatError(f"{own.path}: expected {size} bytes, found {len(content)}")
        return content

    def copy_buffer(self, buffer: int, path: str) -> None:
        """Copy a buffer into a file of its own.

        Args:
            buffer: Its number.
            path: The file to write.
        """
        own = self.buffers[buffer]
        with open(path, "wb") as copy:
            if own.path is None:
                copy.write(own.content)
                return
            with open_input(own.path) as file:
                file.seek(own.begin)
                _copy(file, copy, own.size)

    def write(self, path: str, stem: str, document: Any, buffers: dict[int, str]) -> list[str]:
        """Write the file.

        Args:
            path: Where to write.
            stem: How the names of new .bin files begin.
            document: The JSON; the text that was read is kept if it says the same.
            buffers: Files with the content of the buffers that have changed.

        Returns:
            Names of the new .bin files, beside the file.
        """
        names = []
        for number, changed in sorted(buffers.items()):
            own = document["buffers"][number]
            if own.get("uri", "").startswith(DATA):
                head = own["uri"].partition(",")[0]
                content = base64.b64encode(Path(changed).read_bytes()).decode()
                own["uri"] = f"{head},{content}"
            elif "uri" in own:
                # a new name, so that the file that is there fits its buffer until it is replaced
                names.append(f"{stem}.{_digest(changed)}.bin")
                own["uri"] = quote(names[-1])
                os.replace(changed, os.path.join(os.path.dirname(path), names[-1]))
        indent = 2 if b"\n" in self._text and not self._is_binary else None
        new = json.dumps(document, indent=indent).encode()
        text = self._text if document == self.document else new
        with open(path, "wb") as file:
            if self._is_binary:
                self._write_chunks(file, text, buffers.get(0))
            else:
                file.write(text)
        return names

    def _read_chunks(self) -> bytes:
        """Find the chunks of a .glb file, and return the JSON."""
        with open_input(self.path) as file:
            n_bytes = os.fstat(file.fileno()).st_size
            head = file.read(12)
            if len(head) < 12 or head[:4] != MAGIC:
                raise FileFormatError(f"{self.path}: expected a .glb file, found {head[:4]!r}")
            version, length = struct.unpack("<II", head[4:])
            if version != 2 or length > n_bytes:
                raise FileFormatError(
                    f"{self.path}: expected version 2 with {n_bytes} bytes, found version "
                    f"{version} with {length}"
                )
            chunks = list(self._chunks(file, length))
            if not chunks or chunks[0][0] != JSON_CHUNK or chunks[0][2] > LARGEST_TEXT:
                raise FileFormatError(f"{self.path}: expected a chunk with JSON first")
            if len(chunks) > 1 and chunks[1][0] == BINARY_CHUNK:
                self._binary = Buffer(self.path, *chunks[1][1:], b"")
            if len(chunks) > 2:
                raise FileFormatError(f"{self.path}: expected at most two chunks")
            file.seek(chunks[0][1])
            return file.read(chunks[0][2])

    def _chunks(self, file: BinaryIO, length: int) -> Iterator[tuple[bytes, int, int]]:
        """Yield the kind, the begin and the size of each chunk."""
        begin = 12
        while begin + 8 <= length:
            file.seek(begin)
            size, kind = struct.unpack("<I4s", file.read(8))
            begin += 8
            if size > length - begin:
                raise FileFormatError(
                    f"{self.path}: expected {size} bytes in a chunk, found {length - begin}"
                )
            yield kind, begin, size
            begin += size

    def _parse(self) -> Any:
        def refuse(word: str) -> None:
            raise ValueError(f"{word} is no number of JSON")

        try:
            document = json.loads(self._text.decode("utf-8"), parse_constant=refuse)
        except (ValueError, RecursionError) as error:
            raise FileFormatError(f"{self.path}: expected JSON: {error}") from None
        if not isinstance(document, dict) or not isinstance(document.get("asset"), dict):
            raise FileFormatError(f"{self.path}: expected an object with `asset`")
        if document["asset"].get("version") != "2.0":
            found = document["asset"].get("version")
            raise FileFormatError(f"{self.path}: expected glTF 2.0, found version {found!r}")
        return document

    def _buffer(self, number: int) -> Buffer:
        own = item(self.document, "buffers", number)
        size, uri = whole(own, "byteLength"), own.get("uri")
        if uri is None and number == 0 and self._is_binary:
            found = self._binary
        elif isinstance(uri, str) and uri.startswith(DATA):
            content = base64.b64decode(uri.partition(",")[2], validate=True)
            found = Buffer(None, 0, len(content), content)
        elif isinstance(uri, str) and "://" not in uri and not os.path.isabs(unquote(uri)):
            path = self.path.parent / unquote(uri)
            with open_input(path) as file:
                found = Buffer(path, 0, os.fstat(file.fileno()).st_size, b"")
        else:
            raise FileFormatError(
                f"{self.path}: buffer {number}: expected a file beside it, found {uri!r}"
            )
        if size > found.size:
            raise FileFormatError(
                f"{self.path}: buffer {number}: expected {size} bytes, found {found.size}"
            )
        return found

    def _write_chunks(self, file: BinaryIO, text: bytes, changed: str | None) -> None:
        text += b" " * (-len(text) % 4)
        binary = self._binary
        length = 12 + 8 + len(text) + (8 + binary.size if binary.begin else 0)
        file.write(MAGIC + struct.pack("<II", 2, length))
        file.write(struct.pack("<I4s", len(text), JSON_CHUNK) + text)
        if binary.begin:
            file.write(struct.pack("<I4s", binary.size, BINARY_CHUNK))
            if changed is not None:
                with open(changed, "rb") as content:
                    shutil.copyfileobj(content, file, PIECE)
            else:
                with open_input(self.path) as content:
                    content.seek(binary.begin)
                    _copy(content, file, binary.size)


def _copy(source: BinaryIO, target: BinaryIO, size: int) -> None:
    while size:
        piece = source.read(min(size, PIECE))
        if not piece:
            raise FileFormatError(f"{source.name}: expected {size} bytes more")
        target.write(piece)
        size -= len(piece)


def _digest(path: str) -> str:
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()[:8]
