"""Whether a folder belongs to the user: nobody else can change, replace or add what is in it.

Compiled code is kept on disk as pickles of Python with machine code inside. Who can write such a
file can run any code in the name of the user who loads it. So each folder on the way from the root
down to the files is looked at.
"""

from __future__ import annotations

import os
import stat
from pathlib import Path

FilePath = str | os.PathLike[str]

ROOT = 0  # the user who can do everything anyway
MAX_LINKS = 40  # as many as Linux follows
ACCESS_LIST = "system.posix_acl_access"


def why_unsafe(folder: FilePath) -> str | None:
    """Say why others could change what is in a folder; None if they cannot.

    Each folder and each link on the way has to belong to the user or to root, and no other user
    may write to the folder. A folder above may let others write if it is sticky, as `/tmp` is: they
    cannot replace there what is not theirs. What does not exist yet is safe, because the user makes
    it in a folder that was looked at; look again once it exists. Where the system has no owners of
    files, as Windows, everything is safe.

    Args:
        folder: The folder; it need not exist.

    Returns:
        The reason, without a full stop, or None.
    """
    if not hasattr(os, "geteuid"):
        return None
    place, links = "/", 0
    waiting = list(reversed(Path(os.path.abspath(folder)).parts))  # the first part is the root
    while waiting:
        here = os.path.join(place, waiting.pop())
        try:
            found = os.lstat(here)
            target = os.readlink(here) if stat.S_ISLNK(found.st_mode) else None
        except FileNotFoundError:
            return None
        except OSError as error:
            return f"{here} cannot be looked at: {error.strerror}"
        if found.st_uid not in (ROOT, os.geteuid()):
            return f"{here} belongs to another user, number {found.st_uid}"
        if target is not None:
            links += 1
            if links > MAX_LINKS:
                return f"{here} is a link in a circle of links"
            # `here` without links is the place that `..` of the target starts from
            waiting += reversed(Path(target).parts)
            continue
        if not stat.S_ISDIR(found.st_mode):
            return f"{here} is not a folder"
        is_above_and_sticky = bool(waiting) and bool(found.st_mode & stat.S_ISVTX)
        if others_can_write(found, here) and not is_above_and_sticky:
            return f"other users can write to {here}"
        place = os.path.realpath(here)
    return None


def others_can_write(found: os.stat_result, path: FilePath) -> bool:
    """Return whether users other than its owner and root can write to a file or a folder.

    Args:
        found: What `os.stat` says of it.
        path: Its name.
    """
    if found.st_mode & stat.S_IWOTH:
        return True
    return bool(found.st_mode & stat.S_IWGRP) and not _is_private(found.st_gid, path)


def _is_private(group_id: int, path: FilePath) -> bool:
    """Return whether a group has the user alone in it, as many systems make one for each user.

    It has the name of the user, is the user's first group, and has no other member. With an access
    list, the bits of the group are those of all who are on the list.
    """
    import grp
    import pwd

    try:
        user, group = pwd.getpwuid(os.geteuid()), grp.getgrgid(group_id)
    except KeyError:
        return False
    is_own = user.pw_gid == group_id and group.gr_name == user.pw_name
    return is_own and set(group.gr_mem) <= {user.pw_name} and not _has_access_list(path)


def _has_access_list(path: FilePath) -> bool:
    try:
        return ACCESS_LIST in os.listxattr(path)
    except (AttributeError, OSError):  # not on Linux, or a file system without such lists
        return False


def make_own(folder: Path) -> None:
    """Create a folder, and those above it that are missing, for this user alone.

    Raises:
        OSError: It cannot be created.
        PermissionError: Others could change what is in it; the message says why.
    """
    missing = []
    while not folder.is_dir():
        missing.append(folder)
        if folder == folder.parent:
            break
        folder = folder.parent
    for new in reversed(missing):
        try:
            os.mkdir(new, 0o700)
        except FileExistsError:  # another process was faster
            if not new.is_dir():
                raise
    reason = why_unsafe(missing[0] if missing else folder)
    if reason is not None:
        raise PermissionError(reason)
