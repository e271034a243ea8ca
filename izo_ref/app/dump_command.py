"""What `izo conform --dump` does: judge the arrays that a port wrote of its own scene."""

from __future__ import annotations

from izo_ref.app.files import FilePath, check_outputs, save_json
from izo_ref.porting.dump import judge_dump

AGREES, DIFFERS = 0, 1


def conform_dump(folder: FilePath, json_path: FilePath | None = None) -> int:
    """Judge a dump, print the report, and return the exit code of the command.

    Args:
        folder: A folder of .npy files, or one .npz archive, by the names of a trace.
        json_path: File for the report as JSON; none if None.

    Returns:
        0 if everything that was judged agrees, 1 if something differs or nothing was judged.

    Raises:
        FileFormatError: A file cannot be read or written, or an array has another shape.
        IzoError: `Scene` does not accept the arrays of the scene.
    """
    check_outputs({"--dump": folder}, {"--json": json_path})
    report = judge_dump(folder)
    if json_path is not None:
        save_json(json_path, report.record())
    print(report.text(), end="")
    return AGREES if report.agrees else DIFFERS
