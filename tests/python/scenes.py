"""Small scenes of every model, and the program for comparison: TURGOR, set by scripts/python."""
import json
import os
import pathlib
import subprocess
import tempfile
import tomllib

PROGRAM = os.environ["TURGOR"]


def scene(duration, text, every=0.1):
    """A scene with `text` and a few small pictures. `text` may start with further keys of [world]."""
    return (f"[world]\nduration = {duration}\nframe_rate = 50\n{text}"
            f"[output]\nvideo = false\nsnapshots = {{ every = {every}, size = [160, 120] }}\n")


# Bodies, and the cut of the last one.
PAD_BODY = """[body.pad]
model = "sfem"
block = { size = [0.06, 0.06, 0.03], count = [6, 6, 3] }
fixed = "bottom"
young = 5e3
poisson = 0.4
cache = false
"""
SHEET_BODY = """[body.sheet]
model = "cloth"
sheet = { corner = [0, 0, 0], side = [0.2, 0, 0], up = [0, 0.2, 0], columns = 12, rows = 12 }
[body.sheet.hold.edge]
box = [[-1, 0.19, -1], [1, 1, 1]]
"""
CUT_TORSO = """[body.torso]
model = "lattice"
ct = { phantom = "torso", size = [64, 48, 40], spacing_mm = [6.5, 6.5, 6.5] }
block = 2
fixed = ["bone", "ends"]
[incision.midline]
body = "torso"
from_fraction = [0.5, 0.0, 0.7]
to_fraction = [0.5, 0.0, 0.3]
depth = 0.02
start = 0.02
duration = 0.05
"""
FORCEPS = scene(0.4, """
[body.liver]
model = "rhombus"
surface = { phantom = "liver", detail = 0.3 }
[tool.forceps]
body = "liver"
shape = { forceps = "phantom" }
grasp = { at_fraction = [0.3, 0.5, 1], depth = 0.004, pull = 0.006, start = 0, duration = 0.1 }
""", every=0.2)
PAD = scene(0.2, "\n" + PAD_BODY + """[tool.finger]
body = "pad"
shape = { sphere = 0.006 }
path = [[0, 0.03, 0.03, 0.05]]
""")
CLOTH = scene(0.2, "gravity = [0, 0, -9.81]\n" + SHEET_BODY)
TORSO = scene(0.2, "\n" + CUT_TORSO)
# A pad that is pressed, a sheet, and a torso whose triangles change when it is cut; surfaces are written as glTF.
SURFACES = """[world]
duration = 0.2
frame_rate = 50
gravity = [0, 0, -9.81]
""" + SHEET_BODY + PAD_BODY + """[tool.finger]
body = "pad"
shape = { sphere = 0.006 }
path = [[0, 0.03, 0.03, 0.05], [0.1, 0.03, 0.03, 0.033], [0.2, 0.03, 0.03, 0.05]]
""" + CUT_TORSO + """[output]
video = false
obj = false
meshes = false
gltf = true
snapshots = { every = 0.04, size = [64, 64] }
"""


def hash_of_program(text, *arguments):
    with tempfile.TemporaryDirectory() as folder:
        scene = pathlib.Path(folder) / "s.toml"
        scene.write_text(text)
        subprocess.run([PROGRAM, "run", scene, "-q", "-o", f"{folder}/out", *arguments], check=True)
        return json.loads((pathlib.Path(folder) / "out/report.json").read_text())["state_hash"]


def state_of_program(file, seconds, overrides, folder):
    """State hash of the program after the first seconds of a scene, with as few pictures as possible."""
    small = [f"world.duration={seconds!r}", "output.snapshots={ every = 60, size = [64, 64] }", "output.sections=false",
             "output.recording=false", "output.meshes=false", "output.obj=false"]
    written = tomllib.loads(pathlib.Path(file).read_text()).get("output", {})
    small += [f"output.{key}=" for key in ("deformed_ct", "displacement", "jacobian") if key in written]
    arguments = [text for one in (*overrides, *small) for text in ("--set", one)]
    subprocess.run([PROGRAM, "run", file, "-q", "-o", f"{folder}/out", *arguments], check=True)
    return json.loads((pathlib.Path(folder) / "out/report.json").read_text())["state_hash"]
