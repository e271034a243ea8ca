"""How the time limit of a run is divided among its stages.

The fail-safe has to end in time, so it gets time of its own, and the stages before it end earlier.
How much it needs is judged from the first detection of this very run, because what comes later is
made of the same work. The certificate is such a detection, over all pairs and with new trees. The
fail-safe detects again and again, but only where something moved.
"""

from __future__ import annotations

from izo_ref.base.deadline import Deadline

# The ends of the stages, as fractions of the limit. The first detection may take half of it,
# because the certificate takes as long again. A path that could not be certified by 1 is given up.
# What is returned in its place, everything unpinned at the start, is certified by 1.25 if pinned
# parts move. The time until 1.5 is for what is never cut: the residuals of the zones, and calls
# between two checks.
FIRST_DETECTION, LAST, AT_START = 0.5, 1.0, 1.25
# Time of the certificate and of scaling back: so many first detections, and a share of the limit.
# On armadillo-rollers and stack-6k the certificate takes 0.2 first detections, because the boxes
# have become smaller, and scaling back takes 3 to 4.
CERTIFICATE, CERTIFICATE_SHARE = 1.2, 0.05
SCALING, SCALING_SHARE = 4.0, 0.05
# Scaling back halves scales until this share of its time is gone. Then it sets them to 0 at once,
# which takes fewer rounds.
HALVING = 0.5


class TimePlan:
    """The stages of a run with a time limit, and what the limit ended.

    Without a limit, it does nothing.

    Args:
        deadline: The limit.
        n_certificates: How many certificates the run needs at its end.

    Attributes:
        deadline: As passed.
        stays: Whether everything unpinned stays at the start.
    """

    def __init__(self, deadline: Deadline, n_certificates: int = 1) -> None:
        """Begin outside of any stage."""
        self.deadline, self.stays = deadline, False
        self._n_certificates = n_certificates
        self._name, self._began_s, self._detection_s = "", 0.0, -1.0
        self._ended: list[str] = []  # names of the stages that the limit ended
        self._consequence = ""
        self._halves_until_s = float("inf")

    @property
    def reason(self) -> str:
        """What the limit ended, as sentences for the user; empty if it ended nothing."""
        if not self._ended:
            return ""
        limit = f"The time limit of {self.deadline.limit_s:g} s"
        return f"{limit} ended {' and '.join(self._ended)}. {self._consequence}"

    def begin_first_detection(self) -> None:
        """Begin the stage of the first detection."""
        self._begin("the first detection", FIRST_DETECTION * self.deadline.limit_s)
        self._began_s = self.deadline.elapsed_s()

    def begin_main(self) -> None:
        """Begin the main loop, if the detection that has just ended is the first one."""
        if self._detection_s < 0.0 and self.deadline.is_limited:
            self._detection_s = self.deadline.elapsed_s() - self._began_s
            scaling_s = SCALING * self._detection_s + SCALING_SHARE * self.deadline.limit_s
            self._begin("the main loop", self._before_certificate_s() - scaling_s)

    def begin_rounds(self) -> None:
        """Begin the rounds with new normals. They have a free path, so they need no fail-safe."""
        self._begin("the rounds with new normals", self._before_certificate_s())

    def begin_scaling_back(self) -> None:
        """Begin the fail-safe."""
        end_s = self._before_certificate_s()
        if self.deadline.is_limited:
            now_s = self.deadline.elapsed_s()
            self._halves_until_s = now_s + HALVING * (end_s - now_s)
        self._begin("scaling back", end_s)

    def halves(self) -> bool:
        """Return whether scaling back still has the time to halve scales."""
        return self._halves_until_s == float("inf") or (
            self.deadline.elapsed_s() < self._halves_until_s
        )

    def begin_certificate(self) -> None:
        """Begin the certificate of the path that was found."""
        self._begin("the certificate", LAST * self.deadline.limit_s)

    def begin_at_start(self) -> None:
        """Begin the certificate of the path on which everything unpinned stays at the start."""
        self._begin("the certificate of the start", AT_START * self.deadline.limit_s)

    def end(self) -> None:
        """End the last stage: what follows takes as long as it needs."""
        self._begin("", float("inf"))

    def stay(self) -> None:
        """Note that the limit ended the present stage, and nothing better is left to return."""
        self.stays = True
        self.note("All vertices that are not pinned stay at the start.")

    def note(self, consequence: str) -> None:
        """Note that the limit ended the present stage.

        Args:
            consequence: What is returned because of that, as a sentence.
        """
        self._ended.append(self._name)
        self._consequence = consequence

    def _before_certificate_s(self) -> float:
        """Return when the certificates have to begin [s]."""
        limit_s, detection_s = self.deadline.limit_s, max(self._detection_s, 0.0)
        needed_s = CERTIFICATE * detection_s + CERTIFICATE_SHARE * limit_s
        return LAST * limit_s - self._n_certificates * needed_s

    def _begin(self, name: str, end_s: float) -> None:
        self._name = name
        if self.deadline.is_limited:
            self.deadline.begin_stage(end_s)
