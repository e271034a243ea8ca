"""The commands `izo vectors list`, `show`, `make` and `verify`. They compile nothing."""

from __future__ import annotations

import argparse
import difflib
import re
from pathlib import Path

from izo_ref.base.errors import OptionError, VectorsError
from izo_ref.porting.cases import Case
from izo_ref.porting.files import load_case, load_cases, vectors_folder, wrong_files
from izo_ref.porting.flags import FLAG
from izo_ref.porting.stages import STAGE

RIGHT, WRONG = 0, 1  # exit codes
STAGE_WORD = re.compile(r"[sS]?(\d+)", re.ASCII)
MAX_LISTED = 10  # differences that `verify` names; the others are counted


def stage_name(word: str) -> str:
    """Return the name of a stage for `S3`, `s3` or `3`; other words come back as they are.

    Args:
        word: The word.
    """
    match = STAGE_WORD.fullmatch(word)
    return f"S{int(match[1])}" if match else word


def list_cases(args: argparse.Namespace) -> int:
    """Print one line for each case that has the stage, the flag and the grade asked for."""
    if args.flag is not None and args.flag not in FLAG:
        near = ", ".join(difflib.get_close_matches(args.flag, FLAG, cutoff=0.3)) or "none"
        raise OptionError(
            f"expected --flag to name a flag, found {args.flag!r}; near ones are: {near}. "
            "flags.json explains all of them"
        )
    cases = load_cases(_folder(args), None if args.stage is None else [args.stage])
    found = [
        case
        for case in cases
        if (args.flag is None or args.flag in case.flags)
        and (args.grade is None or args.grade == case.grade)
    ]
    width = max((len(case.id) for case in found), default=0)
    for case in found:
        print(_line(case, width))
    print(f"{len(found)} of {len(cases)} cases")
    return RIGHT


def _line(case: Case, width: int) -> str:
    dtypes = "+".join(case.dtypes)
    flags = " ".join(case.flags)
    head = f"{case.id.ljust(width)}  {case.grade:<6}  {case.verdict:<10}  {dtypes:<5}  {flags}"
    return f"{head}: {case.what}"


def show_case(args: argparse.Namespace) -> int:
    """Print a case as a person reads it, and write its picture if that is asked for."""
    from izo_ref.porting.picture import case_picture
    from izo_ref.porting.show import ROWS, case_text

    stage = stage_name(args.id)
    if stage in STAGE:
        raise OptionError(
            f"expected the id of a case, found {args.id!r}; `izo vectors list --stage {stage}` "
            "lists the cases of this stage"
        )
    case = load_case(args.id, _folder(args))
    text = case_text(case, None if args.all else ROWS)
    if args.picture is not None:
        from izo_ref.app.files import replacing

        picture = case_picture(case)
        with replacing(args.picture) as file:
            file.write(picture.encode("ascii"))
        text += f"\n\npicture: {args.picture}"
    print(text)
    return RIGHT


def make_vectors(args: argparse.Namespace) -> int:
    """Make all vectors, and write them into a folder."""
    from izo_ref.porting.generate.build import contents, generated_cases, write_folder

    cases = generated_cases()
    files = contents(cases)
    write_folder(files, Path(args.output))
    n_cases = sum(len(found) for found in cases.values())
    size = sum(len(content) for content in files.values())
    print(f"{args.output}: {n_cases} cases in {len(files)} files, {size / 1e6:.1f} MB")
    return RIGHT


def verify_vectors(args: argparse.Namespace) -> int:
    """Compare the vectors with their sums, and with what the generators make, bit for bit."""
    from izo_ref.porting.generate.build import contents, generated_cases
    from izo_ref.porting.generate.compare import differences

    folder = vectors_folder() if args.folder is None else Path(args.folder)
    wrong = wrong_files(folder)
    if wrong:
        return _say_wrong(folder, wrong)
    print(f"{folder}: all files have the sums in SHA256SUMS")
    wrong = differences(contents(generated_cases()), folder)
    if wrong:
        return _say_wrong(folder, wrong)
    print("the generators make the same files, bit for bit")
    return RIGHT


def _say_wrong(folder: Path, wrong: list[str]) -> int:
    for line in wrong[:MAX_LISTED]:
        print(f"{folder}: {line}")
    if len(wrong) > MAX_LISTED:
        print(f"{folder}: and {len(wrong) - MAX_LISTED} more files")
    return WRONG


def _folder(args: argparse.Namespace) -> Path | None:
    if args.folder is None:
        return None
    folder = Path(args.folder)
    if not folder.is_dir():
        raise VectorsError(f"{folder}: expected a folder of vectors, found none")
    return folder
