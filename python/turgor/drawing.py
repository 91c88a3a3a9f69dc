"""Pictures of runs are drawn by another Python process, so that a driver of OpenGL that crashes does not end this one."""
import functools
import os
import sys

from . import _turgor

# The process loads the engine alone, without this package, NumPy and the user's settings.
PROGRAM = ("import importlib.util, sys; spec = importlib.util.spec_from_file_location('_turgor', sys.argv[1]); "
           "engine = importlib.util.module_from_spec(spec); spec.loader.exec_module(engine); sys.exit(engine.serve_drawings())")


def command(executable, engine):
    """The command of the process, or an empty list if this program is not a Python interpreter but has one inside."""
    if not os.path.basename(executable or "").lower().startswith("python"):
        return []
    return [executable, "-I", "-S", "-c", PROGRAM, engine]


@functools.cache
def use_process():
    """From now on runs draw in another process; in a program with an interpreter inside they draw nothing and say why."""
    words = command(sys.executable, _turgor.__file__)
    _turgor.set_drawing_program(words, "" if words else f"expected sys.executable to be python, found {sys.executable!r}")
