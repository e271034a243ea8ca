"""Hostile files are refused before they take memory, time, or control."""

import io
import os
import tracemalloc
import zipfile

import numpy as np
import pytest

from izo_ref.app.files import load_result, load_scene
from izo_ref.base.archive_list import LARGEST_LIST
from izo_ref.base.archives import read_archive, read_array
from izo_ref.base.errors import FileFormatError
from izo_ref.base.input_files import read_bytes, read_text
from izo_ref.base.npy_header import array_of, read_header
from izo_ref.porting.trace_files import load_arrays, load_index
from validation.fuzz.archive_bytes import Member, array_bytes, members_of, npy, zip_bytes
from validation.fuzz.archives import ARRAYS, LOADED, RECORDS, RESULT, TERA


def refused(path, content, read=load_result):
    path.write_bytes(content)
    with pytest.raises(FileFormatError) as caught:
        read(path)
    assert "pickle" not in str(caught.value)
    assert str(path) in str(caught.value)
    assert LOADED == []
    return str(caught.value)


@pytest.mark.parametrize("i", range(len(ARRAYS)))
def test_a_hostile_array_is_refused(tmp_path, i):
    members = members_of(RESULT)
    good = members["positions"].data
    members["positions"] = Member("positions.npy", ARRAYS[i](good))
    message = refused(tmp_path / "out.npz", zip_bytes(list(members.values())))
    assert "positions" in message
    refused(tmp_path / "positions.npy", ARRAYS[i](good), _positions)


def _positions(path):
    """Read the positions of a dump, where texts are arrays too."""
    array = read_array(path)
    if array.dtype.kind == "U":
        raise FileFormatError(f"{path}: a text")


@pytest.mark.parametrize("i", range(len(RECORDS)))
def test_hostile_records_are_refused(tmp_path, i):
    members = members_of(RESULT)
    changed = RECORDS[i](members.pop("positions"))
    message = refused(tmp_path / "out.npz", zip_bytes([*members.values(), *changed]))
    assert "positions" in message or "declare" in message


def test_an_array_of_objects_is_never_unpickled(tmp_path):
    message = refused(tmp_path / "a.npy", ARRAYS[13](b""), read_array)
    assert "objects of Python, which are never read" in message


@pytest.mark.parametrize("size", [{"size": TERA}, {"size": TERA, "packed": TERA}])
def test_a_declared_size_takes_no_memory(tmp_path, size):
    """An archive of 500 bytes declares 4 TB; refusing it takes no more than any list may have."""
    members = members_of(RESULT)
    members["positions"] = members["positions"]._replace(**size)
    content = zip_bytes(list(members.values()))
    tracemalloc.start()
    refused(tmp_path / "out.npz", content)
    huge = npy("'<f8'", "(2147483647, 3)", b"\0" * 96)
    refused(tmp_path / "out.npz", zip_bytes([Member("positions.npy", huge)]))
    refused(tmp_path / "positions.npy", huge, read_array)
    assert tracemalloc.get_traced_memory()[1] < LARGEST_LIST + (1 << 20)
    tracemalloc.stop()


def test_arrays_that_share_their_bytes_are_refused(tmp_path):
    zeros = array_bytes(np.zeros((100_000, 3)))
    content = zip_bytes([Member(f"x{i}.npy", zeros) for i in range(100)], shared=True)
    message = refused(tmp_path / "bomb.npz", content, read_archive)
    assert "bytes, but the file has" in message


def test_an_array_of_zeros_is_compressed_by_no_more_than_deflate_can(tmp_path):
    """The bound of 1032 refuses no archive that numpy writes."""
    np.savez_compressed(tmp_path / "zeros.npz", positions=np.zeros((1_000_000, 3)))
    assert load_result(tmp_path / "zeros.npz").positions.shape == (1_000_000, 3)


def test_too_long_a_list_of_contents_is_refused(tmp_path):
    count = LARGEST_LIST // 1000
    content = zip_bytes([Member(f"{i:0950d}.npy", b"", 0) for i in range(count + 100)])
    assert "list of contents" in refused(tmp_path / "many.npz", content)


def test_the_sum_of_an_array_that_nobody_reads_does_not_matter(tmp_path):
    members = [*members_of(RESULT).values(), Member("notes.txt", b"a text", crc=0)]
    (tmp_path / "out.npz").write_bytes(zip_bytes(members))
    np.testing.assert_array_equal(load_result(tmp_path / "out.npz").positions, RESULT["positions"])


def test_damage_to_the_name_of_an_optional_array_is_noticed(tmp_path):
    """The masses would be 1 kg without a word."""
    members = members_of(RESULT)
    members["thickness"] = members["thickness"]._replace(
        name="thicknest.npy", local="thickness.npy"
    )
    assert "thicknest" in refused(tmp_path / "out.npz", zip_bytes(list(members.values())))


@pytest.mark.parametrize("place", [30, 32])
def test_an_array_that_one_wrong_bit_hides_is_missed(tmp_path, place):
    """The length of the extra field, or of the comment, of a record covers the next record."""
    content = bytearray(zip_bytes(list(members_of(RESULT).values())))
    first = content.find(b"PK\x01\x02")
    assert content[first + 46 :].startswith(b"positions.npy")
    content[first + place] ^= 128
    message = refused(tmp_path / "out.npz", bytes(content))
    assert place == 30 or "declares 2 arrays, but has 1" in message


@pytest.mark.parametrize("kind", ["<f4", ">f8", "<f2", ">i8", "u1"])
@pytest.mark.parametrize("version", [(1, 0), (2, 0), (3, 0)])
def test_every_plain_type_is_read_as_numpy_reads_it(kind, version):
    array = np.asfortranarray(np.arange(12).reshape(4, 3).astype(kind))
    file = io.BytesIO()
    np.lib.format.write_array(file, array, version)
    file.seek(0)
    header, begin = read_header(file)
    content = bytearray(file.read())
    assert begin + len(content) == len(file.getvalue())
    found = array_of(header, content)
    np.testing.assert_array_equal(found, array)
    assert found.dtype.isnative


def test_integers_of_python_2_are_read():
    header, _ = read_header(io.BytesIO(npy("'<f8'", "(4L, 3L)", b"")))
    assert header.shape == (4, 3)


@pytest.mark.parametrize("read", [load_scene, load_result, load_arrays, read_bytes, read_text])
def test_what_is_no_file_is_refused_at_once(tmp_path, read):
    """A pipe would wait for ever, and /dev/zero has no end."""
    os.mkfifo(tmp_path / "pipe.npz")
    (tmp_path / "zero.npz").symlink_to("/dev/zero")
    (tmp_path / "loop.npz").symlink_to(tmp_path / "loop.npz")
    for name in ("pipe.npz", "zero.npz", "loop.npz"):
        with pytest.raises(FileFormatError, match=name):
            read(tmp_path / name)
    with pytest.raises(FileFormatError, match=r"file\.npz"):
        read(f"{tmp_path}/{'file.npz' * 90}")
    with pytest.raises(FileFormatError, match=r"a.*b"):
        read(f"{tmp_path}/a\0b")


def test_a_pipe_in_a_dump_is_refused(tmp_path):
    (tmp_path / "scene").mkdir()
    os.mkfifo(tmp_path / "scene" / "faces.npy")
    with pytest.raises(FileFormatError, match="found a pipe"):
        load_arrays(tmp_path)


def test_no_more_is_read_than_is_allowed(tmp_path):
    path = tmp_path / "text"
    path.write_bytes(b"x" * 100)
    assert len(read_bytes(path, 100)) == 100
    with pytest.raises(FileFormatError, match="at most 99 bytes"):
        read_bytes(path, 99)


@pytest.mark.parametrize(
    "text",
    [
        "[" * 200_000,
        '{"scene": 5}',
        '{"scene": {"masses": 1}}',
        '{"iterations": 5}',
        '{"iterations": [5]}',
        '{"iterations": [{"folder": []}]}',
    ],
)
def test_an_index_of_another_form_is_refused(tmp_path, text):
    (tmp_path / "index.json").write_text(text)
    with pytest.raises(FileFormatError, match=r"index\.json"):
        load_index(tmp_path)


def test_the_archives_of_these_tests_are_archives(tmp_path):
    """Python's own reader takes the good ones, so the hostile ones differ by what is stated."""
    (tmp_path / "good.npz").write_bytes(zip_bytes(list(members_of(RESULT).values())))
    with zipfile.ZipFile(tmp_path / "good.npz") as archive:
        assert archive.testzip() is None
    with np.load(tmp_path / "good.npz") as archive:
        np.testing.assert_array_equal(archive["positions"], RESULT["positions"])
