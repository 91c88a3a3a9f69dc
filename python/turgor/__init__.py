"""Tissue you can touch: deformable organs, skin and cloth, with forces in newtons.

    import turgor

    world = turgor.World("scenes/palpation.toml", set={"body.liver.young": 5e3})
    for moment in world.run(every=0.1):
        print(moment.time, abs(moment["liver"].displacement).max())
    force = world.forces("finger")["force_N"]          # (ticks, 3) [N]

    report = turgor.run("scenes/incision.toml", out="out/incision")     # what the program does
"""
import json
import numbers
import os

from . import _turgor
from ._turgor import Body, Error, __version__

__all__ = ["Body", "Error", "World", "run", "__version__"]


def _toml(value):
    """A Python value as scenes write it."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, numbers.Integral):
        return str(int(value))
    if isinstance(value, numbers.Real):
        return repr(float(value))
    if isinstance(value, (str, os.PathLike)):
        return json.dumps(os.fspath(value), ensure_ascii=False)
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{json.dumps(str(k))} = {_toml(v)}" for k, v in value.items()) + " }"
    return "[" + ", ".join(_toml(v) for v in value) + "]"


def _overrides(set):
    """None takes a key out of the scene."""
    return [f"{key}=" + ("" if value is None else _toml(value)) for key, value in (set or {}).items()]


class World(_turgor.World):
    """A scene that is being simulated.

    scene: a TOML file; or with text=..., the scene itself, whose files are sought from `folder`.
    set: keys of the scene to override, as {"body.liver.young": 5e3}; None removes a key.
    threads: 0 = one per core; results do not depend on it. Raises Error with a sentence for what the program refuses.
    """

    def __init__(self, scene=None, *, text=None, folder=".", set=None, threads=0):
        if (scene is None) == (text is None):
            raise TypeError("World: expected either a scene's file or text=")
        file = os.fspath(scene) if text is None else os.path.join(os.fspath(folder), "scene.toml")
        super().__init__(file, text, _overrides(set), threads)

    def run(self, seconds=None, every=0.1):
        """Simulates on (default: to the end of the scene) and yields the world every so many seconds."""
        end = self.frame + round((self.duration - self.time if seconds is None else seconds) / self.dt)
        stride = max(1, round(every / self.dt))
        while self.frame < end:
            self.step(min(stride, end - self.frame))
            yield self


def run(scene, out=None, set=None, threads=0, force=False):
    """Runs a scene as the program does: pictures, meshes and report in the folder `out` (default out/SCENE).

    Returns the report as a dict. force: replace earlier results also where files were added or changed.
    """
    return json.loads(_turgor.run_to_json(os.fspath(scene), _overrides(set), os.fspath(out or ""), force, threads))
