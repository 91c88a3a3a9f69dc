"""Which of a wheel's engines is chosen, forced and refused; scripts/wheel tries the engines themselves."""
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
    def test_the_highest_that_a_processor_can_run_is_chosen(self):
        for flags, level in ((NEHALEM, "v2"), (SANDY_BRIDGE, "v2"), (HASWELL, "v3"), (KNIGHTS_LANDING, "v3"), (SKYLAKE_SERVER, "v4")):
            self.assertEqual(choose(None, flags), level)

    def test_a_lower_one_can_be_forced_and_a_higher_one_is_refused_with_what_it_lacks(self):
        self.assertEqual([choose(level, SKYLAKE_SERVER) for level in NEEDS], ["v2", "v3", "v4"])
        with self.assertRaisesRegex(ImportError, "expected a processor of x86-64-v4, found one without avx512bw, avx512cd"):
            choose("v4", HASWELL)
        with self.assertRaisesRegex(ImportError, "expected a processor of x86-64-v3, found one without abm, avx2"):
            choose("v3", SANDY_BRIDGE)

    def test_no_engine_runs_on_what_is_older_and_none_has_another_name(self):
        with self.assertRaisesRegex(ImportError, "expected a processor of x86-64-v2, found one without popcnt, sse4_2$"):
            choose(None, CORE_2)
        with self.assertRaisesRegex(ImportError, "TURGOR_ENGINE: expected one of v2, v3, v4, found avx2"):
            choose("avx2", HASWELL)

    def test_flags_are_those_of_the_kernel_and_modest_where_it_tells_none(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "cpuinfo"
            file.write_text("processor\t: 0\nflags\t\t: fpu sse4_2 popcnt\nbugs\t\t: none\n\nprocessor\t: 1\nflags\t\t: fpu\n")
            self.assertEqual(processor_flags(file), {"fpu", "sse4_2", "popcnt"})
        self.assertEqual(choose(None, processor_flags("/proc/no-such")), "v2")

    @unittest.skipUnless(os.uname().machine == "x86_64" and shutil.which("gcc"), "another processor, or no gcc")
    def test_an_engine_asks_for_what_gcc_uses_under_that_name(self):
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
        """Three folders, as in the wheel; what lies in them is the one engine that was built."""
        for level in NEEDS:
            (self.package / "engines" / level).mkdir(parents=True)
            module = pathlib.Path(turgor._turgor.__file__)
            (self.package / "engines" / level / module.name).symlink_to(module)

    def test_the_engine_that_is_chosen_or_forced_is_the_one_that_is_loaded(self):
        self.with_engines()
        mine = choose(None, processor_flags())
        for forced, level in ((None, mine), ("v2", "v2")):
            done = import_turgor(self.folder, forced)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn(f"/engines/{level}/_turgor.", done.stdout)
            self.assertIn(turgor.instructions, done.stdout)

    def test_an_engine_that_is_forced_where_there_is_one_alone_is_refused(self):
        module = pathlib.Path(turgor._turgor.__file__)
        (self.package / module.name).symlink_to(module)
        done = import_turgor(self.folder, "v2")
        self.assertIn("TURGOR_ENGINE: expected nothing, since this turgor has one engine alone, found v2", done.stderr)


if __name__ == "__main__":
    unittest.main()
