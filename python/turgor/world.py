"""Worlds: scenes while they are simulated."""
import json
import os
import sys
import tempfile

import numpy as np

from . import _turgor
from .body import Body
from .columns import Columns
from .scenes import GivenScene


def _print_progress(label, fraction):
    print(f"\r{label} {fraction:4.0%}", end="\n" if fraction >= 1 else "", file=sys.stderr, flush=True)


def _told(progress):
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
    """A scene that is being simulated.

    scene: a TOML file, or a dict of its tables; or with text=..., the scene itself. Files that they name are sought from
        `folder`, those that a file names beside it. In a dict, Volume and Mesh may stand where a file is named.
    set: keys of the scene to override, as {"body.liver.young": 5e3}; None removes a key.
    volumes, labels: Volumes by body, in place of the files of its `ct` and `labels`.
    threads: 0 = one per core; results do not depend on it.
    keeps_forces: False: forces() stays empty, however long the world goes on.
    progress: told while the world is made, as progress(word, fraction); True prints it.

    Raises Error with a sentence for what the program refuses.
    """

    def __init__(self, scene=None, *, text=None, folder=".", set=None, volumes=None, labels=None, threads=0,
                 keeps_forces=True, progress=None):
        with tempfile.TemporaryDirectory(prefix="turgor-") as scratch:
            given = GivenScene(scratch)
            file, text = _file_and_text(given, scene, text, folder)
            overrides = given.overrides(set, volumes, labels)
            super().__init__(file, text, overrides, threads, keeps_forces, given.volumes, given.labels, _told(progress))

    def __getitem__(self, name):
        """The body of that name. KeyError: there is none."""
        return Body(self, name)

    def copy(self, threads=0):
        """Another world that goes on as this one does, to the same bits. threads: 0 = as many as this one."""
        other = World.__new__(World)
        _turgor.World.__init__(other, self, threads)
        return other

    def run(self, seconds=None, every=0.1, callback=None, progress=None):
        """Simulates on (default: to the end of the scene) and yields the world every so many seconds.

        callback(world): called before each yield; False ends the run. progress: as for World.
        """
        begin, told = self.frame, _told(progress)
        end = begin + round((self.duration - self.time if seconds is None else seconds) / self.dt)
        stride = max(1, round(every / self.dt))
        while self.frame < end:
            self.step(min(stride, end - self.frame))
            if told:
                told("simulating", (self.frame - begin) / (end - begin))
            goes_on = callback is None or callback(self) is not False
            yield self
            if not goes_on:
                return

    def tick(self, poses, hold=None):
        """Leads all tools through ticks of a millisecond, and returns what they feel in each.

        poses: (ticks, tools, 7): x, y, z [m] and a quaternion w, x, y, z, of every tool as in `tools`.
        hold: (ticks, tools) or what broadcasts to it: do tools take hold (forceps close)?
        Returns (ticks, tools, 6): force [N] and torque [N·m] on every tool. Frames come by themselves when their time is
        over; other Python threads run meanwhile. From the first call on, step(), run() and drive() are over.
        """
        poses = np.ascontiguousarray(poses, dtype=np.float64)
        return self._tick(poses, _holds(hold, poses.shape[:-1]))

    def forces(self, tool):
        """What a tool felt, tick by tick (bodies that are touched by the frame: frame by frame), as Columns:
        time_s, position_m, force_N, torque_Nm, depth_m, contacts."""
        return Columns(self._forces(tool))

    def measures(self, name=None):
        """What step() and run() measured frame by frame, as Columns: of the incision or the cloth of that name, or all by name.

        A wound: time_s, gape_max_m, gape_mean_m, opening_area_m2, edge_displacement_m."""
        all = {of: Columns(columns) for of, columns in self._measures().items()}
        return all if name is None else all[name]

    def report(self):
        """What report.json of a run says of bodies, wounds and tools until now, as a dict. Keys carry their units."""
        return json.loads(self._report())


def _holds(hold, shape):
    if hold is None:
        return None
    return np.ascontiguousarray(np.broadcast_to(np.asarray(hold, dtype=bool), shape))


def tick_all(worlds, poses, hold=None, threads=0):
    """World.tick of many worlds beside each other, one thread each, at most `threads` at a time (0 = one per core).

    poses: (worlds, ticks, tools, 7). hold: what broadcasts to (worlds, ticks, tools). Returns (worlds, ticks, tools, 6).
    Worlds that were made with threads=1 do not wait for each other.
    """
    poses = np.ascontiguousarray(poses, dtype=np.float64)
    hold = _holds(hold, poses.shape[:-1])
    rows = poses.shape[0] * poses.shape[1]
    flat = None if hold is None else hold.reshape(rows, -1)
    return _turgor.tick_all(list(worlds), poses.reshape(rows, *poses.shape[2:]), flat, threads)


def run(scene=None, out=None, *, text=None, folder=".", set=None, threads=0, force=False, on_frame=None, progress=None):
    """Runs a scene as the program does: pictures, meshes and report in the folder `out` (default out/SCENE).

    Returns the report as a dict. force: replace earlier results also where files were added or changed.
    on_frame(seconds): called after every frame; False ends the run there and keeps what there is. An exception of it, and
    Ctrl+C, cancel the run and leave no folder. progress: as for World.
    """
    with tempfile.TemporaryDirectory(prefix="turgor-") as scratch:
        given = GivenScene(scratch)
        file, text = _file_and_text(given, scene, text, folder)
        overrides = given.overrides(set, None, None)
        if given.volumes or given.labels:
            raise _turgor.Error("run: expected volumes as files, which the folder's report names, found one in memory; World takes it")
        return json.loads(_turgor.run_to_json(file, text, overrides, os.fspath(out or ""), force, threads, on_frame, _told(progress)))
