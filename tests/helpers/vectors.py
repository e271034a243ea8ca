"""Simple checks of the vectors of the porting kit, written apart from `izo_ref.porting.judge`."""

from collections import Counter

EPS = {"f8": 2.0**-52, "f4": 2.0**-23}


def require_good_cases(cases, owned):
    """Check identifiers, and that each flag has an easy case, a hard case and a third one."""
    ids = Counter(case.id for case in cases)
    assert not [name for name, count in ids.items() if count > 1]
    assert all(case.dtypes and case.flags and case.what.endswith(".") for case in cases)
    for flag in owned:
        grades = [case.grade for case in cases if flag in case.flags]
        assert len(grades) >= 3, flag
        assert {"easy", "hard"} <= set(grades), flag


def is_close(wanted, got, dtype):
    """Return whether numbers are within the tolerance of the judge `values`."""
    multiple = wanted.get(f"multiple_{dtype}", wanted["multiple"])
    return len(got) == len(wanted["values"]) and all(
        abs(a - b) <= multiple * EPS[dtype] * scale
        for a, b, scale in zip(got, wanted["values"], wanted["scale"], strict=True)
    )


def same_partition(a, b):
    """Return whether two lists of numbers group places alike, with -1 where the other has -1."""
    pairs = set(zip(a, b, strict=True))
    once = all(len({pair[k] for pair in pairs}) == len(pairs) for k in (0, 1))
    return once and all((x == -1) == (y == -1) for x, y in pairs)


def caught(flag, cases, passes):
    """Return the cases of a flag that a wrong implementation does not pass."""
    return [case.id for case in cases if flag in case.flags and not passes(case)]
