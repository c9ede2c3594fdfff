# SPDX-License-Identifier: BSD-3-Clause
"""Pictures and pages: nothing overlaps, nothing is dropped, nothing comes from elsewhere."""
import itertools
import math
import re
import warnings

import numpy as np
import pytest

import ra2d
from ra2d import plots, style
from tests.colours import SEEN, lab, linear, times



@pytest.fixture(scope="session")
def loads(base, folder):
    """Six loads, as the paper varies them, and two speeds."""
    return ra2d.study(base.change(duration=0.01, rate=1e4), {"load": [0.2, 0.5, 1, 2, 5, 10], "speed": [0.1, 0.2]},
                      seeds=2, folder=folder / "loads", show=False)


def boxes(figure, labels):
    renderer = figure.canvas.get_renderer()
    figure.draw(renderer)
    return [label.get_window_extent(renderer) for label in labels if label.get_text() and label.get_visible()]


def test_a_study_draws_every_value_and_its_labels_stand_apart(loads):
    figure = loads.plot()
    against_load, against_speed = figure.axes
    assert [label.get_text() for label in against_load.get_xticklabels()] == ["0.2", "0.5", "1", "2", "5", "10"]
    named = [text.get_text() for text in against_speed.get_legend().get_texts()]
    assert named == ["load [N]", "10", "5", "2", "1", "0.5", "0.2"]
    lines = {line.get_color() for line in against_speed.lines if len(line.get_xdata()) == 40}
    assert len(lines) == 6  # the law of each, in its colour
    for axes in figure.axes:
        found = boxes(figure, axes.get_xticklabels())
        assert not any(a.overlaps(b) for a, b in zip(found, found[1:]))


def test_many_close_values_leave_room_between_labels(study):
    from ra2d.study_plot import _Panel
    wide = study.means().reset_index()
    panel = _Panel(None, study, wide, None, "speed", ["speed", "rq"])
    panel.place = {value: value for value in np.linspace(0.1, 0.12, 60)}
    ticks = [at for _, at in panel._ticks()]
    assert ticks[0] == 0.1 and 10 <= len(ticks) <= 16


@pytest.mark.parametrize("what", ["overview", *plots.PANELS])
def test_every_picture_draws_without_a_warning(result, what):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        figure = result.plot(what)
        assert figure.drawn("png", 30).startswith(b"\x89PNG")
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    assert any(titles) and all(axes.lines or axes.collections or axes.patches for axes in figure.axes)


@pytest.fixture(scope="session")
def silent(folder):
    """A rigid resonator far from the slider: no probes, no shocks, no noise, three samples."""
    still = {"scene": {"duration": 2e-5, "speed": 0.0, "start": 0.0, "gap": 1e-3, "spacing": 8e-6},
             "resonator": {"support": "rigid", "width": 0.01, "length": 0.01},
             "slider": {"support": "rigid", "width": 0.01, "length": 0.001},
             "contact": {"stiffness": 1e14}, "time": {"scheme": "exact", "step": 1e-5}}
    return ra2d.run(still, output=folder / "still.h5", show=False)


@pytest.mark.parametrize("what", ["overview", *plots.PANELS])
def test_a_run_without_noise_says_why(silent, what):
    figure = silent.plot(what)
    if what != "profiles":
        assert any(text.get_text() for axes in figure.axes for text in axes.texts)
    assert figure.drawn("png", 30)


def test_a_notebook_shows_a_picture_whatever_its_backend(result):
    assert result.plot("bands")._repr_png_().startswith(b"\x89PNG")


def test_an_unknown_picture_is_refused(result):
    with pytest.raises(ra2d.RequestError, match="no picture 'spectre'. There are: overview, profiles"):
        result.plot("spectre")


def test_the_users_own_style_is_left_alone(result):
    import matplotlib
    before = dict(matplotlib.rcParams)
    result.plot("bands").drawn("pdf")
    assert dict(matplotlib.rcParams) == before


def test_the_measure_of_colours_is_that_of_cie():
    assert math.dist(lab(linear("#ffffff")), (100, 0, 0)) < 0.01
    assert math.dist(lab(linear("#000000")), (0, 0, 0)) < 1e-9
    assert math.dist(lab(linear("#ff0000")), (53.24, 80.09, 67.20)) < 0.02


@pytest.mark.parametrize("eyes", SEEN)
def test_colours_stay_apart_for_all_eyes(eyes):
    seen = [lab(times(SEEN[eyes], linear(colour))) for colour in style.SERIES]
    assert min(math.dist(a, b) for a, b in itertools.combinations(seen, 2)) > 20


def test_every_colour_has_a_line_and_a_mark_and_shows_on_white():
    assert all(lab(linear(colour))[0] < 85 for colour in style.SERIES)
    assert len(set(style.LINES)) == len(set(style.MARKS)) == len(style.SERIES)


def test_envelopes_hold_the_extremes():
    y = np.random.default_rng(1).normal(size=10_001)
    for ends in (np.linspace(0, y.size, 100), np.geomspace(1, y.size, 100) - 1):
        at, low, mean, high = style.envelope(np.arange(y.size) * 1.0, y, ends)
        assert low.min() == y.min() and high.max() == y.max() and (np.diff(at) > 0).all()
        assert ((low <= mean) & (mean <= high)).all()


def test_units_get_prefixes():
    assert style.scale("m", [3e-6, 2e-7]) == ("\u00b5m", 1e-6)
    assert style.quantity(math.nan, "s") == "not defined"


def page_of(path):
    return pathlib.Path(path).read_text(encoding="utf-8")


EVIL = "<script>alert(1)</script> $x$"


@pytest.fixture(scope="module")
def evil(base, folder):
    """A result whose name and profile would do harm, with the text of its page."""
    face = ra2d.surface.array(2e-6 * np.sin(np.arange(2501) / 40), 8e-6, folder / "secret-face.csv")
    ran = ra2d.run(base, {"scene.name": EVIL, "slider.surface": face}, output=folder / "evil.h5", show=False)
    return ran, page_of(ran.report())


def test_the_page_is_complete_in_itself(evil):
    result, text = evil
    links = re.findall(r'(?:src|href|url)\s*[=(]\s*["\']?([^"\')\s>]+)', text)
    assert links and all(link.startswith(("#", "data:audio/wav")) for link in links)
    assert "default-src 'none'" in text and 'name="viewport"' in text and "prefers-color-scheme: dark" in text
    assert f"{result.level:.2f} dB" in text and text.count("<svg") == 5 and text.count("<audio") == 2
    ids = re.findall(r'\bid="([^"]+)"', text)
    used = set(re.findall(r'(?:url\(#|href="#)([^)"]+)', text))
    assert used <= set(ids)
    assert len(text) < 2_000_000


def test_names_from_outside_bring_no_markup_and_no_folders(evil, folder):
    result, text = evil
    assert EVIL not in text and "&lt;script&gt;" in text
    assert "secret-face.csv" in text and str(folder) not in text
    assert EVIL not in result._repr_html_()
    assert result.plot("level").drawn("png", 30)


def test_the_page_of_a_study(loads, folder):
    text = page_of(loads.report(folder / "loads.html"))
    assert "<th>level [dB re 1 nm/s]</th>" in text and "<th>speed [m/s]</th>" in text
    assert "exponent of speed" in text and "means over the seeds" in text.lower() and text.count("<svg") == 1


def test_a_page_never_replaces_a_result(result):
    with pytest.raises(ra2d.RequestError, match="ends in .html"):
        result.report(result.path)


def test_sound_of_a_part(result):
    sound = result.listen(2, full_scale=0.01, start=0.1, stop=0.2)
    assert sound.about["position"] == 0.152 and len(sound.samples) == 4801
    with pytest.raises(ra2d.RequestError, match="probe"):
        result.listen(7)


def test_several_results_lie_over_one_another(result, base, folder):
    short = ra2d.run(base, duration=2e-4, output=folder / "very-short.h5", show=False)
    figure = ra2d.plot([result, result, short])
    spectrum, bands, level = figure.axes
    assert "very-short: the run is too short for third octaves" in bands.texts[-1].get_text()
    legend = next(text.get_text() for text in figure.findobj(lambda artist: type(artist).__name__ == "Text")
                  if text.get_text().startswith("2: cube"))
    assert f"{result.level:.2f} dB" in legend
    assert {line.get_color() for line in level.lines} == set(style.SERIES[:3])
    assert len(ra2d.plot([result] * 9, "bands").axes[0].lines) == 16  # eight, each with its hollow marks
    with pytest.raises(ra2d.RequestError, match="no picture 'force' of several results"):
        ra2d.plot([result], "force")
