"""The dictionary of flags explains every typical mistake once, in full sentences."""

import json
import re
from collections import Counter

import pytest

from izo_ref.porting.dictionary.record import TYPICAL
from izo_ref.porting.files import CHECKOUT, load_cases
from izo_ref.porting.flags import FLAG, FLAGS, flags_of, flags_text
from izo_ref.porting.stages import STAGES
from validation import house

# Every source that a text names; one that is not here has to be looked up before it is added.
SOURCES = (
    "A typical slip",
    "ARCSim",
    "El Topo",
    "I-Cloth",
    "Newton: issues 3702 and 3795",
    "SLSQP",
    "Scalable-CCD",
    "Wang et al.",
    "XRTailor",
    "armadillo-rollers",
    "data/scenes/",
    "docs/method section",
    "ppf-contact-solver",
    "validation/mutants",
)


@pytest.mark.parametrize("flag", FLAGS, ids=lambda flag: flag.name)
def test_a_flag_is_explained_in_sentences(flag):
    assert re.fullmatch(r"[a-z0-9]+(-[a-z0-9]+)*", flag.name)
    for text in (flag.mistake, flag.harm, flag.seen):
        assert text.isascii()
        assert text[0].isupper()
        assert text.endswith(".")
        assert "  " not in text
    assert min(len(flag.mistake), len(flag.harm)) > 40
    assert set(flag.stages) <= {stage.name for stage in STAGES}
    assert any(source in flag.seen for source in SOURCES)


def test_names_are_unique_and_every_stage_has_flags():
    assert len(FLAG) == len(FLAGS) > 60
    for stage in STAGES:
        assert flags_of(stage.name), stage.name
    assert FLAG["zone-transitive"] in flags_of("S5")
    assert len({flag.mistake for flag in FLAGS}) == len({flag.harm for flag in FLAGS}) == len(FLAGS)


def test_a_typical_slip_is_said_only_where_no_source_is_named():
    for flag in FLAGS:
        assert (TYPICAL in flag.seen) == (flag.seen == TYPICAL), flag.name


def test_files_and_sections_that_texts_name_exist():
    for flag in FLAGS:
        text = f"{flag.mistake} {flag.harm} {flag.seen}"
        for path in re.findall(r"\b(?:data|validation)/[\w/.-]*\w", text):
            assert (house.ROOT / path).exists(), path
        for number in re.findall(r"docs/method section (\d)", text):
            assert list((house.ROOT / "docs/method").glob(f"{number}-*.md")), text


def test_the_stored_file_is_what_the_dictionary_says():
    text = (CHECKOUT / "flags.json").read_text(encoding="ascii")
    assert text == flags_text()
    stored = json.loads(text)
    assert [flag["name"] for flag in stored["flags"]] == list(FLAG)
    assert len(text.splitlines()) == len(FLAGS) + 2


def test_each_flag_has_three_cases_one_easy_and_one_hard():
    counts = Counter((flag, case.grade) for case in load_cases() for flag in case.flags)
    for flag in (flag.name for flag in FLAGS if flag.stages):
        grades = {grade: counts[flag, grade] for grade in ("easy", "medium", "hard")}
        assert sum(grades.values()) >= 3, (flag, grades)
        assert grades["easy"], (flag, grades)
        assert grades["hard"], (flag, grades)


def test_the_stages_of_a_flag_are_those_that_have_cases_of_it():
    found = {(flag, case.stage) for case in load_cases() for flag in case.flags}
    for flag in FLAGS:
        assert {stage for name, stage in found if name == flag.name} == set(flag.stages), flag.name
