"""Faults of the step on a GPU: its buffers, and what it computes before the CPU asks for it."""

from validation.mutants.fault import ON_GPU, Fault

STEP, STAGES = "izo_ref/loop/gpu_step.py", "izo_ref/loop/gpu_stages.py"
START = "izo_ref/detection/gpu_start.py"


def _fault(name: str, file: str, old: str, new: str, what: str) -> Fault:
    """Return a fault that a test in the simulator has to notice."""
    tests = ("tests/cuda/test_simulator.py",)
    return Fault(name, file, old, new, what, tests, flag="gpu-only", not_by_vectors=ON_GPU)


GPU_STEP = [
    _fault(
        "starts-may-cross-on-the-device",
        START,
        "            if counts[CONTACTS] or counts[N_COUNTS + OPEN]:\n",
        "            if counts[CONTACTS]:\n",
        "A GPU takes a start at which edges go through faces.",
    ),
    _fault(
        "starts-may-touch-on-the-device",
        START,
        "            if counts[CONTACTS] or counts[N_COUNTS + OPEN]:\n",
        "            if counts[N_COUNTS + OPEN]:\n",
        "A GPU takes a start at which pairs touch.",
    ),
    _fault(
        "short-list-of-edges-and-faces",
        START,
        "            counts[PAIRS] = max(counts[PAIRS], counts[N_COUNTS + PAIRS])\n",
        "            counts[PAIRS] = max(counts[PAIRS], counts[OPEN])\n",
        "A GPU takes a start at which edges go through faces that found no room in a list.",
    ),
    _fault(
        "pairs-at-rest-are-not-checked",
        "izo_ref/detection/serial/group_boxes.py",
        "at_rest or differs(path.start, path.end, i)",
        "differs(path.start, path.end, i)",
        "A GPU takes every start, because it looks at no pair there.",
    ),
    _fault(
        "lists-that-grew-for-a-start-are-not-those-of-the-step",
        STEP,
        "        self._stages.prepare_anew()\n",
        "        self._stages.prepare_anew.__call__\n",
        "A step on a GPU writes to lists that are too short, and finds no impact.",
    ),
    _fault(
        "new-start-not-taken",
        STEP,
        "        self.detector.go_on(start)\n",
        "        self.detector.go_on(self.positions)\n",
        "A step on a GPU begins where the last one ended, whatever start it gets.",
    ),
    _fault(
        "refused-start-is-not-checked-on-the-cpu",
        "izo_ref/loop/gpu_scene.py",
        '        if has_start and ("positions_t0" in far or not check.is_free()):\n',
        '        if has_start and ("positions_t0" in far and not check.is_free()):\n',
        "A step on a GPU begins at a start that intersects itself.",
    ),
    _fault(
        "detection-before-the-zones-that-were-left",
        STEP,
        "self._is_detected = False, own.zones_left is None\n",
        "self._is_detected = False, True\n",
        "The impacts of a path are kept although the CPU has moved some zones since.",
    ),
    _fault(
        "zones-that-were-left-are-not-measured",
        STEP,
        "        own.measure()\n",
        "        own.measure.__call__\n",
        "The objective leaves out the zones that the CPU has solved for a GPU.",
    ),
    _fault(
        "ends-seen-last-are-forgotten-on-the-device",
        STEP,
        "        detector.remember(self.positions)\n",
        "        detector.remember(self.proposed)\n",
        "On a GPU, vertices count as moved that stay where they were.",
    ),
    _fault(
        "longest-path-follows-the-current-one-on-the-device",
        STEP,
        "            self.longest = (self._longest, found.time_free)\n",
        "            self.longest = (self.positions, found.time_free)\n",
        "On a GPU, the ends of the path that was free for the longest time change afterwards.",
    ),
    _fault(
        "restored-counts-of-active-impacts-are-old",
        STEP,
        "self._squares, self._n_active = saved\n",
        "self._squares, _ = saved\n",
        "A step on a GPU that goes back to an earlier state keeps the number of active impacts.",
    ),
    _fault(
        "selection-not-repeated-with-more-room",
        STAGES,
        "        while self.grow():\n",
        "        while self.grow() and self.total_mass < 0.0:\n",
        "On a GPU, impacts that find no room never enter the zones.",
    ),
    _fault(
        "selection-repeated-without-the-impacts-of-the-cpu",
        STAGES,
        "            self._put_found()  # the detection of the program has found other impacts\n",
        "",
        "On a GPU, impacts that the CPU decided are lost if the selection needs more room.",
    ),
    _fault(
        "impacts-of-the-cpu-are-not-taken",
        STAGES,
        "        self._found_with_cpu = None if found.in_place else found.impacts\n",
        "        self._found_with_cpu = None\n",
        "On a GPU, impacts of parts that touch at the start never enter the zones.",
    ),
    _fault(
        "impacts-of-the-cpu-are-kept",
        STAGES,
        "        self._found_with_cpu = None if found.in_place else found.impacts\n",
        "        if not found.in_place:\n            self._found_with_cpu = found.impacts\n",
        "On a GPU, impacts that the CPU decided come back in later detections.",
    ),
    _fault(
        "detection-not-repeated-with-more-room",
        STAGES,
        "            self._prepare()\n            self._run(self._programs.detection)\n",
        "            self._prepare()\n",
        "On a GPU, a path with more pairs or contacts than there is room for has no impacts.",
    ),
    _fault(
        "old-impacts-are-not-solved-again-on-the-device",
        STAGES,
        "        own[group_counts.FIRST_NEW], own[group_counts.IMPACTS] = 0, n\n",
        "        own[group_counts.IMPACTS] = n\n",
        "On a GPU, a round with new normals solves the zones of the last selection only.",
    ),
    _fault(
        "following-step-in-old-buffers",
        STAGES,
        "        if self.detector.n_arrays_made != self._n_arrays_prepared:\n",
        "        if self.detector.n_arrays_made < 0:\n",
        "The next step on a GPU writes to buffers that were replaced by larger ones.",
    ),
]
