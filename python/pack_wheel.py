"""Packs a built module as a wheel that needs nothing but NumPy: pack_wheel.py BUILD OUT

BUILD/slim/turgor holds the module, pyproject.toml says the rest. The libraries that it needs and that not every Linux has
go with it (auditwheel), and with them what Debian says of their licences.
"""
import pathlib
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import tomllib

SOURCE = pathlib.Path(__file__).parents[1]
LIBRARIES = ("libfmt9", "libmetis5", "libpugixml1v5", "libtbb12", "libtomlplusplus3")  # that are packed with it


def metadata(project):
    lines = ["Metadata-Version: 2.1", f"Name: {project['name']}", f"Version: {project['version']}", f"Summary: {project['description']}",
             f"License: {project['license']['text']}", f"Requires-Python: {project['requires-python']}"]
    lines += [f"Requires-Dist: {need}" for need in project["dependencies"]]
    for extra, needs in project["optional-dependencies"].items():
        lines += [f"Provides-Extra: {extra}"] + [f'Requires-Dist: {need}; extra == "{extra}"' for need in needs]
    readme = (SOURCE / "docs/python.md").read_text(encoding="utf-8")
    return "\n".join(lines) + "\nDescription-Content-Type: text/markdown\n\n" + readme


def fill(folder, build, project):
    """What is in the wheel, under `folder`."""
    package = folder / "turgor"
    shutil.copytree(SOURCE / "python/turgor", package, ignore=shutil.ignore_patterns("__pycache__"))
    for module in (build / "slim/turgor").glob("_turgor.*.so"):
        shutil.copy(module, package)
    subprocess.run([sys.executable, "-m", "nanobind.stubgen", "-q", "-i", package, "-m", "_turgor", "-o", package / "_turgor.pyi"], check=True)
    info = folder / f"turgor-{project['version']}.dist-info"
    (info / "licenses").mkdir(parents=True)
    shutil.copy(SOURCE / "LICENSE", info / "licenses")
    for library in LIBRARIES:
        shutil.copy(f"/usr/share/doc/{library}/copyright", info / "licenses" / f"{library}.txt")
    (info / "METADATA").write_text(metadata(project), encoding="utf-8")
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
    (info / "WHEEL").write_text(f"Wheel-Version: 1.0\nGenerator: turgor\nRoot-Is-Purelib: false\nTag: {python}-{python}-{platform}\n")


def run(*words):
    done = subprocess.run([sys.executable, "-m", *map(str, words)], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{words[0]}: {done.stdout}{done.stderr}")


def main(build, out):
    project = tomllib.loads((SOURCE / "pyproject.toml").read_text())["project"]
    out.mkdir(parents=True, exist_ok=True)
    for old in out.glob("turgor-*.whl"):
        old.unlink()
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(scratch)
        fill(folder / "wheel", build, project)
        run("wheel", "pack", folder / "wheel", "-d", folder)
        run("auditwheel", "repair", next(folder.glob("*.whl")), "-w", out)
    for wheel in out.glob("*.whl"):
        print(f"{wheel} {wheel.stat().st_size / 1e6:.1f} MB")


main(pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]))
