# SPDX-License-Identifier: BSD-3-Clause
"""The notebook of the docs runs, and the package installs, without a network."""
import os
import pathlib
import shutil
import subprocess
import sys

import pytest

import ra2d

PACKAGE = pathlib.Path(ra2d.__file__).resolve().parents[1]
NOTEBOOK = PACKAGE.parents[1] / "docs/notebook.ipynb"


@pytest.mark.skipif(not NOTEBOOK.is_file(), reason="the source's docs are not here")
def test_the_notebook_goes_from_a_profile_to_a_level(tmp_path, monkeypatch):
    nbclient, nbformat = pytest.importorskip("nbclient"), pytest.importorskip("nbformat")
    pytest.importorskip("ipykernel")
    monkeypatch.setenv("PYTHONPATH", str(PACKAGE))
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    nbclient.NotebookClient(notebook, timeout=300,
                            resources={"metadata": {"path": str(tmp_path)}}).execute()
    shown = [output for cell in notebook.cells for output in cell.get("outputs", ())
             if "data" in output]
    texts = " ".join(output["data"].get("text/plain", "") for output in shown)
    assert "dB re 1 nm/s (95 %: " in texts and "v_rms ~ speed^" in texts and "mostly " in texts
    assert sum("image/png" in output["data"] for output in shown) >= 4
    assert any("<audio" in output["data"].get("text/html", "") for output in shown)


def test_pip_installs_it_without_a_network(tmp_path):
    source = tmp_path / "source"
    shutil.copytree(PACKAGE, source, ignore=shutil.ignore_patterns("__pycache__", "build",
                                                                   "*.egg-info"))
    target = tmp_path / "site"
    pip = [sys.executable, "-m", "pip"]
    if subprocess.run([*pip, "--version"], capture_output=True).returncode:
        pytest.skip("there is no pip")
    options = ["--no-index", "--no-build-isolation", "--no-deps", "--quiet", "--target", target]
    subprocess.run([*pip, "install", *options, source], check=True, capture_output=True)
    said = subprocess.run([sys.executable, "-c",
                           "import ra2d; print(ra2d.__file__, ra2d.scene('dang2012').title)"],
                          env={**os.environ, "PYTHONPATH": str(target), "RA2D": str(ra2d.find())},
                          cwd=tmp_path,
                          text=True, capture_output=True, check=True).stdout
    assert str(target) in said and "dang2012" in said
    assert (target / "ra2d/page.html").is_file() and (target / "ra2d/py.typed").is_file()
