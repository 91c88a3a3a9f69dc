"""Members of a study on a Dask cluster, given by its scheduler's address. Workers are started separately (dask worker, dask-jobqueue)
with the same turgor and the study's files; a worker runs one member per thread. Dask only distributes the members. Results are
files, so that no finished member is lost when a process is killed.
"""
from ._turgor import Error
from .study import Interrupted, leave_row, run_member

try:
    import distributed
except ImportError:
    distributed = None


def _run_on_worker(task):
    """Runs a member. If Ctrl+C ends it together with its worker, another worker repeats it."""
    try:
        run_member(task)
    except Interrupted:
        raise distributed.Reschedule from None


def _connect(cluster, jobs):
    if distributed is None:
        raise Error("--cluster: expected Dask, found none; pip install distributed")
    if cluster == "local":
        return distributed.Client(processes=False, threads_per_worker=jobs, n_workers=1, dashboard_address=None)
    try:
        return distributed.Client(cluster)
    except (OSError, ValueError) as error:
        raise Error(f"--cluster: expected the address of a scheduler of Dask, or local, found {cluster}: {error}") from error


def _settle(future, task, cluster):
    """Records a member whose workers died as failed; raises Error for problems that affect all members."""
    if future.status == "cancelled":
        raise Error(f"{cluster}: the scheduler is gone; a restarted study continues from the finished members")
    error = future.exception()
    if isinstance(error, distributed.KilledWorker):
        leave_row(task, {"failed": f"{error.allowed_failures + 1} workers died while running it"})
    elif error:
        said = str(error).partition(". ")[0] or type(error).__name__
        raise Error(f"{cluster}: expected a scheduler and workers with this turgor and the study's files, found: {said}")


def run_on_dask(cluster, tasks, jobs, tell):
    """Yields once per member. jobs: parallel members if the cluster is "local"."""
    with _connect(cluster, jobs) as client:
        threads = sum(client.nthreads().values())
        tell(f"{cluster}: {threads} members in parallel" if threads else f"{cluster}: no worker yet")
        waiting = dict(zip(client.map(_run_on_worker, tasks, pure=False), tasks))
        for future in distributed.as_completed(list(waiting)):
            yield _settle(future, waiting.pop(future), cluster)
