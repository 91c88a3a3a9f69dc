"""Sphinx settings of the documentation site. scripts/docs copies the documents into build/docs/source and runs this there."""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(ROOT / "python"))

project = "Turgor"
author = "The Turgor maintainers"
version = release = re.search(r"project\(turgor VERSION ([0-9.]+)", (ROOT / "CMakeLists.txt").read_text()).group(1)
extensions = ["myst_parser", "breathe", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
source_suffix = {".md": "markdown"}
html_theme = "furo"  # light, dark, and search
html_title = f"Turgor {version}"
html_show_sourcelink = False
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

autodoc_mock_imports = ["turgor._turgor", "gymnasium", "distributed"]
autodoc_member_order = "bysource"
