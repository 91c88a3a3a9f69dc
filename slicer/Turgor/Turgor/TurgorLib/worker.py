"""Cuts with the Python module `turgor`, as `turgor run` does: worker.py FOLDER

Reads FOLDER/scene.toml; writes patient.obj, deformed.nrrd and report.json to FOLDER/out. Prints progress line by line.
Stops when scene.toml is removed, because the launcher between Slicer and this process does not forward signals.
"""
import json
import pathlib
import sys

import numpy as np

import nrrd_file


def make_progress(scene):
    """Callback that prints a line per percent, and exits when the scene file is removed."""
    last = [None]

    def progress(phase, fraction):
        if not scene.exists():
            sys.exit(130)
        if last[0] != (phase, int(100 * fraction)):
            last[0] = (phase, int(100 * fraction))
            print(f"{phase} {fraction:.2f}", flush=True)

    return progress


def write_obj(file, points, skin, wound):
    """Writes points (n, 3) [mm] and triangles (m, 3) of the skin and of the walls of the wound."""
    with open(file, "w", encoding="ascii") as out:
        np.savetxt(out, points, fmt="v %.9g %.9g %.9g")
        for name, triangles in (("skin", skin), ("wound", wound)):
            out.write(f"g {name}\n")
            np.savetxt(out, triangles + 1, fmt="f %d %d %d")


def cut(turgor, folder):
    progress = make_progress(folder / "scene.toml")
    world = turgor.World(folder / "scene.toml", progress=progress)
    for _ in world.run(every=world.dt, progress=progress):
        pass
    patient = world["patient"]
    out = folder / "out"
    out.mkdir()
    deformed = patient.deformed_volume()
    affine = deformed.affine
    affine[:3] *= 1e3
    nrrd_file.write(out / "deformed.nrrd", deformed.samples, affine)
    walls = patient.wall_begin
    write_obj(out / "patient.obj", 1e3 * patient.points, patient.triangles[:walls], patient.triangles[walls:])
    (out / "report.json").write_text(json.dumps(world.report()))


def main(folder):
    try:
        import turgor
    except ImportError as error:
        sys.exit(f"the Python module turgor is installed but cannot be loaded: {error}")
    try:
        cut(turgor, folder)
    except turgor.Error as error:
        sys.exit(str(error))


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]))
