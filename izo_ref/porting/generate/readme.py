"""The README.md of the vectors: how to read them, and how many there are."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence

from izo_ref.porting.cases import GRADES, LARGE, VERDICTS, Case
from izo_ref.porting.flags import FLAGS
from izo_ref.porting.parameters import JUDGES
from izo_ref.porting.stages import STAGES

BEGIN = f"""\
# Vectors of the method, version 1

Small cases with known answers for each stage of impact zone optimization, for ports of the method
to other languages and machines. `izo conform --exec ./my_port` runs a port on them; `izo vectors
list` and `izo vectors show ID` print them for people. The page "Check a port" of the documentation
explains the order of work.

These files are the truth. They are never edited: a mistake in them is corrected in a folder `v2`.
`izo vectors verify` compares them with `SHA256SUMS` and makes them again, bit for bit.

## Format

* `S1.json` to `S13.json` hold the cases of one stage, one case a line. `flags.json` explains the
  typical mistakes that cases catch. `schema.json` describes all of them exactly, in JSON Schema.
* Arrays are flat lists, row by row. `schema.json` has the shape, the unit and the meaning of each.
* A float is a string in C's hexadecimal notation, such as `"0x1.8p+0"`, `"inf"` or `"nan"`.
  Integers and flags (0 or 1) are JSON integers.
* An array of more than {LARGE} numbers is a file of its own: `{{"npy": "NAME.npy"}}`.
* `input` has the inputs of the stage. `expected` has, for each output, the name of a judge and what
  the judge needs to know. `dtypes` says whether the case has a meaning for float64 (`f8`), for
  float32 (`f4`) or for both. In float32, round the inputs first.
* eps is 2^-52 for f8 and 2^-23 for f4. A tolerance is `multiple` * eps * `scale`. Where there is a
  member `multiple_f8` or `multiple_f4`, it takes the place of `multiple` for that type.

## Read them in C

1. Read a line of a stage's file, without the comma at its end. Each line between the first and the
   last one is a case, and a JSON object of its own.
2. Give strings that begin with `0x` or `-0x`, and `inf`, `-inf` and `nan`, to `strtod`. It returns
   the exact number in float64; cast it to `float` for f4.
3. In a `.npy` file, the two bytes at offset 8 are the length of the header, least byte first. The
   header says `<f8` or `<i4`; the numbers follow it, least byte first, up to the end of the file.

There is no need to read these files at all to use `izo conform`: it sends one case after another
to the port, one line of JSON in, one line out.
"""


def readme_text(cases: Sequence[Case]) -> str:
    """Return the content of README.md.

    Args:
        cases: All cases.
    """
    titles = {stage.name: stage.title for stage in STAGES}
    flags = [flag.name for flag in FLAGS if flag.stages]
    parts = [
        BEGIN,
        "## Verdicts\n\n" + _items(VERDICTS),
        "## Judges\n\n" + _items({name: judge.what for name, judge in JUDGES.items()}),
        f"## Counts\n\n{len(cases)} cases.\n\n"
        + _table("stage", titles, cases, lambda case: [case.stage]),
        "A case may have several flags, so the counts below overlap.\n\n"
        + _table("flag", dict.fromkeys(flags, ""), cases, lambda case: case.flags),
    ]
    return "\n".join(parts)


def _items(texts: dict[str, str]) -> str:
    return "".join(f"* `{name}`: {text}.\n" for name, text in texts.items())


def _table(
    heading: str,
    titles: dict[str, str],
    cases: Sequence[Case],
    names_of: Callable[[Case], Sequence[str]],
) -> str:
    """Return a table of counts by grade, one row for each name."""
    counts = Counter((name, case.grade) for case in cases for name in names_of(case))
    lines = [f"| {heading} | {' | '.join(GRADES)} | all |", f"|---{'|---:' * (len(GRADES) + 1)}|"]
    for name, title in titles.items():
        row = [counts[name, grade] for grade in GRADES]
        label = f"{name}, {title}" if title else f"`{name}`"
        lines.append(f"| {label} | {' | '.join(map(str, row))} | {sum(row)} |")
    return "\n".join(lines) + "\n"
