# SPDX-License-Identifier: Apache-2.0
"""Threads, processes, signals, progress, memory."""
import gc
import multiprocessing
import os
import pickle
import subprocess
import sys
import weakref
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import cellwalk as cw
from conftest import random_rays, rough, same
from program import PRELOAD, read

Z = rough(257, 257)


def test_threads_on_one_field():
    field = cw.Field(Z, threads=2)
    rays = [random_rays(field, 60000, seed) for seed in range(4)]

    def ask(k):
        return field.closest(rays[k % 4]).records.tobytes(), field.shadow().tobytes()
    with ThreadPoolExecutor(4) as threads:
        assert list(threads.map(ask, range(20))) == 5 * [ask(k) for k in range(4)]


def test_update_and_queries_keep_apart():
    """Each query sees the samples of before or after an update, and who comes second is refused. No update is lost, also if it is the
    first, which copies the samples."""
    n, seen, refused = 500, set(), set()
    origins = np.column_stack([np.linspace(1, 127, n), np.linspace(1, 62, n), np.full(n, 9.0)])
    for _ in range(100):
        field, wanted = cw.Field(np.zeros((129, 129), np.float32), threads=1), np.zeros((129, 129), np.float32)

        def update(rows, height):
            field.update(rows.start, 0, np.full((rows.stop - rows.start, 129), height, np.float32))
            wanted[rows] = height

        def query():
            seen.add(tuple(np.unique(field.closest(origins, [0, 0, -1]).t).tolist()))
        with ThreadPoolExecutor(3) as threads:
            asked = [threads.submit(*work) for k in range(8)
                     for work in ((update, slice(64 + 8 * k, 72 + 8 * k), 5), (update, slice(0, 64), k % 2), (query,))]
        same(field.z[64:], wanted[64:])
        refused |= {str(one.exception()) for one in asked if one.exception()}
    assert seen == {(9.0,), (8.0,)} and all("running" in r or "changed" in r for r in refused)


INHERITED = cw.Field(Z, threads=2)


def _ask(field):
    field = INHERITED if field is None else field if isinstance(field, cw.Field) else cw.open(field)
    return field.closest(random_rays(field, 3000)).records.tobytes(), field.sky_view(4).tobytes()


@pytest.mark.parametrize("start, processes", [("fork", 2), ("spawn", 1)])
def test_other_processes(tmp_path, start, processes):
    """Pools have threads in this one, which a child lacks."""
    np.save(tmp_path / "z.npy", Z)
    field = cw.open(tmp_path / "z.npy")
    wanted = _ask(None)
    with multiprocessing.get_context(start).Pool(processes) as pool:
        assert pool.map_async(_ask, [None, field, str(tmp_path / "z.npy"), None]).get(300) == [wanted] * 4


# Pools that nobody uses end.
THREADS = """
import os, threading, numpy as np, cellwalk as cw
def ask(threads):
    field = cw.Field(np.zeros((300, 300), "float32"), threads=threads)
    return field.closest(np.full((9000, 3), 50.0), [0, 0, -1]).t
assert (ask(1) == 50).all()
alone = len(os.listdir("/proc/self/task"))
for threads in range(2, 33):
    assert (ask(threads) == 50).all()
# The two pools used last: 31 and 32 threads, of which the caller's is one each.
assert len(os.listdir("/proc/self/task")) - alone <= 31 + 30, len(os.listdir("/proc/self/task"))
wrong = []
def many(first):
    for threads in range(first, first + 20):
        wrong.extend(ask(2 + threads % 7)[ask(2 + threads % 5) != 50])
asking = [threading.Thread(target=many, args=(k,)) for k in range(4)]
[t.start() for t in asking], [t.join() for t in asking]
assert not wrong
if os.fork() == 0:
    os._exit(0 if (ask(8) == 50).all() and (ask(3) == 50).all() else 1)
assert os.wait()[1] == 0
"""


# A fork while a thread reads: its lock would stay locked in the child. The thread goes on reading until the fork has begun, and from then
# on runs only if the fork waits for it.
READ = """
import os, signal, sys, threading, numpy as np, cellwalk as cw
np.save("z.npy", np.zeros((20, 20), "float32"))
inside, forking = threading.Event(), threading.Event()
def read():
    with cw._core.raster_door:
        inside.set()
        forking.wait()
threading.Thread(target=read).start()
inside.wait()
sys.setswitchinterval(99)
os.register_at_fork(before=forking.set)  # runs before cellwalk's, which was registered earlier
if os.fork() == 0:
    signal.alarm(20)
    cw.open("z.npy")
    os._exit(0)
assert os.wait()[1] == 0
"""

# Files may change while a field lives.
CUT = """
import os, sys, numpy as np, cellwalk as cw
z = np.random.default_rng(1).normal(0, 9, (700, 600))
for dtype in ("<f4", "<f8"):
    for window in (None, (20, 30, 400, 500)):
        np.save("z.npy", z.astype(dtype))
        field, same = cw.open("z.npy", window=window), cw.open("z.npy", window=window)
        wanted = same.shadow(200, 20)
        os.truncate("z.npy", 200)  # mapped pages behind the end would kill this process
        assert (field.shadow(200, 20) == wanted).all()
        np.save("z.npy", -z.astype(dtype))
        assert (field.shadow(200, 20) == wanted).all() and (field.z == same.z).all()
"""


@pytest.mark.parametrize("code", [THREADS, READ, CUT], ids=["pools", "fork", "files"])
def test_processes_of_their_own(code):
    subprocess.run([sys.executable, "-c", code], check=True)


def test_pickles_are_of_the_same_field(tmp_path):
    path = tmp_path / "z.npy"
    np.save(path, Z)
    whole, part = cw.open(path), cw.open(path, window=(5, 5, 40, 30))
    pickles = [pickle.dumps(whole), pickle.dumps(part)]
    same(pickle.loads(pickles[0]).z, Z)
    np.save(path, Z[:200])
    with pytest.raises(ValueError, match="z.npy: 200 x 257 samples, the pickled field had 257 x 257"):
        pickle.loads(pickles[0])
    same(pickle.loads(pickles[1]).z, Z[5:35, 5:45])
    part.update(0, 0, np.zeros((3, 3), np.float32))
    with pytest.raises(TypeError, match="not pickled after update"):
        pickle.dumps(part)


def test_progress():
    """A callable gets growing shares up to 1, and ends the query by an exception; what has update() gets its total."""
    field, told = cw.Field(Z), []
    rays = random_rays(field, 1000)

    class Bar:  # like tqdm's
        total, n = 50, 0

        def update(self, more):
            self.n += more
    for ask in (lambda progress: field.closest(rays, progress=progress), lambda progress: field.sky_view(64, progress=progress),
                lambda progress: field.viewshed(128, 128, progress=progress), lambda progress: cw.Field(Z, progress=progress)):
        ask(told.append)
        assert told == sorted(told) and told[-1] == 1 and all(0 <= share <= 1 for share in told)
        told.clear()
        with pytest.raises(ZeroDivisionError):
            ask(lambda share: 1 / 0)
        ask(bar := Bar())
        assert bar.n == pytest.approx(50)
    assert field.closest(rays).hit.any()


# A call that takes long ends from within, by what a progress callable raises or by a signal after 0.1 s of the process's CPU time; not behind it.
SLOW = """
import signal, sys, traceback, numpy as np, cellwalk as cw
z, far = {field}, np.full(8_000_000, 2000.)
f, progress = cw.Field(z.astype('float32'), threads={threads}), {progress}
def end(cause, frame):
    sys.exit(not any(frame.f_code.co_name == 'python_watch' for frame, _ in traceback.walk_stack(frame)))
signal.signal(signal.SIGPROF, end)
signal.setitimer(signal.ITIMER_PROF, 0 if progress else 0.1)
{call}
sys.exit('the call has come to its end')
"""
HILLS = "np.add.outer(60 * np.sin(np.arange(4097) / 90), 50 * np.cos(np.arange(4097) / 70))"


# Rays along a plane, just above it; on large land, of which Python makes one call for each direction.
@pytest.mark.parametrize("threads, progress", [(1, None), (2, None), (2, "lambda share: end(share, sys._getframe())")])
@pytest.mark.parametrize("field, call", [
    ("np.full((1025, 1025), .5).cumsum(1)", "f.occluded([1, 512, 1.0001], [1, 0, .5], tmax=far, progress=progress)"),
    *((HILLS, f"f.{call}, progress=progress)") for call in ("sky_view(3600", "horizon(8", "viewshed(2048, 2048, needed=True"))])
def test_long_calls_end_early(field, call, threads, progress):
    subprocess.run([sys.executable, "-c", SLOW.format(field=field, call=call, threads=threads, progress=progress)], check=True)


def use(times):
    big = rough(513, 513)
    np.save("z.npy", Z)
    for _ in range(times):
        field = cw.Field(big, progress=lambda share: None)
        h = field.closest(random_rays(field, 200))
        h.points(), h.normals(True), field.at([1, 2], [3, 4])
        field.update(0, 0, np.zeros((3, 3)))
        field.shadow(), field.horizon(2), field.sky_view(2), field.viewshed(9, 9), field.line_of_sight((1, 1, 2), (50, 50, 2))
        cw.open("z.npy")
        for wrong in (lambda: field.closest([1, 2]), lambda: field.update(0, 0, np.full((3, 3), 2e30)),
                      lambda: field.closest([1, 1, 1], [0, 0, 1], kernel="none"), lambda: cw.Field(np.full((99, 999), 1e35)),
                      lambda: cw.open("missing.npy"), lambda: field.viewshed(-9, 9)):
            with pytest.raises((ValueError, OSError)):
                wrong()
    gc.collect()


def test_nothing_leaks():
    """Python keeps fewer than ten blocks a time, and C less than one (../faults/preload.c), which some things that happen once need."""
    use(5)
    before = sys.getallocatedblocks()
    use(30)
    assert sys.getallocatedblocks() - before < 30 * 10
    kept = []
    for times in 5, 85:
        program = f"import sys; sys.path[:] = {sys.path!r}; import test_process; test_process.use({times})"
        subprocess.run([sys.executable, "-c", program], check=True, env={**os.environ, "LD_PRELOAD": PRELOAD, "CELLWALK_FAULT_COUNTS": "counts"})
        kept.append(int(read("counts").split()[-1]))
    assert kept[1] - kept[0] < 80


def test_samples_live_as_long_as_the_field():
    """And that as long as hits of it; a field of a copy lets go of what it was given."""
    z = rough(holes=False)
    field, h = cw.Field(z.copy()), cw.Field(z.copy()).closest([5, 5, 99], [0, 0, -1])
    wanted, given, copied = cw.Field(z).at(5, 5), weakref.ref(z), cw.Field(z, copy=True)
    del z
    gc.collect()
    assert given() is None and field.at(5, 5) == copied.at(5, 5) == h.points()[2] == wanted


def test_sub_interpreters_are_refused():
    subinterpreters = pytest.importorskip("_xxsubinterpreters")
    number = subinterpreters.create()
    subinterpreters.run_string(number, f"import sys\nsys.path[:] = {sys.path!r}\ntry:\n    import cellwalk\nexcept ImportError as e:\n"
                               "    assert 'sub-interpreters' in str(e), e\nelse:\n    raise AssertionError('imported')\n")
    subinterpreters.destroy(number)
