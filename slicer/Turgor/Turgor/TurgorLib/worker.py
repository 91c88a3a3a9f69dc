"""Cuts with the Python module `turgor`, as `turgor run` would: worker.py FOLDER

FOLDER has scene.toml; FOLDER/out gets patient.obj, deformed.nrrd and report.json. How far it is, is printed line by line.
It stops when scene.toml is gone: between it and Slicer is a launcher, which passes no signal on.
"""
import json
import pathlib
import sys

import numpy as np

import nrrd_file


def make_told(scene):
    """A line a percent, and the end where nobody waits any more."""
    last = [None]

    def told(word, fraction):
        if not scene.exists():
            sys.exit(130)
        if last[0] != (word, int(100 * fraction)):
            last[0] = (word, int(100 * fraction))
            print(f"{word} {fraction:.2f}", flush=True)

    return told


def write_obj(file, points, skin, wound):
    """points: (n, 3) [mm]; triangles (m, 3) of the skin and of the wound's walls."""
    with open(file, "w", encoding="ascii") as out:
        np.savetxt(out, points, fmt="v %.4f %.4f %.4f")
        for name, triangles in (("skin", skin), ("wound", wound)):
            out.write(f"g {name}\n")
            np.savetxt(out, triangles + 1, fmt="f %d %d %d")


def cut(turgor, folder):
    told = make_told(folder / "scene.toml")
    world = turgor.World(folder / "scene.toml", progress=told)
    for _ in world.run(every=world.dt, progress=told):
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
        sys.exit(f"the Python module turgor is there but cannot be loaded: {error}")
    try:
        cut(turgor, folder)
    except turgor.Error as error:
        sys.exit(str(error))


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]))
