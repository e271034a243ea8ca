"""Read arrays of files that users name: an .npz archive, or one .npy file.

A hostile file can declare any size, name an array twice, or repeat one part of itself a thousand
times. So each declared size is compared with the bytes that are there before memory is taken:

* A file has at least as many bytes as its compressed arrays have in all. So arrays that share their
  bytes are refused.
* Deflate, the compression of numpy, makes at most 1032 bytes of one byte. So an archive never takes
  more than 1032 times its own size, and an array that declares more is refused.
* An array has exactly the bytes that shape and type ask for, and its checksum is right.
* The end of an archive says how many arrays there are, and there are as many.
* The list of contents has at most `LARGEST_LIST` bytes, which is some 30,000 arrays.

Only the arrays that are asked for are read. Nothing is ever unpickled.
"""

from __future__ import annotations

import os
import zipfile
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from typing import Any, BinaryIO, cast

from izo_ref.base.archive_list import Bounded, declared_count
from izo_ref.base.errors import FileFormatError
from izo_ref.base.input_files import FilePath, open_input
from izo_ref.base.npy_header import Header, HeaderError, array_of, read_header
from izo_ref.base.values import shown

INFLATED = 1032  # times the compressed size, the most that deflate can give
SMALL = 1 << 10  # bytes; the compressed size of tiny arrays is rounded up to whole bits and blocks
ENCRYPTED = 0x1  # flag of a member
PIECE = 1 << 20  # bytes that are read at once
ENDING = ".npy"


class Archive:
    """The arrays of an .npz archive that is open.

    Attributes:
        names: Names of the arrays, in the order of the archive.
    """

    def __init__(self, path: FilePath, file: BinaryIO) -> None:
        """Read the list of contents, and check the sizes that it declares."""
        self._path, size = path, os.fstat(file.fileno()).st_size
        self._archive = zipfile.ZipFile(cast(Any, Bounded(file)))
        members = [member for member in self._archive.infolist() if not member.is_dir()]
        count = declared_count(file, size)
        if count != len(self._archive.infolist()):
            found = len(self._archive.infolist())
            raise HeaderError(f"its list of contents declares {count} arrays, but has {found}")
        self._members: dict[str, zipfile.ZipInfo] = {}
        for member in members:
            name = member.filename.removesuffix(ENDING)
            if name in self._members:
                raise HeaderError(f"the array {shown(name)} is there twice")
            self._members[name] = member
        packed = sum(member.compress_size for member in members)
        if packed > size:
            raise HeaderError(f"its arrays declare {packed} bytes, but the file has {size}")
        self.names = list(self._members)

    def read(self, name: str) -> Any:
        """Return an array.

        Args:
            name: Its name.

        Raises:
            HeaderError: It is no array of plain numbers, or its sizes do not fit.
        """
        header, file = self.open_array(name)
        with file:
            return array_of(header, all_bytes(file, header.n_bytes))

    def open_array(self, name: str) -> tuple[Header, BinaryIO]:
        """Open an array whose bytes are read piece by piece.

        Args:
            name: Its name.

        Returns:
            Its header, and the file behind it, which has as many bytes as the header asks for
            unless it is damaged.

        Raises:
            HeaderError: It is no array of plain numbers, or its sizes do not fit.
        """
        file = self.open_member(name)
        header, begin = read_header(file)
        size = self._members[name].file_size
        if begin + header.n_bytes != size:
            raise HeaderError(
                f"shape {header.shape} and type {header.dtype} take {header.n_bytes} bytes, "
                f"but there are {size - begin}"
            )
        return header, file

    def open_member(self, name: str) -> BinaryIO:
        """Open the bytes of an array, its header first, or those of another file of the archive.

        Args:
            name: Its name.

        Raises:
            HeaderError: It is encrypted, or compressed in an unknown way.
        """
        member = self._members[name]
        _check_member(member)
        return cast(BinaryIO, self._archive.open(member))

    def member(self, name: str) -> zipfile.ZipInfo:
        """Return what the list of contents says of an array: file name, date, compression.

        Args:
            name: Its name.
        """
        return self._members[name]

    def check(self, name: str) -> None:
        """Check that an array which nobody reads has the same name where it lies as in the list.

        Otherwise damage to a name would make an array that is optional disappear.

        Args:
            name: Its name.

        Raises:
            HeaderError: It is encrypted, or compressed in an unknown way.
        """
        self.open_member(name).close()


def _check_member(member: zipfile.ZipInfo) -> None:
    """Raise an error if an array is encrypted, or compressed in another way than numpy does."""
    if member.flag_bits & ENCRYPTED:
        raise HeaderError("it is encrypted; write the archive without a password")
    stored = member.compress_type == zipfile.ZIP_STORED
    if not stored and member.compress_type != zipfile.ZIP_DEFLATED:
        raise HeaderError(
            f"it is compressed by method {member.compress_type}; write the archive with "
            "numpy.savez or numpy.savez_compressed"
        )
    most = member.compress_size if stored else INFLATED * member.compress_size + SMALL
    if member.file_size > most:
        raise HeaderError(
            f"it declares {member.file_size} bytes, but {member.compress_size} compressed bytes "
            f"give at most {most}"
        )


def all_bytes(file: Any, size: int) -> bytearray:
    """Return the bytes up to the end, of which there have to be as many as were declared.

    Args:
        file: Is at their beginning.
        size: Their number.

    Raises:
        HeaderError: There are fewer, or more.
    """
    content = bytearray()
    while len(content) <= size:
        piece = file.read(min(PIECE, size + 1 - len(content)))
        if not piece:
            break
        content += piece
    if len(content) != size:
        found = "more" if len(content) > size else f"{len(content)}"
        raise HeaderError(f"expected {size} bytes of numbers, found {found}")
    return content


def read_archive(path: FilePath, names: Collection[str] | None = None) -> dict[str, Any]:
    """Read arrays of an .npz archive.

    Args:
        path: The archive.
        names: Names of the arrays to read, of which any may be missing; all if None.

    Returns:
        The arrays, by name.

    Raises:
        FileFormatError: The file cannot be read, is damaged, or holds something else than plain
            arrays.
    """
    with _readable(path) as (file, name_part):
        archive = Archive(path, file)
        wanted = set(archive.names if names is None else names)
        arrays = {}
        for name in archive.names:
            name_part(f"the array {shown(name)}: ")
            if name in wanted:
                arrays[name] = archive.read(name)
            else:
                archive.check(name)
        return arrays


def names_in(path: FilePath) -> list[str]:
    """Return the names of the arrays of an .npz archive, without reading them.

    Args:
        path: The archive.

    Raises:
        FileFormatError: The file cannot be read, or is damaged.
    """
    with _readable(path) as (file, _):
        return Archive(path, file).names


def read_array(path: FilePath) -> Any:
    """Read the array of an .npy file.

    Args:
        path: The file.

    Raises:
        FileFormatError: The file cannot be read, or is no array of plain numbers.
    """
    with _readable(path) as (file, _):
        size = os.fstat(file.fileno()).st_size
        header, begin = read_header(file)
        if begin + header.n_bytes != size:
            raise HeaderError(
                f"shape {header.shape} and type {header.dtype} take {header.n_bytes} bytes, but "
                f"there are {size - begin}"
            )
        return array_of(header, all_bytes(file, header.n_bytes))


@contextmanager
def _readable(path: FilePath) -> Iterator[tuple[BinaryIO, Callable[[str], None]]]:
    """Open a file, and turn every error of reading it into one that names the file and the part."""
    with open_input(path) as file, damage_named(path) as name_part:
        yield file, name_part


@contextmanager
def damage_named(path: FilePath) -> Iterator[Callable[[str], None]]:
    """Turn every error of reading an archive into one that names the file and the part.

    Args:
        path: The file.

    Yields:
        A function that takes the beginning of the message: the part that is read next.

    Raises:
        FileFormatError: The file cannot be read, or is damaged.
    """
    part = [""]

    def name_part(text: str) -> None:
        part[0] = text

    try:
        yield name_part
    except FileFormatError:
        raise
    except HeaderError as error:
        raise FileFormatError(f"{path}: {part[0]}{error}") from None
    except OSError as error:
        raise FileFormatError(f"{path}: cannot be read: {error.strerror or error}") from None
    except MemoryError:
        raise FileFormatError(
            f"{path}: {part[0]}needs more memory than is free; use a machine with more memory"
        ) from None
    except Exception as error:  # a damaged archive can raise anything: zlib.error, KeyError, ...
        raise FileFormatError(
            f"{path}: {part[0]}the archive is damaged ({shown(str(error))}); write it again"
        ) from None
