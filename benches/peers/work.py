"""The work that Turgor and its peers do, and the loop in which a peer's process does it.

Sheet: side × side vertices 10 mm apart, horizontal, held along the column x = 0; it falls and swings.
Block: cells of 50 mm, 8 high, held at its lowest layer of vertices; it sags under gravity.
Every frame is 1/60 s. A peer's module has CASES, {case: (build, note)}: build(size, threads) returns a Body.
"""
import json
import os
import sys
import time
from typing import Any, Callable, NamedTuple

FRAME = 1 / 60  # [s]
GRAVITY = 9.81  # [m/s²]
SHEET = {"spacing": 0.01, "density": 0.2, "stiffness": 1000, "thickness": 0.005, "iterations": 8}  # [m] [kg/m²] [N/m] [m]
BLOCK = {"spacing": 0.05, "density": 1000, "young": 2e5, "poisson": 0.45, "iterations": 5}  # [m] [kg/m³] [Pa]
TITLES = {
    "cloth": "sheet without self-collision",
    "cloth-self": "sheet with self-collision",
    "block-pbd": "block, distances and volumes (PBD)",
    "block": "block of elastic solid",
}


class Body(NamedTuple):
    """frame(): one frame. heights(): of all vertices [m]. nodes, elements: their numbers."""

    frame: Callable[[], object]
    heights: Callable[[], Any]
    nodes: int
    elements: int


def sizes(case, doublings):
    """Sizes of a case, each about twice the one before: sides of a sheet [vertices], cells of a block."""
    if case.startswith("cloth"):
        return [round(50 * 2 ** (n / 2)) for n in range(doublings + 1)]
    return [(16 << (n + 1) // 2, 16 << n // 2, 8) for n in range(doublings + 1)]


def lame():
    """Lamé's µ and λ of the block [Pa]."""
    young, poisson = BLOCK["young"], BLOCK["poisson"]
    return young / (2 * (1 + poisson)), young * poisson / ((1 + poisson) * (1 - 2 * poisson))


def block_mesh(cells):
    """Points [m] and tetrahedra of a block, five in each cell."""
    import numpy as np

    nx, ny, nz = cells
    points = np.stack(np.meshgrid(*[np.arange(n + 1) * BLOCK["spacing"] for n in cells], indexing="ij"), -1).reshape(-1, 3)
    even = [(0, 4, 2, 1), (3, 7, 1, 2), (5, 4, 1, 7), (6, 4, 7, 2), (1, 4, 7, 2)]
    odd = [(1, 5, 0, 3), (2, 3, 0, 6), (4, 5, 6, 0), (7, 5, 3, 6), (0, 3, 5, 6)]
    tets = []
    for i in range(nx):
        for j in range(ny):
            for k in range(nz):
                corner = [((i + a) * (ny + 1) + j + b) * (nz + 1) + k + c for a in (0, 1) for b in (0, 1) for c in (0, 1)]
                tets += [[corner[n] for n in tet] for tet in (odd if (i + j + k) % 2 else even)]
    tets = np.array(tets)
    a, b, c, d = (points[tets[:, n]] for n in range(4))
    inverted = np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) < 0
    tets[inverted] = tets[inverted][:, [0, 1, 3, 2]]
    return points, tets


def frames(body, count):
    """Wall and processor time of each frame [ms]; processor time includes all threads."""
    wall, processor = [], []
    for _ in range(count):
        begin = time.perf_counter(), time.process_time()
        body.frame()
        wall.append(1e3 * (time.perf_counter() - begin[0]))
        processor.append(1e3 * (time.process_time() - begin[1]))
    return {"wall": wall, "processor": processor}


def worker(cases):
    """Builds a case, then runs as many frames as each line of the standard input says. Answers with lines of JSON.

    Arguments: the case, its size as JSON, the number of threads.
    """
    case, size, threads = sys.argv[1], json.loads(sys.argv[2]), int(sys.argv[3])
    answers, sys.stdout = os.fdopen(os.dup(1), "w"), sys.stderr
    os.dup2(2, 1)  # peers print to the standard output
    if case not in cases:
        print("{}", file=answers, flush=True)
        return
    build, note = cases[case]
    body = build(size, threads)
    extreme = min if case.startswith("cloth") else max
    start = extreme(body.heights())
    print(json.dumps({"nodes": body.nodes, "elements": body.elements, "note": note}), file=answers, flush=True)
    for line in sys.stdin:
        found = frames(body, int(line))
        print(json.dumps({**found, "fall": float(start - extreme(body.heights()))}), file=answers, flush=True)
