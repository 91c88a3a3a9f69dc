"""Tissue parameters of a scene from a measured force, as `turgor identify` finds them."""
from __future__ import annotations

import dataclasses
import os
import tempfile
from typing import Mapping, Optional, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _turgor
from .scenes import GivenScene
from .world import Overrides, SceneGiven, Text, _file_and_text


@dataclasses.dataclass(frozen=True)
class FittedParameter:
    """A key of a scene after the fit."""

    value: float
    low: float  #: lower end of the 95 % confidence interval
    high: float  #: upper end; infinite where the force does not show the parameter
    sensitivity: float  #: relative change of the force (root mean square) per relative change of the value
    observable: bool  #: the interval is narrower than a factor of two to each side


@dataclasses.dataclass(frozen=True)
class Identified:
    """Fitted parameters by key, and how well the force of the model agrees with the measured one."""

    parameters: dict[str, FittedParameter]
    force_N: Union[NDArray[np.float64], dict[str, NDArray[np.float64]]]  #: of the model, as the measured force was given
    residuals: list[float]  #: of the tools, each relative to the force of its tool
    residual: float  #: root mean square of the difference, relative to that of the measured force
    start_residual: float  #: the same at the start values
    iterations: int
    runs: int  #: of the scene
    converged: bool
    notes: list[str]  #: parameters that the force does not show, or does not tell apart


Column = Union[ArrayLike, Mapping[str, ArrayLike]]


def _rows(at: Column, force: Column, tool: str) -> list[tuple[str, list[float], list[float]]]:
    """Name, abscissa and force of each tool."""
    if isinstance(at, Mapping) != isinstance(force, Mapping):
        raise TypeError("identify: expected both columns as arrays, or both by the name of the tool")
    if not (isinstance(at, Mapping) and isinstance(force, Mapping)):
        at, force = {tool: at}, {tool: force}
    elif tool or at.keys() != force.keys():
        raise ValueError(f"identify: expected the same tools in both columns, found {sorted(at)} and {sorted(force)}"
                         if not tool else "identify: columns by the name of the tool exclude tool=")
    rows = []
    for name in at:
        column, forces = np.asarray(at[name], dtype=np.float64), np.asarray(force[name], dtype=np.float64)
        if column.ndim != 1 or column.shape != forces.shape:
            raise ValueError(f"identify: expected (rows,) for both columns, found arrays of {column.shape} and {forces.shape}")
        rows.append((name, column.tolist(), forces.tolist()))
    return rows


def identify(scene: SceneGiven = None, *, fit: Mapping[str, float], force: Column, depth: Optional[Column] = None,
             time: Optional[Column] = None, tool: str = "", text: Text = None, folder: Union[str, os.PathLike[str]] = ".",
             set: Overrides = None, threads: int = 0) -> Identified:
    """Fits keys of a scene until the force of a tool is the measured one.

    fit: start values by key, as {"body.liver.young": 3e3}; an entry of an array is "body.pad.viscosity.pairs[0][1]".
    force: (rows,) norm of the force [N], at depths below the surface at rest [m] while the tool moves in, or at times [s].
    tool: its name; the first by default. Several tools are fitted together by columns with their names, as
    depth={"small": [...], "wide": [...]} and the same for force. scene, text, folder, set, threads: as for World.

    Raises Error for an unknown key or tool, a start value that is not above 0, fewer rows than parameters and two, rows
    that do not ascend, or a tool of the scene that goes less deep or ends earlier than the rows.
    """
    if (depth is None) == (time is None):
        raise TypeError("identify: expected either depth= or time=")
    rows = _rows(time if depth is None else depth, force, tool)  # type: ignore[arg-type]
    with tempfile.TemporaryDirectory(prefix="turgor-") as scratch:
        given = GivenScene(scratch)
        file, text = _file_and_text(given, scene, text, folder)
        if given.volumes or given.labels:
            raise _turgor.Error("identify: expected volumes as files, found one in memory")
        found = _turgor.identify(file, text, given.overrides(set, None, None), depth is None, rows,
                                 list(fit.items()), threads)
    found["parameters"] = {key: FittedParameter(**one) for key, one in found["parameters"].items()}
    if isinstance(force, Mapping):
        ends = np.cumsum([len(at) for _, at, _ in rows])[:-1]
        found["force_N"] = dict(zip((name for name, _, _ in rows), np.split(found["force_N"], ends)))
    return Identified(**found)
