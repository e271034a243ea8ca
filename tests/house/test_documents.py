"""Files, commands, constants and versions that the documents name exist."""

import re

import pytest

import izo_ref
from validation import house
from validation.__main__ import _parser

CONTRIBUTING = (house.ROOT / "CONTRIBUTING.md").read_text()
# Files and folders that exist only after a command has made them, or outside of a checkout.
MADE = ("reports/quick", "reports/*.html", ".venv", "build", "..")


def named_paths():
    """Yield the paths in backticks that begin with a folder of the repository or name a file."""
    for quoted in re.findall(r"`([^`\s]+)`", CONTRIBUTING):
        in_folder = "/" in quoted and (house.ROOT / quoted.partition("/")[0]).is_dir()
        if quoted.endswith((".toml", ".md")) or (in_folder and not quoted.startswith(MADE)):
            yield quoted


def test_files_named_for_contributors_exist():
    paths = sorted(set(named_paths()))
    assert len(paths) > 40
    missing = [path for path in paths if not any(house.ROOT.glob(path.rstrip("/")))]
    assert missing == []


def test_constants_named_for_contributors_exist():
    """Each constant, a word in capitals, occurs in a file that its paragraph names."""
    checked = 0
    for block in re.split(r"\n\n|\n\d\. |\n\* ", CONTRIBUTING):
        files = [house.ROOT / path for path in re.findall(r"`([\w/]+\.py)`", block)]
        sources = [path.read_text() for path in files if path.is_file()]
        for name in re.findall(r"`([A-Z_]{5,})(?:\[\"\w+\"\])?`", block):
            if sources and not name.startswith("IZO_"):
                assert any(re.search(rf"\b{name}\b", source) for source in sources), name
                checked += 1
    assert checked > 8


@pytest.mark.parametrize("command", ["house", "study speed", "study cuda", "report", "zones"])
def test_commands_that_make_the_reports_exist(command):
    assert f"`{command}`" in CONTRIBUTING or f"validation {command}" in CONTRIBUTING
    assert callable(_parser().parse_args(command.split()).run)


def test_the_version_is_the_same_everywhere():
    citation = (house.ROOT / "CITATION.cff").read_text()
    changelog = (house.ROOT / "CHANGELOG.md").read_text()
    assert re.search(r"^version: (.+)$", citation, re.M)[1] == izo_ref.__version__
    headings = re.findall(r"^## (\S+)", changelog, re.M)
    assert headings[:2] == ["Unreleased", izo_ref.__version__]
