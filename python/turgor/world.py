"""Worlds: scenes during simulation."""
import json
import os
import sys
import tempfile
import warnings

import numpy as np

from . import _turgor
from .body import Body
from .columns import Columns
from .scenes import GivenScene


def _print_progress(label, fraction):
    print(f"\r{label} {fraction:4.0%}", end="\n" if fraction >= 1 else "", file=sys.stderr, flush=True)


def _progress_callback(progress):
    return _print_progress if progress is True else progress or None


def _file_and_text(given, scene, text, folder):
    if (scene is None) == (text is None):
        raise TypeError("expected either a scene (a file or a dict) or text=")
    if isinstance(scene, dict):
        text = given.document(scene)
    if text is None:
        return os.fspath(scene), None
    return os.path.join(os.fspath(folder), "scene.toml"), text


class World(_turgor.World):
    """A scene during simulation.

    scene: a TOML file, or a dict of its tables. Use text=... for the text of a scene instead. Relative paths in a dict or a
    text are relative to `folder`, those in a file to the file. In a dict, a Volume or a Mesh may replace a file name.
    set: keys of the scene to override, as {"body.liver.young": 5e3}; None removes a key.
    volumes, labels: Volumes by body, instead of the files of `ct` and `labels`.
    threads: up to 1024; 0 = one per core; results do not depend on it.
    keeps_forces: False: forces() stays empty, which limits the memory of long runs.
    progress: callback progress(label, fraction) during loading; True prints it.

    Raises Error with a message if the scene is invalid.
    """

    def __init__(self, scene=None, *, text=None, folder=".", set=None, volumes=None, labels=None, threads=0,
                 keeps_forces=True, progress=None):
        with tempfile.TemporaryDirectory(prefix="turgor-") as scratch:
            given = GivenScene(scratch)
            file, text = _file_and_text(given, scene, text, folder)
            overrides = given.overrides(set, volumes, labels)
            super().__init__(file, text, overrides, threads, keeps_forces, given.volumes, given.labels, _progress_callback(progress))

    def __getitem__(self, name):
        """Body of that name. Raises KeyError for an unknown name."""
        return Body(self, name)

    def copy(self, threads=0):
        """Independent copy, which continues with the same bits. threads: 0 = as many as this world."""
        other = World.__new__(World)
        _turgor.World.__init__(other, self, threads)
        return other

    def run(self, seconds=None, every=0.1, callback=None, progress=None):
        """Simulates for `seconds` (default: to the end of the scene) and yields the world every `every` seconds.

        callback(world): called before each yield; False ends the run. progress: as for World.
        """
        begin, report = self.frame, _progress_callback(progress)
        end = begin + round((self.duration - self.time if seconds is None else seconds) / self.dt)
        stride = max(1, round(every / self.dt))
        while self.frame < end:
            self.step(min(stride, end - self.frame))
            if report:
                report("simulating", (self.frame - begin) / (end - begin))
            continues = callback is None or callback(self) is not False
            yield self
            if not continues:
                return

    def tick(self, poses, hold=None):
        """Moves all tools through ticks of one millisecond, and returns the forces on them.

        poses: (ticks, tools, 7): x, y, z [m] and a quaternion w, x, y, z of every tool, in the order of `tools`.
        hold: (ticks, tools) or an array that broadcasts to it; true grasps the tissue in contact (forceps close).
        Returns (ticks, tools, 6): force [N] and torque [N·m] on every tool. Frames are included when they are due. Other
        Python threads run meanwhile. After the first call, step(), run() and drive() are refused.
        """
        poses = np.ascontiguousarray(poses, dtype=np.float64)
        return self._tick(poses, _holds(hold, poses.shape[:-1]))

    @property
    def is_led(self):
        """Deprecated: use is_ticked."""
        warnings.warn("World.is_led is now World.is_ticked; the old name is removed in the next release", DeprecationWarning, stacklevel=2)
        return self.is_ticked
    def forces(self, tool):
        """Forces on a tool as Columns, per tick, or per frame on lattices and cloth:
        time_s, position_m, force_N, torque_Nm, depth_m, contacts."""
        return Columns(self._forces(tool))

    def measures(self, name=None):
        """Measurements of step() and run(), frame by frame, as Columns: of one incision or cloth, or a dict of all.

        Columns of a wound: time_s, gape_max_m, gape_mean_m, opening_area_m2, edge_displacement_m."""
        all = {of: Columns(columns) for of, columns in self._measures().items()}
        return all if name is None else all[name]

    def report(self):
        """Present content of report.json for bodies, wounds and tools, as a dict. Keys include their units."""
        return json.loads(self._report())


def _holds(hold, shape):
    if hold is None:
        return None
    return np.ascontiguousarray(np.broadcast_to(np.asarray(hold, dtype=bool), shape))


def tick_all(worlds, poses, hold=None, threads=0):
    """World.tick of many worlds in parallel, one thread per world, at most `threads` at a time (0 = one per core).

    poses: (worlds, ticks, tools, 7). hold: broadcasts to (worlds, ticks, tools). Returns (worlds, ticks, tools, 6).
    Worlds created with threads=1 do not wait for each other.
    """
    poses = np.ascontiguousarray(poses, dtype=np.float64)
    hold = _holds(hold, poses.shape[:-1])
    rows = poses.shape[0] * poses.shape[1]
    flat = None if hold is None else hold.reshape(rows, -1)
    return _turgor.tick_all(list(worlds), poses.reshape(rows, *poses.shape[2:]), flat, threads)


def run(scene=None, out=None, *, text=None, folder=".", set=None, threads=0, force=False, on_frame=None, progress=None):
    """Runs a scene like the program: writes pictures, meshes and a report into the folder `out` (default out/SCENE).

    Returns the report as a dict. force: replaces earlier results even if files were added or changed.
    on_frame(seconds): called after every frame; False ends the run and keeps its results. An exception of it and Ctrl+C
    cancel the run and leave no folder. progress: as for World.
    """
    with tempfile.TemporaryDirectory(prefix="turgor-") as scratch:
        given = GivenScene(scratch)
        file, text = _file_and_text(given, scene, text, folder)
        overrides = given.overrides(set, None, None)
        if given.volumes or given.labels:
            raise _turgor.Error("run: expected volumes as files, which the report names, found one in memory; World accepts it")
        return json.loads(_turgor.run_to_json(file, text, overrides, os.fspath(out or ""), force, threads, on_frame, _progress_callback(progress)))
