"""Members of a study on a cluster of Dask, of which only its scheduler's address is known here. Workers are started by whoever has
the machines (dask worker, dask-jobqueue), with this turgor and the study's files; a worker does as many members at once as it has
threads. Dask says who does what and nothing else: what was done are files, so that whoever is killed takes nothing with them.
"""
from ._turgor import Error
from .study import leave_row, run_member

try:
    import distributed
except ImportError:
    distributed = None


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
    """A member whose workers die of it costs its row; what would be wrong with every member is an Error."""
    if future.status == "cancelled":
        raise Error(f"{cluster}: the scheduler is gone; started again, the study goes on from what is done")
    error = future.exception()
    if isinstance(error, distributed.KilledWorker):
        leave_row(task, {"failed": f"{error.allowed_failures + 1} workers died while they did it"})
    elif error:
        said = str(error).partition(". ")[0] or type(error).__name__
        raise Error(f"{cluster}: expected a scheduler and workers with this turgor and the study's files, found: {said}")


def run_on_dask(cluster, tasks, jobs, tell):
    """Yields once a member. jobs: members beside each other where the cluster is "local"."""
    with _connect(cluster, jobs) as client:
        threads = sum(client.nthreads().values())
        tell(f"{cluster}: {threads} members beside each other" if threads else f"{cluster}: no worker is there yet")
        waiting = dict(zip(client.map(run_member, tasks, pure=False), tasks))
        for future in distributed.as_completed(list(waiting)):
            yield _settle(future, waiting.pop(future), cluster)
