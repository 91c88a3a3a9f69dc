"""A cut in a separate process: writes the volume and a scene to a folder, starts Turgor, and reads its results.

Does not depend on Slicer. Volumes are arrays (k, j, i) with the (4, 4) matrix from (i, j, k, 1) to RAS [mm]. Lines are
(n, 3) in RAS [mm], as in Slicer. Only this file converts to Turgor's frame, LPS in meters.
"""
import dataclasses
import importlib.util
import itertools
import json
import os
import pathlib
import re
import shutil
import subprocess
import tempfile

import numpy as np

from . import nrrd_file

RAS = np.diag([-1.0, -1.0, 1.0])  # between LPS and RAS
AIR = -1000  # [HU]
PROGRESS = re.compile(r"^(\D+) (\d\.\d\d)$")

MISSING = ("Turgor is not installed. Install its wheel in Slicer's Python console, "
           "slicer.util.pip_install('/path/to/turgor-….whl'), or enter the path of the program turgor below (docs/slicer.md).")


class CutError(Exception):
    """Error with a sentence for the panel."""


@dataclasses.dataclass
class CutOptions:
    """Parameters of the cut and of the skin."""
    depth: float = 10  # below the skin [mm]
    tension: tuple = (45, 45)  # along and across Langer's lines [N/m]
    direction: object = None  # of Langer's lines, (3,) RAS; None: from right to left
    step: float = 4  # spacing of the lattice [mm]
    seconds: float = 2  # simulated


@dataclasses.dataclass
class Opened:
    """Results of a cut. Points are in RAS [mm]."""
    points: np.ndarray  # (n, 3), of the deformed surface
    skin: np.ndarray  # (m, 3) triangles
    wound: np.ndarray  # (w, 3) triangles: the walls of the wound
    samples: np.ndarray  # (k, j, i) [HU], on the grid of the input volume
    measures: list  # of (name, value, unit)
    profile: np.ndarray  # (p, 2): distance along the cut, gape [mm]
    warnings: list


@dataclasses.dataclass
class Cutter:
    """A function from a folder to the command line, and the environment of the process."""
    command: object
    environment: dict


def find_cutter(program, python, program_environment):
    """The program named by the user, else the Python module, else a program on the PATH."""
    if program and not (os.path.isfile(program) and os.access(program, os.X_OK)):
        raise CutError(f"{program}: expected the program turgor, found no executable file.")
    found = program or (None if importlib.util.find_spec("turgor") else shutil.which("turgor"))
    if found:
        return Cutter(lambda folder: [found, "run", f"{folder}/scene.toml", "--progress", "--out", f"{folder}/out"],
                      program_environment)
    if not importlib.util.find_spec("turgor"):
        raise CutError(MISSING)
    if not python:
        raise CutError("PythonSlicer, in which the Python module turgor would run, was not found on Slicer's PATH.")
    worker = pathlib.Path(__file__).with_name("worker.py")
    return Cutter(lambda folder: [python, str(worker), str(folder)], dict(os.environ))


def spread(points, apart):
    """Points of a polyline at distances of about `apart`, with its ends."""
    length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    count = max(2, round(length[-1] / apart) + 1)
    along = np.linspace(0, length[-1], count)
    return np.column_stack([np.interp(along, length, points[:, axis]) for axis in range(3)])


def scene_text(line, options):
    """Scene of a cut along a line in RAS [mm] through the body in volume.nrrd."""
    path = (line @ RAS * 1e-3).tolist()
    direction = [1, 0, 0] if options.direction is None else (RAS @ options.direction / np.linalg.norm(options.direction)).tolist()
    return f"""[world]
duration = {options.seconds}
[body.patient]
model = "lattice"
ct = "volume.nrrd"
spacing = {options.step * 1e-3}
fixed = ["bone", "ends"]
skin = {{ tension = {list(map(float, options.tension))}, direction = {direction} }}
[incision.cut]
body = "patient"
path = {path}
depth = {options.depth * 1e-3}
start = {0.05 * options.seconds}
duration = {0.2 * options.seconds}
[output]
snapshots = {{ every = {options.seconds}, size = [64, 64] }}
deformed_ct = "deformed.nrrd"
mesh_unit = "mm"
meshes = false
recording = false
sections = false
volume_rendering = false
"""


def hounsfield(samples):
    """Samples as int16; NaN becomes air."""
    if not np.issubdtype(samples.dtype, np.integer):
        samples = np.rint(np.nan_to_num(samples, nan=AIR))
    return np.clip(samples, -32768, 32767).astype(np.int16)


def upright(samples, affine):
    """The volume with k nearest to the patient's long axis, because the engine fixes the body at both ends of k."""
    along = np.abs(affine[:3, :3] / np.linalg.norm(affine[:3, :3], axis=0))
    order = list(max(itertools.permutations(range(3)), key=lambda order: sum(along[axis, order[axis]] for axis in range(3))))
    return samples.transpose(2, 1, 0).transpose(order).transpose(2, 1, 0), affine[:, [*order, 3]]


def on_grid(samples, affine, wanted, shape):
    """The same volume with the axis order and directions of the matrix `wanted`."""
    steps = np.linalg.inv(wanted[:3, :3]) @ affine[:3, :3]
    source = np.abs(steps).argmax(axis=1)
    ijk = samples.transpose(2, 1, 0).transpose(source)
    backwards = [axis for axis in range(3) if steps[axis, source[axis]] < 0]
    turned = np.flip(ijk, backwards).transpose(2, 1, 0)
    whole = np.zeros((3, 3))
    whole[range(3), source] = np.sign(steps[range(3), source])
    if turned.shape != tuple(shape) or np.abs(steps - whole).max() > 1e-3:
        raise CutError("the grid of the deformed volume differs from the input volume.")
    return np.ascontiguousarray(turned)


def read_obj(file):
    """Returns points (n, 3), and triangles (m, 3) by group name."""
    points, groups, triangles = [], {}, []
    with open(file, encoding="ascii") as lines:
        for line in lines:
            word, _, rest = line.partition(" ")
            if word == "v":
                points.append(rest.split())
            elif word == "g":
                triangles = groups.setdefault(rest.strip(), [])
            elif word == "f":
                triangles.append([corner.partition("/")[0] for corner in rest.split()])
    as_triangles = {name: np.array(rows, dtype=np.int64).reshape(-1, 3) - 1 for name, rows in groups.items()}
    return np.array(points, dtype=float), as_triangles


MEASURES = (("gape, largest", "gape_max_mm", "mm"), ("gape, mean", "gape_mean_mm", "mm"),
            ("opening area", "opening_area_mm2", "mm²"), ("lip displacement", "edge_displacement_mm", "mm"),
            ("length of the cut skin", "length_mm", "mm"), ("depth", "depth_mm", "mm"),
            ("angle to Langer's lines", "angle_to_lines_deg", "°"),
            ("skin tension across the cut", "tension_across_cut_N_per_m", "N/m"))


def measures_of(report):
    """Rows (name, value, unit) of the first wound."""
    wound = report["wounds"][0]
    return [(name, float(wound[key]), unit) for name, key, unit in MEASURES if wound.get(key) is not None]


def read_sentence(log):
    """Last message of Turgor, without locations in the generated scene file."""
    said = [line for line in log.splitlines() if line.strip() and not PROGRESS.match(line)]
    sentence = re.sub(r"^(turgor: )?(\S*scene\.toml(:\d+)*: )?(incision\.cut: )?(incision 'cut': )?", "", said[-1] if said else "")
    if re.search(r"\) m\b", sentence):
        sentence += " (Coordinates are LPS in meters: R and A of Slicer with the opposite sign.)"
    return sentence


class Cut:
    """A running cut. Poll is_over(), then call opened(); or stop it with cancel()."""

    def __init__(self, cutter, samples, ijk_to_ras, line, options):
        self.affine, self.shape = np.diag([-1.0, -1.0, 1.0, 1.0]) @ ijk_to_ras, samples.shape
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="turgor-slicer-"))
        self.process = None
        try:
            nrrd_file.write(self.folder / "volume.nrrd", *upright(hounsfield(samples), self.affine))
            (self.folder / "scene.toml").write_text(scene_text(line, options), encoding="utf-8")
            with open(self.folder / "log.txt", "wb") as log:
                self.process = subprocess.Popen(cutter.command(self.folder), env=cutter.environment, stdin=subprocess.DEVNULL,
                                                stdout=log, stderr=subprocess.STDOUT)
        except OSError as error:
            self.cancel()
            raise CutError(f"Turgor could not be started: {error}.") from error

    def is_over(self):
        return self.process.poll() is not None

    def progress(self):
        """Name of the current phase and its finished fraction."""
        matches = [PROGRESS.match(line) for line in self._log().splitlines()[-3:]]
        last = [match for match in matches if match]
        return (last[-1].group(1), float(last[-1].group(2))) if last else ("starting", 0.0)

    def cancel(self):
        """Stops the process and removes its folder. A worker behind a launcher gets no signal, so its scene is removed too."""
        if self.process is not None and not self.is_over():
            self.process.terminate()
            (self.folder / "scene.toml").unlink(missing_ok=True)
            self.process.wait()
        shutil.rmtree(self.folder, ignore_errors=True)

    def opened(self):
        """Results of the finished cut; removes its folder. CutError: the message of Turgor."""
        try:
            if self.process.returncode != 0:
                said = read_sentence(self._log()) or "no message"
                raise CutError(said if self.process.returncode in (1, 2, 3) else
                               f"Turgor ended with code {self.process.returncode}: {said}.")
            return self._read(self.folder / "out")
        finally:
            shutil.rmtree(self.folder, ignore_errors=True)

    def _read(self, out):
        report = json.loads((out / "report.json").read_text(encoding="utf-8"))
        points, triangles = read_obj(out / "patient.obj")
        samples, affine = nrrd_file.read(out / "deformed.nrrd")
        return Opened(points=points @ RAS, skin=triangles["skin"], wound=triangles["wound"],
                      samples=on_grid(samples, affine, self.affine, self.shape), measures=measures_of(report),
                      profile=np.array(report["wounds"][0].get("profile", []), dtype=float).reshape(-1, 2),
                      warnings=report.get("warnings", []))

    def _log(self):
        return (self.folder / "log.txt").read_text(encoding="utf-8", errors="replace")
