"""Making maps: killed and resumed, by threads and by Dask, within time and memory."""

import contextlib
import hashlib
import itertools
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
import warnings
from pathlib import Path

import numpy as np
import pytest

import srs_ik
from srs_ik.errors import InvalidMap
from srs_ik.maps import build, build_map, tasks
from srs_ik.maps.store import Store

pytest.importorskip("zarr")

MAKE = """
import sys
import srs_ik
if __name__ == "__main__":
    srs_ik.build_map(srs_ik.load("human_arm"), 0.04, sys.argv[1], orientations=576, threads=2)
"""


CLUSTER_MAKE = """
import sys
import srs_ik
from dask.distributed import Client
if __name__ == "__main__":
    with Client(scheduler_file=sys.argv[2], timeout=60) as client:
        srs_ik.build_map(srs_ik.load("human_arm"), 0.04, sys.argv[1], client, orientations=576)
"""


def digests(path: Path) -> dict[str, str]:
    """Every file of a store, by its content."""
    return {
        str(each.relative_to(path)): hashlib.sha256(each.read_bytes()).hexdigest()
        for each in sorted(path.rglob("*"))
        if each.is_file()
    }


def block_cells(plan, block) -> int:
    return int(np.prod([part.stop - part.start for part in block])) * len(plan.orientations)


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    path = tmp_path_factory.mktemp("whole") / "map.zarr"
    build_map(srs_ik.load("human_arm"), 0.04, path, orientations=576)
    return path


def test_killed_at_any_moment_and_resumed_the_store_is_the_same(undisturbed, tmp_path, monkeypatch):
    path, rng, kills = tmp_path / "map.zarr", np.random.default_rng(36), int(os.environ.get("KILLS", "3"))
    assert len(Store(undisturbed).plan.blocks) > 4
    for _ in range(kills):
        process = subprocess.Popen([sys.executable, "-c", MAKE, str(path)])
        limit = time.monotonic() + 120.0
        while not path.exists() and process.poll() is None and time.monotonic() < limit:
            time.sleep(0.01)
        time.sleep(float(rng.uniform(0.0, 2.5)))
        process.send_signal(signal.SIGKILL)
        process.wait()
    plan, records = Store(path).plan, Store(path).records()
    done = sum(block_cells(plan, block) for block, record in zip(plan.blocks, records, strict=True) if record)
    said, made, run = [], [], tasks.run_task
    monkeypatch.setattr(
        build, "run_task", lambda job, path, task, stop: made.append(task) or run(job, path, task, stop)
    )
    build_map(srs_ik.load("human_arm"), 0.04, path, orientations=576, progress=lambda *cells: said.append(cells))
    assert digests(path) == digests(undisturbed)
    np.testing.assert_array_equal(sorted(made), np.flatnonzero(records == 0))  # what was done is not done again
    assert done == 0 or (done, plan.cells) in said
    assert said == sorted(said)
    assert said[-1][0] == said[-1][1]
    assert not list(tmp_path.glob(".*"))


def test_of_processes_that_start_together_one_makes_the_map_and_others_say_so(undisturbed, tmp_path):
    path = tmp_path / "map.zarr"
    started = [
        subprocess.Popen([sys.executable, "-c", MAKE, str(path)], stderr=subprocess.PIPE, text=True) for _ in range(3)
    ]
    said = [(process.communicate(timeout=300.0)[1], process.returncode) for process in started]
    assert any(code == 0 for _, code in said)
    for words, code in said:
        assert code == 0 or words.rstrip().endswith("is being made by somebody else just now: wait until it is done")
    assert digests(path) == digests(undisturbed)
    assert not list(tmp_path.glob(".*"))


def test_a_map_that_is_being_made_is_left_alone(undisturbed, tmp_path, monkeypatch):
    arm, path, made = srs_ik.load("human_arm"), tmp_path / "map.zarr", build.create

    def create(folder, plan):
        made(folder, plan)  # another process was as fast
        made(folder, plan)

    def ask(*_):
        with pytest.raises(InvalidMap, match=r"map\.zarr is being made by somebody else just now"):
            build_map(arm, 0.04, path, orientations=576)
        asked.append(1)

    asked = []
    monkeypatch.setattr(build, "create", create)
    build_map(arm, 0.04, path, orientations=576, progress=ask)
    assert asked
    build_map(arm, 0.04, path, orientations=576)
    assert digests(path) == digests(undisturbed)


def cluster(folder: Path, workers: int) -> dict[str, list[subprocess.Popen]]:
    """A scheduler and its workers, each a process of its own."""
    pytest.importorskip("distributed")
    file = str(folder / "scheduler.json")
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "cwd": folder}
    command = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", "0"]
    scheduler = subprocess.Popen([*command, "--no-dashboard", "--scheduler-file", file], **quiet)
    command = [sys.executable, "-m", "distributed.cli.dask_worker", "--scheduler-file", file, "--nthreads", "1"]
    started = [subprocess.Popen([*command, "--no-nanny", "--no-dashboard"], **quiet) for _ in range(workers)]
    return {"scheduler": [scheduler], "worker": started}


@pytest.mark.parametrize("victim", ["client", "worker", "scheduler"])
def test_a_cluster_that_loses_a_process_is_resumed_to_the_same_store(undisturbed, tmp_path, victim):
    rng = np.random.default_rng(["client", "worker", "scheduler"].index(victim))
    for k in range(int(os.environ.get("KILLS", "1"))):
        folder = tmp_path / str(k)
        folder.mkdir()
        path = folder / "map.zarr"
        processes = cluster(folder, 2)
        making = [sys.executable, "-c", CLUSTER_MAKE, str(path), str(folder / "scheduler.json")]
        processes["client"] = [subprocess.Popen(making, stderr=subprocess.DEVNULL)]
        try:
            limit = time.monotonic() + 120.0
            while not list(path.glob("done/c/*")) and time.monotonic() < limit:
                assert processes["client"][0].poll() is None
                time.sleep(0.02)
            time.sleep(float(rng.uniform(0.0, 1.5)))
            processes[victim][0].send_signal(signal.SIGKILL)
            if victim == "worker":
                # The other worker does the rest.
                assert processes["client"][0].wait(120.0) == 0
        finally:
            for each in itertools.chain(*processes.values()):
                each.kill()
                each.wait()
        build_map(srs_ik.load("human_arm"), 0.04, path, orientations=576)
        assert digests(path) == digests(undisturbed)


def test_a_cluster_whose_workers_come_late_is_waited_for(undisturbed, tmp_path):
    """The client of a cluster that is just starting is often there before the first worker is."""
    distributed = pytest.importorskip("distributed")
    path = tmp_path / "map.zarr"
    quiet = {"processes": False, "dashboard_address": None}
    with distributed.LocalCluster(n_workers=0, **quiet) as cluster, distributed.Client(cluster) as client:
        assert not client.nthreads()
        late = threading.Timer(1.0, cluster.scale, (1,))
        late.start()
        build_map(srs_ik.load("human_arm"), 0.04, path, client, orientations=576)
        late.join()
    assert digests(path) == digests(undisturbed)


def test_a_cluster_without_workers_is_an_error(tmp_path, monkeypatch):
    distributed = pytest.importorskip("distributed")
    monkeypatch.setattr(build, "ARRIVAL", 0.2)
    quiet = {"processes": False, "dashboard_address": None}
    refused = pytest.raises(InvalidMap, match="no worker, and none came within")
    with distributed.LocalCluster(n_workers=0, **quiet) as cluster, distributed.Client(cluster) as client, refused:
        build_map(srs_ik.load("human_arm"), 0.2, tmp_path / "map.zarr", client, orientations=576)


def test_an_interruption_does_not_wait_for_tasks_to_end(tmp_path, monkeypatch):
    arm, threads, cells_after = srs_ik.load("gen3"), 2, []
    some = tasks.measures_at

    def measured(job, points, rotations):
        if interrupted:
            cells_after.append(len(points) * len(rotations))
        return some(job, points, rotations)

    def interrupt(done, cells):
        if done > 0:
            interrupted.append(done)
            raise KeyboardInterrupt

    interrupted = []
    monkeypatch.setattr(tasks, "measures_at", measured)
    with pytest.raises(KeyboardInterrupt):
        build_map(arm, 0.1, tmp_path / "map.zarr", orientations=576, threads=threads, progress=interrupt)
    # Each thread may be about to begin a part when it is told.
    assert len(cells_after) <= threads
    assert sum(cells_after) <= threads * tasks.AT_ONCE


def test_threads_give_the_same_checksums(undisturbed, tmp_path):
    build_map(srs_ik.load("human_arm"), 0.04, tmp_path / "map.zarr", orientations=576, threads=1)
    assert digests(tmp_path / "map.zarr") == digests(undisturbed)


@pytest.mark.parametrize("lost", ["reached", "width", "yaw"])
def test_lost_and_changed_files_are_found_and_made_again(undisturbed, tmp_path, lost):
    arm, path = srs_ik.load("human_arm"), tmp_path / "map.zarr"
    shutil.copytree(undisturbed, path)
    poses = [
        arm.forward_kinematics(q).homogeneous for q in np.random.default_rng(3).uniform(arm.lower, arm.upper, (50, 7))
    ]
    whole = srs_ik.open_map(path).query(poses)
    assert whole.reached.any()
    shutil.rmtree(path / lost / "c")
    for ask in (lambda: srs_ik.open_map(path).query(poses), lambda: srs_ik.open_map(path).mean(lost)):
        with pytest.raises(InvalidMap, match="is damaged: files are lost or changed"):
            ask()
    with pytest.warns(UserWarning, match="tasks that were done are damaged, and made again"):
        build_map(arm, 0.04, path, orientations=576)
    assert digests(path) == digests(undisturbed)
    # One file, changed and still readable: the same of another task.
    files = sorted(
        (each for each in (path / "width" / "c").rglob("*") if each.is_file()), key=lambda p: p.stat().st_size
    )
    shutil.copy(files[-1], files[-2])
    with pytest.warns(UserWarning, match=r": 1 of \d+ tasks that were done are damaged"):
        build_map(arm, 0.04, path, orientations=576, progress=lambda *cells: None)
    assert digests(path) == digests(undisturbed)
    np.testing.assert_array_equal(srs_ik.open_map(path).query(poses).reached, whole.reached)


def test_a_whole_map_is_gone_on_with_without_a_word(undisturbed, tmp_path):
    path = tmp_path / "map.zarr"
    shutil.copytree(undisturbed, path)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        build_map(srs_ik.load("human_arm"), 0.04, path, orientations=576)
    assert digests(path) == digests(undisturbed)


def test_what_is_left_half_written_is_cleared(undisturbed, tmp_path):
    path = tmp_path / "map.zarr"
    shutil.copytree(undisturbed, path)
    shutil.rmtree(path / "done" / "c")
    (path / "width" / "c" / "0.abc.partial").write_bytes(b"half")
    (tmp_path / ".map.zarr.abc.partial").mkdir()
    build_map(srs_ik.load("human_arm"), 0.04, path, orientations=576)
    assert digests(path) == digests(undisturbed)
    assert not (tmp_path / ".map.zarr.abc.partial").exists()


@pytest.mark.parametrize("workers", [1, 2, 4])
def test_dask_workers_give_the_same_checksums(undisturbed, tmp_path, workers):
    distributed = pytest.importorskip("dask.distributed")
    path = tmp_path / "map.zarr"
    options = {"n_workers": workers, "threads_per_worker": 1, "dashboard_address": None}
    cluster = distributed.LocalCluster(**options)
    try:
        with distributed.Client(cluster) as client:
            build_map(srs_ik.load("human_arm"), 0.04, path, client, orientations=576)
    finally:
        # Dask gives a worker five seconds to end, which a busy machine may not.
        with contextlib.suppress(TimeoutError):
            cluster.close()
    assert digests(path) == digests(undisturbed)


def test_memory_is_bounded(tmp_path):
    code = MAKE.replace('"human_arm"), 0.04', '"iiwa14"), 0.05').replace("576", "2304") + (
        # Not by getrusage, which begins with the memory of the process that started this one.
        "    print(int(open('/proc/self/status').read().split('VmHWM:')[1].split()[0]) / 1024)\n"
    )
    for _ in range(2):  # the first run may compile, which takes memory of its own
        done = subprocess.run([sys.executable, "-c", code, str(tmp_path / "m.zarr")], capture_output=True, text=True)
        (tmp_path / "m.zarr").rename(tmp_path / f"{time.monotonic()}.zarr")
    assert float(done.stdout.split()[-1]) < 300.0
