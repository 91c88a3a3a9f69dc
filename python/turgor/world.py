"""Worlds: scenes during simulation."""
from __future__ import annotations

import json
import math
import operator
import os
import sys
import tempfile
import warnings
from collections import abc
from typing import Any, Callable, Iterator, Mapping, Optional, Sequence, Union, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _turgor, drawing
from .body import Body
from .columns import Columns
from .scenes import GivenScene
from .volume import Volume

_LONGEST = 1e9  # between two moments of a run [s]

Progress = Union[None, bool, Callable[[str, float], object]]
SceneGiven = Union[None, str, "os.PathLike[str]", Mapping[str, Any]]
Text = Optional[str]
Overrides = Optional[Mapping[str, Any]]


def _print_progress(label, fraction):
    print(f"\r{label} {fraction:4.0%}", end="\n" if fraction >= 1 else "", file=sys.stderr, flush=True)


def _progress_callback(progress):
    return _print_progress if progress is True else progress or None


def _is_false(answer):
    """True for False of Python or NumPy, the answers of a callback that end a run."""
    return isinstance(answer, (bool, np.bool_)) and not answer


def _file_and_text(given, scene, text, folder):
    if (scene is None) == (text is None):
        raise TypeError("expected either a scene (a file or a dict) or text=")
    if isinstance(scene, abc.Mapping):
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

    def __init__(self, scene: SceneGiven = None, *, text: Text = None, folder: Union[str, os.PathLike[str]] = ".",
                 set: Overrides = None, volumes: Optional[Mapping[str, Volume]] = None,
                 labels: Optional[Mapping[str, Volume]] = None, threads: int = 0, keeps_forces: bool = True,
                 progress: Progress = None) -> None:
        with tempfile.TemporaryDirectory(prefix="turgor-") as scratch:
            given = GivenScene(scratch)
            file, text = _file_and_text(given, scene, text, folder)
            overrides = given.overrides(set, volumes, labels)
            super().__init__(file, text, overrides, given.folder_text, threads, keeps_forces, given.volumes, given.labels, _progress_callback(progress))

    def __getitem__(self, name: str) -> Body:
        """Body of that name. Raises KeyError for an unknown name."""
        return Body(self, name)

    def step(self, frames: int = 1) -> None:
        """Simulates this number of frames. Raises ValueError for a negative number."""
        if (number := operator.index(frames)) < 0:
            raise ValueError(f"step: expected frames of at least 0, found {number}")
        super().step(number)

    def drive(self, tool: str, rows: ArrayLike) -> None:
        """Moves a tool from its present position along rows of [t, x, y, z], linearly interpolated, with t [s] from now on.

        A fifth column grasps (1) or not (0), four more are the orientation (a quaternion w, x, y, z).
        """
        path = np.ascontiguousarray(rows, dtype=np.float64)
        if path.ndim != 2:
            raise ValueError(f"drive: expected rows (n, 4), (n, 5) or (n, 9), found an array of {path.shape}")
        super().drive(tool, path)

    def cut(self, body: str, points: ArrayLike, depth: float, *, tilt: float = 0, duration: float = 0.2, name: Optional[str] = None) -> str:
        """Starts a cut of a lattice in the frame that is computed next. Returns the name of the wound in measures() and report().

        points: (n, 3), on or near the present skin [m]; two are a straight line, more a smooth curve.
        depth: below the skin [m]. tilt: of the blade [degrees]. duration: of its motion [s]; 0 = instantaneous.
        name: default is the first of hand-1, hand-2, … that is free.
        The cut has the bits of the same incision of a scene. Raises KeyError for an unknown body, and Error for a cut that is
        refused, which changes nothing.
        """
        return self._cut(body, _points("cut", points), depth, tilt, duration, name or "")

    def stitch(self, body: str, points: ArrayLike, *, wound: Optional[str] = None, thread: str = "nylon 3-0",
               tension: Optional[float] = None, duration: float = 0.5) -> str:
        """Lays a single stitch through a wound in the frame that is computed next, and pulls it. Returns its name.

        points: (n, 3), in the CT (at rest), in the order of the thread, which closes to a loop [m].
        wound: its name; None = the nearest one that the stitch crosses. thread: a preset, such as "nylon 3-0".
        tension: at which it is knotted [N]; None = when the lips meet under it. duration: of the pull [s].
        The stitch has the bits of the same suture of a scene. Raises KeyError for an unknown body, and Error for a stitch that
        is refused, which changes nothing.
        """
        return self._stitch(body, _points("stitch", points), wound or "", thread, tension, duration)

    def tighten(self, stitch: str, tension: Optional[float] = None, duration: float = 0.3) -> None:
        """Pulls a stitch of stitch() to another tension [N], or without one until the lips meet, during a time [s]."""
        self._tighten(stitch, tension, duration)

    def copy(self, threads: int = 0) -> World:
        """Independent copy, which continues with the same bits. threads: 0 = as many as this world."""
        other = World.__new__(World)
        _turgor.World.__init__(other, self, threads)
        return other

    def run(self, seconds: Optional[float] = None, every: float = 0.1, callback: Optional[Callable[[World], object]] = None,
            progress: Progress = None) -> Iterator[World]:
        """Simulates for `seconds` (default: to the end of the scene) and yields the world every `every` seconds.

        callback(world): called before each yield; False, of Python or NumPy, ends the run, and other answers do not.
        progress: as for World. Times are rounded to whole frames, halves upwards, as by the program.
        """
        if seconds is not None and not 0 <= seconds < math.inf:
            raise ValueError(f"run: expected seconds of at least 0, found {seconds}")
        if not every > 0:
            raise ValueError(f"run: expected every above 0 s, found {every}")
        return self._run(seconds, every, callback, progress)

    def _run(self, seconds, every, callback, progress):
        begin, report = self.frame, _progress_callback(progress)
        end = self._frame_count if seconds is None else begin + self._frames_in(seconds)
        stride = max(1, self._frames_in(min(every, _LONGEST)))
        while self.frame < end:
            self.step(min(stride, end - self.frame))
            if report:
                report("simulating", (self.frame - begin) / (end - begin))
            ends = callback is not None and _is_false(callback(self))
            yield self
            if ends:
                return

    def _frames_in(self, seconds):
        """Nearest number of frames, halves upwards."""
        return math.floor(seconds * self._frame_rate + 0.5)

    def tick(self, poses: ArrayLike, hold: Optional[ArrayLike] = None) -> NDArray[np.float64]:
        """Moves all tools through ticks of one millisecond, and returns the forces on them.

        poses: (ticks, tools, 7): x, y, z [m] and a quaternion w, x, y, z of every tool, in the order of `tools`.
        hold: (ticks, tools) or an array that broadcasts to it; true grasps the tissue in contact (forceps close).
        Returns (ticks, tools, 6): force [N] and torque [N·m] on every tool. Frames are included when they are due. Other
        Python threads run meanwhile. After the first call, step(), run() and drive() are refused.
        """
        poses = _poses("tick", poses, ("ticks", "tools", 7))
        return self._tick(poses, _holds(hold, poses.shape[:-1]))

    def touch_tick(self, poses: ArrayLike, hold: Optional[ArrayLike] = None) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """One tick of one millisecond, between begin_touch() and end_touch(), while another thread may call step().

        poses: (tools, 7), as for tick(); a row of NaN moves its tool along the path of the scene. hold: (tools,).
        Returns forces and torques (tools, 6) and the poses (tools, 7). Never waits for a frame; the newest finished one counts.
        """
        poses = _poses("touch_tick", poses, ("tools", 7))
        hold = None if hold is None else _holds(hold, poses.shape[:-1])[None]
        return self._touch_tick(poses[None], hold)

    @property
    def is_led(self) -> bool:
        """Deprecated; use is_ticked."""
        warnings.warn("World.is_led is now World.is_ticked; the old name is removed in the next release", DeprecationWarning, stacklevel=2)
        return self.is_ticked

    def forces(self, tool: str) -> Columns:
        """Forces on a tool as Columns, per tick, or per frame on lattices and cloth:
        time_s, position_m, force_N, torque_Nm, depth_m, contacts."""
        return Columns(self._forces(tool))

    @overload
    def measures(self, name: str) -> Columns: ...
    @overload
    def measures(self, name: None = None) -> dict[str, Columns]: ...

    def measures(self, name: Optional[str] = None) -> Union[Columns, dict[str, Columns]]:
        """Measurements of step() and run(), frame by frame, as Columns: of one wound, suture, cloth, rigid body, attachment
        or contact of two bodies, or a dict of all. A suture with the name of a wound is suture.NAME; the same holds for
        body.NAME, attachment.NAME and contact.NAME.

        Columns of a wound: time_s, gape_max_m, gape_mean_m, opening_area_m2, edge_displacement_m. Of a suture: time_s,
        closing_force_N, tension_max_N, gape_max_m. Of a cloth: time_s, largest_speed_m_per_s. Of an attachment or a
        contact: time_s, force_N (on its first body), largest_force_N (of one spring or site), bearing, sliding.
        Of a rigid body: time_s, center_m (of mass), rotation (from the start, quaternion w, x, y, z),
        velocity_m_per_s and spin_rad_per_s (of the middle of the frame)."""
        all = {of: Columns(columns) for of, columns in self._measures().items()}
        if name is None:
            return all
        if name not in all:
            raise KeyError(f"nothing that is measured has the name {name}; known are {', '.join(all) or 'none'}")
        return all[name]

    def report(self) -> dict[str, Any]:
        """Present content of report.json for bodies, wounds and tools, as a dict. Keys include their units."""
        return json.loads(self._report())


def _poses(function, poses, shape):
    """Poses as a contiguous array. Raises ValueError for another shape than `shape`, whose last entry is 7."""
    array = np.ascontiguousarray(poses, dtype=np.float64)
    if array.ndim != len(shape) or array.shape[-1] != 7:
        raise ValueError(f"{function}: expected poses ({', '.join(map(str, shape))}), found an array of {array.shape}")
    return array


def _points(function, points):
    """Points as a contiguous array (n, 3). Raises ValueError for another shape."""
    array = np.ascontiguousarray(points, dtype=np.float64)
    if array.ndim != 2 or array.shape[-1] != 3:
        raise ValueError(f"{function}: expected points (n, 3), found an array of {array.shape}")
    return array


def _holds(hold, shape):
    if hold is None:
        return None
    return np.ascontiguousarray(np.broadcast_to(np.asarray(hold, dtype=bool), shape))


def tick_all(worlds: Sequence[World], poses: ArrayLike, hold: Optional[ArrayLike] = None, threads: int = 0) -> NDArray[np.float64]:
    """World.tick of many worlds in parallel, one thread per world, at most `threads` at a time (0 = one per core).

    poses: (worlds, ticks, tools, 7). hold: broadcasts to (worlds, ticks, tools). Returns (worlds, ticks, tools, 6).
    Worlds created with threads=1 do not wait for each other. Raises ValueError for poses of another number of worlds.
    """
    poses, worlds = _poses("tick_all", poses, ("worlds", "ticks", "tools", 7)), list(worlds)
    if len(poses) != len(worlds):
        raise ValueError(f"tick_all: expected poses of {len(worlds)} worlds, found those of {len(poses)}")
    hold = _holds(hold, poses.shape[:-1])
    rows = poses.shape[0] * poses.shape[1]
    flat = None if hold is None else hold.reshape(rows, -1)
    return _turgor.tick_all(worlds, poses.reshape(rows, *poses.shape[2:]), flat, threads)


def run(scene: SceneGiven = None, out: Union[None, str, os.PathLike[str]] = None, *, text: Text = None,
        folder: Union[str, os.PathLike[str]] = ".", set: Overrides = None, threads: int = 0, force: bool = False,
        on_frame: Optional[Callable[[float], object]] = None, progress: Progress = None) -> dict[str, Any]:
    """Runs a scene like the program: writes pictures, meshes and a report into the folder `out` (default out/SCENE).

    Returns the report as a dict. force: replaces earlier results even if files were added or changed.
    on_frame(seconds): called after every frame; False, of Python or NumPy, ends the run and keeps its results, and other
    answers do not. An exception of it and Ctrl+C cancel the run and leave no folder. progress: as for World.
    """
    with tempfile.TemporaryDirectory(prefix="turgor-") as scratch:
        given = GivenScene(scratch)
        file, text = _file_and_text(given, scene, text, folder)
        overrides = given.overrides(set, None, None)
        if given.volumes or given.labels:
            raise _turgor.Error("run: expected volumes as files, which the report names, found one in memory; World accepts it")
        drawing.use_process()
        continues = None if on_frame is None else lambda seconds: not _is_false(on_frame(seconds))
        return json.loads(_turgor.run_to_json(file, text, overrides, given.folder_text, os.fspath(out or ""), force, threads, continues,
                                              _progress_callback(progress)))
