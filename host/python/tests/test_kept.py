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
