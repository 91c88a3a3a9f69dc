"""Writes the generated pages of the site: the gallery of scenes, and the C++ headers to start with."""
import pathlib
import re
import sys

HEADERS = ["core/exec.hpp", "core/result.hpp", "geometry/grid.hpp", "geometry/volume.hpp", "geometry/phantom.hpp", "io/ct.hpp",
           "models/lattice/lattice.hpp", "models/sfem/sfem.hpp", "models/rhombus/rhombus.hpp", "models/cloth/cloth.hpp",
           "contact/tool_io.hpp", "haptics/device.hpp", "haptics/loop.hpp", "sim/scene/scene.hpp", "sim/world.hpp", "sim/run.hpp"]

SECTIONS = ("briefdescription detaileddescription innernamespace innerclass public-type public-func public-attrib public-static-func "
            "func var typedef enum user-defined")  # nothing private


def comment_of(scene):
    """Opening comment of a scene, and the command for own data in it."""
    lines = re.match(r"(?:#[^\n]*\n)+", scene.read_text()).group(0).splitlines()
    text = " ".join(line.lstrip("# ") for line in lines)
    about, _, own = text.partition("Your own ")
    return about.strip(), own.partition(": ")[2].strip()


def gallery(root):
    """Every scene with its picture and its command."""
    page = ["# Gallery", "", "Every scene of `scenes/`, with the command that runs it.", ""]
    for scene in sorted((root / "scenes").glob("*.toml")):
        about, own = comment_of(scene)
        command = "calibrate" if scene.stem.startswith("calibrate") else "run"
        page += [f"## {scene.stem}", "", about, ""]
        for folder in ("docs/pictures", "scenes/pictures"):  # large ones first
            if (root / folder / f"{scene.stem}.png").exists():
                page += [f"![{scene.stem}]({folder}/{scene.stem}.png)", ""]
                break
        page += [f"    turgor {command} scenes/{scene.name}", *([f"    {own}"] if own else []), "",
                 f"[scenes/{scene.name}](scenes/{scene.name})", ""]
    (root / "gallery.md").write_text("\n".join(page))


def headers(root):
    """A section per header, from its comments."""
    page = [(root / "api-cpp.md").read_text()]
    for header in HEADERS:
        if not (root / "turgor" / header).exists():
            sys.exit(f"{__file__}: expected the header turgor/{header}, found none")
        page += [f"## turgor/{header}", "", "```{doxygenfile} " + pathlib.PurePath(header).name,
                 ":sections: " + SECTIONS, "```", ""]
    (root / "api-cpp.md").write_text("\n".join(page))
    with open(root / "Doxyfile", "a") as settings:
        settings.write("INPUT = c/turgor.h " + " ".join(f"turgor/{header}" for header in HEADERS) + "\n")


if __name__ == "__main__":
    gallery(pathlib.Path(sys.argv[1]))
    headers(pathlib.Path(sys.argv[1]))
