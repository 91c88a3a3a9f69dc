"""Packs built modules as a wheel that needs only NumPy: pack_wheel.py OUT BUILD [BUILD ...], or pack_wheel.py --full OUT BUILD

BUILD/slim/turgor contains a module, pyproject.toml the metadata. Several modules are engines for the processor levels in their
folder names, such as build/x86-64-v3, and v2 in build/package; python/turgor/engine.py selects one. Required libraries that are not
part of every Linux are included (auditwheel). Their licenses from Debian are included too, and those of code that is compiled in. The
full wheel has the module of BUILD/python/turgor, which draws and reads every format, and the programs with the window (turgor/bin).
"""
import importlib.metadata
import os
import pathlib
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import tomllib

import nanobind

if sys.version_info >= (3, 12):  # nanobind uses the stable ABI from 3.12 on: one module for all versions
    PYTHON, SUFFIX = "cp312-abi3", ".abi3.so"
else:
    PYTHON, SUFFIX = "cp3{0}-cp3{0}".format(sys.version_info.minor), sysconfig.get_config_var("EXT_SUFFIX")
SOURCE = pathlib.Path(__file__).parents[1]
LIBRARIES = ("libfmt9", "libmetis5", "libpng16-16", "libpugixml1v5", "libtbb12", "libtomlplusplus3")  # included in the slim wheel
PROGRAMS = ("turgor", "turgor-view", "turgor-bench", "turgor-read")  # of the full wheel
SHARED = ("fonts/truetype/dejavu/DejaVuSans.ttf", "javascript/three/three.min.js", "javascript/three/examples/js/controls/OrbitControls.js")
COMPILED_IN = ("libeigen3-dev", "nlohmann-json3-dev", "libboost-dev")  # all of packaging/compiled-in.txt in the full wheel
DATA = ("fonts-dejavu-core", "libjs-three")  # packages of SHARED
DRIVERS = ("libEGL.so.1", "libGL.so.1", "libGLX.so.0", "libGLdispatch.so.0", "libOpenGL.so.0")  # of the machine's display


def version(pyproject):
    """The version in CMakeLists.txt, found by the expression that scikit-build-core uses."""
    source = pyproject["tool"]["scikit-build"]["metadata"]["version"]
    return re.search(source["regex"], (SOURCE / source["input"]).read_text())["value"]


def metadata(project):
    lines = ["Metadata-Version: 2.1", f"Name: {project['name']}", f"Version: {project['version']}", f"Summary: {project['description']}",
             f"License: {project['license']['text']}", f"Requires-Python: {project['requires-python']}"]
    lines += [f"Requires-Dist: {need}" for need in project["dependencies"]]
    for extra, needs in project["optional-dependencies"].items():
        lines += [f"Provides-Extra: {extra}"] + [f'Requires-Dist: {need}; extra == "{extra}"' for need in needs]
    readme = (SOURCE / "docs/python.md").read_text(encoding="utf-8")
    return "\n".join(lines) + "\nDescription-Content-Type: text/markdown\n\n" + readme


def copy_modules(builds, package):
    """Copies the modules and returns the folder of the first, which every processor can load."""
    levels = ["v2" if build.name == "package" else build.name.rpartition("-")[2] for build in builds]
    folders = [package / "engines" / level if len(builds) > 1 else package for level in levels]
    for build, folder in zip(builds, folders):
        folder.mkdir(parents=True, exist_ok=True)
        shutil.copy(build / f"slim/turgor/_turgor{SUFFIX}", folder)
    return folders[0]


def copy_programs(build, package):
    """Copies the full module, the programs, scenes and the files that pictures and reports need; returns the module's folder."""
    shutil.copy(build / f"python/turgor/_turgor{SUFFIX}", package)
    (package / "bin").mkdir()
    for program in PROGRAMS:
        shutil.copy(build / program, package / "bin")
    shutil.copy(build / "turgor-read", package)  # the module's
    (package / "share/turgor").mkdir(parents=True)
    for file in SHARED:
        shutil.copy(pathlib.Path("/usr/share") / file, package / "share/turgor")
    shutil.copytree(SOURCE / "scenes", package / "share/turgor/scenes", ignore=shutil.ignore_patterns("pictures"))
    for file in [package / f"_turgor{SUFFIX}", package / "turgor-read", *(package / "bin").iterdir()]:
        subprocess.run(["strip", "--strip-unneeded", file], check=True)
    return package


def packages_of(files):
    """Debian packages whose libraries these files load, without those of the machine (DRIVERS)."""
    found = set()
    for file in files:
        for line in subprocess.run(["ldd", file], check=True, capture_output=True, text=True).stdout.splitlines():
            library = re.search(r"=> (/\S+)", line)
            if not library or os.path.basename(library[1]) in DRIVERS:
                continue
            name = os.path.basename(os.path.realpath(library[1]))
            owner = subprocess.run(["dpkg", "-S", f"*-linux-gnu/{name}"], capture_output=True, text=True).stdout.split(":")[0]
            if not owner:
                sys.exit(f"{file}: expected {library[1]} of a Debian package, found none of this name")
            found.add(owner)
    return sorted(found)


def copy_licenses(packages, folder):
    """Copies the licenses of Turgor, of these Debian packages, and of nanobind with its hash table."""
    shutil.copy(SOURCE / "LICENSE", folder)
    subprocess.run([SOURCE / "scripts/licenses", folder, *packages], check=True)
    license = next(file for file in importlib.metadata.files("nanobind") if file.name == "LICENSE")
    shutil.copyfile(license.locate(), folder / "nanobind.txt")
    header = pathlib.Path(nanobind.source_dir()).parent / "ext/robin_map/include/tsl/robin_map.h"
    (folder / "robin-map.txt").write_text(re.match(r"/\*\*(.*?)\*/", header.read_text(), re.S)[1])


def fill(folder, builds, project, is_full):
    """Creates the content of the wheel in `folder`."""
    package = folder / "turgor"
    shutil.copytree(SOURCE / "python/turgor", package, ignore=shutil.ignore_patterns("__pycache__"))
    first = copy_programs(builds[0], package) if is_full else copy_modules(builds, package)
    subprocess.run([sys.executable, "-m", "nanobind.stubgen", "-q", "-i", first, "-m", "_turgor", "-o", package / "_turgor.pyi"], check=True)
    info = folder / f"turgor-{project['version']}.dist-info"
    (info / "licenses").mkdir(parents=True)
    licensed = LIBRARIES + COMPILED_IN
    if is_full:
        licensed = (*packages_of([package / f"_turgor{SUFFIX}", *(package / "bin").iterdir()]), SOURCE / "packaging/compiled-in.txt", *DATA)
        (info / "entry_points.txt").write_text("[console_scripts]\nturgor = turgor.program:main\n")
    copy_licenses(licensed, info / "licenses")
    (info / "METADATA").write_text(metadata(project), encoding="utf-8")
    platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
    build = "Build: 1full\n" if is_full else ""  # pip prefers it to the slim wheel of the same version
    (info / "WHEEL").write_text(f"Wheel-Version: 1.0\nGenerator: turgor\nRoot-Is-Purelib: false\nTag: {PYTHON}-{platform}\n{build}")
    for file in folder.rglob("*"):  # modes do not depend on the umask of the source tree
        file.chmod(0o755 if file.is_dir() or os.access(file, os.X_OK) else 0o644)


def run(*words):
    done = subprocess.run([sys.executable, "-m", *map(str, words)], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{words[0]}: {done.stdout}{done.stderr}")


def main(out, builds, is_full):
    pyproject = tomllib.loads((SOURCE / "pyproject.toml").read_text())
    project = pyproject["project"] | {"version": version(pyproject)}
    out.mkdir(parents=True, exist_ok=True)
    for old in out.glob("turgor-*.whl"):
        if ("-1full-" in old.name) == is_full:
            old.unlink()
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(scratch)
        fill(folder / "wheel", builds, project, is_full)
        run("wheel", "pack", folder / "wheel", "-d", folder)
        excluded = [f"--exclude={library}" for library in DRIVERS] if is_full else []
        run("auditwheel", "repair", *excluded, next(folder.glob("*.whl")), "-w", out)
    for wheel in out.glob("*.whl"):
        print(f"{wheel} {wheel.stat().st_size / 1e6:.1f} MB")


if __name__ == "__main__":
    arguments = [argument for argument in sys.argv[1:] if argument != "--full"]
    main(pathlib.Path(arguments[0]), [pathlib.Path(build) for build in arguments[1:]], "--full" in sys.argv)
