"""A cut outside of Slicer: a folder with the volume and a scene, a process of Turgor's, and what comes back.

Nothing here needs Slicer. Volumes are arrays (k, j, i) with the (4, 4) matrix from (i, j, k, 1) to RAS [mm], lines are
(n, 3) in RAS [mm], as Slicer has them. Turgor's own frame, LPS in metres, is known here and nowhere else of the module.
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

MISSING = ("Turgor itself is not here. Install its wheel in Slicer's Python console, "
           "slicer.util.pip_install('/path/to/turgor-….whl'), or say below where the program turgor is (docs/slicer.md).")


class CutError(Exception):
    """What was not as expected, as a sentence for the panel."""


@dataclasses.dataclass
class Wishes:
    """How to cut, and what the skin is like."""
    depth: float = 10  # below the skin [mm]
    tension: tuple = (45, 45)  # along and across Langer's lines [N/m]
    direction: object = None  # of Langer's lines, (3,) RAS; None: from right to left
    step: float = 4  # of the lattice [mm]
    seconds: float = 2  # simulated


@dataclasses.dataclass
class Opened:
    """What a cut has made of the patient. Places are RAS [mm]."""
    points: np.ndarray  # (n, 3), of the surface as it lies now
    skin: np.ndarray  # (m, 3) triangles
    wound: np.ndarray  # (w, 3) triangles: the walls of the wound
    samples: np.ndarray  # (k, j, i) [HU], on the grid of the volume that was given
    measures: list  # of (name, value, unit)
    profile: np.ndarray  # (p, 2): place along the cut, gape there [mm]
    warnings: list


@dataclasses.dataclass
class Cutter:
    """What cuts: a command that takes a folder, and the environment that it runs in."""
    command: object
    environment: dict


def find_cutter(program, python, program_environment):
    """The program that the user named, else the module, else a program that the shell would find."""
    if program and not (os.path.isfile(program) and os.access(program, os.X_OK)):
        raise CutError(f"{program}: expected the program turgor, found nothing that runs.")
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
    """Points of a polyline about `apart` from each other, its ends among them."""
    way = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    count = max(2, round(way[-1] / apart) + 1)
    along = np.linspace(0, way[-1], count)
    return np.column_stack([np.interp(along, way, points[:, axis]) for axis in range(3)])


def scene_text(line, wishes):
    """The scene of a cut along a line, RAS [mm], through what is in volume.nrrd."""
    path = (line @ RAS * 1e-3).tolist()
    direction = [1, 0, 0] if wishes.direction is None else (RAS @ wishes.direction / np.linalg.norm(wishes.direction)).tolist()
    return f"""[world]
duration = {wishes.seconds}
[body.patient]
model = "lattice"
ct = "volume.nrrd"
step = {wishes.step * 1e-3}
fixed = ["bone", "ends"]
skin = {{ tension = {list(map(float, wishes.tension))}, direction = {direction} }}
[incision.cut]
body = "patient"
path = {path}
depth = {wishes.depth * 1e-3}
start = {0.05 * wishes.seconds}
duration = {0.2 * wishes.seconds}
[output]
snapshots = {{ every = {wishes.seconds}, size = [64, 64] }}
deformed_ct = "deformed.nrrd"
mesh_unit = "mm"
meshes = false
recording = false
sections = false
volume_rendering = false
"""


def hounsfield(samples):
    """Whole numbers as the engine has them; what is no number is air."""
    if not np.issubdtype(samples.dtype, np.integer):
        samples = np.rint(np.nan_to_num(samples, nan=AIR))
    return np.clip(samples, -32768, 32767).astype(np.int16)


def upright(samples, affine):
    """The volume with k nearest to the patient's long axis, as the engine takes it: where a scan ends, it holds the body."""
    along = np.abs(affine[:3, :3] / np.linalg.norm(affine[:3, :3], axis=0))
    order = list(max(itertools.permutations(range(3)), key=lambda order: sum(along[axis, order[axis]] for axis in range(3))))
    return samples.transpose(2, 1, 0).transpose(order).transpose(2, 1, 0), affine[:, [*order, 3]]


def on_grid(samples, affine, wanted, shape):
    """The same volume with its axes in the order and direction of another matrix, along which each of them runs."""
    steps = np.linalg.inv(wanted[:3, :3]) @ affine[:3, :3]
    source = np.abs(steps).argmax(axis=1)
    ijk = samples.transpose(2, 1, 0).transpose(source)
    backwards = [axis for axis in range(3) if steps[axis, source[axis]] < 0]
    turned = np.flip(ijk, backwards).transpose(2, 1, 0)
    whole = np.zeros((3, 3))
    whole[range(3), source] = np.sign(steps[range(3), source])
    if turned.shape != tuple(shape) or np.abs(steps - whole).max() > 1e-3:
        raise CutError("the deformed volume came back on another grid than the volume's.")
    return np.ascontiguousarray(turned)


def read_obj(file):
    """Points (n, 3), and triangles (m, 3) by the names of their groups."""
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
            ("opening area", "opening_area_mm2", "mm²"), ("way of the lips", "edge_displacement_mm", "mm"),
            ("length of the cut skin", "length_mm", "mm"), ("depth", "depth_mm", "mm"),
            ("angle to Langer's lines", "angle_to_lines_deg", "°"),
            ("skin tension across the cut", "tension_across_cut_N_per_m", "N/m"))


def measures_of(report):
    """Rows (name, value, unit) of a wound."""
    wound = report["wounds"][0]
    return [(name, float(wound[key]), unit) for name, key, unit in MEASURES if wound.get(key) is not None]


def read_sentence(log):
    """What Turgor said when it ended, without what a user of Slicer has no use for."""
    said = [line for line in log.splitlines() if line.strip() and not PROGRESS.match(line)]
    sentence = re.sub(r"^(turgor: )?(\S*scene\.toml(:\d+)*: )?(incision\.cut: )?(incision 'cut': )?", "", said[-1] if said else "")
    if re.search(r"\) m\b", sentence):
        sentence += " (These places are metres to the left, to the back and to the head: Slicer's R and A with the other sign.)"
    return sentence


class Cut:
    """A cut that is under way: ask is_over() now and then, then take opened() or stop with cancel()."""

    def __init__(self, cutter, samples, ijk_to_ras, line, wishes):
        self.affine, self.shape = np.diag([-1.0, -1.0, 1.0, 1.0]) @ ijk_to_ras, samples.shape
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="turgor-slicer-"))
        self.process = None
        try:
            nrrd_file.write(self.folder / "volume.nrrd", *upright(hounsfield(samples), self.affine))
            (self.folder / "scene.toml").write_text(scene_text(line, wishes), encoding="utf-8")
            with open(self.folder / "log.txt", "wb") as log:
                self.process = subprocess.Popen(cutter.command(self.folder), env=cutter.environment, stdin=subprocess.DEVNULL,
                                                stdout=log, stderr=subprocess.STDOUT)
        except OSError as error:
            self.cancel()
            raise CutError(f"Turgor could not be started: {error}.") from error

    def is_over(self):
        return self.process.poll() is not None

    def progress(self):
        """A word and the finished part of it."""
        told = [PROGRESS.match(line) for line in self._log().splitlines()[-3:]]
        last = [match for match in told if match]
        return (last[-1].group(1), float(last[-1].group(2))) if last else ("starting", 0.0)

    def cancel(self):
        """Ends it and leaves nothing. A worker behind a launcher hears no signal, but sees that its scene is gone."""
        if self.process is not None and not self.is_over():
            self.process.terminate()
            (self.folder / "scene.toml").unlink(missing_ok=True)
            self.process.wait()
        shutil.rmtree(self.folder, ignore_errors=True)

    def opened(self):
        """What came of it, once it is over; its folder goes. CutError: what Turgor said."""
        try:
            if self.process.returncode != 0:
                said = read_sentence(self._log()) or "it said nothing"
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
