"""The self-test: it breaks replies in every way, and it notices a judge that lets one pass."""

import pytest

from izo_ref.porting.conform import selftest
from izo_ref.porting.conform.breaks import broken_replies
from izo_ref.porting.conform.right import right_reply
from izo_ref.porting.judge import verdict
from izo_ref.porting.judge.outcome import FAILED, PASSED
from izo_ref.porting.judge.verdict import judge
from tests.helpers import porting_cases as made

CASES = [*made.small_cases(), made.step()]


@pytest.mark.parametrize("dtype", ["f8", "f4"])
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.id)
def test_a_right_reply_passes_and_every_broken_one_fails(case, dtype):
    reply = made.right(case) or right_reply(case)
    assert judge(case, reply, dtype).result == PASSED
    broken = list(broken_replies(case, reply, dtype))
    assert len(broken) >= 4
    for way, bad in broken:
        assert judge(case, bad, dtype).result == FAILED, way


def test_each_judge_is_broken_in_a_way_of_its_own():
    ways = {}
    for case in CASES:
        for way, _ in broken_replies(case, made.right(case) or right_reply(case), "f8"):
            ways.setdefault(way, case.id)
    wanted = {
        "beyond the tolerance",
        "sign flipped",
        "another value",
        "pair dropped",
        "pair with a common vertex",
        "put into another group",
        "group split",
        "group for none",
        "longer than 1",
        "order reversed",
        "twice as large",
        "pinned vertex moved",
        "proposed path, said to be free",
        "missing output",
        "element dropped",
        "element added",
        "NaN for a value",
        "decimal text for a value",
        "refuses good input",
        "accepts bad input",
    }
    assert wanted <= ways.keys()


def test_the_self_test_passes_and_shows_what_it_tried():
    result = selftest.self_test(made.small_cases())
    assert result.problems == ()
    assert "The harness rejects every broken reply." in result.text
    assert "flood-of-errors        flood" in result.text
    assert "S12  there are no cases" in result.text


@pytest.mark.parametrize("name", ["values", "superset", "partition", "time", "side", "kkt"])
def test_a_judge_that_lets_everything_pass_is_noticed(monkeypatch, name):
    monkeypatch.setitem(verdict.JUDGES, name, lambda question: [])
    monkeypatch.setattr(selftest, "KIND_OF_WAY", {})
    assert any("passes with" in text for text in selftest.self_test(CASES[:-1]).problems)


def test_a_judge_that_lets_nothing_pass_is_noticed(monkeypatch):
    monkeypatch.setitem(
        verdict.JUDGES, "values", lambda question: [question.difference("it is wrong")]
    )
    monkeypatch.setattr(selftest, "KIND_OF_WAY", {})
    problems = selftest.self_test([made.clamp()]).problems
    assert any("a right reply fails" in text for text in problems)
