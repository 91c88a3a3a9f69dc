from collections.abc import Mapping, Sequence
import os
from typing import Annotated, overload

import numpy
from numpy.typing import NDArray


class Error(ValueError):
    pass

instructions: str

def plain_text(arg: str, /) -> str: ...

class Body:
    """A body of a world in its present state. Arrays are copies."""

    def __init__(self, world: World, name: str) -> None: ...

    @property
    def name(self) -> str: ...

    @property
    def world(self) -> object:
        """the body's world"""

    @property
    def model(self) -> str:
        """sfem, lattice, rhombus, cloth or rigid"""

    @property
    def rest_points(self) -> NDArray[numpy.float32]:
        """(n, 3), rest positions of the surface vertices, patient frame [m]"""

    @property
    def points(self) -> NDArray[numpy.float32]:
        """(n, 3), present positions [m]"""

    @property
    def displacement(self) -> NDArray[numpy.float32]:
        """(n, 3) [m]"""

    @property
    def normals(self) -> NDArray[numpy.float32]:
        """(n, 3), unit, outward"""

    @property
    def pressure(self) -> NDArray[numpy.float32]:
        """(n,) contact pressure [Pa]; empty if unknown"""

    @property
    def stretch(self) -> NDArray[numpy.float32]:
        """(n,) area stretch of the skin: area / rest area - 1; empty if unknown"""

    @property
    def triangles(self) -> NDArray[numpy.int32]:
        """(m, 3), counter-clockwise seen from outside; a cut changes them"""

    @property
    def wall_begin(self) -> int:
        """
        index of the first wound wall in `triangles`; their number without wounds
        """

class LiveVectors:
    """
    Vectors with one array per component x, y and z. Writable views, which keep their world alive.
    """

    @property
    def x(self) -> NDArray[numpy.float32]: ...

    @property
    def y(self) -> NDArray[numpy.float32]: ...

    @property
    def z(self) -> NDArray[numpy.float32]: ...

class LiveBody:
    """
    Views of a body's memory. The next step starts from values written into them.
    """

    @property
    def rest_vertices(self) -> Annotated[NDArray[numpy.float64], dict(writable=False)]:
        """
        (n, 3) vertices of the model's mesh at rest [m], sfem and rhombus; read-only
        """

    @property
    def u(self) -> LiveVectors:
        """
        lattice: displacements [k, j, parity, i // 2] along the lattice's axes [m]; in rows with an odd number of nodes the last odd entry is unused
        """

    @property
    def v(self) -> LiveVectors:
        """lattice: velocities, in the same layout [m/s]"""

    @property
    def x(self) -> LiveVectors:
        """cloth: positions (n,) in the model's vertex order [m]"""

    @property
    def original(self) -> Annotated[NDArray[numpy.int32], dict(writable=False)]:
        """cloth: (n,) mesh vertex of each model vertex; read-only"""

def live_of(body: Body) -> LiveBody: ...

class State:
    """State of a world at one moment, for World.set_state."""

class World:
    """A scene during simulation."""

    @overload
    def __init__(self, scene: str | os.PathLike, text: str | None, overrides: Sequence[str], folder: str, threads: int, keeps_forces: bool, volumes: Mapping[str, tuple[Annotated[NDArray[numpy.int16], dict(shape=(None, None, None), order='C', device='cpu', writable=False)], Sequence[float], Sequence[float], Sequence[float]]], labels: Mapping[str, tuple[Annotated[NDArray[numpy.uint16], dict(shape=(None, None, None), order='C', device='cpu', writable=False)], Sequence[float], Sequence[float], Sequence[float]]], progress: object | None) -> None: ...

    @overload
    def __init__(self, other: World, threads: int) -> None: ...

    def step(self, frames: int = 1) -> None:
        """Simulates this number of frames."""

    @property
    def time(self) -> float:
        """simulated time [s]"""

    @property
    def frame(self) -> int:
        """finished frames"""

    @property
    def dt(self) -> float:
        """duration of a frame [s]"""

    @property
    def duration(self) -> float:
        """duration of the scene [s]"""

    @property
    def state_hash(self) -> str:
        """hash of all bodies and forces; equal hashes mean equal bits"""

    @property
    def bodies(self) -> list[str]:
        """names of the bodies"""

    @property
    def tools(self) -> list[str]:
        """names of the tools"""

    @property
    def notes(self) -> list[str]:
        """notes of loading: old names in the scene, guesses, limits"""

    def __repr__(self) -> str: ...

    def get_state(self) -> State:
        """Copies the state, for set_state."""

    def set_state(self, state: State) -> None:
        """Restores a state of this world or of a copy of it."""

    def save(self, path: str | os.PathLike) -> None:
        """
        Writes the state to a file, with cuts and stitches by the caller and with measures. On an error an earlier file is kept.
        """

    def load(self, path: str | os.PathLike) -> None:
        """
        Continues from a file of save(), with the bits of the world that was saved. Raises Error for a file of another program or scene, or a damaged one; the world is unchanged then.
        """

    def drive(self, tool: str, rows: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)]) -> None:
        """
        Moves a tool from its present position along rows of [t, x, y, z], linearly interpolated, with t [s] from now on. A fifth column grasps (1) or not (0), four more are the orientation (a quaternion w, x, y, z).
        """

    def begin_touch(self) -> None:
        """
        Starts ticks on a thread of their own: one thread calls touch_tick(), another one step(). Once for a world, before its first tick.
        """

    def end_touch(self) -> None:
        """
        Ends them; no call of touch_tick() may be in progress. Afterwards the world neither steps nor ticks, until set_state() returns it to a state from before begin_touch().
        """

    @property
    def is_ticked(self) -> bool:
        """
        true after the first tick() or begin_touch(); drive() is refused then, and step() but between begin_touch() and end_touch()
        """

    @property
    def tool_poses(self) -> NDArray[numpy.float64]:
        """
        (tools, 7) present poses from the tools' paths: x, y, z [m] and a quaternion w, x, y, z
        """

def tick_all(worlds: Sequence[World], poses: Annotated[NDArray[numpy.float64], dict(shape=(None, None, 7), order='C', device='cpu', writable=False)], hold: Annotated[NDArray[numpy.bool_], dict(shape=(None, None), order='C', device='cpu', writable=False)] | None, threads: int) -> NDArray[numpy.float64]: ...

def identify(scene: str | os.PathLike, text: str | None, overrides: Sequence[str], by_time: bool, rows: Sequence[tuple[str, Sequence[float], Sequence[float]]], start: Sequence[tuple[str, float]], threads: int) -> dict: ...

def serve_drawings() -> int: ...

def set_drawing_program(command: Sequence[str], refusal: str) -> None: ...

def run_to_json(scene: str | os.PathLike, text: str | None, overrides: Sequence[str], folder: str, out: str | os.PathLike, force: bool, threads: int, on_frame: object | None, progress: object | None) -> str: ...

class RecordingFile:
    """recording.h5 of a run."""

    @property
    def count(self) -> int: ...

    @property
    def frame_rate(self) -> float: ...

    @property
    def report(self) -> str: ...

    def snapshot(self, index: int) -> dict: ...

    def write_usda(self, arg: str | os.PathLike, /) -> None: ...

    def write_glb(self, arg: str | os.PathLike, /) -> None: ...

def open_recording(file: str | os.PathLike, overrides: Sequence[str], threads: int) -> RecordingFile: ...
