"""Recordings of runs: surfaces at every snapshot, and their export to USD and glTF.

    recording = turgor.Recording("out/palpation/recording.h5")
    for moment in recording:
        print(moment.time, abs(moment.bodies["liver"].displacement).max())
    turgor.export_usd(recording, "palpation.usda")
    turgor.export_gltf(recording, "palpation.glb")
"""
import json
import os
import pathlib
import tempfile
from types import SimpleNamespace

from . import _turgor
from ._turgor import Error
from .scenes import GivenScene


class Recording:
    """recording.h5 of a run. `recording[i]` is its snapshot i; negative numbers count from the end.

    set: keys that may have changed since the run, as for `turgor run --replay`: {"body.torso.ct": "elsewhere/ct.nrrd"}.
    threads: 0 = one per core.

    A snapshot has `time` [s], `frame`, `bodies` and `tools`: dicts by name. A body has the arrays `rest_points`, `points`,
    `displacement`, `normals`, `pressure`, `triangles` and the number `wall_begin` of turgor.Body; a tool has `points`,
    `triangles`, `position` and `force` [N]. Positions are in meters, in the patient frame.
    """

    def __init__(self, file, *, set=None, threads=0):
        given = GivenScene(None)
        overrides = given.overrides(set, None, None)
        if given.volumes or given.labels:
            raise Error("a recording: expected volumes as files, found one in memory")
        self._name = os.fspath(file)
        self._file = _turgor.open_recording(self._name, overrides, threads)

    def __repr__(self):
        return f"<turgor.Recording {self._name}: {len(self)} snapshots>"

    def __len__(self):
        return self._file.count

    def __getitem__(self, index):
        if not -len(self) <= index < len(self):
            raise IndexError(f"the recording has {len(self)} snapshots, found {index}")
        found = self._file.snapshot(index % len(self))
        named = {group: {name: SimpleNamespace(name=name, **arrays) for name, arrays in found[group].items()} for group in ("bodies", "tools")}
        return SimpleNamespace(time=found["time"], frame=found["frame"], **named)

    @property
    def frame_rate(self):
        """Frames of the simulation per second [1/s]."""
        return self._file.frame_rate

    @property
    def report(self):
        """report.json of the run, without pictures."""
        return json.loads(self._file.report)


def _recording(given):
    return given if isinstance(given, Recording) else Recording(given)


def _is_named(path, endings):
    """The file's path. Raises Error for another ending."""
    path = pathlib.Path(path)
    if path.suffix not in endings:
        raise Error(f"{path}: expected a name that ends in {' or '.join(endings)}")
    return path


def export_usd(recording, path):
    """Writes all snapshots of a recording (or of the file of that name) as USD: .usda, .usdc, .usd or .usdz.

    Text (.usda) needs nothing else. The binary forms need usd-core: pip install turgor[usd].
    """
    path = _is_named(path, (".usda", ".usdc", ".usd", ".usdz"))
    if path.suffix == ".usda":
        return _recording(recording)._file.write_usda(path)
    try:
        from pxr import Sdf, UsdUtils
    except ImportError:
        raise Error(f"{path}: expected usd-core, found none; pip install usd-core, or name a .usda file") from None
    recording = _recording(recording)
    with tempfile.TemporaryDirectory(prefix="turgor-", dir=path.parent) as folder:
        text, binary = pathlib.Path(folder) / "surfaces.usda", pathlib.Path(folder) / "surfaces.usdc"
        recording._file.write_usda(text)
        if not Sdf.Layer.FindOrOpen(str(text)).Export(str(binary)):
            raise Error(f"{path}: usd-core did not write it")
        if path.suffix == ".usdz" and not UsdUtils.CreateNewUsdzPackage(str(binary), str(pathlib.Path(folder) / "surfaces.usdz")):
            raise Error(f"{path}: usd-core did not write it")
        os.replace(binary.with_suffix(".usdz") if path.suffix == ".usdz" else binary, path)


def export_gltf(recording, path):
    """Writes all snapshots of a recording (or of the file of that name) as glTF 2.0 in one file, .glb."""
    path = _is_named(path, (".glb",))
    _recording(recording)._file.write_glb(path)
