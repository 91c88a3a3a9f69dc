"""Packs built modules as a wheel that needs only NumPy: pack_wheel.py OUT BUILD [BUILD ...]

BUILD/slim/turgor contains a module, pyproject.toml the metadata. Several modules are engines for the processor levels in their
folder names, such as build/x86-64-v3; python/turgor/engine.py selects one. Required libraries that are not part of every Linux
are included (auditwheel), with their licenses from Debian.
"""
import pathlib
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import tomllib

if sys.version_info >= (3, 12):  # nanobind uses the stable ABI from 3.12 on: one module for all versions
    PYTHON, SUFFIX = "cp312-abi3", ".abi3.so"
else:
    PYTHON, SUFFIX = "cp3{0}-cp3{0}".format(sys.version_info.minor), sysconfig.get_config_var("EXT_SUFFIX")
SOURCE = pathlib.Path(__file__).parents[1]
LIBRARIES = ("libfmt9", "libmetis5", "libpugixml1v5", "libtbb12", "libtomlplusplus3")  # included in the wheel


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
    folders = [package / "engines" / build.name.rpartition("-")[2] if len(builds) > 1 else package for build in builds]
    for build, folder in zip(builds, folders):
        folder.mkdir(parents=True, exist_ok=True)
        shutil.copy(build / f"slim/turgor/_turgor{SUFFIX}", folder)
    return folders[0]


def fill(folder, builds, project):
    """Creates the content of the wheel in `folder`."""
    package = folder / "turgor"
    shutil.copytree(SOURCE / "python/turgor", package, ignore=shutil.ignore_patterns("__pycache__"))
    first = copy_modules(builds, package)
    subprocess.run([sys.executable, "-m", "nanobind.stubgen", "-q", "-i", first, "-m", "_turgor", "-o", package / "_turgor.pyi"], check=True)
    info = folder / f"turgor-{project['version']}.dist-info"
    (info / "licenses").mkdir(parents=True)
    shutil.copy(SOURCE / "LICENSE", info / "licenses")
    for library in LIBRARIES:
        shutil.copy(f"/usr/share/doc/{library}/copyright", info / "licenses" / f"{library}.txt")
    (info / "METADATA").write_text(metadata(project), encoding="utf-8")
    platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
    (info / "WHEEL").write_text(f"Wheel-Version: 1.0\nGenerator: turgor\nRoot-Is-Purelib: false\nTag: {PYTHON}-{platform}\n")


def run(*words):
    done = subprocess.run([sys.executable, "-m", *map(str, words)], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{words[0]}: {done.stdout}{done.stderr}")


def main(out, builds):
    pyproject = tomllib.loads((SOURCE / "pyproject.toml").read_text())
    project = pyproject["project"] | {"version": version(pyproject)}
    out.mkdir(parents=True, exist_ok=True)
    for old in out.glob("turgor-*.whl"):
        old.unlink()
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(scratch)
        fill(folder / "wheel", builds, project)
        run("wheel", "pack", folder / "wheel", "-d", folder)
        run("auditwheel", "repair", next(folder.glob("*.whl")), "-w", out)
    for wheel in out.glob("*.whl"):
        print(f"{wheel} {wheel.stat().st_size / 1e6:.1f} MB")


main(pathlib.Path(sys.argv[1]), [pathlib.Path(build) for build in sys.argv[2:]])
