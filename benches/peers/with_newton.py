"""Newton on Warp's CPU device: vertex block descent (VBD), one step a frame."""
import newton
import numpy as np
import warp
from work import BLOCK, FRAME, GRAVITY, SHEET, Body, lame, worker


def run(builder, elements, **options):
    warp.config.quiet = True
    warp.set_device("cpu")
    builder.color()
    model = builder.finalize()
    solver = newton.solvers.SolverVBD(model, **options)
    states, control = [model.state(), model.state()], model.control()

    def frame():
        states[0].clear_forces()
        solver.step(states[0], states[1], control, None, FRAME)
        states.reverse()
    return Body(frame, lambda: states[0].particle_q.numpy()[:, 2], model.particle_count, elements)


def sheet(collides):
    def build(side, _threads):
        builder = newton.ModelBuilder(gravity=(0, 0, -GRAVITY))
        spacing = SHEET["spacing"]
        builder.add_cloth_grid(pos=warp.vec3(0, 0, 0), rot=warp.quat_identity(), vel=warp.vec3(0, 0, 0), dim_x=side - 1, dim_y=side - 1,
                               cell_x=spacing, cell_y=spacing, mass=SHEET["density"] * spacing**2, fix_left=True,
                               tri_ke=SHEET["stiffness"], tri_ka=SHEET["stiffness"], tri_kd=1e-3, edge_ke=1e-5, edge_kd=0,
                               particle_radius=SHEET["thickness"])
        contact = {"particle_enable_self_contact": True, "particle_self_contact_margin": SHEET["thickness"],
                   "particle_self_contact_gap": SHEET["thickness"] / 2} if collides else {}
        return run(builder, 2 * (side - 1) ** 2, iterations=SHEET["iterations"], **contact)
    return build


def block(cells, _threads):
    mu, second = lame()
    builder = newton.ModelBuilder(gravity=(0, 0, -GRAVITY))
    size = {f"cell_{axis}": BLOCK["spacing"] for axis in "xyz"} | {f"dim_{axis}": n for axis, n in zip("xyz", cells)}
    builder.add_soft_grid(pos=warp.vec3(0, 0, 0), rot=warp.quat_identity(), vel=warp.vec3(0, 0, 0), density=BLOCK["density"], k_mu=mu,
                          k_lambda=second, k_damp=0, **size)
    heights = np.array([list(q) for q in builder.particle_q])[:, 2]
    for n in np.nonzero(heights < 1e-6)[0]:
        builder.particle_mass[n] = 0.0
    return run(builder, 5 * cells[0] * cells[1] * cells[2], iterations=BLOCK["iterations"])


CASES = {
    "cloth": (sheet(False), "StVK triangles and dihedral angles, VBD, 8 iterations"),
    "cloth-self": (sheet(True), "the same, contacts of vertices, triangles and edges; motion bounded by them"),
    "block": (block, "neo-Hookean tetrahedra, five a cell, VBD, 5 iterations"),
}
if __name__ == "__main__":
    worker(CASES)
