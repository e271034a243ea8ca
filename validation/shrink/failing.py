"""What failing is: by a command, by the check of a step, or by the claims of a result."""

import re
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from izo_ref.base.errors import IzoError
from izo_ref.solvers.solve import solve_zone
from izo_ref.zones.distance import distance_bound
from izo_ref.zones.problem import ZoneProblem
from validation.check import check
from validation.limits import Limits
from validation.oracles.rational import EXACT_IMPACTS, ExactZone, active_rows
from validation.stability_steps.case import Case
from validation.stability_steps.run import run_case

# How an input fails; inputs with the same words fail in the same way. None does not fail.
Failure: TypeAlias = str | None
Judge: TypeAlias = Callable[[Any], Failure]

ERROR_LINE = re.compile(r"(?:^|[\s:.])([A-Z]\w*(?:Error|Exception|Warning|Interrupt|Exit))\b")
TIMED_OUT = 124


def by_command(command: str, save: Callable[[Path, Any], None], seconds: float) -> Judge:
    """Return a judge that runs a command with the path of a file that holds the input.

    An input fails if the exit code is not 0. Failures are the same if the exit code is, and the
    class of the last error that the output names.

    Args:
        command: The command. The path takes the place of `{}`, or comes last.
        save: Writes an input to a file.
        seconds: Time of one run; a run that takes longer fails with the exit code 124.
    """

    def judge(candidate: Any) -> Failure:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "step.npz"
            save(path, candidate)
            words = shlex.split(command)
            if any("{}" in word for word in words):
                words = [word.replace("{}", str(path)) for word in words]
            else:
                words.append(str(path))
            words[0] = sys.executable if words[0] == "python" else words[0]
            return _run(words, seconds)

    return judge


def _run(words: list[str], seconds: float) -> Failure:
    try:
        done = subprocess.run(
            words, stdin=subprocess.DEVNULL, capture_output=True, timeout=seconds, check=False
        )
    except subprocess.TimeoutExpired:
        return f"exit code {TIMED_OUT}"
    if done.returncode == 0:
        return None
    text = (done.stdout + b"\n" + done.stderr).decode(errors="replace")
    errors = [m[1] for line in text.splitlines() for m in ERROR_LINE.finditer(line)]
    return f"exit code {done.returncode}" + (f", {errors[-1]}" if errors else "")


def by_check(case: Case) -> Failure:
    """Judge a step as `python -m validation check` does, in this process.

    Returns:
        The first judge that rejects, or the class of the error that refuses the step.
    """
    try:
        scene, limits = case.scene(), Limits(20.0)
        verdict = check(scene, None, case.thickness, case.options(), limits=limits)
    except IzoError as error:
        return type(error).__name__
    failed = [f"{fact.question}, {fact.by}" for fact in verdict.facts if fact.passed is False]
    return failed[0] if failed else None


def by_claims(case: Case) -> Failure:
    """Judge the claims of the results of a case, as the study of random steps does.

    Returns:
        The rule that is broken first.
    """
    violations = run_case(case).violations
    return violations[0].split(":")[0] if violations else None


def by_zone(problem: ZoneProblem) -> Failure:
    """Judge the answer of `solve_zone`: it is solved to tolerance, and as near as is proved.

    The exact optimum is asked for up to `EXACT_IMPACTS` impacts.

    Returns:
        What is wrong.
    """
    try:
        solution = solve_zone(problem)
    except IzoError as error:
        return type(error).__name__
    if not np.isfinite(solution.positions).all():
        return "not finite"
    if not solution.residuals.solved(1e-9, 1e-9):
        return "not solved" if solution.feasible else "infeasible"
    if len(problem.nodes) > EXACT_IMPACTS:
        return None
    exact = ExactZone(problem)
    optimum = exact.solve(active_rows(solution.multipliers))
    if optimum is None:
        return None
    bound = distance_bound(problem, solution.positions, solution.multipliers)
    distance = exact.distance(exact.moves(solution.positions), optimum.moves)
    return None if distance <= bound * (1.0 + 1e-12) else "distance bound"
