"""Table of Turgor and its peers: benches/peers/run starts it.

A process for each peer builds the same case. After some frames, the processes run a few frames each in turn, round after round, while
the others wait. Medians of the rounds count. Ratios are of processor time per node in the same round, peer to Turgor.
"""
import argparse
import datetime
import importlib
import importlib.metadata
import importlib.util
import json
import os
import pathlib
import platform
import select
import statistics
import subprocess
import sys

import work

FOLDER = pathlib.Path(__file__).resolve().parent
PEERS = ("turgor", "pypbd", "newton", "mujoco", "pybullet")
WARM, ROUND = 30, 5  # frames


def version(peer):
    """Version of an installed module, or None."""
    module = importlib.util.find_spec(peer)
    if not module or not module.origin:  # without an origin it is a folder of another kind
        return None
    try:
        return importlib.metadata.version(peer)
    except importlib.metadata.PackageNotFoundError:  # Turgor in a build folder
        return str(getattr(importlib.import_module(peer), "__version__", "of this folder"))


def machine():
    try:
        lines = pathlib.Path("/proc/cpuinfo").read_text().splitlines()
        name = next(line for line in lines if line.startswith("model name")).partition(":")[2].strip()
    except (OSError, StopIteration):
        name = platform.processor() or platform.machine()
    return f"{name}, {os.cpu_count()} processors, load {os.getloadavg()[0]:.1f}"


class Stopped(Exception):
    """Reason why a process has no figures."""


class Process:
    """A peer's process at a case."""

    def __init__(self, peer, case, size, options):
        self.peer, self.limit, self.rounds = peer, options.limit, []
        threads = str(options.threads)
        modules = os.pathsep.join(os.path.abspath(folder) for folder in sys.path)  # folders may be relative, the process runs elsewhere
        self.errors = open(os.path.join(options.errors, f"{peer}.txt"), "w+")
        self.process = subprocess.Popen(
            [sys.executable, str(FOLDER / f"with_{peer}.py"), case, json.dumps(size), threads], stdin=subprocess.PIPE,
            stdout=subprocess.PIPE, stderr=self.errors, text=True, cwd=options.errors, env={**os.environ, "OMP_NUM_THREADS": threads, "PYTHONPATH": modules})

    def answer(self, limit):
        if not select.select([self.process.stdout], [], [], limit)[0]:
            raise Stopped(f"stopped after {limit:.0f} s")
        if line := self.process.stdout.readline():
            return json.loads(line)
        self.errors.seek(0)
        raise Stopped(([line.strip() for line in self.errors if line.strip()] or ["ended without a message"])[-1][:90])

    def frames(self, count):
        print(count, file=self.process.stdin, flush=True)
        return self.answer(self.limit)

    def end(self):
        self.process.kill()
        self.process.wait()
        for stream in (self.process.stdin, self.process.stdout, self.errors):
            stream.close()


def start(peer, case, size, options):
    """Row of a peer, and its process after the first frames; no process without figures, no row without the case."""
    row = {"case": case, "size": size, "peer": peer}
    if not version(peer):
        return {**row, "missing": "not built: scripts/python" if peer == "turgor" else "not installed"}, None
    process = Process(peer, case, size, options)
    try:
        facts = process.answer(10 * options.limit)  # Newton compiles its kernels in the first run
        if not facts:
            process.end()
            return None, None
        row |= facts
        process.frames(1)
        process.frames(WARM - 1)
        return row, process
    except Stopped as reason:
        process.end()
        return {**row, "missing": str(reason)}, None


def run_rounds(pairs, rounds):
    """Runs rounds of frames, all peers in turn, and stores times in the rows."""
    for row, _ in pairs:
        row.update(wall=[], processor=[])
    for _ in range(rounds):
        for row, process in pairs:
            try:
                found = process.frames(ROUND)
            except Stopped as reason:
                row["missing"] = str(reason)
                continue
            for clock in ("wall", "processor"):
                row[clock].append(statistics.median(found[clock]))
            row["fall"] = found["fall"]
        pairs = [pair for pair in pairs if "missing" not in pair[0]]


def add_ratios(rows):
    """Ratio of each peer's processor time per node to Turgor's in the same round."""
    own = next((row for row in rows if row["peer"] == "turgor" and "missing" not in row), None)
    for row in rows:
        if own and row is not own and "missing" not in row:
            row["ratio"] = statistics.median(a / b for a, b in zip(row["processor"], own["processor"])) * own["nodes"] / row["nodes"]


def measure(case, size, options):
    rows, pairs = [], []
    for peer in PEERS:
        row, process = start(peer, case, size, options)
        if row:
            rows.append(row)
        if process:
            pairs.append((row, process))
    run_rounds(pairs, options.rounds)
    for _, process in pairs:
        process.end()
    add_ratios(rows)
    return rows


def line(row):
    if "missing" in row:
        return f"| {row['peer']} | {row.get('nodes', '')} | {row['missing']} | | | |"
    wall, processor = (statistics.median(row[clock]) for clock in ("wall", "processor"))
    ratio = f"{row['ratio']:.1f}" if "ratio" in row else ""
    return f"| {row['peer']} | {row['nodes']} | {wall:.2f} | {processor:.2f} | {ratio} | {1e3 * row['fall']:.0f} |"


def print_notes(rows):
    seen = {row["peer"]: row["note"] for row in rows if "note" in row}
    print("\n" + "".join(f"- {peer}: {note}\n" for peer, note in seen.items()), flush=True)


def parse():
    parser = argparse.ArgumentParser(prog="benches/peers/run", description="Compares Turgor with its peers on this machine.")
    parser.add_argument("cases", nargs="*", metavar="CASE", help=f"{', '.join(work.TITLES)}; default: all")
    parser.add_argument("--doublings", type=int, default=2, help="how often the number of nodes doubles (default 2)")
    parser.add_argument("--rounds", type=int, default=5, help=f"of {ROUND} frames each (default 5)")
    parser.add_argument("--threads", type=int, default=1, help="of Turgor and of peers that use OpenMP (default 1)")
    parser.add_argument("--limit", type=float, default=120, help="seconds until a peer's answer is given up (default 120)")
    parser.add_argument("--json", help="writes all figures to this file")
    options = parser.parse_args()
    for name, least in (("doublings", 0), ("rounds", 1), ("threads", 1)):
        if getattr(options, name) < least:
            parser.error(f"--{name}: expected at least {least}, found {getattr(options, name)}")
    if unknown := set(options.cases) - set(work.TITLES):
        parser.error(f"expected cases {', '.join(work.TITLES)}, found {', '.join(sorted(unknown))}")
    return options


def main():
    options = parse()
    options.errors = os.environ.get("WARP_CACHE_PATH", "build/peers/warp")
    os.makedirs(options.errors, exist_ok=True)
    facts = {"machine": machine(), "date": datetime.date.today().isoformat(), "threads": options.threads, "rounds": options.rounds,
             "versions": {peer: version(peer) for peer in PEERS}}
    print(f"{facts['date']}, {facts['machine']}, {options.threads} threads")
    print(", ".join(f"{peer} {number or 'missing'}" for peer, number in facts["versions"].items()), flush=True)
    found = []
    for case in options.cases or work.TITLES:
        print(f"\n{work.TITLES[case]}, a frame of 1/60 s\n")
        print("| peer | nodes | wall [ms] | processor [ms] | ratio per node | fall [mm] |\n|---|---|---|---|---|---|")
        rows = []
        for size in work.sizes(case, options.doublings):
            rows += (measured := measure(case, size, options))
            print("\n".join(line(row) for row in measured), flush=True)
        print_notes(rows)
        found += rows
    if options.json:
        pathlib.Path(options.json).write_text(json.dumps({**facts, "rows": found}, indent=1) + "\n")


if __name__ == "__main__":
    main()
