"""Selection of the engine. A wheel has three, engines/v2, v3 and v4, for levels of x86-64. The highest level that the processor
supports is used, or the one in TURGOR_ENGINE. `pip install .` builds one engine, for the processor of the build.
"""
import os
import pathlib

# Flags of /proc/cpuinfo [x86-64 psABI, 3.1.1].
V2 = {"cx16", "lahf_lm", "pni", "popcnt", "sse4_1", "sse4_2", "ssse3"}
V3 = V2 | {"abm", "avx", "avx2", "bmi1", "bmi2", "f16c", "fma", "movbe", "xsave"}
V4 = V3 | {"avx512bw", "avx512cd", "avx512dq", "avx512f", "avx512vl"}
NEEDS = {"v2": V2, "v3": V3, "v4": V4}


def processor_flags(cpuinfo="/proc/cpuinfo"):
    """Processor flags from the kernel; if they are unknown, those of processors since 2009."""
    try:
        text = pathlib.Path(cpuinfo).read_text()
    except OSError:
        return V2
    line = next((line for line in text.splitlines() if line.startswith("flags")), "")
    return set(line.partition(":")[2].split())


def choose(forced, flags):
    """The `forced` engine, or the highest for a processor with these `flags`. Raises ImportError if it cannot run."""
    if forced and forced not in NEEDS:
        raise ImportError(f"TURGOR_ENGINE: expected one of {', '.join(NEEDS)}, found {forced}")
    level = forced or next((level for level in reversed(NEEDS) if NEEDS[level] <= flags), "v2")
    missing = sorted(NEEDS[level] - flags)
    if missing:
        raise ImportError(f"turgor: expected a processor of x86-64-{level}, found one without {', '.join(missing)}")
    return level


def folders():
    """Search path for the module _turgor: the folder of the selected engine, if there are several.

    Fonts and scripts of a full wheel are made known to the engine.
    """
    shared = pathlib.Path(__file__).parent / "share/turgor"
    if shared.is_dir():
        os.environ.setdefault("TURGOR_SHARE", str(shared))
    forced, engines = os.environ.get("TURGOR_ENGINE"), pathlib.Path(__file__).parent / "engines"
    if engines.is_dir():
        return [str(engines / choose(forced, processor_flags()))]
    if forced:
        raise ImportError(f"TURGOR_ENGINE: expected nothing, since this turgor has only one engine, found {forced}")
    return []
