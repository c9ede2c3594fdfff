# SPDX-License-Identifier: BSD-3-Clause
"""Examples and tests run in one folder, which holds a result, a study and a profile."""
from __future__ import annotations

import pathlib
import sys
from collections.abc import Iterator

import numpy as np
import pytest

import ra2d

sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "tests" / "host"))
import warm_python  # noqa: E402


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> pathlib.Path:
    return tmp_path_factory.mktemp("work")


@pytest.fixture(scope="session")
def warm() -> Iterator[dict[str, str]]:
    """An environment in which the program finds a `python3` that starts quickly."""
    with warm_python.started() as path:
        yield {"PATH": path}


@pytest.fixture(autouse=True)
def _in_folder(folder: pathlib.Path, monkeypatch: pytest.MonkeyPatch, result: ra2d.Result,
               study: ra2d.Study) -> None:
    monkeypatch.chdir(folder)


@pytest.fixture(scope="session")
def base() -> ra2d.Scene:
    """The paper's scene, cheap."""
    return ra2d.scene("dang2012").change(tolerance=1e-6)


@pytest.fixture(scope="session")
def result(folder: pathlib.Path, base: ra2d.Scene) -> ra2d.Result:
    """A second of sliding, with a probe between the places of the shapes and one on one of them."""
    with pytest.warns(ra2d.Notice, match="contact.stiffness"):
        return ra2d.run(base, {"output.probes": [0.15, 0.152]},
                        output=folder / "cube.h5", show=False)


@pytest.fixture(scope="session")
def study(folder: pathlib.Path, base: ra2d.Scene) -> ra2d.Study:
    both = ("resonator.surface.rq", "slider.surface.rq")
    with pytest.warns(ra2d.Notice, match="contact.stiffness"):
        return ra2d.study(base.change(duration=0.02, rate=1e4),
                          {"speed": [0.1, 0.2, 0.4], both: [4e-6, 8e-6]}, seeds=2,
                          folder=folder / "small", show=False)


@pytest.fixture(scope="session")
def profile(folder: pathlib.Path) -> pathlib.Path:
    """A measured profile: millimetres along, micrometres high."""
    x = np.arange(0, 12, 0.002)
    z = 2 * np.sin(2 * np.pi * x / 0.8) + 0.3 * x
    file = folder / "measured.txt"
    file.write_text("".join(f"{a:.4f} {b:.5f}\n" for a, b in zip(x, z)))
    return file
