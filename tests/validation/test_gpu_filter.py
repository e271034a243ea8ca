"""The study of the float32 filter counts pairs and instructions, on one small step."""

import numpy as np

from izo_ref import find_impacts
from tests.helpers.steps import load_step
from validation.report.cuda import page
from validation.rows import read
from validation.study import gpu_filter
from validation.study.gpu_parts import Clock


def test_the_filter_of_a_small_step_is_measured(tmp_path, monkeypatch):
    monkeypatch.setattr(gpu_filter.steps, "step_names", lambda: ["sheets"])
    monkeypatch.setattr(gpu_filter, "PAIRS", 1)
    folder = tmp_path / "rows"
    gpu_filter.study_filter(folder, print, Clock(folder, "filter", np.inf))
    proposed, answer = read(tmp_path / "rows", "filter")
    assert (proposed["path"], answer["path"]) == ("proposed", "answer")
    assert (proposed["contacts"], answer["contacts"]) == (
        len(find_impacts(load_step("sheets")).toi),
        0,
    )
    for row in (proposed, answer):
        assert row["missed"] == 0
        assert 0.0 < row["settled_of_apart"] <= 1.0
        assert row["settled"] == round(row["settled_of_apart"] * (row["pairs"] - row["contacts"]))
        assert 0.0 <= row["groups_left_open"] <= 1.0
    text = page(tmp_path / "rows", tmp_path).read_text()
    assert "| sheets | proposed |" in text


def test_the_filter_before_the_proofs_finds_the_same_on_the_cpu(monkeypatch):
    scene = load_step("sheets")
    expected = find_impacts(scene)
    boxes = gpu_filter.path_boxes(scene, scene.positions_t1)
    monkeypatch.setattr("izo_ref.detection.near_pairs.find_contacts", gpu_filter.Filtered(boxes))
    found = find_impacts(scene)
    for own, other in zip(found, expected, strict=True):
        assert np.array_equal(own, other)
