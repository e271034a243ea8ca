"""The guide for porters: its tables are those of the code, names exist, its program conforms."""

import re
import sys
from collections import Counter
from pathlib import Path

from izo_ref.porting.conform.run import Choice, requests_of, run_program
from izo_ref.porting.files import load_cases
from izo_ref.porting.flags import FLAG
from izo_ref.porting.guide import with_tables
from izo_ref.porting.judge.outcome import NOT_SUPPORTED, PASSED
from izo_ref.porting.stages import STAGES

DOCS = Path(__file__).parents[2] / "docs"
GUIDE = DOCS / "porting.md"
STAGE_PAGE = DOCS / "porting-stages.md"
NUMBERS = DOCS / "porting-numbers.md"


def test_tables_of_the_guide_are_those_of_the_code():
    text = STAGE_PAGE.read_text()
    assert text == with_tables(text), "run: python -m validation guide"


def test_each_stage_has_a_section_and_a_table():
    text = STAGE_PAGE.read_text()
    for stage in STAGES:
        assert f"\n## {stage.name}: {stage.title}\n" in text
        assert text.count(f"<!-- {stage.name}:begin -->\n`") == 1


def test_cases_and_flags_that_the_guide_names_exist():
    text = GUIDE.read_text()
    ids = set(re.findall(r"\bS\d+-[a-z0-9-]+-\d\d\b", text))
    assert ids
    assert ids <= {case.id for case in load_cases()}
    text = NUMBERS.read_text()
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


def test_the_program_of_the_guide_conforms(tmp_path):
    program = re.search(r"```python\n(.*?)```", GUIDE.read_text(), re.S)[1]
    (tmp_path / "port.py").write_text(program)
    requests = requests_of(load_cases(), Choice(dtypes=("f8",)))
    run = run_program([sys.executable, str(tmp_path / "port.py")], requests)
    results = Counter(row.outcome.result for row in run.rows)
    assert set(results) == {PASSED, NOT_SUPPORTED}
    assert results[PASSED] == sum(case.stage == "S9" for case in load_cases())
