"""A study of several parts, each of which adds the rows that are missing."""


def run_parts(parts, folder, only, say):
    """Run them in turn.

    Args:
        parts: {name: part}, each called with `folder` and `say`.
        folder: of the CSV files, one a part.
        only: one of the names, or None for all.
        say: called with a line of progress.
    """
    for name, part in parts.items():
        if only in (None, name):
            part(folder, say)
