"""The guide for porters shows the tables of the code, and names stages and flags that exist."""

import re
from pathlib import Path

from izo_ref.porting.files import load_cases
from izo_ref.porting.flags import FLAG
from izo_ref.porting.guide import with_tables
from izo_ref.porting.stages import STAGES

GUIDE = Path(__file__).parents[2] / "docs" / "porting.md"


def test_tables_of_the_guide_are_those_of_the_code():
    text = GUIDE.read_text()
    assert text == with_tables(text), "run: python -m validation guide"


def test_each_stage_has_a_section_and_a_table():
    text = GUIDE.read_text()
    for stage in STAGES:
        assert f"### {stage.name}: {stage.title}" in text
        assert text.count(f"<!-- {stage.name}:begin -->\n`") == 1


def test_cases_and_flags_that_the_guide_names_exist():
    text = GUIDE.read_text()
    ids = set(re.findall(r"\bS\d+-[a-z0-9-]+-\d\d\b", text))
    assert len(ids) >= 2
    assert ids <= {case.id for case in load_cases()}
    table = text[text.index("flags of the vectors") : text.index("An empty cell")]
    named = re.findall(r"`([a-z0-9-]+-[a-z0-9-]+)`", table)
    assert len(named) > 10
    assert set(named) <= set(FLAG)


def test_sources_of_stages_exist():
    root = GUIDE.parents[1]
    for stage in STAGES:
        path, _, name = stage.source.partition(":")
        assert re.search(rf"^(def|class) {name}\b", (root / path).read_text(), re.M), stage.source
        assert (root / "docs" / "method" / f"{stage.method}.md").is_file()
