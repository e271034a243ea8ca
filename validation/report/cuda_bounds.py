"""Sections of the page of a GPU that need none: counts, lower bounds, kernels and occupancy."""

from izo_ref.base.cuda.compile import THREADS
from validation.occupancy import occupancy
from validation.ptx import FRAMES
from validation.report.tables import NOT_MEASURED, table
from validation.rows import Columns, Row
from validation.study.gpu_bounds import (
    Sizes,
    calls_ms,
    goal_counts,
    stage_ms,
    stages_of,
    step_ms,
    waits_ms,
    zone_ms,
)
from validation.study.gpu_counts import Counts
from validation.study.gpu_limits import LIMITS
from validation.study.gpu_machines import MACHINES
from validation.study.group_zones import GroupZone, count_waits

OURS = "H200"  # the goals are set for this GPU
GOALS_MS = {100_000: 5.0, 1_000_000: 30.0}  # of a whole step, by triangles
ZONE_GOAL_MS = 1.0  # of a zone of a thousand impacts
NEAR = 0.01  # a scene has the nearest number of triangles that two square sheets can have
MANY_THREADS = 256
COMPUTED = "computed, not measured"
COUNTS_INTRO = (
    "The simulator runs sheets that meet, and counts what each iteration asks of a GPU. Then the "
    "host code that runs on a GPU runs over a driver that runs no kernels, and has to ask for the "
    "same. The table has the largest counts of the iterations after the first one. A test holds "
    "them to the limits, which are those of `validation/study/gpu_limits.py`."
)
HOST = (
    "Python alone takes {host_ms:.2g} ms for such an iteration, over the driver that runs nothing. "
    "This is measured, on the machine that counted, and not a time of a GPU."
)
BOUNDS_INTRO = (
    "Every time in this section is computed, not measured. Sizes of the steps (pairs, impacts, "
    "zones, iterations) are measured on a CPU, on sheets that meet. From them follow the bytes "
    "that each stage of an iteration has to move, if it reads each input once and writes each "
    "output once. The operations are those in float64 of the proofs, and of one dense "
    "factorisation of each zone, n^3 / 3 for n active impacts. Those of the proofs are counted by "
    "running their text as Python on numbers that count: {each:.0f} operations a pair, on average. "
    "A stage takes at least the time to move its bytes at the published bandwidth, or the time to "
    "compute at the published rate of float64, whichever is longer. A real kernel takes longer: "
    "its reads are scattered, and its threads wait for each other."
)
SOURCES = (
    "Bandwidths, rates and links are those of NVIDIA's data sheets. A launch takes 3 us, a kernel "
    "of a graph 0.5 us; a read of the host counts as nothing, because no published time was found; "
    "`validation/study/gpu_machines.py` names the sources. For the H200, 0.7 us for a kernel of a "
    "graph, 21 us for a read of 64 bytes and 26 us for a new array were measured."
)
STEPS_INTRO = (
    "A whole step is its iterations, one more detection for the certificate, and the way of the "
    "positions to the GPU and back. The host asks for work while the GPU works, so the longer of "
    "the two counts; the reads are added. The counts now are those of the table above. The counts "
    "of the goal are one program with 15 kernels, one read and no arrays. The time of the CPU is "
    "that of the loop and the certificate, the median of five runs; the goal is that a GPU is 30 "
    "times as fast as two cores."
)
ZONES_INTRO = (
    "One block solves a zone of up to 1,024 impacts if its factor has at most 256 tiles; all "
    "blocks solve others together. There is no last solution here. The solves, the tiles of the "
    "factor and its operations are those of the same text on one thread. The time of the "
    "operations is that of one factor for each solve, at the published rate of one multiprocessor "
    "or of all. The waits of all blocks for each other are counted from these; one takes 1.3 us on "
    "an H200 (measured). The waits in a block are not counted, because the time of one is not "
    "measured. The sum of both is compared with the goal. The real time is longer, because most "
    "steps between two waits read memory that is far away."
)
KERNELS_INTRO = (
    "ptxas says what each kernel needs. From that follows how many threads a multiprocessor holds, "
    "by the limits of NVIDIA's CUDA C++ Programming Guide, for blocks of 128 and of 256 threads, "
    "without dynamic shared memory. The share is that of the threads that it could hold."
)
KERNELS: Columns = {
    "kernel": "kernel",
    "types": "types",
    "compute capability": "capability",
    "registers": "registers",
    "fixed shared [B]": "shared_bytes",
    "stack [B]": "stack_bytes",
    "spilled [B]": "spilled_bytes",
    "threads, blocks of 128": "few",
    "share": "few_share",
    "threads, blocks of 256": "many",
    "share of these": "many_share",
}


SIZES: Columns = {
    "triangles": "triangles",
    "vertices": "vertices",
    "edges": "edges",
    "pairs of the first detection": "pairs",
    "impacts of the first detection": "found",
    "impacts in zones at the end": "impacts",
    "zones": "zones",
    "sum of (active impacts of a zone)^3": "rows_cubed",
    "iterations": "iterations",
}


def counts_section(
    before: Counts | None, now: Counts | None, host_ms: float | None = None
) -> list[str]:
    """Return the section of counts.

    Args:
        before: Counts of an iteration before the work of an iteration became a few programs.
        now: Counts of an iteration; None if they were not measured.
        host_ms: Time of Python for such an iteration, measured where it was counted [ms].
    """
    title = "## Launches, arrays and reads of an iteration"
    if now is None:
        return [title, COUNTS_INTRO, NOT_MEASURED]
    lines = [
        {
            "count": name.replace("_", " "),
            "before": None if before is None else getattr(before, name),
            "now": getattr(now, name),
            "most": limit.most,
            "goal": limit.goal,
            "reason": limit.reason,
        }
        for name, limit in LIMITS.items()
    ]
    columns: Columns = {
        "an iteration asks for": "count",
        "before": "before",
        "now": "now",
        "limit": "most",
        "goal": "goal",
        "why it counts": "reason",
    }
    sections = [title, COUNTS_INTRO, table(columns, lines)]
    if host_ms is not None:
        sections.append(HOST.format(host_ms=host_ms))
    return sections


def bounds_section(sizes: list[Row], zones: list[Row], counts: Counts | None) -> list[str]:
    """Return the section of lower bounds.

    Args:
        sizes: Rows of the sizes of steps.
        zones: Rows of the sizes of zones.
        counts: Counts of an iteration; None if they were not measured.
    """
    title = "## Lower bounds: computed, not measured"
    if not sizes or counts is None:
        return [title, NOT_MEASURED]
    own = [(Sizes(*(row[name] for name in Sizes._fields)), row) for row in sizes]
    each = own[-1][1]["operations_of_a_pair"]
    return [
        title,
        BOUNDS_INTRO.format(each=each),
        SOURCES,
        table(SIZES, sizes),
        "Stages of one iteration:",
        _stages(own),
        STEPS_INTRO,
        _steps(own, counts),
        ZONES_INTRO,
        _zones(zones) if zones else NOT_MEASURED,
    ]


def goal_ms(triangles: int) -> float | None:
    """Return the goal for a step with about this many triangles [ms]; None if there is none."""
    return next((ms for n, ms in GOALS_MS.items() if abs(triangles / n - 1.0) < NEAR), None)


def _stages(own: list[tuple[Sizes, Row]]) -> str:
    """Return the table of the stages of an iteration."""
    lines = [
        {
            "triangles": sizes.triangles,
            "stage": stage.name,
            "mb": stage.n_bytes / 1e6,
            "mflop": stage.operations / 1e6,
            "how": COMPUTED,
        }
        | {name: stage_ms(stage, machine) for name, machine in MACHINES.items()}
        for sizes, row in own
        for stage in stages_of(sizes, row["operations_of_a_pair"])
    ]
    columns: Columns = {"triangles": "triangles", "stage": "stage", "bytes [MB]": "mb"}
    columns["operations [10^6]"] = "mflop"
    return table(columns | _times(), lines)


def _times() -> Columns:
    """Return the columns of the times on each GPU."""
    return {**{f"{name} [ms]": name for name in MACHINES}, "how": "how"}


def _steps(own: list[tuple[Sizes, Row]], now: Counts) -> str:
    """Return the table of whole steps, and whether they allow the goal."""
    lines: list[Row] = []
    for sizes, row in own:
        goal = goal_ms(sizes.triangles)
        for name, counts in (("counts now", now), ("counts of the goal", goal_counts())):
            line: Row = {"triangles": sizes.triangles, "iterations": sizes.iterations}
            calls = calls_ms(counts, MACHINES[OURS])
            reads = 1e3 * counts.reads * MACHINES[OURS].read_s
            times = {
                gpu: step_ms(sizes, row["operations_of_a_pair"], counts, machine)
                for gpu, machine in MACHINES.items()
            }
            inside = None if goal is None else times[OURS] <= goal
            more = {"with": name, "goal": goal, "inside": inside, "how": COMPUTED}
            if row.get("cpu_ms"):
                more |= {"cpu": row["cpu_ms"], "ratio": row["cpu_ms"] / times[OURS]}
            lines.append(line | {"calls": calls, "reads": reads} | times | more)
    columns: Columns = {"triangles": "triangles", "iterations": "iterations", "with": "with"}
    columns |= {f"{OURS}: calls of an iteration [ms]": "calls", "its reads [ms]": "reads"}
    columns |= {f"{name}, step [ms]": name for name in MACHINES}
    columns |= {"goal [ms]": "goal", f"{OURS}: within the goal": "inside"}
    columns |= {"two CPU cores, measured [ms]": "cpu", f"CPU / {OURS}": "ratio", "how": "how"}
    return table(columns, lines)


def _zones(rows: list[Row]) -> str:
    """Return the table of zones of a thousand impacts."""
    lines: list[Row] = []
    for row in rows:
        own = GroupZone(*(row[name] for name in GroupZone._fields))
        for name, all_blocks in (("one block", False), ("all blocks", True)):
            times = {
                gpu: zone_ms(own, machine, machine.n_multiprocessors if all_blocks else 1)
                for gpu, machine in MACHINES.items()
            }
            waits = waits_ms(own) if all_blocks else None
            inside = times[OURS] + (waits or 0.0) <= ZONE_GOAL_MS
            more = {"n_waits": count_waits(own) if all_blocks else None, "waits": waits}
            more |= {"on": name, "goal": ZONE_GOAL_MS, "inside": inside, "how": COMPUTED}
            lines.append(row | times | more)
    names = "zone", "impacts", "solved", "active", "solves", "tiles", "on"
    columns: Columns = {name: name for name in names}
    columns |= {"waits": "n_waits"} | {f"{name} [ms]": name for name in MACHINES}
    columns |= {f"{OURS}: waits [ms]": "waits", "goal [ms]": "goal"}
    columns |= {f"{OURS}: within the goal": "inside", "how": "how"}
    return table(columns, lines)


def kernels_section(rows: list[Row]) -> list[str]:
    """Return the section of the kernels: what they need, and their occupancy."""
    # stable, so that the kernels stay in the order of their files
    order = list(dict.fromkeys((row["kernel"], row["types"]) for row in rows))
    places = {name: place for place, name in enumerate(order)}
    rows = sorted(rows, key=lambda r: (places[r["kernel"], r["types"]], float(r["capability"])))
    lines = [row | _occupancies(row) for row in rows]
    return [
        "## Kernels",
        KERNELS_INTRO,
        table(KERNELS, lines) if lines else NOT_MEASURED,
        *(f"`{kernel}` has a stack frame: {reason}." for kernel, reason in FRAMES.items()),
    ]


def _occupancies(row: Row) -> Row:
    """Return the threads of a kernel that a multiprocessor holds, and their share."""
    major, minor = map(int, str(row["capability"]).split("."))
    found: Row = {}
    for name, n_threads in (("few", THREADS), ("many", MANY_THREADS)):
        own = occupancy((major, minor), n_threads, row["registers"], row["shared_bytes"])
        found |= {name: own.threads, f"{name}_share": own.share}
    return found
