"""PyBullet's deformable world: four steps of 1/240 s a frame. Vertices are held by anchors."""
import pathlib
import tempfile

import numpy as np
import pybullet
from work import BLOCK, FRAME, GRAVITY, SHEET, Body, block_mesh, lame, worker

STEPS = 4  # a frame


def run(name, text, held, elements, mass, **options):
    pybullet.connect(pybullet.DIRECT)
    pybullet.resetSimulation(pybullet.RESET_USE_DEFORMABLE_WORLD)
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / name
        file.write_text(text)
        body = pybullet.loadSoftBody(str(file), basePosition=[0, 0, 0], mass=mass, **options)

    def positions():
        return np.array(pybullet.getMeshData(body, -1, flags=pybullet.MESH_DATA_SIMULATION_MESH)[1])
    points = positions()
    for n in np.nonzero(held(points))[0]:
        pybullet.createSoftBodyAnchor(body, int(n), -1, -1)
    pybullet.setGravity(0, 0, -GRAVITY)
    pybullet.setTimeStep(FRAME / STEPS)

    def frame():
        for _ in range(STEPS):
            pybullet.stepSimulation()
    return Body(frame, lambda: positions()[:, 2], len(points), elements)


def sheet(collides):
    def build(side, _threads):
        spacing = SHEET["spacing"]
        lines = [f"v {spacing * i} {spacing * j} 0" for j in range(side) for i in range(side)]
        for corner in (j * side + i + 1 for j in range(side - 1) for i in range(side - 1)):
            lines += [f"f {corner} {corner + 1} {corner + side + 1}", f"f {corner} {corner + side + 1} {corner + side}"]
        return run("sheet.obj", "\n".join(lines) + "\n", lambda x: x[:, 0] < 1e-6, 2 * (side - 1) ** 2,
                   SHEET["density"] * (spacing * (side - 1)) ** 2, useMassSpring=1, useBendingSprings=1, springElasticStiffness=3,
                   springDampingStiffness=0.03, springBendingStiffness=0.3, useSelfCollision=int(collides),
                   collisionMargin=SHEET["thickness"] / 2)
    return build


def block(cells, _threads):
    points, tets = block_mesh(cells)
    lines = ["# vtk DataFile Version 2.0", "block", "ASCII", "DATASET UNSTRUCTURED_GRID", f"POINTS {len(points)} double"]
    lines += ["{:g} {:g} {:g}".format(*x) for x in points]
    lines += ["", f"CELLS {len(tets)} {5 * len(tets)}"] + ["4 {} {} {} {}".format(*t) for t in tets]
    lines += ["", f"CELL_TYPES {len(tets)}"] + ["10"] * len(tets)
    mu, second = lame()
    return run("block.vtk", "\n".join(lines) + "\n", lambda x: x[:, 2] < 1e-6, len(tets),
               BLOCK["density"] * np.prod(cells) * BLOCK["spacing"] ** 3, useNeoHookean=1, NeoHookeanMu=mu, NeoHookeanLambda=second,
               NeoHookeanDamping=0.01, useSelfCollision=0, collisionMargin=0.001)


CASES = {
    "cloth": (sheet(False), "springs along edges and across them of 3 N/m, explicit (stiffer ones diverge), 4 steps a frame"),
    "cloth-self": (sheet(True), "the same, contacts of vertices and faces"),
    "block": (block, "neo-Hookean tetrahedra, five a cell, 4 steps a frame"),
}
if __name__ == "__main__":
    worker(CASES)
