"""Real-time simulation of deformable organs, skin and cloth, with forces in newtons.

    import turgor

    world = turgor.World("scenes/palpation.toml", set={"body.liver.young": 5e3})
    for moment in world.run(every=0.1):
        print(moment.time, abs(moment["liver"].displacement).max())
    force = world.forces("finger")["force_N"]          # (ticks, 3) [N]

    report = turgor.run("scenes/incision.toml", out="out/incision")     # the whole program
"""
from . import engine

__path__[:0] = engine.folders()

from ._turgor import Error, LiveBody, LiveVectors, State, __version__, instructions  # noqa: E402
from .body import Body
from .columns import Columns
from .identify import FittedParameter, Identified, identify
from .recording import Recording, export_gltf, export_usd
from .scenes import Mesh
from .volume import Volume
from .world import World, run, tick_all

__all__ = ["Body", "Columns", "Error", "FittedParameter", "Identified", "LiveBody", "LiveVectors", "Mesh", "Recording", "State", "Volume",
           "World", "export_gltf", "export_usd", "identify", "instructions", "run", "tick_all", "__version__"]
