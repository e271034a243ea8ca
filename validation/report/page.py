"""The page of a verdict: the facts, and the step in 3D with everything that is wrong."""

from izo_ref.app.summary import excluded_line
from izo_ref.app.view.model import (
    Kind,
    Table,
    View,
    join_pairs,
    pairs_at_rest,
    pairs_on_path,
)
from izo_ref.app.view.of_step import proposed_side, step_side, view_of_sides
from izo_ref.app.view.page import view_page
from izo_ref.detection.find import find_impacts
from izo_ref.scene import Scene
from validation.check import Verdict

MARKS = {True: "passed", False: "failed", None: "info"}


def verdict_page(title: str, scene: Scene, verdict: Verdict) -> str:
    """Return the HTML page of a verdict on a result of this scene; it needs no other file."""
    return view_page(verdict_view(title, scene, verdict))


def verdict_view(title: str, scene: Scene, verdict: Verdict) -> View:
    """Return what the page of a verdict shows: the proposed path, and the judged one."""
    impacts = find_impacts(scene)
    sides = [proposed_side(scene, impacts)]
    on_path = pairs_on_path(verdict.meeting, verdict.meeting_toi)
    first, second = (scene.faces[verdict.crossing.reshape(-1, 2)[:, side]] for side in (0, 1))
    at_end = pairs_at_rest(Kind.FACE_FACE, first, second)
    sides.append(step_side("Judged", scene, verdict.positions, join_pairs([on_path, at_end])))
    word = "passed" if verdict.passed else "failed"
    if verdict.excluded["count"]:
        word += ", except for pairs that were left out"
    facts = Table(
        "Facts",
        ("Verdict", "Question", "Asked", "Answer", "Time"),
        [
            (MARKS[fact.passed], fact.question, fact.by, fact.answer, f"{fact.seconds:.2f} s")
            for fact in verdict.facts
        ],
    )
    return view_of_sides(
        title=title,
        scene=scene,
        sides=sides,
        in_zones=impacts,
        verdict=word,
        passed=None if verdict.passed and verdict.excluded["count"] else verdict.passed,
        tables=[facts, *_left_out(verdict)],
    )


def _left_out(verdict: Verdict) -> list[Table]:
    """Return a table of the first pairs that were left out, if there are any."""
    summary = verdict.excluded
    if not summary["count"]:
        return []
    rows = [
        (row["kind"], " ".join(map(str, row["nodes"])), row["reason"], row["at_end"])
        for row in summary["first"]
    ]
    title = f"Nothing is said about some pairs: {excluded_line(summary)}. The first of them"
    return [Table(title, ("Kind", "Vertices", "Left out because", "At the end"), rows)]
