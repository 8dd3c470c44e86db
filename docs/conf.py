"""Settings of the documentation. ``python docs/build.py`` builds it."""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path

from jupyter_cache.cache.db import create_db

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent)]

from making.pages import write_pages  # noqa: E402
from making.state import cache_folder  # noqa: E402

import flexmech  # noqa: E402

project = "flexmech"
author = "The flexmech developers"
project_copyright = "The flexmech developers, BSD-3-Clause"
version = release = flexmech.__version__

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "sphinx.ext.mathjax",
    "sphinx_copybutton",
]
exclude_patterns = ["_build", "making", "**/.ipynb_checkpoints"]
nitpicky = False

# Markdown. Headings have the anchors that a public forge gives them.
myst_enable_extensions = ["amsmath", "attrs_inline", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3
myst_dmath_double_inline = True

# Code cells run when the pages are built, and an error ends the build. What they gave is kept
# for as long as the code of flexmech, the models and the versions beneath stay the same.
nb_execution_mode = "cache"
nb_execution_cache_path = str(cache_folder() / "cells")
# Pages are read by several processes: one would find the database while another makes its tables.
Path(nb_execution_cache_path).mkdir(parents=True, exist_ok=True)
create_db(nb_execution_cache_path)
nb_execution_in_temp = True
nb_execution_raise_on_error = True
nb_execution_timeout = 240
nb_merge_streams = True
os.environ["PYTHONPATH"] = os.pathsep.join(
    [str(HERE.parent), *filter(None, [os.environ.get("PYTHONPATH")])]
)
_startup = HERE / "_build" / "ipython" / "profile_default" / "startup"
_startup.mkdir(parents=True, exist_ok=True)
shutil.copy(HERE / "making" / "kernel_startup.py", _startup)
os.environ["IPYTHONDIR"] = str(_startup.parents[1])
for _threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):  # pages are read side by side
    os.environ[_threads] = "1"
# Cells run `flexmech` of this interpreter, not one that happens to be found first.
os.environ["PATH"] = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])

autodoc_member_order = "groupwise"
autodoc_typehints = "none"  # the docstrings state types, shapes and units
autosummary_generate = True
napoleon_google_docstring = False
napoleon_use_rtype = False

html_theme = "furo"
html_title = "flexmech"
html_static_path: list[str] = []
html_show_sourcelink = False
copybutton_exclude = ".linenos, .gp, .go"

write_pages(HERE / "made")
