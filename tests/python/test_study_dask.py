"""Studies on Dask: a scheduler and its workers as processes, and recovery after one of them was killed."""
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest
import unittest.mock

import turgor
from test_study import command_of, folder_with, table_of
from turgor.study import _task, run_study

try:
    import distributed  # noqa: F401
except ImportError:
    distributed = None

QUIET = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
DASK = {**os.environ, "DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "1", "DASK_DISTRIBUTED__COMM__TIMEOUTS__CONNECT": "2s"}


def dask(*words):
    return subprocess.Popen([sys.executable, "-m", "dask", *words, "--no-dashboard"], env=DASK, **QUIET)


def wait_for(what, seconds=120):
    """Result of `what()` as soon as it is true."""
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        found = what()
        if found:
            return found
        time.sleep(0.01)
    raise AssertionError(f"{what} was not true within {seconds} s")


def members_of(process):
    """Process ids of the children of a worker."""
    threads = pathlib.Path(f"/proc/{process.pid}/task").glob("*/children")
    return [int(child) for thread in threads for child in thread.read_text().split()]


def is_alive(pid):
    try:
        return pathlib.Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


class Cluster:
    """A scheduler and workers with one thread each."""

    def __init__(self, workers):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="turgor-dask-"))
        file = self.folder / "scheduler.json"
        self.scheduler = dask("scheduler", "--host", "127.0.0.1", "--port", "0", "--scheduler-file", str(file))
        self.workers = [dask("worker", "--scheduler-file", str(file), "--nthreads", "1", "--no-nanny", "--local-directory", str(self.folder))
                        for _ in range(workers)]
        self.address = json.loads(wait_for(lambda: file.exists() and file.read_text()))["address"]

    def close(self):
        for process in (*self.workers, self.scheduler):
            process.kill()
            process.wait()
        shutil.rmtree(self.folder, ignore_errors=True)


def command(folder, address):
    return [sys.executable, "-m", "turgor.study", str(folder / "study.toml"), "--out", str(folder / "out"), "--cluster", address]


def study_of(rows, timeout):
    """A study with one case per row of [young, duration]. A duration of 3590 s exceeds every timeout."""
    folder = folder_with()
    (folder / "pad.toml").write_text((folder / "pad.toml").read_text().replace("every = 0.1", "every = 1"))
    text = (folder / "study.toml").read_text().replace('"body.pad.young" = { values = [2e3, 4e3, 8e3] }\n', "").replace(
        "[0.0, 0.6]", "[0.3]").replace("timeout = 20", f"timeout = {timeout}").replace("[vary]", 'cases = "cases.csv"\n[vary]')
    (folder / "study.toml").write_text(text)
    (folder / "cases.csv").write_text("body.pad.young,world.duration\n" + "".join(f"{young},{duration}\n" for young, duration in rows))
    return folder


@unittest.skipUnless(distributed, "Dask is not installed")
class OnDask(unittest.TestCase):
    def cluster(self, workers):
        cluster = Cluster(workers)
        self.addCleanup(cluster.close)
        return cluster

    def driver(self, folder, address):
        driver = subprocess.Popen(command(folder, address), env=DASK, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        self.addCleanup(driver.stderr.close)
        return driver

    # A killed worker, a killed driver and a member that hangs lose no finished members.
    def test_killed_worker_and_driver_lose_nothing(self):
        good = [(young, 0.2) for young in (2e3, 3e3, 4e3, 5e3)]
        folder = study_of([(4e3, 3590), (-1, 0.2), *good], timeout=8)
        cluster = self.cluster(2)
        members = folder / "out/members"
        driver = self.driver(folder, cluster.address)
        wait_for(lambda: len(list(members.glob("*.json"))) >= 2)
        driver.kill()
        driver.wait()
        before = {file.name: file.stat().st_mtime_ns for file in members.glob("*.json") if "measured" in file.read_text()}

        driver = self.driver(folder, cluster.address)
        wait_for(lambda: members_of(cluster.workers[0]))
        cluster.workers[0].kill()
        self.assertEqual(driver.wait(), 0)

        rows = table_of(folder / "out")
        self.assertIn("longer than 8 s", rows[0]["failed"])
        self.assertIn("young", rows[1]["failed"])
        after = {file.name: file.stat().st_mtime_ns for file in members.glob("*.json")}
        self.assertEqual({name: after[name] for name in before}, before)
        self.assertEqual(len(after), 6)
        serial = study_of(good, timeout=20)
        run_study(serial / "study.toml", serial / "out", jobs=2)
        self.assertEqual(rows[2:], table_of(serial / "out"))

    # A member whose workers die costs its row; a scheduler that dies is reported.
    def test_dying_workers_and_scheduler_are_reported(self):
        folder = study_of([(4e3, 3590), (3e3, 0.2)], timeout=60)
        cluster = self.cluster(2)
        driver = self.driver(folder, cluster.address)
        wait_for(lambda: list((folder / "out/members").glob("*.json")))
        for _ in cluster.workers:
            busy = wait_for(lambda: next((worker for worker in cluster.workers if members_of(worker)), None))
            hanging = members_of(busy)[0]
            busy.kill()
            busy.wait()
            wait_for(lambda: not is_alive(hanging))
        self.assertEqual(driver.wait(), 0)
        rows = table_of(folder / "out")
        self.assertEqual(rows[0]["failed"], "2 workers died while running it")
        self.assertGreater(float(rows[1]["force"]), 0)

        driver = self.driver(folder, cluster.address)
        self.assertIn("no worker yet", driver.stderr.readline())
        cluster.scheduler.kill()
        self.assertIn("the scheduler is gone", driver.communicate()[1])
        self.assertEqual(driver.returncode, 2)
        self.assertEqual(table_of(folder / "out"), rows)

    # A worker repeats a member that Ctrl+C ended.
    def test_interrupted_member_is_repeated(self):
        folder = study_of([(4e3, 3590)], timeout=100)
        cluster = self.cluster(1)
        driver = self.driver(folder, cluster.address)

        def running():
            return [pid for pid in members_of(cluster.workers[0]) if "--member" in command_of(pid)]

        first = wait_for(running)[0]
        os.kill(first, signal.SIGINT)
        wait_for(lambda: any(pid != first for pid in running()))
        self.assertEqual(list((folder / "out/members").iterdir()), [])
        self.assertIsNone(driver.poll())
        driver.kill()
        driver.wait()

    # Dask inside of this process gives the same table as a run without it.
    def test_local_dask_gives_same_table(self):
        folder = study_of([(2e3, 0.2), (3e3, 0.2)], timeout=20)
        for out, cluster in (("plain", None), ("local", "local")):
            run_study(folder / "study.toml", folder / out, jobs=2, cluster=cluster)
        self.assertEqual(table_of(folder / "local"), table_of(folder / "plain"))

    # A worker with another version of Turgor is rejected with a message.
    def test_worker_with_other_version_is_rejected(self):
        folder = study_of([(2e3, 0.2)], timeout=20)
        of_another = lambda *given: {**_task(*given), "version": "9.9"}
        with unittest.mock.patch("turgor.study._task", of_another), self.assertRaisesRegex(turgor.Error, "local: expected .* turgor 9.9 as on"):
            run_study(folder / "study.toml", folder / "out", cluster="local")
        self.assertEqual(list((folder / "out/members").iterdir()), [])

    # An address without a scheduler gives an error message.
    def test_unreachable_scheduler_is_reported(self):
        folder = study_of([(2e3, 0.2)], timeout=20)
        for driver in [self.driver(folder, address) for address in ("tcp://127.0.0.1:9", "no-such-thing://7")]:
            said = driver.communicate()[1].strip().splitlines()
            self.assertEqual(driver.returncode, 2, said)
            self.assertIn("expected the address of a scheduler of Dask, or local, found", said[-1])


class WithoutDask(unittest.TestCase):
    # Without Dask a cluster is rejected with the command that installs it.
    def test_cluster_needs_dask(self):
        folder = study_of([(2e3, 0.2)], timeout=20)
        script = "import sys; sys.modules['distributed'] = None; from turgor.study import main; sys.exit(main(sys.argv[1:]))"
        done = subprocess.run([sys.executable, "-c", script, *command(folder, "local")[3:]], capture_output=True, text=True)
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertIn("pip install distributed", done.stderr)


if __name__ == "__main__":
    unittest.main()
