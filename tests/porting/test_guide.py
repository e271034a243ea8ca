"""The guide for porters shows the tables of the code, and names stages and flags that exist."""

import re
from pathlib import Path

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


def test_sources_of_stages_exist():
    root = GUIDE.parents[1]
    for stage in STAGES:
        path, _, name = stage.source.partition(":")
        assert re.search(rf"^(def|class) {name}\b", (root / path).read_text(), re.M), stage.source
        assert (root / "docs" / "method" / f"{stage.method}.md").is_file()
