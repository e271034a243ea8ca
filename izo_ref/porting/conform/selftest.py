"""The self-test of the harness: right replies pass, and every broken reply is rejected.

For cases of each stage it makes a right reply, breaks it in each way that applies, and judges both.
Then it runs a real program that misbehaves at one case, in each way of `bad_port.py`.
"""

from __future__ import annotations

import json
import math
import sys
import tempfile
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from izo_ref.porting.cases import Case, encode
from izo_ref.porting.conform import incidents
from izo_ref.porting.conform.breaks import broken_replies
from izo_ref.porting.conform.protocol import Request
from izo_ref.porting.conform.right import has_multipliers, right_reply
from izo_ref.porting.conform.run import run_program
from izo_ref.porting.judge.outcome import FAILED, PASSED
from izo_ref.porting.judge.verdict import judge
from izo_ref.porting.stages import STAGE

SAMPLE = 8  # cases of a stage; one for each different set of judges at least
SESSION_CASES = 3
HANG_S = 3.0  # for programs that do not answer; they need a second to start on a busy machine
OTHER_S = 60.0
BAD_PORT = Path(__file__).with_name("bad_port.py")

# How each way of `bad_port.py` must be reported.
KIND_OF_WAY = {
    "exit": incidents.CRASH,
    "crash": incidents.CRASH,
    "killed": incidents.MEMORY,
    "out-of-memory": incidents.MEMORY,
    "hang": incidents.HANG,
    "half-a-line": incidents.HANG,
    "half-a-line-and-exit": incidents.CRASH,
    "garbage": incidents.GARBAGE,
    "rubbish-bytes": incidents.GARBAGE,
    "empty-line": incidents.GARBAGE,
    "not-an-object": incidents.GARBAGE,
    "deep-nesting": incidents.GARBAGE,
    "long-integer": incidents.GARBAGE,
    "two-lines": incidents.SEVERAL,
    "wrong-id": incidents.WRONG_ID,
    "no-id": incidents.WRONG_ID,
    "other-case": incidents.ORDER,
    "closed-output": incidents.CLOSED,
    "flood": incidents.FLOOD,
    "flood-of-errors": incidents.FLOOD,
}
SLOW_WAYS = ("hang", "half-a-line")


class SelfTest(NamedTuple):
    """What the self-test found.

    Attributes:
        text: Tables of what was tried.
        problems: A sentence for each broken reply that passed, and each right one that failed.
    """

    text: str
    problems: tuple[str, ...]


class _Tried(NamedTuple):
    """Replies to cases of one stage."""

    requests: list[Request]
    replies: list[dict[str, Any]]
    unknown: int
    ways: Counter[str]
    problems: list[str]


def self_test(cases: Sequence[Case]) -> SelfTest:
    """Run the self-test on a sample of cases."""
    lines, problems = ["broken replies, all of which must be rejected"], []
    good: list[tuple[Request, dict[str, Any]]] = []
    for stage in STAGE:
        sample = sample_of([case for case in cases if case.stage == stage])
        if not sample:
            lines.append(f"{stage:<4} there are no cases")
            continue
        tried = _try_stage(sample)
        good += zip(tried.requests, tried.replies, strict=True)
        problems += tried.problems
        lines.append(
            f"{stage:<4} {len(tried.replies)} right replies, {sum(tried.ways.values())} broken"
            + (
                f"; {tried.unknown} cases have no right reply without a solver"
                * bool(tried.unknown)
            )
        )
        lines += [f"     {count:>6}  {way}" for way, count in sorted(tried.ways.items())]
    if good:
        lines.append("programs that misbehave at one case, and how this is reported")
        text, found = _try_programs(good[:: max(1, len(good) // SESSION_CASES)][:SESSION_CASES])
        lines += text
        problems += found
    else:
        problems.append("there is no case with which a program could be tried")
    lines += [f"problem: {problem}" for problem in problems]
    end = "The harness rejects every broken reply." if not problems else "The harness is wrong."
    return SelfTest("\n".join([*lines, end, ""]), tuple(problems))


def sample_of(cases: Sequence[Case]) -> list[Case]:
    """Return some cases of a stage: one of each kind, then the first ones."""
    kinds: dict[Any, Case] = {}
    for case in cases:
        judges = tuple((name, expected["judge"]) for name, expected in case.expected.items())
        kinds.setdefault((judges, case.verdict, case.dtypes), case)
    chosen = list(kinds.values())
    ids = {case.id for case in chosen}
    rest = [case for case in cases if case.id not in ids]
    return chosen + rest[: max(0, SAMPLE - len(chosen))]


def _try_stage(cases: Sequence[Case]) -> _Tried:
    """Judge right and broken replies to cases of a stage."""
    tried = _Tried([], [], 0, Counter(), [])
    for case in cases:
        reply = right_reply(case)
        if reply is None:
            tried = tried._replace(unknown=tried.unknown + 1)
            continue
        for dtype in case.dtypes:
            outcome = judge(case, reply, dtype)
            if outcome.result != PASSED and has_multipliers(case):
                tried = tried._replace(unknown=tried.unknown + 1)
                continue
            if outcome.result != PASSED:
                sentence = outcome.differences[0].sentence if outcome.differences else ""
                name = f"{case.id} {dtype}"
                tried.problems.append(f"{name}: a right reply fails: {sentence}")
                continue
            tried.requests.append(Request(case, dtype))
            tried.replies.append(reply)
            for way, broken in broken_replies(case, reply, dtype):
                tried.ways[way] += 1
                if judge(case, broken, dtype).result != FAILED:
                    tried.problems.append(f"{case.id} {dtype}: passes with: {way}")
    return tried


def _try_programs(good: Sequence[tuple[Request, dict[str, Any]]]) -> tuple[list[str], list[str]]:
    """Run a program that misbehaves at one of the requests, in each way."""
    requests = [request for request, _ in good]
    hello = {"name": "bad-port", "version": "1", "stages": list(STAGE), "dtypes": ["f8", "f4"]}
    replies = {" ".join(request.key): _plain(reply) for request, reply in good}
    lines, problems = [], []
    bad = len(requests) // 2
    later = [request.case.id for request in requests[bad + 1 :]]
    other = next((name for name in later if name != requests[bad].case.id), None)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "replies.json"
        path.write_text(json.dumps({"hello": hello, **replies}))
        for way, kind in KIND_OF_WAY.items():
            if way == "other-case" and other is None:
                continue
            words = [sys.executable, str(BAD_PORT), str(path), way, *requests[bad].key]
            words.append(json.dumps({"id": other, "status": "ok", "output": {}}))
            run = run_program(words, requests, HANG_S if way in SLOW_WAYS else OTHER_S)
            wanted = [PASSED] * len(requests)
            wanted[bad] = FAILED
            got = [row.outcome.result for row in run.rows]
            outputs = [item.output for row in run.rows for item in row.outcome.differences]
            lines.append(f"     {way:<22} {', '.join(outputs)}")
            if got != wanted or outputs != [kind] or run.notes:
                problems.append(f"{way}: expected the report {kind}, got {outputs}, {got}")
    return lines, problems


def _plain(value: Any) -> Any:
    """Return a reply as JSON holds it, with hexadecimal floats where JSON has no number."""
    if isinstance(value, float):
        return value if math.isfinite(value) else encode(value)
    if isinstance(value, list):
        return [_plain(item) for item in value]
    return (
        {name: _plain(item) for name, item in value.items()} if isinstance(value, dict) else value
    )
