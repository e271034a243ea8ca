"""The device: what its kernels need, whether it finds the same, and how long it takes.

Needs numba, numba-cuda, numpy and scipy; ptxas, or a GPU, for what they are there for.
"""

import numpy as np

from izo_ref import find_impacts
from izo_ref.errors import DeviceUnavailable
from izo_ref.gpu.device import require_device
from validation import ptx
from validation.rows import Rows
from validation.study import steps
from validation.study.timing import measure

REPEATS = 5  # of which the median is taken, after one that does not count
CPU_BUDGET_S = 20.0  # for those of the processor


def _kernels(folder, say):
    """What ptxas says of every kernel."""
    rows = Rows(folder, "kernels", ("kernel", "types", "capability"))
    if ptx.ptxas() is None:
        say("kernels: no ptxas (nvidia-cuda-nvcc)")
        return
    for name, kernel in ptx.kernels():
        for types, signature in ptx.signatures(kernel).items():
            for major, minor in ptx.CAPABILITIES:
                key = {"kernel": name, "types": types, "capability": f"{major}.{minor}"}
                if not rows.has(**key):
                    rows.add(**key, **ptx.build(kernel, signature, (major, minor))._asdict())
        say(f"kernels: {name}")


def _detection(folder, say):
    """All impacts of a step: the same as the processor's, and the time of both."""
    rows = Rows(folder, "detection", ("step",))
    try:
        require_device()
    except DeviceUnavailable as error:
        say(f"detection: {error}")
        return
    from numba import cuda

    from izo_ref.gpu.arrays import on_device, on_host
    from izo_ref.gpu.detect import Detector

    gpu = getattr(cuda.get_current_device(), "name", "simulator")
    for step in steps.step_names():
        if rows.has(step=step):
            continue
        scene = steps.load_step(step)
        detector, end = Detector(scene), on_device(scene.positions_t1)
        found = [on_host(column) for column in detector.find(end)]
        expected = find_impacts(scene)
        rows.add(
            step=step,
            gpu=gpu.decode() if isinstance(gpu, bytes) else gpu,
            triangles=len(scene.faces),
            impacts=len(expected.toi),
            **_differences(found, expected),
            gpu_ms=_event_ms(lambda d=detector, e=end: d.find(e)),
            cpu_ms=1e3 * measure(lambda s=scene: find_impacts(s), REPEATS, CPU_BUDGET_S).seconds,
        )
        say(f"detection: {step}: {rows.all()[-1]['gpu_ms']:.2f} ms")


def _differences(found, expected):
    """Pairs of one alone; of both, the farthest times and normals."""
    nodes, kinds, toi, _, normals = found
    own, other = (
        {(bool(k), *map(int, row)): i for i, (k, row) in enumerate(zip(ks, ns, strict=True))}
        for ks, ns in ((kinds, nodes), (expected.is_edge_edge, expected.nodes))
    )
    both = sorted(own.keys() & other.keys())
    a, b = [own[key] for key in both], [other[key] for key in both]
    return {
        "only_gpu": len(own) - len(both),
        "only_cpu": len(other) - len(both),
        "toi_difference": float(np.abs(toi[a] - expected.toi[b]).max(initial=0.0)),
        "normal_difference": float(np.abs(normals[a] - expected.normals[b]).max(initial=0.0)),
    }


def _event_ms(call):
    from numba import cuda

    call()
    times = []
    for _ in range(REPEATS):
        begin, end = cuda.event(), cuda.event()
        begin.record()
        call()
        end.record()
        end.synchronize()
        times.append(begin.elapsed_time(end))
    return float(np.median(times))


PARTS = {"kernels": _kernels, "detection": _detection}
