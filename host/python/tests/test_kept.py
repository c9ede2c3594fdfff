# SPDX-License-Identifier: BSD-3-Clause
"""Results with less in them, and windows with more of the time (docs/results.md)."""
import numpy as np
import pytest

import ra2d
from ra2d import program


@pytest.mark.filterwarnings("ignore")
def test_without_modes_all_else_is_there(base, folder):
    less = ra2d.run(base, {"output.modes": "none", "output.precision": "float",
                           "output.compression": "deflate"},
                    output=folder / "less.h5", show=False)
    assert less.level.low < less.level < less.level.high
    assert less.probes.velocity.dtype == np.float32 and less.contact.nodes.dtype == np.int64
    assert np.isnan(less.spectrum().density).all() and np.isfinite(
        less.spectrum().density_probe).all()
    assert less.shocks.index.name == "shock" and "velocity" not in less.modes()
    with pytest.raises(ra2d.RequestError, match="no motion of the modes"):
        less.field(0.1)
    less.check()
    less.plot()
    assert less.report(folder / "less.html").stat().st_size > 0


def test_a_zoom_has_the_shock(base, folder):
    short = base.change(duration=0.05)
    program.call("run", short.file(folder), *short.options(), "-o", folder / "zoomed.h5", "--zoom",
                 "strongest=1")
    whole = ra2d.load(folder / "zoomed.h5")
    shock = whole.shocks.loc[whole.shocks.peak_force.idxmax()]
    zoom = whole.zoom()
    assert (zoom.shocks.loc[shock.name] == shock).all()
    force = zoom.contact.force.sel(time=slice(shock.start, shock.start + shock.duration))
    assert force.size > 1.5e6 * shock.duration and float(force.max()) > 0.9 * shock.peak_force
    zoom.plot()
    with pytest.raises(ra2d.FileError, match="no window 2"):
        whole.zoom(2)


def test_a_result_without_a_name_is_called_after_its_file(base, folder):
    short = base.change({"scene.duration": 0.001, "scene.name": ""})
    program.call("run", short.file(folder), *short.options(), "-o", folder / "nameless.h5")
    assert ra2d.load(folder / "nameless.h5").title == "nameless"


def test_a_window_of_another_run_is_refused(base, folder):
    short = base.change({"scene.duration": 0.02, "output.probes": [0.1]})

    def run(scene, *words):
        program.call("run", scene.file(folder), *scene.options(), "-o", folder / "left.h5", *words)

    run(short, "--zoom", "0.005,0.006")
    # its name and what is heard of it are not of the motion
    place = {"x": 0.1, "y": 0.1, "z": 0.2}
    run(short.change({"scene.name": "renamed", "output.microphones": [place]}), "--fresh")
    assert ra2d.load(folder / "left.h5").title == "renamed"
    assert ra2d.load(folder / "left.h5").zoom().contact.time.size > 1000
    for change in ({"contact.stiffness": 1e14}, {"slider.surface.seed": 77}):
        run(short.change(change), "--force")
        with pytest.raises(ra2d.FileError, match="window of another run.*make it again"):
            ra2d.load(folder / "left.h5").zoom()
    run(short.change(change), "--zoom", "0.005,0.006", "--force")
    ra2d.load(folder / "left.h5").zoom()


def test_a_window_between_other_measured_faces_is_refused(base, folder):
    face = folder / "face.txt"
    scene = base.change({"scene.duration": 0.02,
                         "slider.surface": {"kind": "file", "path": face, "x_unit": "mm",
                                            "z_unit": "um"}})
    for depth, words in ((8, ["--zoom", "0.005,0.006"]), (9, ["--force"])):
        x = np.linspace(0, 20, 2001)
        np.savetxt(face, np.column_stack([x, depth * np.sin(9 * x)]))
        program.call("run", scene.file(folder), *scene.options(), "-o", folder / "measured.h5",
                     *words)
        if depth == 8:
            ra2d.load(folder / "measured.h5").zoom()
    with pytest.raises(ra2d.FileError, match="window of another run"):
        ra2d.load(folder / "measured.h5").zoom()
