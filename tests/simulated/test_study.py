"""What the study of the device says, of a scene made here."""

import pytest

from tests.shapes import vertex_over_face
from validation.report.cuda import cuda_report
from validation.rows import read
from validation.study import cuda
from validation.study.parts import run_parts


@pytest.fixture
def one_step(monkeypatch):
    monkeypatch.setattr(cuda.steps, "step_names", lambda: ["falls"])
    monkeypatch.setattr(cuda.steps, "load_step", lambda name: vertex_over_face())
    monkeypatch.setattr(cuda, "REPEATS", 1)


def test_detection_is_compared_with_the_processor(tmp_path, one_step):
    run_parts(cuda.PARTS, tmp_path / "rows", "detection", print)
    (row,) = read(tmp_path / "rows", "detection")
    assert (row["step"], row["triangles"], row["impacts"]) == ("falls", 2, 1)
    assert (row["only_gpu"], row["only_cpu"]) == (0, 0)
    assert (row["toi_difference"], row["normal_difference"]) == (0.0, 0.0)
    assert row["gpu"] == "simulator"
    cuda_report(tmp_path, "the command")
    assert "| falls |" in (tmp_path / "README.md").read_text()


def test_pairs_of_one_alone_are_counted():
    import izo_ref

    found = izo_ref.find_impacts(vertex_over_face())
    other = found._replace(nodes=found.nodes[:, [1, 0, 2, 3]])
    said = cuda._differences(other, found)
    assert (said["only_gpu"], said["only_cpu"]) == (1, 1)
