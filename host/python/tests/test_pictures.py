# SPDX-License-Identifier: BSD-3-Clause
"""Pictures and pages: nothing overlaps, nothing is dropped, nothing comes from elsewhere."""
import ast
import itertools
import math
import pathlib
import subprocess
import warnings

import numpy as np
import pytest
import xarray as xr

import ra2d
from ra2d import plots, spectrogram, stretch, style
from tests.colours import SEEN, lab, linear, times



@pytest.fixture(scope="session")
def loads(base, folder):
    """Six loads, as the paper varies them, and two speeds."""
    return ra2d.study(base.change(duration=0.01, rate=1e4),
                      {"load": [0.2, 0.5, 1, 2, 5, 10], "speed": [0.1, 0.2]},
                      seeds=2, folder=folder / "loads", show=False)


def boxes(figure, labels):
    renderer = figure.canvas.get_renderer()
    figure.draw(renderer)
    return [label.get_window_extent(renderer) for label in labels if label.get_text()
            and label.get_visible()]


def test_a_study_draws_every_value_and_its_labels_stand_apart(loads):
    figure = loads.plot()
    against_load, against_speed = figure.axes
    assert [label.get_text()
            for label in against_load.get_xticklabels()] == ["0.2", "0.5", "1", "2", "5", "10"]
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
    assert any(titles) and all(axes.lines or axes.collections or axes.patches
                               for axes in figure.axes)


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
    with pytest.raises(ra2d.RequestError,
                       match="no picture 'spectre'. There are: overview, profiles"):
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


def test_sound_of_a_part(result):
    sound = result.listen(2, full_scale=0.01, start=0.1, stop=0.2)
    assert sound.about["position"] == 0.152 and len(sound.samples) == 4801
    with pytest.raises(ra2d.RequestError, match="probe"):
        result.listen(7)


def test_the_sound_at_a_microphone(result):
    sound = result.listen(at=[(0.15, 0.1, 0.5), (0, 0.1, 1)], rate=96000, start=0.1, stop=0.3)
    found = result.analysis(at=[(0.15, 0.1, 0.5), (0, 0.1, 1)], start=0.1, stop=0.3)["microphones"]
    assert sound.about[
        "quantity"] == "sound pressure" and "file" not in sound.about and sound.rate == 96000
    rms = np.sqrt((sound.samples ** 2).mean(axis=0)) * sound.about["full_scale_pa"]
    # resampled, nearly all of the band is left
    assert rms == pytest.approx([one["p_rms"] for one in found], rel=0.01)
    assert sound.encoded(
        "wav-24")[:4] == b"RIFF" and "slider's own sound" in sound.describe("x.wav")
    low = result.listen(at=[(0.15, 0.1, 0.5)], rate=8000)
    assert low.samples.ndim == 1 and any("modes are left out" in doubt for doubt in low.doubts)
    for options, words in (({"at": [(0.15, 0.1, 0)]}, "0.001 m or more"),
                           ({"at": [(0, 0, 1)], "probe": 2}, "give one of"),
                           ({"at": [(0, 0, 1)] * 3}, "one channel or two"),
                           ({"at": [(0, 1)]}, "three numbers")):
        with pytest.raises(ra2d.RequestError, match=words):
            result.listen(**options)


@pytest.mark.parametrize("what", ["bands", "level"])
def test_legends_of_microphones_cover_no_line(result, what):
    figure = result.with_microphones([(0.15, 0.1, 0.5), (0, 0.1, 1), (0.3, 0, 0.2)]).plot(what)
    figure.draw_without_rendering()
    lines = [line for axes in figure.axes for line in axes.get_lines()]
    assert len(lines) >= 3
    for axes in figure.axes:
        if (legend := axes.get_legend()) is None:
            continue
        box = legend.get_window_extent()
        for line in lines:
            points = line.axes.transData.transform(line.get_xydata())
            assert not box.count_contains(points), line.get_label()
        for bar in axes.patches:
            assert not box.overlaps(bar.get_window_extent())


def test_hatched_bars_stand_in_one_legend_with_the_microphones(result):
    """In a narrow panel one legend would cover the other."""
    for heard, names in ((result, ["above"]),
                         (result.with_microphones([(0.15, 0.1, 0.5)]), ["pressure", "above"])):
        legends = [axes.get_legend() for axes in heard.plot("bands").axes if axes.get_legend()]
        assert [[text.get_text().split()[0] for text in legend.get_texts()]
                for legend in legends] == [names]


def test_the_level_of_the_run_has_no_colour_of_a_microphone(result):
    figure = result.with_microphones([(0.15, 0.1, 0.5)]).plot("level")
    own, heard = [{line.get_color() for line in axes.get_lines()} for axes in figure.axes]
    assert len(own) == 2 and not own & heard


def test_a_short_run_has_a_level_without_weighting(base, folder):
    """No third octave with modes fits in what is heard: page and pictures say so."""
    short = ra2d.run(base, {"output.microphones": [{"x": 0.15, "y": 0.1, "z": 0.2}]},
                     duration=0.0015, output=folder / "short-sound.h5", show=False)
    found = short.analysis()["microphones"][0]
    assert found["lpa"] is None and "too short" in found["no_lpa"]
    assert plots.microphone_words(found).endswith(" dB")
    assert short.plot("bands").drawn("png", 30)
    text = short.report(folder / "short-sound.html").read_text("utf-8")
    assert "dB(A) not known: the stretch is too short: the third octave of" in text


def test_a_level_from_above_the_last_mode_is_told_everywhere(base, folder):
    changes = {"output.microphones": [{"x": 0.15, "y": 0.1, "z": 0.5}],
               "resonator.max_frequency": 2e3}
    with pytest.warns(ra2d.Notice, match="% of the A-weighted power lies above the last mode"):
        few = ra2d.run(base, changes, duration=0.05, output=folder / "few-modes.h5", show=False)
    assert few.analysis()["microphones"][0]["share_above_last_mode"] > 0.2
    assert "Microphone 1: " in few.report(folder / "few-modes.html").read_text("utf-8")


def test_several_results_at_a_microphone(result, folder):
    near, far = (result.with_microphones([(0.15, 0.1, z), (0, 0, 1)]) for z in (0.2, 2.0))
    found = near.analysis()["microphones"][0]
    figure = ra2d.plot([near, result, far])
    spectrum, bands, heard_bands, level, heard_level = figure.axes
    lines = [line for line in heard_bands.get_lines() if line.get_linestyle() != "None"]
    assert [line.get_color() for line in lines] == [style.SERIES[0], style.SERIES[2]]
    assert lines[0].get_ydata() == pytest.approx(np.array(found["bands"]["level"], dtype=float))
    assert "no microphone" in heard_bands.texts[
        -1].get_text() and "sound pressure" in heard_level.get_ylabel()
    assert len(ra2d.plot([near, far],
                         "spectrum").axes) == 1 and len(ra2d.plot([result, result],
                                                                  "level").axes) == 1
    made = folder / "two.png"
    subprocess.run([ra2d.find(), "plot", result.path, result.path, "--at", "0.15,0.1,0.5", "--what",
                    "bands", "-o", made,
                    "--quiet"], check=True)
    assert made.read_bytes()[:4] == b"\x89PNG"


def test_several_results_lie_over_one_another(result, base, folder):
    short = ra2d.run(base, duration=2e-4, output=folder / "very-short.h5", show=False)
    figure = ra2d.plot([result, result, short])
    spectrum, bands, level = figure.axes
    assert "very-short: the run is too short for third octaves" in bands.texts[-1].get_text()
    legend = next(text.get_text()
                  for text in figure.findobj(lambda artist: type(artist).__name__ == "Text")
                  if text.get_text().startswith("2: cube"))
    assert f"{result.level:.2f} dB" in legend
    assert {line.get_color() for line in level.lines} == set(style.SERIES[:3])
    # eight, each with its hollow marks
    assert len(ra2d.plot([result] * 9, "bands").axes[0].lines) == 16
    with pytest.raises(ra2d.RequestError, match="no picture 'force' of several results"):
        ra2d.plot([result], "force")


# ---- stretches, the spectrogram, one shock
# ------------------------------------------------------------

def test_a_stretch_has_the_numbers_of_the_stretch(result):
    """Those of `ra2d analyze --from --to`; sums of energy count from its first sample."""
    part = stretch.of(result, 0.2, 0.3)
    messages = result.analysis(start=0.2, stop=0.3)
    assert part.level == messages["lv"] and len(part.shocks) == messages["shocks"][
        "count"] and part.samples == 10_001
    assert float(part.contact.time[0]) == 0.2 and float(part.probes.time[-1]) == pytest.approx(0.3)
    assert part.bands().level.values[-3] == messages["bands"]["level"][-3]
    assert float(part.energy.damping_loss[0]) == 0
    lost = result.energy.damping_loss.sel(time=[0.2, 0.3], method="nearest").values
    assert float(part.energy.damping_loss[-1]) == pytest.approx(lost[1] - lost[0], rel=1e-9)
    assert stretch.of(result, None, None) is result


# the overview draws the first panels, each alone is tried of one stretch
IN_OVERVIEW = ("profiles", "force", "displacement", "spectrum", "shocks", "level", "energy")
OF_ANY_STRETCH = [what for what in ["overview", *plots.PANELS, "shock"] if what not in IN_OVERVIEW]


@pytest.mark.parametrize("start, stop, what", [
    *((start, stop, what) for start, stop in ((0.2, 0.5), (0.9, None), (None, 0.001))
      for what in OF_ANY_STRETCH),
    *((0.5, 0.50002, what) for what in [*OF_ANY_STRETCH, *IN_OVERVIEW])])
def test_every_picture_of_a_stretch_draws_without_a_warning(result, what, start, stop):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        figure = result.plot(what, start=start, stop=stop)
        assert figure.drawn("png", 30).startswith(b"\x89PNG")
    words = [text.get_text()
             for text in figure.findobj(lambda artist: type(artist).__name__ == "Text")]
    assert any(", from " in text for text in words)


def test_axes_of_a_stretch_end_where_it_does(result):
    for what in ("force", "displacement", "level", "energy"):
        assert result.plot(what, start=0.25,
                           stop=0.75).axes[0].get_xlim() == pytest.approx((250, 750), abs=1)
    low, high = ra2d.plot([result, result], "level", start=0.25, stop=0.75).axes[0].get_xlim()
    assert (low, high) == pytest.approx((250, 750), abs=1)
    # mm: 0.1 m + 0.1 m/s t, 20 mm more
    low, high = result.plot("profiles", start=0.5, stop=0.6).axes[0].get_xlim()
    assert low == pytest.approx(150 - 1.2, abs=0.1) and high == pytest.approx(180 + 1.2, abs=0.1)


@pytest.mark.parametrize("start, stop",
                         [(2, None), (0.5, 0.5), (0.6, 0.5), (-1, None), (float("nan"), None),
                          ("now", None), (None, True), (0.5, 0.500001)])
def test_stretches_that_are_none(result, start, stop):
    with pytest.raises(ra2d.RequestError,
                       match="there is nothing of|expected a time|fewer than two samples"):
        result.plot("force", start=start, stop=stop)


def test_a_stretch_behind_the_end_is_named_as_asked(result):
    with pytest.raises(ra2d.RequestError, match="from 2 s to 3 s there is nothing"):
        result.plot("force", start=2, stop=3)
    with pytest.raises(ra2d.RequestError, match="from 2 s on there is nothing"):
        result.plot("force", start=2)


def test_a_spectrogram_has_the_power_of_the_spectrum(result):
    """Parseval: the densities summed over the lines and meaned over time are the mean square
    velocity, but for the windows' weights at both ends and 0 Hz."""
    time, frequency, density, length = spectrogram.densities(result)
    assert length == 2048 and frequency[1] == pytest.approx(1e5
                                                            / 2048) and (np.diff(time) > 0).all()
    assert 0 < time[0] < 0.02 and 0.98 < time[-1] < 1
    square = density.sum(axis=0).mean() * frequency[1]
    assert 10 * np.log10(square) + 180 == pytest.approx(result.level, abs=0.3)


def test_a_tone_stands_at_its_time_and_frequency():
    """A mode that sounds in the second half: its line there carries a^2/2, spread over Hann's 1.5
    lines."""
    rate, n, amplitude = 1e4, 20_000, 3e-3
    t = np.arange(n) / rate
    velocity = amplitude * np.sin(2 * np.pi * 1250.0 * t) * (t >= 1)
    tone = Tone(xr.Dataset({"velocity": (("time", "mode"), velocity[:, None]),
                            "mean_square": ("mode", [2.0])},
                           {"time": t}), rate)
    time, frequency, density, length = spectrogram.densities(tone)
    line = int(np.argmin(abs(frequency - 1250)))
    after, before = density[:, time > 1.1], density[:, time < 0.9]
    assert before.max() < 1e-12 * after.max() and (after.argmax(axis=0) == line).all()
    assert (after.sum(axis=0) * frequency[1]).mean() == pytest.approx(2.0 * amplitude ** 2 / 2,
                                                                      rel=1e-6)
    assert after[line].mean() == pytest.approx(2.0 * amplitude ** 2 / 2 / (1.5 * frequency[1]),
                                               rel=0.02)


class Tone:
    """What the spectrogram reads of a result."""

    def __init__(self, modes, rate):
        self._modes, self.rate = modes, rate

    def modes(self, body):
        return self._modes


def test_long_runs_are_put_together():
    t = np.arange(4_000_000) / 1e5
    long = Tone(xr.Dataset({"velocity": (("time", "mode"), np.ones((t.size, 1))),
                            "mean_square": ("mode", [1.0])},
                           {"time": t}), 1e5)
    time, frequency, density, length = spectrogram.densities(long)
    assert length == spectrogram.MOST and time.size <= spectrogram.MOST_COLUMNS and 39 < time[
        -1] < 40
    assert np.allclose(np.diff(time), np.diff(time)[0])


def test_the_spectrograms_scale_says_what_it_is(result):
    figure = result.plot("waterfall")
    axes, bar = figure.axes
    assert "dB re 1 (nm/s)²/Hz" in bar.get_ylabel()
    assert "Hann" in axes.get_xlabel() and "48.8 Hz" in axes.get_xlabel()
    colours = figure.findobj(lambda artist: type(artist).__name__ == "QuadMesh")[0]
    assert colours.get_cmap().name == "viridis" and bar.get_ylim()[1] - bar.get_ylim()[0] == 70


def test_the_strongest_shock_is_shown_with_its_samples(result):
    figure = result.plot("shock")
    strongest = result.shocks.peak_force.idxmax()
    shock = result.shocks.loc[strongest]
    words = " ".join(text.get_text()
                     for text in figure.findobj(lambda artist: type(artist).__name__ == "Text"))
    assert f"Shock {strongest}, the strongest of {len(result.shocks)}" in words
    force = result.contact.force
    count = int(((force.time >= shock.start) & (force.time <= shock.start + shock.duration)).sum())
    assert count < 10 and f"{count} sample" in words and "ra2d run --zoom" in words
    peak = figure.axes[0].lines[1].get_ydata()
    assert peak[0] == pytest.approx(shock.peak_force) and len(figure.axes) == 3
    low, high = figure.axes[0].get_xlim()
    assert high - low > 8 * shock.duration * 1e6  # µs


def test_a_chosen_shock_and_a_long_one(result):
    lasting = result.shocks.duration.idxmax()
    words = " ".join(text.get_text() for text in result.plot("shock", shock=int(lasting)).findobj(
        lambda artist: type(artist).__name__ == "Text"))
    assert (f"Shock {lasting}, number" in words and "samples fall into it." in words
            and "--zoom" not in words)
    first = int(result.shocks.index[0])
    assert len(result.plot("shock", shock=first).axes) == 3
    for wrong in (-1, 10**9, 1.5, "strongest", True):
        with pytest.raises(ra2d.RequestError, match="shock is .*numbers 0 to"):
            result.plot("shock", shock=wrong)
    with pytest.raises(ra2d.RequestError, match="for the picture 'shock'"):
        result.plot("force", shock=3)


def test_runs_with_no_shock_one_shock_and_no_probes(silent, base, folder):
    assert "no shocks" in " ".join(text.get_text() for axes in silent.plot("shock").axes
                                   for text in axes.texts)
    with pytest.raises(ra2d.RequestError, match="there were none"):
        silent.plot("shock", shock=0)
    drop = ra2d.run("drop", {"output.probes": []}, duration=2e-4,
                    output=folder / "one.h5", show=False)
    figure = drop.plot("shock")
    assert figure.drawn("png", 30) and len(figure.axes) in (1, 3)


def test_a_head_is_wrapped_to_three_lines():
    """Neither cut inside a number nor as high as a page."""
    words = "  \u00b7  ".join(f"energy balance off by 6.0e-{i:02}" for i in range(10))
    figure, _ = style.page(10, 5, [(words, 9.5, "normal", style.BLACK)])
    shown = [text.get_text() for text in figure.subfigs[0].texts]
    assert len(shown) > 1 and all(part.split()[-1] != "6.0e-" for part in shown)
    assert " ".join(shown).split() == words.split()
    for wide in ("W" * 9 + " " + "M" * 9 + " ") * 5, "\u2014" * 400, r"\$W " * 60:
        figure, _ = style.page(10, 5, [(wide, 13.0, "bold", style.BLACK)])
        figure.draw_without_rendering()
        for text in figure.subfigs[0].texts:
            assert text.get_window_extent().x1 < figure.bbox.x1
    figure, _ = style.page(10, 5, [("word " * 20_000, 13.0, "bold", style.BLACK)])
    shown = [text.get_text() for text in figure.subfigs[0].texts]
    assert len(shown) == 3 and shown[-1].endswith("\u2026")


def test_scripts_draw_with_names_that_there_are():
    """The figures of bench take hours to make, so no test draws them."""
    scripts = sorted((pathlib.Path(__file__).resolve().parents[3] / "bench").rglob("*.py"))
    used = {(script.name, node.attr) for script in scripts
            for node in ast.walk(ast.parse(script.read_text()))
            if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name)
            and node.value.id == "style"}
    assert len(used) > 40
    assert [(script, name) for script, name in used if not hasattr(style, name)] == []
