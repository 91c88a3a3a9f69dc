"""PositionBasedDynamics (pypbd): distance, bending and volume constraints."""
import numpy as np
import pypbd
from work import BLOCK, FRAME, SHEET, Body, worker


def run(add_model, held, nodes, elements, iterations, up):
    """Body whose `up` is the axis against gravity; pypbd's is y."""
    simulation = pypbd.Simulation.getCurrent()
    simulation.initDefault()
    model, step = simulation.getModel(), simulation.getTimeStep()
    add_model(model)
    particles = model.getParticles()

    def heights():
        return np.array([particles.getPosition(n)[up] for n in range(nodes)])
    positions = np.array([particles.getPosition(n) for n in range(nodes)])
    for n in np.nonzero(held(positions))[0]:
        particles.setMass(int(n), 0.0)
    step.setValueUInt(pypbd.TimeStepController.MAX_ITERATIONS, iterations)
    step.setValueUInt(pypbd.TimeStepController.NUM_SUB_STEPS, 1)
    pypbd.TimeManager.getCurrent().setTimeStepSize(FRAME)
    return Body(lambda: step.step(model), heights, nodes, elements)


def cloth(side, _threads):
    def add(model):
        length = SHEET["spacing"] * (side - 1)
        turned = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])  # horizontal
        model.addRegularTriangleModel(side, side, [0, 0, 0], turned, [length, length])
        triangles = model.getTriangleModels()[0]
        model.addClothConstraints(triangles, 1, 1.0, 1, 1, 1, 0.3, 0.3, False, False)
        model.addBendingConstraints(triangles, 2, 0.1)
    return run(add, lambda x: x[:, 0] < x[:, 0].min() + 1e-6, side * side, 2 * (side - 1) ** 2, SHEET["iterations"], 1)


def block(cells, _threads):
    nx, nz, ny = cells

    def add(model):
        model.addRegularTetModel(nx + 1, ny + 1, nz + 1, [0, 0, 0], np.identity(3), [n * BLOCK["spacing"] for n in (nx, ny, nz)])
        model.addSolidConstraints(model.getTetModels()[0], 1, 1.0, 0.3, 1.0, False, False)
    return run(add, lambda x: x[:, 1] < x[:, 1].min() + 1e-6, (nx + 1) * (ny + 1) * (nz + 1), 5 * nx * ny * nz, BLOCK["iterations"], 1)


CASES = {
    "cloth": (cloth, "distances along all edges and dihedral angles, 8 Gauss–Seidel iterations"),
    "block-pbd": (block, "distances and volumes of five tetrahedra a cell, 5 Gauss–Seidel iterations"),
}
if __name__ == "__main__":
    worker(CASES)
