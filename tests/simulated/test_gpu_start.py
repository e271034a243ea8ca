"""Steps on a GPU that begin elsewhere than the last one ended; the CPU has the same verdicts."""

import weakref

import numpy as np
import pytest

import izo_ref
from izo_ref import Options, Scene, Status
from izo_ref.base.errors import (
    DeviceMemoryError,
    InitialIntersectionError,
    NonFiniteError,
    OptionError,
    ShapeError,
    UncertifiedStartError,
)
from izo_ref.base.gpu_arrays import shared_copy, to_cpu, to_gpu
from izo_ref.base.gpu_interop import own_array
from izo_ref.detection.gpu_detector import Detector
from izo_ref.detection.gpu_start import StartCheck
from izo_ref.detection.intersections import find_intersections
from izo_ref.detection.serial.found_counts import N_COUNTS, PAIRS
from izo_ref.loop import gpu_scene
from izo_ref.loop.gpu_scene import ResidentScene
from tests.helpers.shapes import pinched_sheet, two_sheets
from validation.study.gpu_counts import Counter, counting

THICKNESS = 1e-3
TWO_FACES = [[0, 1, 2], [3, 4, 5]]
LOW = np.array([[0, 0, 0], [3, 0, 0], [0, 3, 0]], float)
HIGH = np.array([[1, 1, 1], [2, 1, 2], [1, 2, 2]], float)
FREE = np.concatenate((LOW, HIGH))
pytestmark = pytest.mark.filterwarnings("ignore:.*(divide by zero|overflow|invalid value)")


def on_cpu(result):
    return to_cpu(own_array(result.positions))


def two_faces(high=HIGH, **named):
    """Return a scene of two faces at rest; the second one is at these positions."""
    start = np.concatenate((LOW, high))
    return Scene(start, start, TWO_FACES, **named)


def checked(scene, positions):
    """Return whether the GPU alone finds positions of the mesh of a scene free."""
    check = StartCheck(Detector(scene))
    check.start.copy_to_device(positions)
    return check.is_free()


def make_room(detector, n_pairs):
    """Give the lists of a detector room for so many pairs."""
    detector._make_room_for_pairs(n_pairs)
    detector._forget_launches()


@pytest.fixture
def no_cpu(monkeypatch):
    """Let it fail to check a start on the CPU."""

    def refused(*_):
        raise AssertionError("the CPU checks the start")

    monkeypatch.setattr(ResidentScene, "_checked_on_cpu", refused)


@pytest.mark.parametrize("kept", [0, 32])
@pytest.mark.parametrize("send", [np.copy, shared_copy])
def test_a_step_begins_where_it_is_told(rng, monkeypatch, no_cpu, kept, send):
    monkeypatch.setattr(gpu_scene, "KEPT_STEPS", kept)
    scene = two_sheets(rng, 2)
    on_gpu = ResidentScene(scene, THICKNESS)
    for _ in range(3):
        start = scene.positions_t0 + rng.normal(0, 1e-3, scene.positions_t0.shape)
        moved = Scene(start, scene.positions_t1, scene.faces, scene.masses)
        found = on_gpu.resolve(send(scene.positions_t1), send(start))
        expected = izo_ref.resolve(moved, THICKNESS)
        assert found.status is expected.status is Status.FREE
        assert found.n_impacts == len(expected.impacts.toi) > 0
        assert izo_ref.certify_path(moved, on_cpu(found)).free
        np.testing.assert_allclose(on_cpu(found), expected.positions, rtol=0.0, atol=1e-13)
    again = on_gpu.resolve(found.positions)
    assert np.array_equal(on_cpu(again), on_cpu(found)), "the next step begins at the end of it"


def test_a_reset_gives_the_same_bits_again(rng, no_cpu):
    scene = two_sheets(rng, 2)
    on_gpu = ResidentScene(scene, THICKNESS)
    first, again = (on_gpu.resolve(scene.positions_t1, scene.positions_t0) for _ in range(2))
    assert np.array_equal(on_cpu(first), on_cpu(again))
    assert first.n_impacts > 0
    plain = ResidentScene(scene, THICKNESS).resolve(scene.positions_t1)
    assert np.array_equal(on_cpu(first), on_cpu(plain))


def test_a_check_is_one_program_and_one_read(rng):
    scene = two_sheets(rng, 2)
    check = StartCheck(Detector(scene))
    check.start.copy_to_device(scene.positions_t0)
    assert check.is_free()
    with counting(Counter()) as counter:
        assert check.is_free()
    own = counter.counts
    assert (own.programs, own.nodes, own.launches, own.prepared, own.arrays) == (1, 6, 0, 0, 0)
    assert (own.reads, own.read_bytes, own.sends) == (1, 256, 0)


# Positions of the second face, and whether the GPU can tell that they are free.
STARTS = {
    "an edge through the face": (HIGH - (0, 0, 1.5), False),
    "all edges beyond the face": (HIGH - (0, 0, 2.5), True),
    "an edge that misses the face": (HIGH + (2.0, 0, -1.5), True),
    "a vertex on the face": (HIGH - (0, 0, 1), False),
    "a vertex on an edge": (HIGH - (1, 0, 1), False),
    "a vertex on a vertex": (HIGH - (1, 1, 1), False),
    "edges that meet in a point": ([[1, -1, -1], [1, 1, 1], [1, -1, 1]], False),
    "faces in one plane that overlap": ([[1, 1, 0], [2, 2, 0], [1, 3, 0]], False),
    "one face inside the other": ([[0.5, 0.5, 0], [1, 0.5, 0], [0.5, 1, 0]], False),
    "faces in one plane that are apart": ([[2, 2, 0], [3, 2, 0], [2, 3, 0]], True),
    "faces in one place": (LOW, False),
    "a face without area that is apart": ([[1, 1, 1], [1, 1, 2], [1, 1, 3]], True),
}


@pytest.mark.parametrize("name", STARTS)
@pytest.mark.parametrize("send", [np.copy, shared_copy])
def test_starts_are_judged_as_by_a_scene(name, send):
    high, is_free = STARTS[name]
    scene = two_faces()
    start = np.concatenate((LOW, high))
    assert checked(scene, start) == is_free
    on_gpu = ResidentScene(scene, THICKNESS)
    if is_free:
        assert np.array_equal(on_cpu(on_gpu.resolve(send(start), send(start))), start)
        return
    with pytest.raises(InitialIntersectionError) as expected:
        Scene(start, FREE, TWO_FACES)
    with pytest.raises(InitialIntersectionError) as found:
        on_gpu.resolve(send(FREE), send(start))
    assert str(found.value) == str(expected.value)
    assert str(found.value).startswith("positions_t0: ")
    assert np.array_equal(found.value.pairs.nodes, expected.value.pairs.nodes)
    raised = FREE + (0, 0, 0.5)
    assert np.array_equal(on_cpu(on_gpu.resolve(raised)), raised), "the scene goes on"
    with pytest.raises(InitialIntersectionError):
        on_gpu.resolve(raised, start)
    assert np.array_equal(on_cpu(on_gpu.resolve(FREE)), FREE), "and again after a step"


def test_elements_that_share_a_vertex_do_not_touch():
    fan = Scene(FREE, FREE, [[0, 1, 2], [0, 3, 4], [0, 4, 5], [0, 1, 2]])
    assert checked(fan, FREE), "two faces with the same vertices are no intersection"
    square = Scene(FREE[:4], FREE[:4], [[0, 1, 2], [1, 2, 3]])
    start = np.array([[0, 0, 0], [2, 0, 0], [0, 2, 0], [2, 2, 0]], float)
    assert checked(square, start), "flat"
    start[3] = 0.5, 0.5, 1e-3
    assert checked(square, start), "nearly folded"
    start[3, 2] = 0.0
    assert not checked(square, start), "a vertex in the face on the other side of the edge"


@pytest.mark.parametrize("choice", ["ratchet", "exclude"])
@pytest.mark.parametrize(
    ("down", "message"), [(1.0, "pairs that touch at the start"), (1.5, "pairs that are left out")]
)
def test_starts_that_need_the_cpu_each_step_are_refused(choice, down, message):
    on_gpu = ResidentScene(two_faces(initial_intersections=choice), THICKNESS)
    start = np.concatenate((LOW, HIGH - (0, 0, down)))
    with pytest.raises(OptionError, match=f"positions_t0: .* {message}"):
        on_gpu.resolve(FREE, start)
    assert np.array_equal(on_cpu(on_gpu.resolve(FREE)), FREE)


def test_pinned_parts_that_meet_and_vertices_to_weld_are_refused():
    on_gpu = ResidentScene(two_faces(pinned=np.ones(6, bool)), THICKNESS)
    start = np.concatenate((LOW, HIGH - (0, 0, 1.5)))
    with pytest.raises(OptionError, match=r"positions_t0: .* pairs that are left out"):
        on_gpu.resolve(start, start)
    on_gpu = ResidentScene(two_faces(weld=0), THICKNESS)
    start = np.concatenate((LOW, HIGH - (1, 1, 1)))
    with pytest.raises(OptionError, match=r"positions_t0: .* welded vertices"):
        on_gpu.resolve(start, start)


@pytest.mark.parametrize(
    ("bad", "error"),
    [
        (FREE[:-1], ShapeError),
        (FREE.astype(str), ShapeError),
        (shared_copy(FREE[:-1].copy()), ShapeError),
        (shared_copy(FREE.astype(np.float32)), ShapeError),
        (np.where(np.arange(6)[:, None] == 4, np.nan, FREE), NonFiniteError),
        (shared_copy(np.where(np.arange(6)[:, None] == 4, np.inf, FREE)), NonFiniteError),
        (FREE * 1e305, izo_ref.errors.SizeError),
    ],
)
def test_bad_starts_are_refused_and_change_nothing(bad, error):
    on_gpu = ResidentScene(two_faces(), THICKNESS)
    raised = FREE + (0, 0, 0.5)
    for end in (raised, FREE):
        with pytest.raises(error, match="positions_t0"):
            on_gpu.resolve(FREE, bad)
        with pytest.raises(ShapeError, match="positions_t1"):
            on_gpu.resolve(FREE[:-1], FREE)
        assert np.array_equal(on_cpu(on_gpu.resolve(end)), end)


def test_an_end_far_away_needs_no_check_on_the_cpu(no_cpu):
    on_gpu = ResidentScene(two_faces(), THICKNESS)
    far, raised = FREE + (1000.0, 0.0, 0.0), FREE + (0, 0, 0.5)
    found = on_gpu.resolve(far, raised)
    assert np.array_equal(on_cpu(found), far)
    assert np.array_equal(on_gpu._scene.positions_t0, raised)
    with pytest.raises(NonFiniteError, match="positions_t1"):
        on_gpu.resolve(far * np.nan, far)


@pytest.mark.parametrize("kept", [0, 32])
def test_old_buffers_are_gone_when_new_ones_are_made(monkeypatch, kept):
    monkeypatch.setattr(gpu_scene, "KEPT_STEPS", kept)
    on_gpu, make, alive = ResidentScene(two_faces(), THICKNESS), gpu_scene.GpuStep, []

    def made(*arguments):
        alive.append([old() for old in olds])
        return make(*arguments)

    monkeypatch.setattr(gpu_scene, "GpuStep", made)
    for start in (None, FREE + (0, 0, 0.5), FREE + (1000.0, 0.0, 0.0)):
        olds = [weakref.ref(on_gpu._step), weakref.ref(on_gpu._start_check)]
        on_gpu.resolve(FREE + (2000.0, 0.0, 0.0), start)
    assert alive == 3 * [[None, None]]


def test_a_start_far_away_gets_new_coordinates():
    on_gpu = ResidentScene(two_faces(), THICKNESS)
    far = FREE + (1000.0, 0.0, 0.0)
    assert np.array_equal(on_cpu(on_gpu.resolve(far, far)), far)
    crossing = np.concatenate((LOW, HIGH - (0, 0, 1.5))) - (1000.0, 0.0, 0.0)
    with pytest.raises(InitialIntersectionError, match=r"goe?s? through"):
        on_gpu.resolve(far, crossing)
    assert np.array_equal(on_cpu(on_gpu.resolve(far)), far)


def test_a_start_that_only_exact_arithmetic_proves_free():
    high = HIGH - (0, 0, 1)
    high[0, 2] = 1e-17
    start = np.concatenate((LOW, high))
    assert not checked(two_faces(), start)
    on_gpu = ResidentScene(two_faces(), THICKNESS)
    found, expected = on_gpu.resolve(FREE, start), izo_ref.resolve(Scene(start, FREE, TWO_FACES))
    assert found.status is expected.status is Status.FREE
    assert np.array_equal(on_cpu(found), FREE)


def test_a_blocked_step_is_followed_by_a_new_start():
    scene = pinched_sheet(-0.05, bump=0.2, side=2)
    on_gpu = ResidentScene(scene, THICKNESS)
    found = on_gpu.resolve(scene.positions_t1)
    assert found.status is Status.BLOCKED
    crossing = scene.positions_t0.copy()
    crossing[4, 2] += 0.3
    with pytest.raises(InitialIntersectionError):
        on_gpu.resolve(scene.positions_t0, crossing)
    with pytest.raises(UncertifiedStartError, match=r"was blocked.*pass positions_t0"):
        on_gpu.resolve(scene.positions_t0)
    again = on_gpu.resolve(scene.positions_t0, scene.positions_t0)
    assert again.status is Status.FREE
    assert np.array_equal(on_cpu(again), scene.positions_t0)
    assert on_gpu.resolve(scene.positions_t1).status is Status.BLOCKED


def test_a_step_that_an_error_ended_is_followed_by_a_new_start(rng, monkeypatch):
    scene = two_sheets(rng, 2)
    expected = on_cpu(ResidentScene(scene, THICKNESS).resolve(scene.positions_t1))
    on_gpu = ResidentScene(scene, THICKNESS)

    def failing(*_):
        raise DeviceMemoryError("no memory")

    for owner, name in ((gpu_scene.GpuStep, "select"), (gpu_scene.GpuStep, "__init__")):
        with monkeypatch.context() as patch:
            patch.setattr(owner, name, failing)
            with pytest.raises(DeviceMemoryError):
                on_gpu.resolve(scene.positions_t1, scene.positions_t0)
        with pytest.raises(UncertifiedStartError, match="ended with an error"):
            on_gpu.resolve(scene.positions_t1)
    found = on_gpu.resolve(scene.positions_t1, scene.positions_t0)
    assert np.array_equal(on_cpu(found), expected)


def test_a_step_by_the_fail_safe_begins_at_the_new_start(rng):
    scene = two_sheets(rng, 2)
    start = scene.positions_t0 + rng.normal(0, 1e-3, scene.positions_t0.shape)
    options = Options(max_iterations=1)
    found = ResidentScene(scene, THICKNESS, options).resolve(scene.positions_t1, start)
    moved = Scene(start, scene.positions_t1, scene.faces, scene.masses)
    expected = izo_ref.resolve(moved, THICKNESS, options=options)
    assert found.status is expected.status is Status.FREE_BY_FALLBACK
    np.testing.assert_allclose(on_cpu(found), expected.positions, rtol=0.0, atol=1e-13)


def random_starts(rng, kind, scene, n):
    """Yield positions of a mesh: some free, some not."""
    shape = scene.positions_t0.shape
    for _ in range(n):
        if kind == "integers":
            yield rng.integers(-2, 3, shape).astype(float)
        elif kind == "in a plane":
            yield np.column_stack(
                (rng.integers(-4, 5, (shape[0], 2)) * 0.1, np.full(shape[0], 0.3))
            )
        elif kind == "anywhere":
            yield rng.normal(size=shape)
        else:
            share = rng.random()
            own = (1.0 - share) * scene.positions_t0 + share * scene.positions_t1
            yield own + rng.normal(0, 0.02, shape)


@pytest.mark.parametrize("kind", ["integers", "in a plane", "anywhere", "on the path"])
def test_random_starts_are_judged_as_by_a_scene(rng, kind):
    seed = int(rng.integers(2**31))
    print(f"seed of the starts: {seed}")
    own = np.random.default_rng(seed)
    scene = two_sheets(own, 2)
    detector, on_gpu = Detector(scene), ResidentScene(scene, THICKNESS)
    check = StartCheck(detector)
    verdicts, is_generic = [], kind in {"anywhere", "on the path"}
    for start in random_starts(own, kind, scene, 25):
        expected = find_intersections(start, scene.edges, scene.faces).n_found == 0
        check.start.copy_to_device(start)
        make_room(detector, int(own.integers(0, 20)))
        said = check.is_free()
        assert expected or not said, "no start that intersects itself is said to be free"
        if is_generic:
            assert said == expected, "nothing touches or is in one plane by chance"
        try:
            on_gpu.resolve(start, start)
            found = True
        except InitialIntersectionError:
            found = False
        assert found == expected
        verdicts.append(expected)
    assert len(set(verdicts)) == 2 or not is_generic


def test_lists_that_are_too_short_grow(rng, monkeypatch):
    scene = two_sheets(rng, 2)
    expected = on_cpu(ResidentScene(scene, THICKNESS).resolve(scene.positions_t1))
    on_gpu = ResidentScene(scene, THICKNESS)
    detector = on_gpu._step.detector
    make_room(detector, 1)
    made = detector.n_arrays_made
    with pytest.raises(InitialIntersectionError):
        on_gpu.resolve(scene.positions_t1, scene.positions_t1 * (1.0, 1.0, 0.0))
    assert detector.n_arrays_made == made, "what may touch is enough for the CPU"
    found = on_gpu.resolve(scene.positions_t1, scene.positions_t0)
    assert np.array_equal(on_cpu(found), expected)
    assert detector.n_arrays_made > made
    assert detector is on_gpu._step.detector


def test_a_list_of_edges_and_faces_that_is_too_short_grows(rng):
    scene = two_sheets(rng, 3)
    detector = Detector(scene)
    check = StartCheck(detector)
    check.start.copy_to_device(scene.positions_t0)
    assert check.is_free()
    counts = to_cpu(check._counts)
    n_pairs, n_edge_faces = counts[PAIRS], counts[N_COUNTS + PAIRS]
    assert 0 < n_pairs < n_edge_faces
    make_room(detector, n_pairs)
    made = detector.n_arrays_made
    assert check.is_free()
    assert detector.n_arrays_made == made + 1


def test_lists_that_grow_for_a_start_are_those_of_the_step(rng):
    scene = two_sheets(rng, 4, gap=0.008)
    proposed = scene.positions_t0.copy()
    proposed[16, 2] -= 0.05  # a corner moves, so its path has fewer pairs than the whole start
    expected = ResidentScene(scene, THICKNESS).resolve(proposed)
    own = Detector(scene)
    own.find(to_gpu(proposed))
    room = sum(own.counts.pairs.values()) - 1
    on_gpu = ResidentScene(scene, THICKNESS)
    detector, stages = on_gpu._step.detector, on_gpu._step._stages
    make_room(detector, room)
    stages.prepare_anew()
    made = detector.n_arrays_made
    found = on_gpu.resolve(proposed, scene.positions_t0)
    assert detector.n_arrays_made == made + 1, "only the check of the start makes longer lists"
    assert found.n_impacts == expected.n_impacts > 0
    assert np.array_equal(on_cpu(found), on_cpu(expected))
