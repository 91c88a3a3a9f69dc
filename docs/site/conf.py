"""Sphinx settings of the documentation site. scripts/docs copies the documents into build/docs/source and runs this there."""
import __future__
import pathlib
import re
import sys
import types
import typing

import numpy.typing
import sphinx.errors

ROOT = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(ROOT / "python"))

project = "Turgor"
author = "The Turgor maintainers"
version = release = re.search(r"project\(turgor VERSION ([0-9.]+)", (ROOT / "CMakeLists.txt").read_text()).group(1)
extensions = ["myst_parser", "breathe", "sphinx.ext.autodoc"]
source_suffix = {".md": "markdown"}
html_theme = "furo"  # light, dark, and search
html_title = f"Turgor {version}"
html_show_sourcelink = False
html_static_path = html_js_files = ["versions.js"]
exclude_patterns = ["docs/site", "docs/notebooks"]

# every link between pages must exist, with its heading
myst_heading_anchors = 4
myst_enable_extensions = ["colon_fence"]
nitpicky = False
# C declares the names of structs and of their typedefs twice, headers share namespaces, and snippets leave lines out with …
suppress_warnings = ["duplicate_declaration.c", "duplicate_declaration.cpp", "misc.highlighting_failure"]

breathe_projects = {"turgor": "doxygen/xml"}
breathe_default_project = "turgor"
breathe_default_members = ("members",)
breathe_domain_by_extension = {"h": "c"}

autodoc_mock_imports = ["gymnasium", "distributed"]
autodoc_member_order = "bysource"
autodoc_typehints_format = "short"


Scalar = typing.TypeVar("Scalar")


class ArrayLike:
    """Stands for numpy.typing.ArrayLike, which is a union of ten types."""


class NDArray(typing.Generic[Scalar]):
    """Stands for numpy.typing.NDArray."""


def load_module():
    """Imports the module without its engine, whose types and texts are in _turgor.pyi. Names of array types stay short."""
    numpy.typing.ArrayLike, numpy.typing.NDArray = ArrayLike, NDArray
    engine = sys.modules["turgor._turgor"] = types.ModuleType("turgor._turgor")
    stub = ROOT / "python/turgor/_turgor.pyi"
    exec(compile(stub.read_text(), stub, "exec", __future__.annotations.compiler_flag), engine.__dict__)
    engine.__version__, engine.instructions = version, "x86-64-v2"
    import turgor
    return turgor


def format_docstring(app, what, name, obj, options, lines):
    """Lines such as "threads: 0 = one per core" become items of a list, and indented text becomes literal."""
    text, in_list = lines[:], False
    del lines[:]
    for i, line in enumerate(text):
        after_blank = i == 0 or not text[i - 1].strip()
        if after_blank and i > 0 and line.startswith("    ") and not any(before.startswith("    ") for before in lines[-3:]):
            lines += ["::", ""]
        argument = re.match(r"[a-z_]+(, [a-z_]+)*: ", line)
        if argument and what != "property":
            lines += ([] if in_list else [""]) + [f"* ``{argument.group().rstrip(': ')}``: {line[argument.end():]}"]
        elif line and in_list and not line[0].isupper():
            lines.append("  " + line)
        else:
            lines += ([""] if in_list and line else []) + [line]
        in_list = bool(line) and (bool(argument) and what != "property" or in_list and not line[0].isupper())


def check_reference(app, exception):
    """Every public name of the module has an entry."""
    described = {entry[0] for entry in app.env.get_domain("py").get_objects()}
    missing = [name for name in turgor.__all__ if name != "__version__" and f"turgor.{name}" not in described]
    if missing and not exception:
        raise sphinx.errors.ExtensionError(f"api-python.md: expected entries for all names of the module, found none for {', '.join(missing)}")


def setup(app):
    app.connect("autodoc-process-docstring", format_docstring)
    app.connect("build-finished", check_reference)


turgor = load_module()
