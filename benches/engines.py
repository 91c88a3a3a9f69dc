"""Speed and bit equality of the engines in the wheel: python benches/engines.py [rounds [scene ...]], with the wheel installed

Measures the CPU time of a frame on one thread for the scenes of tests/golden/states.txt, reduced by its overrides. Engines
alternate within a round, and the best round counts, because other programs may use the machine. Compares the final states.
"""
import json
import os
import pathlib
import resource
import subprocess
import sys
import tomllib

SOURCE = pathlib.Path(__file__).resolve().parents[1]
ENGINES = ("v2", "v3", "v4")


def measure(file, frames, overrides):
    """Seconds per frame, state hash and instruction set of the engine; runs in a separate process."""
    import turgor

    given = dict(one.split("=", 1) for one in overrides)
    world = turgor.World(SOURCE / "scenes" / file, set={key: tomllib.loads(f"v = {value}")["v"] for key, value in given.items()}, threads=1)
    begin = resource.getrusage(resource.RUSAGE_SELF).ru_utime
    world.step(int(frames))
    seconds = resource.getrusage(resource.RUSAGE_SELF).ru_utime - begin
    return {"frame": seconds / int(frames), "hash": world.state_hash, "instructions": world.report()["machine"]["instructions"]}


def measured_with(engine, words):
    command = [sys.executable, __file__, "--measure", *words]
    found = json.loads(subprocess.run(command, env={**os.environ, "TURGOR_ENGINE": engine}, capture_output=True, check=True).stdout)
    assert found["instructions"] == f"x86-64-{engine}"
    return found


def main(rounds, scenes):
    print("| scene | v2 [ms] | v3 | v4 | equal bits |\n|---|---|---|---|---|")
    for line in (SOURCE / "tests/golden/states.txt").read_text().splitlines():
        words = line.split()[1:]
        if line.startswith("#") or (scenes and words[0] not in scenes):
            continue
        found = [[measured_with(engine, words) for engine in ENGINES] for _ in range(rounds)]
        v2, v3, v4 = (min(one[k]["frame"] for one in found) for k in range(3))
        engines_of = {}
        for engine, one in zip(ENGINES, found[0]):
            engines_of.setdefault(one["hash"], []).append(engine)
        same = "; ".join(", ".join(engines) for engines in engines_of.values() if len(engines) > 1) or "none"
        print(f"| {words[0]} | {v2 * 1e3:.1f} | {v2 / v3:.2f} × | {v2 / v4:.2f} × | {same} |", flush=True)


if sys.argv[1:2] == ["--measure"]:
    print(json.dumps(measure(sys.argv[2], sys.argv[3], sys.argv[4:])))
else:
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 5, sys.argv[2:])
