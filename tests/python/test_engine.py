"""Selection of a wheel's engine: chosen, forced or rejected. scripts/wheel tests the engines themselves."""
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import turgor
from turgor.engine import NEEDS, V2, V3, V4, choose, processor_flags

CORE_2 = {"cx16", "lahf_lm", "pni", "sse4_1", "ssse3"}  # Penryn, of 2008
NEHALEM = CORE_2 | {"popcnt", "sse4_2"}  # 2008
SANDY_BRIDGE = NEHALEM | {"avx", "xsave"}  # 2011
HASWELL = SANDY_BRIDGE | {"abm", "avx2", "bmi1", "bmi2", "f16c", "fma", "movbe"}  # 2013, and Zen
KNIGHTS_LANDING = HASWELL | {"avx512cd", "avx512er", "avx512f", "avx512pf"}  # AVX-512, but neither all nor for short vectors
SKYLAKE_SERVER = HASWELL | {"avx512bw", "avx512cd", "avx512dq", "avx512f", "avx512vl"}  # 2017, and Zen 4


def import_turgor(folder, forced=None):
    environment = {key: value for key, value in os.environ.items() if key != "TURGOR_ENGINE"}
    environment |= {"PYTHONPATH": str(folder)} | ({"TURGOR_ENGINE": forced} if forced else {})
    command = [sys.executable, "-c", "import turgor; print(turgor._turgor.__file__, turgor.instructions)"]
    return subprocess.run(command, env=environment, capture_output=True, text=True)


class Choice(unittest.TestCase):
    # The highest engine that the processor supports is chosen.
    def test_chooses_highest_supported_level(self):
        for flags, level in ((NEHALEM, "v2"), (SANDY_BRIDGE, "v2"), (HASWELL, "v3"), (KNIGHTS_LANDING, "v3"), (SKYLAKE_SERVER, "v4")):
            self.assertEqual(choose(None, flags), level)

    # A lower engine can be forced; a higher one is rejected with the missing flags.
    def test_forced_level_must_be_supported(self):
        self.assertEqual([choose(level, SKYLAKE_SERVER) for level in NEEDS], ["v2", "v3", "v4"])
        with self.assertRaisesRegex(ImportError, "expected a processor of x86-64-v4, found one without avx512bw, avx512cd"):
            choose("v4", HASWELL)
        with self.assertRaisesRegex(ImportError, "expected a processor of x86-64-v3, found one without abm, avx2"):
            choose("v3", SANDY_BRIDGE)

    # Processors older than x86-64-v2 and unknown engine names are rejected.
    def test_rejects_old_processors_and_unknown_names(self):
        with self.assertRaisesRegex(ImportError, "expected a processor of x86-64-v2, found one without popcnt, sse4_2$"):
            choose(None, CORE_2)
        with self.assertRaisesRegex(ImportError, "TURGOR_ENGINE: expected one of v2, v3, v4, found avx2"):
            choose("avx2", HASWELL)

    # Flags are read from the kernel; without them the lowest engine is chosen.
    def test_processor_flags_come_from_kernel(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "cpuinfo"
            file.write_text("processor\t: 0\nflags\t\t: fpu sse4_2 popcnt\nbugs\t\t: none\n\nprocessor\t: 1\nflags\t\t: fpu\n")
            self.assertEqual(processor_flags(file), {"fpu", "sse4_2", "popcnt"})
        self.assertEqual(choose(None, processor_flags("/proc/no-such")), "v2")

    # The flags of each level are those that gcc uses for the architecture of that name.
    @unittest.skipUnless(os.uname().machine == "x86_64" and shutil.which("gcc"), "another processor, or no gcc")
    def test_levels_match_gcc(self):
        names = {"pni": "SSE3", "abm": "LZCNT", "bmi1": "BMI", "cx16": "GCC_HAVE_SYNC_COMPARE_AND_SWAP_16", "lahf_lm": "LAHF_SAHF"}
        for level, needs in NEEDS.items():
            done = subprocess.run(["gcc", f"-march=x86-64-{level}", "-dM", "-E", "-x", "c", "/dev/null"], capture_output=True, text=True)
            defined = {line.split()[1].strip("_") for line in done.stdout.splitlines()}
            used = {flag for flag in V4 if names.get(flag, flag.upper()) in defined}
            self.assertEqual(used, needs, level)


class Package(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="turgor-engines-"))
        self.addCleanup(shutil.rmtree, self.folder)
        self.package = self.folder / "turgor"
        shutil.copytree(pathlib.Path(turgor.__file__).parent, self.package, ignore=shutil.ignore_patterns("*.so", "__pycache__"))

    def with_engines(self):
        """Three folders as in the wheel; each one contains the one engine that was built."""
        for level in NEEDS:
            (self.package / "engines" / level).mkdir(parents=True)
            module = pathlib.Path(turgor._turgor.__file__)
            (self.package / "engines" / level / module.name).symlink_to(module)

    # The chosen or forced engine is the one that is loaded.
    def test_loads_chosen_or_forced_engine(self):
        self.with_engines()
        mine = choose(None, processor_flags())
        for forced, level in ((None, mine), ("v2", "v2")):
            done = import_turgor(self.folder, forced)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn(f"/engines/{level}/_turgor.", done.stdout)
            self.assertIn(turgor.instructions, done.stdout)

    # Forcing an engine is rejected if the package has only one.
    def test_single_engine_cannot_be_forced(self):
        module = pathlib.Path(turgor._turgor.__file__)
        (self.package / module.name).symlink_to(module)
        done = import_turgor(self.folder, "v2")
        self.assertIn("TURGOR_ENGINE: expected nothing, since this turgor has only one engine, found v2", done.stderr)


if __name__ == "__main__":
    unittest.main()
