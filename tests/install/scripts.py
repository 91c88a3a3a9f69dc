"""Scripts on a pretended system: scripts.py. Programs that install, build or need root are replaced by fakes, which write what they were
called with to a log. Each test copies scripts/ to a tree of its own."""
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tarfile
import tempfile
import unittest

SOURCE = pathlib.Path(__file__).resolve().parents[2]
LOG = 'echo "$(basename "$0") $*" >>"$FAKE_LOG"\n'

# fake of Python: `-m venv FOLDER` makes an environment whose pip fails for names in $FAKE_MISSING; tests pass
PYTHON = LOG + r"""
[ "$1 $2" = "-m venv" ] || { echo "Ran 1 test" >&2; echo OK >&2; exit 0; }
[ -z "${FAKE_NO_VENV:-}" ] || exit 1
mkdir -p "$3/bin"
cp "$0" "$3/bin/python"
cat >"$3/bin/pip" <<'END'
#!/bin/sh
echo "pip $*" >>"$FAKE_LOG"
[ -z "${FAKE_KILLS_PIP:-}" ] || { kill -KILL "$PPID"; exit 1; }
for name in "$@"; do case " ${FAKE_MISSING:-} " in *" $name "*) exit 1 ;; esac; done
END
chmod +x "$3/bin/pip"
"""

# fake of unshare: runs the command of try-packages in the unpacked system, as far as it is in /work
UNSHARE = LOG + r"""
for word in "$@"; do case $word in --root=*) root=${word#--root=} ;; esac; command=$word; done
sh -euc "$(echo "$command" | sed "s|cd /work|cd $root/work|")"
"""


class Scripts(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.tree, self.fakes, self.log = self.folder / "tree", self.folder / "fakes", self.folder / "log"
        self.fakes.mkdir()
        shutil.copytree(SOURCE / "scripts", self.tree / "scripts")
        shutil.copytree(SOURCE / "packaging", self.tree / "packaging")
        for name in ("apt-get", "cmake", "ctest"):
            self.fake(name, LOG)
        self.fake("dpkg-query", "echo installed")
        self.fake("python3", PYTHON)

    def fake(self, name, text, folder=None):
        file = (folder or self.fakes) / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text("#!/bin/sh\n" + text)
        file.chmod(0o755)

    def run_script(self, name, *arguments, cwd=None, **environment):
        """Ended process of a script, and the lines that the fakes logged meanwhile."""
        self.log.write_text("")
        clean = {key: value for key, value in os.environ.items() if not key.startswith("TURGOR") and key != "CI"}
        clean |= {"PATH": f"{self.fakes}:{os.environ['PATH']}", "FAKE_LOG": str(self.log)} | environment
        ended = subprocess.run([self.tree / "scripts" / name, *map(str, arguments)], cwd=cwd or self.folder, env=clean, text=True,
                               stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=60)
        return ended, self.log.read_text().splitlines()

    def expect(self, ended, status, sentence=""):
        self.assertEqual(ended.returncode, status, ended.stdout)
        self.assertIn(sentence, ended.stdout)
        self.assertNotIn("Traceback", ended.stdout)

    def only(self, lines, start, *words):
        """The only logged line that begins with `start` and has these words."""
        found = [line for line in lines if line.startswith(start) and all(word in line for word in words)]
        self.assertEqual(len(found), 1, lines)
        return found[0]

    def make_package(self, name, program):
        """A tarball as scripts/release makes it, with a shell script as its program."""
        self.fake("turgor", program, self.folder / name / "bin")
        with tarfile.open(self.folder / f"{name}.tar.gz", "w:gz") as package:
            package.add(self.folder / name, name)

    # sudo passes no variables on; apt-get never prompts nonetheless.
    def test_apt_never_prompts_under_sudo(self):
        self.fake("id", "echo 1000")
        self.fake("sudo", 'exec env -i PATH="$PATH" FAKE_LOG="$FAKE_LOG" "$@"')
        self.fake("dpkg-query", "exit 1")
        self.fake("apt-get", 'echo "$DEBIAN_FRONTEND $*" >>"$FAKE_LOG"')
        ended, lines = self.run_script("install-deps")
        self.expect(ended, 0)
        self.only(lines, "noninteractive install")
        (self.folder / "some.deb").touch()
        _, lines = self.run_script("demo", "--package", "some.deb")
        self.only(lines, "noninteractive install", "/some.deb")

    # The commands of docs/python.md need no other packages.
    def test_full_list_has_python(self):
        self.fake("dpkg-query", "exit 1")
        self.fake("id", "echo 0")
        _, lines = self.run_script("install-deps")
        installed = self.only(lines, "apt-get install").split()
        self.assertLessEqual({"python3-venv", "python3-dev", "libgl1"}, set(installed))
        _, lines = self.run_script("install-deps", "ci")  # check_words needs Python before scripts/test installs the full list
        self.assertIn("python3-venv", self.only(lines, "apt-get install").split())

    # A relative path begins in the folder of the caller; a file that is missing costs nothing.
    def test_demo_takes_relative_paths(self):
        self.make_package("turgor-1-linux-x86_64", LOG)
        ended, lines = self.run_script("demo", "--package", "turgor-1-linux-x86_64.tar.gz")
        self.expect(ended, 0)
        self.assertIn("--out out/incision", self.only(lines, "turgor run"))
        (self.folder / "turgor-1-linux-x86_64.tar.gz").unlink()
        ended, lines = self.run_script("demo", "--package", "turgor-1-linux-x86_64.tar.gz")
        self.expect(ended, 2, "expected a file, found none")
        self.assertTrue((self.tree / "out/turgor-1-linux-x86_64/bin/turgor").is_file())
        self.assertEqual(lines, [])

    def fake_debian(self):
        (self.tree / "scenes").mkdir()
        self.fake("id", "echo 0")
        self.fake("mmdebstrap", LOG + 'for file in "$@"; do :; done; mkdir empty; mkdir empty/etc; tar -C empty -cf "$file" etc')
        self.fake("unshare", UNSHARE)

    # The files of build/packages are tried as the glob of docs/releasing.md names them; others stop before anything is installed.
    def test_packages_are_checked_before_the_first(self):
        self.fake_debian()
        self.make_package("turgor-1", "mkdir -p out; echo {} >out/report.json; echo 1 >out/report.html; echo 1 >out/a.png")
        for name in ("turgor-1.cdx.json", "turgor-1.zip"):
            (self.folder / name).touch()
        ended, lines = self.run_script("try-packages", "turgor-1.tar.gz", "turgor-1.zip")
        self.expect(ended, 2, "turgor-1.zip: expected a .deb, .tar.gz or .whl")
        self.assertEqual(lines, [])
        ended, lines = self.run_script("try-packages", "turgor-1.cdx.json", "turgor-1.tar.gz")
        self.expect(ended, 0, "turgor-1.tar.gz: installed")
        self.assertIn(" libgl1 ", self.only(lines, "apt-get install") + " ")

    # A package that draws no pictures fails.
    def test_packages_must_draw(self):
        self.fake_debian()
        run = "mkdir -p out; echo 1 >out/report.html; "
        self.make_package("turgor-1", run + "echo {} >out/report.json")
        self.assertNotEqual(self.run_script("try-packages", self.folder / "turgor-1.tar.gz")[0].returncode, 0)
        self.make_package("turgor-1", run + """echo '{"warnings": ["no pictures of surfaces: cannot draw"]}' >out/report.json; echo 1 >out/a.png""")
        self.assertNotEqual(self.run_script("try-packages", self.folder / "turgor-1.tar.gz")[0].returncode, 0)

    # Ctrl-C leaves no trees in the folder for temporary files.
    def test_interrupted_scripts_clean_up(self):
        self.fake_debian()
        self.make_package("turgor-1", "")
        temporary = self.folder / "temporary"
        temporary.mkdir()
        for command in (["init", "-q"], ["add", "-A"], ["-c", "user.name=a", "-c", "user.email=a@b", "commit", "-q", "-m", "a"]):
            subprocess.run(["git", "-C", self.tree, *command], check=True)
        for fake in ("cmake", "unshare"):
            self.fake(fake, LOG + 'ls "$TMPDIR"/* >>"$FAKE_LOG"; kill -INT "$PPID"')
        for script in (["reproducible"], ["try-packages", self.folder / "turgor-1.tar.gz"]):
            ended, lines = self.run_script(*script, TMPDIR=str(temporary))
            self.assertEqual(ended.returncode, 130, ended.stdout)
            self.assertGreater(len(lines), 1)
            self.assertEqual(list(temporary.iterdir()), [])

    # Options of an earlier build do not stay: a build states all that scripts set.
    def test_build_states_its_options(self):
        _, lines = self.run_script("build")
        configured = self.only(lines, "cmake --preset release", "-D").split()
        self.assertLessEqual({"-DTURGOR_CHECKED=OFF", "-DTURGOR_WERROR=OFF", "-DTURGOR_WINDOW=AUTO", "-DTURGOR_PYTHON=OFF"}, set(configured))
        _, lines = self.run_script("build", TURGOR_CHECKED="ON", CI="1")
        configured = self.only(lines, "cmake --preset release", "-D").split()
        self.assertLessEqual({"-DTURGOR_CHECKED=ON", "-DTURGOR_WERROR=ON"}, set(configured))
        for preset in ("checked", "debug", "asan", "tsan"):  # they check invariants, CMakePresets.json
            _, lines = self.run_script("build", preset)
            self.assertNotIn("TURGOR_CHECKED", self.only(lines, f"cmake --preset {preset}", "-D"))

    # Fuzzing keeps the checks of the build that the tests used, as in .ci/run.
    def test_fuzz_keeps_checks(self):
        for value in ("ON", "OFF"):
            cache = self.tree / "build/release/CMakeCache.txt"
            cache.parent.mkdir(parents=True, exist_ok=True)
            cache.write_text(f"TURGOR_CHECKED:BOOL={value}\n")
            _, lines = self.run_script("fuzz", "1", "release")
            self.assertIn(f"-DTURGOR_CHECKED={value}", self.only(lines, "cmake --preset release", "-D").split())

    # gpu-check has a folder of its own, since it leaves out the window.
    def test_gpu_check_leaves_release_alone(self):
        self.fake("nvidia-smi", "exit 0")
        _, lines = self.run_script("gpu-check")
        configured = [line for line in lines if line.startswith("cmake --preset")]
        self.assertTrue(configured)
        for line in configured:
            self.assertIn("-B build/gpu-check ", line)
        self.assertFalse([line for line in lines if "build/release" in line])

    def toy_python_tests(self):
        tests = self.tree / "tests/python"
        tests.mkdir(parents=True)
        (tests / "test_nothing.py").touch()

    # An environment whose installation was interrupted is made again.
    def test_interrupted_environment_is_made_again(self):
        self.toy_python_tests()
        ended, _ = self.run_script("python", FAKE_KILLS_PIP="1")
        self.assertNotEqual(ended.returncode, 0)
        ended, lines = self.run_script("python")
        self.expect(ended, 0)
        self.only(lines, "pip install", "nanobind numpy")
        _, lines = self.run_script("python")
        self.assertFalse([line for line in lines if line.startswith("pip") or " venv " in line])

    # An optional package that could not be installed is tried again, and only that.
    def test_failed_extras_are_tried_again(self):
        self.toy_python_tests()
        ended, _ = self.run_script("python", FAKE_MISSING="pandas")
        self.expect(ended, 0, "not tested with pandas")
        _, lines = self.run_script("python")
        self.assertIn("pandas", self.only(lines, "pip install"))

    # Ctrl-C leaves no option of the module in the folder of the release.
    def test_interrupted_python_resets_the_build(self):
        self.toy_python_tests()
        for number, status in ((signal.SIGINT, 130), (signal.SIGTERM, 130)):
            self.fake("cmake", LOG + f'[ "$1" != --build ] || kill -{int(number)} "$PPID"')
            ended, lines = self.run_script("python")
            self.assertEqual(ended.returncode, status)
            self.assertIn("-DTURGOR_PYTHON=OFF", lines[-1])

    # The last line of scripts/test names what was skipped; CI does not pass without Python.
    def test_skipped_python_is_named(self):
        self.fake("check_layers", "", self.tree / "scripts")
        ended, _ = self.run_script("test", FAKE_NO_VENV="1")
        self.expect(ended, 0)
        self.assertIn("the Python module and the slim wheel: NOT tested", ended.stdout.splitlines()[-1])
        ended, _ = self.run_script("test", FAKE_NO_VENV="1", CI="1")
        self.expect(ended, 1)

    # Without Git these scripts have no list of files; they say so, and check nothing silently.
    def test_checks_need_a_list_of_files(self):
        self.fake("clang-format", LOG)
        (self.fakes / "python3").unlink()
        (self.tree / "docs/site").mkdir(parents=True)
        (self.tree / "docs/site/index.md").touch()
        for script in (("format", "--check"), ("check_words",), ("check_pages",), ("release",)):
            self.expect(self.run_script(*script, GIT_CEILING_DIRECTORIES=str(self.folder))[0], 2, "expected a Git checkout")
        # nor in a tree that was unpacked in another checkout
        subprocess.run(["git", "init", "-q", self.folder], check=True)
        for script in (("format", "--check"), ("check_words",)):
            self.expect(self.run_script(*script)[0], 2, "expected a Git checkout")

    # The tarball has the libraries of a program, without those that drivers of the machine load too.
    @unittest.skipUnless(shutil.which("patchelf") and shutil.which("g++"), "needs patchelf and g++ (scripts/install-deps release)")
    def test_libraries_of_the_machine_stay_out(self):
        (self.fakes / "cmake").unlink()
        package = self.folder / "package"
        (package / "bin").mkdir(parents=True)
        (self.folder / "program.cpp").write_text("#include <stdexcept>\n#include <zlib.h>\n"
                                                 "int main() { try { throw std::runtime_error(zlibVersion()); } catch (std::exception&) {} }\n")
        subprocess.run(["g++", self.folder / "program.cpp", "-o", package / "bin/program", "-lz"], check=True)
        self.expect(self.run_script("copy-libraries", package)[0], 0)
        self.assertEqual([file.name for file in (package / "lib").iterdir()], ["libz.so.1"])
        needs = subprocess.run(["ldd", package / "bin/program"], capture_output=True, text=True, check=True).stdout
        self.assertIn("package/bin/../lib/libz.so.1", needs)
        (package / "lib/libstdc++.so.6").touch()
        self.expect(self.run_script("copy-libraries", package)[0], 1, "expected no libraries of the machine")

    # A package has the license of each of its components, and the licenses of Debian that these refer to.
    @unittest.skipUnless(pathlib.Path("/usr/share/doc/fonts-dejavu-core/copyright").exists() and shutil.which("dpkg"), "needs Debian")
    def test_each_component_has_a_license(self):
        for name in ("python3", "dpkg-query"):
            (self.fakes / name).unlink()
        package, licenses, bom = self.folder / "package", self.folder / "licenses", self.folder / "turgor.cdx.json"
        (package / "share/turgor").mkdir(parents=True)
        self.fake("turgor", "", package / "bin")
        self.fake("turgor-view", "", package / "bin")
        shutil.copy("/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf", package / "share/turgor")
        self.expect(self.run_script("sbom", "1.0", package, bom)[0], 0)
        self.expect(self.run_script("licenses", licenses, bom)[0], 0)
        content = json.loads(bom.read_text())
        components = {component["name"] for component in content["components"]}
        self.assertLessEqual({"fonts-dejavu-core", "libeigen3-dev", "libimgui-dev"}, components)
        for component in components:
            self.assertGreater((licenses / f"{component}.txt").stat().st_size, 300, component)
        self.assertTrue((licenses / "common-licenses/LGPL-2.1").is_file())  # Eigen's
        programs = {file["name"] for file in content["metadata"]["component"]["components"]}
        self.assertEqual(programs, {"bin/turgor", "bin/turgor-view"})
        self.expect(self.run_script("licenses", licenses, "no-such-package")[0], 1, "expected the license of no-such-package")


if __name__ == "__main__":
    sys.exit(unittest.main())
