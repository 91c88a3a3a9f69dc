"""Many runs of one scene: python -m turgor.study STUDY.toml [--out FOLDER] [--jobs N] [--part i/n] [--cluster ADDRESS]

    [study]
    scene = "incision.toml"                                # relative to the study
    design = { kind = "saltelli", count = 64, seed = 1 }   # or lhs with count and seed; grid
    cases = "cohort.csv"                                   # repeats the design for every row; columns are keys of the scene, files are relative to the study
    [vary]
    "body.torso.skin.tension" = { uniform = [20, 80] }     # or log_uniform, or values = [...]; ends may be vectors
    [measure]
    gape = "wounds.midline.gape_max_mm"                    # key in report.json; items of a list by their name
    [run]
    threads = 1                                            # per member
    timeout = 600                                          # per member [s]

Every member runs in its own process and writes one file, FOLDER/members/KEY.json, by rename. KEY is the hash of the scene, its
files, the varied values and the version, so that a restarted study continues from the finished members. A member that crashes,
hangs or is refused has a row with a message, and runs again when the study is restarted. `--part i/n` runs a share of the
members, for job arrays on one file system; the last share gathers the results. `--cluster` uses Dask (study_dask.py).
"""
import argparse
import concurrent.futures
import contextlib
import difflib
import json
import math
import os
import pathlib
import signal
import subprocess
import sys
import threading
import time

import numpy as np

from ._turgor import Error, __version__, instructions, plain_text
from .study_design import sobol_indices
from .study_file import Study, check_is_file


# Members


def _entries(value):
    """Entries of a report's object by key, or of its list of objects by their names; None for other values."""
    if isinstance(value, list):
        return {item.get("name"): item for item in reversed(value) if isinstance(item, dict)}
    return value if isinstance(value, dict) else None


def _number_of(report, path):
    """Number in a report under a dotted path; items of a list by their name."""
    for key in path.split("."):
        report = (_entries(report) or {}).get(key)
    if not isinstance(report, (int, float)):
        raise Error(f"measure: expected a number of the report as {path}, found {'nothing' if report is None else type(report).__name__}")
    return report


def _missing(report, path):
    """Sentence about the first key of a dotted path that a report lacks; None if it has the path."""
    for key in path.split("."):
        entries = _entries(report)
        if entries is None:
            return None  # a value that is not known yet
        if key not in entries:
            near = difflib.get_close_matches(key, map(str, entries), n=1)
            known = ", ".join(map(str, reversed(entries) if isinstance(report, list) else entries)) or "nothing"
            return f"expected {path}, found no {key}" + (f": did you mean {near[0]}?" if near else f" among {known}")
        report = entries[key]
    return None


def check_measures(study, task):
    """Checks that the report of the first member's scene has every path of [measure]. Raises Error if it has not.

    task: the first member's. Its scene is loaded in a process of its own; if that fails, the member's row says why.
    """
    command = [sys.executable, "-m", "turgor.study", "--check", json.dumps({**task, "parent": os.getpid()})]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=task["timeout"])
        missing = json.loads(done.stdout) if done.returncode == 0 else {}
    except subprocess.TimeoutExpired:
        return
    for name, sentence in missing.items():
        raise Error(f"{study.file}: measure.{name}: {sentence}")


def _check_member(task):
    """Sentences by measurement whose path the report of this member lacks before its first frame."""
    from .world import World

    os.chdir(task["folder"])
    report = World(task["scene"], set=task["set"], threads=task["threads"]).report()
    missing = {name: _missing(report, path) for name, path in task["measure"].items()}
    return {name: sentence for name, sentence in missing.items() if sentence}


def _do_member(task):
    """Runs the scene in this process, and returns the measurements at its end."""
    from .world import World

    os.chdir(task["folder"])
    begin = time.perf_counter()
    world = World(task["scene"], set=task["set"], threads=task["threads"])
    for _ in world.run():
        if os.getppid() != task["parent"]:
            raise Error("the parent process of this member ended")
    report = world.report()
    row = {name: _number_of(report, path) for name, path in task["measure"].items()}
    return {"measured": row, "state_hash": world.state_hash, "instructions": instructions, "seconds": time.perf_counter() - begin}


def _write(file, text):
    """Writes a file atomically, also with concurrent writers."""
    partial = file.with_name(f".{file.name}.{os.getpid()}.{time.monotonic_ns()}")
    partial.write_text(text, encoding="utf-8")
    os.replace(partial, file)


def _task(study, member, folder):
    """Description of a member for its worker, on any machine with the same files."""
    return {"file": str(_file_of(member, folder.resolve())), "folder": str(study.file.parent.resolve()), "scene": str(study.scene.resolve()),
            "set": member["set"], "measure": study.measure,
            "threads": study.run.get("threads", 1), "timeout": study.run.get("timeout", 3600), "version": __version__}


class Interrupted(Error):
    """Ctrl+C ended the process of a member."""


_INTERRUPTED = "interrupted; a restarted study continues from the finished members"


def _ended(command, timeout, stopped):
    """Process of a command at its end. Raises TimeoutExpired after a time [s], and Interrupted once `stopped` is set."""
    deadline = time.monotonic() + timeout
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        while True:
            remaining = deadline - time.monotonic()
            try:
                out, err = process.communicate(timeout=min(max(remaining, 0), 0.1))
                return subprocess.CompletedProcess(command, process.returncode, out, err)
            except subprocess.TimeoutExpired:
                if not stopped.is_set() and remaining > 0:
                    continue
                process.kill()
                if stopped.is_set():
                    raise Interrupted(_INTERRUPTED) from None
                raise


def _was_interrupted(done):
    """True if the signal of Ctrl+C, which all processes of a terminal receive, ended this one."""
    return done.returncode == -signal.SIGINT or (done.returncode > 0 and _why(done).startswith("KeyboardInterrupt"))


def run_member(task, stopped=threading.Event()):
    """Runs a member and writes its row, or a message on failure. If this process is killed, the member ends itself without a row.

    stopped: an event that kills the member. Raises Interrupted then, and after Ctrl+C; such a member has no row either.
    """
    if "measured" in (_row(task["file"], task["measure"]) or {}):
        return  # a cluster repeats tasks of lost machines
    if task["version"] != __version__:
        raise Error(f"{sys.prefix}: expected turgor {task['version']} as on the machine that the study was started on, found {__version__}")
    command = [sys.executable, "-m", "turgor.study", "--member", json.dumps({**task, "parent": os.getpid()})]
    try:
        done = _ended(command, task["timeout"], stopped)
        if _was_interrupted(done):
            raise Interrupted(_INTERRUPTED)
        row = json.loads(done.stdout) if done.returncode == 0 else {"failed": _why(done)}
    except subprocess.TimeoutExpired:
        row = {"failed": f"took longer than {task['timeout']} s"}
    leave_row(task, row)


def leave_row(task, row):
    """Writes a row. A failure does not replace measurements, since another worker may have run the member of a lost one."""
    if "measured" in row or "measured" not in (_row(task["file"], task["measure"]) or {}):
        _write(pathlib.Path(task["file"]), json.dumps({**row, "set": task["set"]}))


def _why(done):
    if done.returncode < 0:
        return f"ended by signal {-done.returncode}"
    lines = done.stderr.strip().splitlines()
    return lines[-1] if lines else f"ended with {done.returncode}"


def _file_of(member, folder):
    return folder / "members" / f"{member['key']}.json"


def _row(file, names):
    """Row of a member with measurements of these names; None if it is missing or cut short. Raises Error for content that no member writes."""
    try:
        check_is_file(file)
    except OSError:
        return None
    try:
        row = json.loads(pathlib.Path(file).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    if not isinstance(row, dict):
        raise Error(f"{file}: expected the row of a member, a JSON object, found {type(row).__name__}; remove it to run the member again")
    measured = row.get("measured")
    numbers = isinstance(measured, dict) and all(isinstance(measured.get(name), (int, float)) for name in names)
    if not numbers and ("measured" in row or not isinstance(row.get("failed"), str)):
        raise Error(f"{file}: expected measured numbers or a failure, found {', '.join(row) or 'nothing'}; remove it to run the member again")
    return row


# The study


def _report(study, rows):
    """Statistics for report.json."""
    measured = {name: [row["measured"][name] if row and "measured" in row else math.nan for row in rows] for name in study.measure}
    failed = [{"set": m["set"], "failed": row["failed"]} for m, row in zip(study.members, rows) if row and "failed" in row]
    report = {"version": __version__, "study": str(study.file), "members": len(rows), "failed": failed,
              "core_hours": sum(row.get("seconds", 0) for row in rows if row) * study.run.get("threads", 1) / 3600, "measures": {}}
    for name, values in measured.items():
        good = np.array([v for v in values if math.isfinite(v)])
        one = {"mean": float(good.mean()), "sd": float(good.std()), "min": float(good.min()), "max": float(good.max())} if len(good) else {}
        if study.design["kind"] == "saltelli" and study.case_count == 1:
            first, total = sobol_indices(values, len(study.vary)).tolist()
            one["sobol"] = {key: {"first": f[0], "first_95": f[1], "total": t[0], "total_95": t[1]} for key, f, t in zip(study.vary, first, total)}
        report["measures"][name] = one
    return report


def _cell(value):
    """Cell of a CSV table. A text that a spreadsheet would take for a formula starts with an apostrophe; a number keeps its sign."""
    if isinstance(value, (int, float)):
        return repr(value)
    text = plain_text(str(value))
    if text.startswith(("=", "+", "-", "@", "\t")):
        text = "'" + text
    return '"' + text.replace('"', '""') + '"'


def _gather(study, folder, rows):
    keys = list(dict.fromkeys(key for member in study.members for key in member["set"]))
    lines = [[*keys, *study.measure, "failed"]]
    for member, row in zip(study.members, rows):
        measured = (row or {}).get("measured", {})
        lines.append([*(member["set"].get(key, "") for key in keys), *(measured.get(name, "") for name in study.measure), (row or {}).get("failed", "")])
    _write(folder / "table.csv", "".join(",".join(map(_cell, line)) + "\n" for line in lines))
    report = _report(study, rows)
    _write(folder / "report.json", json.dumps(report, indent=1))
    return report


def _run_here(tasks, jobs):
    """Runs members in parallel, each in a thread that waits for its process. Yields once per member.

    An exception, such as that of Ctrl+C, kills the running members and starts no others.
    """
    stopped = threading.Event()
    pool = concurrent.futures.ThreadPoolExecutor(jobs)
    try:
        for future in concurrent.futures.as_completed([pool.submit(run_member, task, stopped) for task in tasks]):
            yield future.result()
    finally:
        stopped.set()
        pool.shutdown(cancel_futures=True)


def run_study(file, out=None, jobs=0, part=(1, 1), tell=lambda sentence: None, cluster=None):
    """Runs the missing members of a study, and gathers the results. Returns the report, or None while other shares are missing.

    jobs: parallel members; 0 = number of cores / threads per member. tell: called with progress messages.
    cluster: None = child processes, "local" = Dask in this process, or the address of a Dask scheduler.
    """
    if jobs < 0:
        raise Error(f"--jobs: expected a number of parallel members, or 0 for one per core, found {jobs}")
    study = Study(file)
    folder = pathlib.Path(out or pathlib.Path("out") / study.file.stem)
    (folder / "members").mkdir(parents=True, exist_ok=True)
    mine = list({m["key"]: m for m in study.members[part[0] - 1::part[1]]}.values())
    missing = [_task(study, m, folder) for m in mine if "measured" not in (_row(_file_of(m, folder), study.measure) or {})]
    if missing:
        check_measures(study, missing[0])
    jobs = jobs or max(1, (os.cpu_count() or 1) // max(1, study.run.get("threads", 1)))
    if cluster:
        from .study_dask import run_on_dask

        run = run_on_dask(cluster, missing, jobs, tell)
    else:
        run = _run_here(missing, jobs)
    begin = time.perf_counter()
    with contextlib.closing(run):
        for done, _ in enumerate(run, 1):
            if done == 5 or done % 50 == 0:
                remaining = (time.perf_counter() - begin) / done * (len(missing) - done)
                tell(f"{done} of {len(missing)} members, about {remaining / 60:.1f} minutes remaining")
    rows = [_row(_file_of(m, folder), study.measure) for m in study.members]
    return _gather(study, folder, rows) if all(rows) else None


def _print(report):
    print(f"{report['members']} members, {len(report['failed'])} failed, {report['core_hours']:.3g} core hours")
    for name, one in report["measures"].items():
        print(f"{plain_text(name)}: mean {one.get('mean', math.nan):.4g}, sd {one.get('sd', math.nan):.3g}")
        for key, s in one.get("sobol", {}).items():
            print(f"  {plain_text(key)}: first {s['first']:.2f} ± {s['first_95']:.2f}, total {s['total']:.2f} ± {s['total_95']:.2f}")
    for one in report["failed"][:10]:
        print(plain_text(f"failed: {one['failed']}"))


def _part(text):
    number, _, count = text.partition("/")
    if not (number.isdigit() and count.isdigit() and 1 <= int(number) <= int(count)):
        raise argparse.ArgumentTypeError(f"expected i/n with i from 1 to n, found {text}")
    return int(number), int(count)


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="python -m turgor.study", description="Many runs of one scene, with statistics of their measurements.")
    parser.add_argument("study", nargs="?", help="a TOML file")
    parser.add_argument("--out", help="folder of the results (default: out/STUDY)")
    parser.add_argument("--jobs", type=int, default=0, help="parallel members (default: one per core)")
    parser.add_argument("--part", type=_part, default=(1, 1), metavar="i/n", help="runs only this share of the members")
    parser.add_argument("--cluster", metavar="ADDRESS", help="address of a Dask scheduler, or local")
    parser.add_argument("--member", help=argparse.SUPPRESS)
    parser.add_argument("--check", help=argparse.SUPPRESS)
    options = parser.parse_args(arguments)
    try:
        if options.check:
            print(json.dumps(_check_member(json.loads(options.check))))
            return 0
        if options.member:
            print(json.dumps(_do_member(json.loads(options.member))))
            return 0
        if not options.study:
            parser.error("expected a study")
        report = run_study(options.study, options.out, options.jobs, options.part, lambda sentence: print(plain_text(sentence), file=sys.stderr), options.cluster)
    except (Error, OSError) as error:
        print(plain_text(f"turgor: {error}"), file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        if options.member or options.check:
            raise  # the parent process recognizes its end by the signal
        print(f"turgor: {_INTERRUPTED}", file=sys.stderr)
        return 128 + signal.SIGINT
    if report is None:
        print("this share is done; other shares are missing")
    else:
        _print(report)
    return 0


if __name__ == "__main__":
    sys.exit(main())
