"""MuJoCo's flexes: four steps of 1/240 s a frame, conjugate gradients."""
import mujoco
from work import BLOCK, FRAME, GRAVITY, SHEET, Body, worker

STEPS = 4  # a frame


def run(flex):
    text = f"""<mujoco><option timestep="{FRAME / STEPS}" gravity="0 0 {-GRAVITY}" solver="CG" tolerance="1e-6" integrator="discrete"/>
        <size memory="4G"/><worldbody>{flex}</worldbody></mujoco>"""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)

    def frame():
        for _ in range(STEPS):
            mujoco.mj_step(model, data)
    return Body(frame, lambda: data.flexvert_xpos[:, 2], model.nflexvert, model.nflexelem)


def sheet(collides):
    def build(side, _threads):
        spacing = SHEET["spacing"]
        thickness = 1e-3  # [m]; the stiffness of the sheet is Young's modulus times it
        return run(f"""<flexcomp name="sheet" type="grid" dim="2" count="{side} {side} 1" spacing="{spacing} {spacing} {spacing}"
            radius="{SHEET['thickness'] / 2}" mass="{SHEET['density'] * (spacing * (side - 1)) ** 2}">
            <elasticity young="{SHEET['stiffness'] / thickness}" poisson="0.2" thickness="{thickness}" elastic2d="stretch" damping="0.001"/>
            <contact selfcollide="{'sap' if collides else 'none'}" contype="0" conaffinity="0"/><pin gridrange="0 0 0 {side - 1}"/></flexcomp>""")
    return build


def block(cells, _threads):
    nx, ny, nz = cells
    spacing = BLOCK["spacing"]
    return run(f"""<flexcomp name="block" type="grid" dim="3" count="{nx + 1} {ny + 1} {nz + 1}" spacing="{spacing} {spacing} {spacing}"
        radius="0.001" mass="{BLOCK['density'] * nx * ny * nz * spacing**3}">
        <elasticity young="{BLOCK['young']}" poisson="{BLOCK['poisson']}" damping="0.001"/>
        <contact selfcollide="none" contype="0" conaffinity="0"/><pin gridrange="0 0 0 {nx} {ny} 0"/></flexcomp>""")


CASES = {
    "cloth": (sheet(False), "elastic triangles without bending, CG to 1e-6, 4 steps a frame"),
    "cloth-self": (sheet(True), "the same, contacts of elements"),
    "block": (block, "Saint Venant–Kirchhoff tetrahedra, six a cell, CG to 1e-6, 4 steps a frame"),
}
if __name__ == "__main__":
    worker(CASES)
