"""Turgor's Python module: cloth of springs in Chebyshev sweeps, and blocks of voxels as a lattice."""
import numpy as np
import turgor
from work import BLOCK, FRAME, GRAVITY, SHEET, Body, worker


def world_of(name, body, threads, volumes=None):
    world = turgor.World({"world": {"gravity": [0, 0, -GRAVITY], "duration": 60.0, "frame_rate": round(1 / FRAME)}, "body": {name: body}},
                         volumes=volumes, threads=threads, keeps_forces=False)
    return world, lambda: world[name].points[:, 2]


def sheet(collides):
    def build(side, threads):
        length = SHEET["spacing"] * (side - 1)
        world, heights = world_of("sheet", {
            "model": "cloth",
            "sheet": {"corner": [0, 0, 0], "side": [length, 0, 0], "up": [0, length, 0], "columns": side - 1, "rows": side - 1},
            "fabric": {"law": "springs", "density": SHEET["density"], "warp": SHEET["stiffness"], "weft": SHEET["stiffness"]},
            "solver": {"method": "sweeps", "sweeps": SHEET["iterations"]},
            "collision": {"self": collides, "thickness": SHEET["thickness"]},
            "hold": {"column": {"box": [[-0.001, -1, -1], [0.001, 100, 1]]}},
        }, threads)
        return Body(lambda: world.step(1), heights, side * side, 2 * (side - 1) ** 2)
    return build


def block(tissue, solver):
    def build(cells, threads):
        hounsfield = np.full([n + 3 for n in reversed(cells)], -1000, np.int16)
        hounsfield[1:-1, 1:-1, 1:-1] = 50
        world, heights = world_of("block", {
            "model": "lattice", "ct": "memory", "block": 1, "fixed": {"sides": "bottom", "depth": 0.0}, "skin": False, "tissue": tissue,
            "solver": {"sweeps": BLOCK["iterations"], **solver},
        }, threads, {"block": turgor.Volume(hounsfield, (BLOCK["spacing"],) * 3)})
        return Body(lambda: world.step(1), heights, world.report()["bodies"][0]["body_nodes"], 0)
    return build


CASES = {
    "cloth": (sheet(False), "springs along edges and across them, 8 Chebyshev sweeps"),
    "cloth-self": (sheet(True), "the same, contacts of vertices and CCD of all triangles and edges"),
    "block-pbd": (block({}, {"method": "pbd", "pbd_volume": True}), "edges and volumes of the tetrahedra of a lattice, 5 sweeps"),
    "block": (block({"young": BLOCK["young"], "poisson": BLOCK["poisson"]}, {}), "neo-Hookean cells, VBD, 5 sweeps and a coarse correction"),
}
if __name__ == "__main__":
    worker(CASES)
