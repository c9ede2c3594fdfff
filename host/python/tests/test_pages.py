# SPDX-License-Identifier: BSD-3-Clause
"""Pages: all that a result or a study has to say, on any screen, and nothing from elsewhere."""
import base64
import html.parser
import io
import json
import math
import pathlib
import re
import shutil
import subprocess
import warnings

import h5py
import numpy as np
import pytest
import soundfile

import ra2d
from ra2d import page, page_pictures, page_svg, page_words, program, style
from ra2d.page_words import number, without_folders

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))),
                None)
EVIL = "</title><script>alert(1)</script>\"'><img src=x onerror=alert(2)>\u202e $x^2$"


class Tags(html.parser.HTMLParser):
    """All tags of a page with their attributes, as a browser sees them."""

    def __init__(self, text):
        super().__init__()
        self.found = []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.found.append((tag, dict(attrs)))


def read(path):
    return pathlib.Path(path).read_text(encoding="utf-8")


def require_harmless(text):
    """Nothing leads away from the page, and one program runs in it, the page's own."""
    tags = Tags(text).found
    names = [tag for tag, _ in tags]
    assert names.count("script") == 1 and not set(names) & {"link", "img", "iframe", "object",
                                                            "embed", "base", "form"}
    attributes = [(name, value or "") for _, attrs in tags for name, value in attrs.items()]
    assert not [name for name, _ in attributes if name.startswith("on")]
    links = [value for name, value in attributes if name in ("href", "src", "data", "action",
                                                             "xlink:href")]
    links += [found for _, value in attributes for found in re.findall(r"url\((.*?)\)", value)]
    assert all(link.startswith(("#", "data:audio/wav;base64,")) for link in links), links
    style_text = text.split("<style>")[1].split("</style>")[0]
    assert "url(" not in style_text and "@import" not in style_text
    ids = [value for name, value in attributes if name == "id"]
    assert len(ids) == len(set(ids)) and {link[1:]
                                          for link in links if link.startswith("#")} <= set(ids)
    assert ("\u202e" not in text and "Content-Security-Policy" in text
            and "default-src 'none'" in text)


def rows(text, heading):
    """A table of facts below a heading, without markup."""
    table = text.split(f">{heading}</h3>")[1].split("</table>")[0]
    return [tuple(re.sub("<[^>]+>", "", cell) for cell in row)
            for row in re.findall(r'<th scope="row">(.*?)</th><td>(.*?)</td>', table)]


def sounds(text):
    return [soundfile.read(io.BytesIO(base64.b64decode(data)))
            for data in re.findall(r"data:audio/wav;base64,([A-Za-z0-9+/=]+)", text)]


# ---- words and numbers
# -----------------------------------------------------------------------------

def test_no_markup_goes_through():
    shown = page_words.html("<b>{}</b>", "<b a=\"1\" c='2'>&</b>")
    assert shown == "<b>&lt;b a=&#34;1&#34; c=&#39;2&#39;&gt;&amp;&lt;/b&gt;</b>"
    shown = str(page_words.html("{}", "a\x1b\nb\udcff\u2066\x85"))
    assert shown == r"a\u001B\u000Ab\xFF\u2066\u0085"


@pytest.mark.parametrize("value, digits, text", [
    (1234.5, 4, "1234"), (0, 3, "0"), (-0.25, 3, "−0.25"),
    (7.2134e-4, 3, "7.21\u00a0×\u00a010<sup>−4</sup>"),
    (1e15, 3, "1\u00a0×\u00a010<sup>15</sup>"), (math.nan, 3, "–"), (None, 3, "–"),
    (-math.inf, 3, "−∞")])
def test_numbers_are_for_people(value, digits, text):
    assert number(value, digits) == text


@pytest.mark.parametrize("toml, bare", [
    ('path = "/home/ann/a \\"b\\"/c.csv" # "/x"', 'path = "c.csv" # "x"'),
    ("base='/home/ann/b.toml'\nname = \"a/b\"\nx = \"/", "base='b.toml'\nname = \"a/b\"\nx = \"/"),
    ('a = "/it\'s/x" b = "/" c = "\\', 'a = "x" b = "/" c = "\\'),
    ('a = "/open\nb = "/home/x"', 'a = "open\nb = "x"'),
    ('# the paper\'s\nbase = "/home/ann/b.toml"', '# the paper\'s\nbase = "b.toml"'),
    ("# the paper's, in '/home/ann/b.toml'", "# the paper's, in 'b.toml'"),
    ('path = """\n/home/ann/c.csv"""\nb = \'\'\'/home/d\'\'\'',
     'path = """\nc.csv"""\nb = \'\'\'d\'\'\''),
    ('a = ""\nb = "/home/x#y"', 'a = ""\nb = "x#y"')])
def test_texts_lose_their_folders_and_keep_their_names(toml, bare):
    assert without_folders(toml) == bare


def test_what_was_asked_has_the_units_of_its_keys():
    facts = dict(page_words.requested(ra2d.scene("moving-force").complete()))
    assert facts == facts | {
        "sliding": "0.015 s at 0 m/s, from 140 mm on",
        "resonator":
        "pinned beam, 300 mm long, 2 mm thick, 200 mm wide; 210 GPa, 7800 kg/m³, damping ratio 0; "
                     "modes up to 20 kHz",
        "its face": "flat", "slider": "rigid beam, 20 mm long, 20 mm wide",
        "contact": "penalty, 1\u00a0×\u00a010<sup>15</sup> Pa/m", "spacing": "500 µm",
        "samples": "100 kHz; counted from 0 s on", "moving force": "10 N at 20 m/s"}


# ---- pictures
# --------------------------------------------------------------------------------------

def drawn(plot):
    figure, body = style.page(3, 2, [])
    axes = body.subplots()
    plot(axes)
    return page_svg.drawn(figure, page_svg.Sheet(), "\"><script>")


def test_a_picture_is_short_and_bears_every_value():
    def plot(axes):
        axes.plot([-1, 0, 1, 10, 1e300], [np.nan, -5, 5, np.inf, -1e300])
        axes.set(xlim=(1, 100), ylim=(0, 10), xscale="log", xlabel="<x>", ylabel="\u202e$")
    svg = drawn(plot)
    assert "<script" not in svg and "<x>" not in svg and "nan" not in svg and "inf" not in svg
    assert "&lt;x&gt;" in svg and r"\u202E$" in svg and "clip-path" in svg and len(svg) < 4000


def test_a_long_line_keeps_its_extremes():
    y = np.random.default_rng(3).normal(size=100_000)
    y[54_321] = 40
    svg = drawn(lambda axes: (axes.plot(y), axes.set_ylim(-10, 50)))
    d = max(re.findall(r'd="([^"]+)"', svg), key=len)
    assert 1000 < len(d) < 4000  # not the 600 000 of all its points
    height, heights = 0, []
    for word, numbers in re.findall(r"([Mlhvm])([-\d ]*)", d):
        values = [int(value) for value in re.findall(r"-?\d+", numbers)]
        for dy in [0] * len(values) if word == "h" else values if word == "v" else values[1::2]:
            height = dy if word == "M" else height + dy
            heights.append(height)
    plot_height = (max(heights) - min(heights)) / (y.max() - y.min()) * 60
    assert 1000 < plot_height < 1440 and heights.count(min(heights)) == 1


# ---- one result
# ------------------------------------------------------------------------------------

@pytest.fixture(scope="module")
def short(base, folder):
    """A fifth of a second, with a name, a file and a profile that would do harm, and its page."""
    face = ra2d.surface.array(2e-6 * np.sin(np.arange(2501) / 40), 8e-6, folder / "secret's.csv")
    ran = ra2d.run(base, {"scene.name": EVIL, "slider.surface": face}, duration=0.2,
                   output=folder / "<img src=x>'.h5",
                   show=False)
    return ran, page.results_text([ran], "ra2d report <img src=x>")


@pytest.fixture(scope="module")
def whole(result):
    """The page of a second of sliding."""
    return page.results_text([result], "ra2d report cube.h5 -o page.html")


@pytest.fixture
def undrawn(monkeypatch):
    """Pages without their pictures, which take a second: for tests of what else stands there."""
    monkeypatch.setattr(page_pictures, "of_result", lambda result, sheet: [])


def test_a_page_has_it_all(result, whole):
    text = whole
    require_harmless(text)
    facts = dict(rows(text, "What came out"))
    level = result.level
    assert facts["level Lv"].startswith(f"{level:.2f} dB re 1 nm/s")
    assert facts["level Lv"].endswith(
        f"; 95 %: {level.low:.1f} to {level.high:.1f} dB, with these surfaces")
    assert facts["shocks"].startswith(
        f"{result.shock_rate:.0f} a second ({len(result.shocks)} in all); 95 %: ")
    assert facts["their duration"].startswith("median ") and "eight of ten from" in facts[
        "their impulse"]
    assert set(facts) == {"level Lv", "shocks", "their duration", "their peak force",
                          "their impulse", "at once",
                          "energy they give", "in contact", "loudest third octave",
                          "half-power damping", "power",
                          "energy balance"}
    for caption in ("Velocity spectrum", "Third octaves", "Level in time", "how long they last",
                    "their peak force",
                    "Faces"):
        assert len(re.findall(f"<figcaption><b>[^<]*{caption}", text)) == 1
    assert text.count("<svg ") == 6 and text.count('role="img" aria-label="') == 6
    assert ("Made by ra2d 0." in text
            and "with <code>ra2d report cube.h5 -o page.html</code>" in text)
    assert (f"ra2d {result.attrs['version']} ({result.attrs['commit']}), started "
            f"{result.attrs['started']}" in text)
    assert ("&#34;roughness noise&#34;" in text and 'name="viewport"' in text
            and "prefers-color-scheme: dark" in text)
    assert dict(rows(text,
                     "What was asked"))["time scheme"] == "adaptive, tolerance 1\u00a0×\u00a010−6"
    assert "modal damping 0.02" in text and "<summary>Damping of the modes</summary>" in text
    assert len(text) < 900_000


def test_two_sounds_on_one_scale(result, whole):
    text = whole
    (plain, rate), (slow, slow_rate) = sounds(text)
    assert (len(plain), rate) == (48_001, 48_000) and (len(slow), slow_rate) == (160_001, 8000)
    assert "Shortened" not in text and "What is heard at 1 kHz moves at 20 kHz." in text
    # one second of samples: both peaks are those of the probe, but for what they miss of waves of
    # 20 kHz: those of the file, at 100 kHz, down to cos(pi/5), of the sound, at 160 kHz, cos(pi/8)
    scale = float(re.search(r"Full scale is ([\d.]+) m/s", text)[1])
    peak = float(abs(result.probes.velocity.isel(position=0)).max()) / scale
    assert math.cos(math.pi / 8) < abs(slow).max() / peak < 1 / math.cos(math.pi / 5)


def test_results_share_their_full_scale(base, folder, short, undrawn):
    result, _ = short
    loud = ra2d.run(base, speed=0.5, duration=0.05, output=folder / "loud.h5", show=False)
    text = page.results_text([result, loud])
    assert len(set(re.findall(r"Full scale is (\S+) m/s", text))) == 1
    scale = float(re.search(r"Full scale is (\S+) m/s", text)[1])
    expected = [of.listen(slow=slow, rate=rate, full_scale=scale) for of in (result, loud)
                for slow, rate in ((1, 48_000), (20, 8000))]
    for (samples, _), sound in zip(sounds(text), expected, strict=True):
        np.testing.assert_allclose(samples, sound.samples, atol=2 ** -15)
        assert abs(samples).max() <= 1


def test_long_sounds_are_shortened(base, folder, undrawn):
    slow = ra2d.run(base, duration=1.2, speed=0.05, tolerance=1e-3,
                    output=folder / "long.h5", show=False)
    text = page.results_text([slow])
    assert "Shortened: all of it would last 24 s." in text
    assert [round(len(samples) / rate) for samples, rate in sounds(text)] == [1, 20]


def test_the_same_page_has_the_same_bytes(short):
    result, text = short
    assert page.results_text([ra2d.load(result.path)], "ra2d report <img src=x>") == text


def test_what_comes_from_outside_stays_text(short):
    result, text = short
    require_harmless(text)
    assert "<img" not in text and "&lt;script&gt;" in text and r"\u202E" in text
    assert EVIL not in result._repr_html_()
    assert result.plot("level").drawn("png", 30)


def test_profiles_are_named_without_folders_and_with_their_hash(short, folder):
    result, text = short
    assert str(folder) not in text and str(folder.parent) not in text
    with h5py.File(result.path) as file:
        seal = file["surface/slider/height"].attrs["xxh3_128"]
        assert str(folder) in file.attrs["scene"]  # the result itself runs again from anywhere
    assert ("# secret&#39;s.csv: put it beside this scene. surface/slider/height in the result: "
            f"xxh3_128 {seal}\n") in text
    assert "path = &#34;secret&#39;s.csv&#34;" in text and "measured: secret&#39;s.csv" in text


def test_messages_name_files_without_folders(folder):
    face = ra2d.surface.array(2e-6 * np.sin(np.arange(3000) / 40), 2e-6, folder / "my trace.csv",
                              short="repeat")
    scene = ra2d.scene("dang2012").change({"slider.surface": face}, duration=0.005, tolerance=1e-6,
                                          rate=1e4)
    table = ra2d.study(scene, vary={"speed": [0.1, 0.2]}, folder=folder / "traces", show=False)
    text = page.study_text(table)
    assert "my trace.csv: 0.0" in text and str(folder) not in text
    results = [ra2d.run(scene, output=folder / f"{v}.h5", speed=v, show=False) for v in (0.1, 0.2)]
    text = page.results_text(results)
    assert "differ in more than their faces" in text and str(folder) not in text


def test_the_level_has_a_reason_where_it_has_no_interval(short, whole):
    result, text = short
    of_intervals = "The 95 % intervals of level and shocks are of this run"
    assert of_intervals in whole and of_intervals not in text
    assert dict(rows(text,
                     "What came out"))["level Lv"].endswith(
                         f"; no interval: {result.analysis()['no_interval']}")


def test_hardly_anything_is_still_a_page(folder):
    for scene, changes in (("peaks", {}), ("drop", {}), ("moving-force", {}),
                           ("drop", {"duration": 1e-4}),
                           ("drop", {"duration": 1e-7, "rate": 1e7}),
                           ("drop", {"duration": 1e-3, "from": 0.99e-3})):
        ran = ra2d.run(scene, output=folder / "little.h5", force=True, show=False, **changes)
        text = page.results_text([ran])
        require_harmless(text)
        assert not re.search(r"[ >]-?(?:nan|inf|None)\b",
                             re.sub(r"<style>.*</style>", "", text, flags=re.DOTALL))
        assert text.endswith("</html>")


def test_a_page_without_noise_shocks_and_probes(folder):
    still = {"scene": {"duration": 2e-5, "speed": 0.0, "start": 0.0, "gap": 1e-3, "spacing": 8e-6},
             "resonator": {"support": "rigid", "width": 0.01, "length": 0.01},
             "slider": {"support": "rigid", "width": 0.01, "length": 0.001},
             "contact": {"stiffness": 1e14}, "time": {"scheme": "exact", "step": 1e-5}}
    text = page.results_text([ra2d.run(still, output=folder / "silent.h5", show=False)])
    facts = dict(rows(text, "What came out"))
    assert facts["level Lv"] == "−∞ dB: the resonator did not vibrate" and facts["shocks"] == "none"
    assert "No sound: the result has no probe" in text and "<audio " not in text and text.count(
        "<svg ") == 1


def test_doubts_stand_on_top(folder, base):
    with pytest.raises(ra2d.SimulationError):
        ra2d.run("dang2012", {"time.force": True}, scheme="explicit-euler", step=1e-6,
                 output=folder / "unstable.h5", show=False)
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # the page says it
        text = page.results_text([ra2d.load(folder / "unstable.h5")])
    box = text.split('<div class="note" role="note">')[1].split("</div>")[0]
    assert ("The run was cut short: unstable" in box
            and "beyond a limit of stability, on request: explicit-euler" in box)
    assert box.count("of the energy is unaccounted for") == 1


def test_doubts_of_the_scene_stand_on_top(result):
    box = page.results_text([result]).split('<div class="note" role="note">')[1].split("</div>")[0]
    assert box.count("The scene: contact.stiffness = 1e+15 Pa/m: ") == 1


def test_warnings_of_a_run_stand_on_top(folder):
    with pytest.warns(ra2d.Notice, match="^the resonator's vibration holds"):
        slow = ra2d.run("dang2012", {"slider.load": 100.0, "contact.stiffness": 4e12}, speed=1e-4,
                        duration=0.01, scheme="adaptive", tolerance=1e-6,
                        output=folder / "slow.h5", show=False)
    box = page.results_text([slow]).split('<div class="note" role="note">')[1].split("</div>")[0]
    assert box.count("The run warned: the resonator&#39;s vibration holds ") == 1
    assert "Try 1e-09" in box


def test_aliased_modes_the_meshs_tone_and_bands_without_modes(result, whole, base, folder):
    few = ra2d.run(base, duration=0.02, rate=1e4, output=folder / "few.h5", show=False)
    assert f"{few.analysis()['aliased_modes']} modes lie above half the rate" in page.results_text(
        [few])
    low = ra2d.run(base, {"resonator.max_frequency": 2000.0}, duration=0.2,
                   output=folder / "low.h5", show=False)
    assert "Hollow: above the last mode that was kept, at 1.8" in page.results_text([low])
    text = whole
    assert ("The mesh&#39;s own tone at 12.5 kHz" in text) == result.analysis()["mesh_tone"][
        "stands_out"]
    assert "Dashed: speed/spacing, 12.5 kHz" in text


# ---- several results
# -------------------------------------------------------------------------------

def test_several_results_stand_side_by_side(short, result):
    text = page.results_text([result, short[0]])
    require_harmless(text)
    assert "<title>Roughness noise: 2 results</title>" in text
    assert 'href="#result2">&lt;img src=x&gt;&#39;.h5</a>' in text
    assert text.count("<svg ") == 12 and text.count("<audio ") == 4 and text.count("<section ") == 2
    means = json.loads(program.call("analyze", result.path, short[0].path, "--json"))["mean"]
    table = text.split(">Means</h2>")[1].split("</table>")[0]
    lv = means["lv"]
    assert ("<td>level Lv, dB re 1 "
            f"nm/s</td><td>{number(lv['mean'], 5)}</td><td>{number(lv['low'], 5)} to" in table)
    assert f"<td>{number(1e6 * means['shocks.duration.median']['mean'], 5)}</td>" in table
    assert table.count("<tr>") == 1 + len(means)


def test_several_results_from_python(short, folder, undrawn):
    made = ra2d.report([short[0], short[0]], folder / "both.html")
    text = read(made)
    assert text.count("<section ") == 2
    assert " are of one run: in the means it counts 2 times" in text.split(">Means</h2>")[1]
    with pytest.raises(ra2d.RequestError, match="one or more results"):
        ra2d.report(["a.h5"], folder / "none.html")


def test_the_first_eight_are_heard(short, monkeypatch):
    monkeypatch.setattr(page, "MOST_SOUNDS", 2)
    first, second, third = page._clips([short[0]] * 3)
    assert len(first["clips"]) == len(second["clips"]) == 2 and not third["clips"]
    assert third["why_none"].startswith("Of many results the first 2 alone have their sounds here")


# ---- files
# -------------------------------------------------------------------------------------------

def test_a_refusal_leaves_everything_as_it_was(result, folder):
    with pytest.raises(ra2d.RequestError, match="ends in .html"):
        result.report(result.path)
    with pytest.raises(ra2d.FileError, match="no folder"):
        result.report(folder / "nowhere" / "page.html")
    with pytest.raises(ra2d.RequestError, match="one or more results"):
        page.of_results([], folder / "none.html")
    assert not (folder / "none.html").exists()
    result.check()


def test_an_earlier_page_gives_way(result, folder, undrawn):
    (folder / "page.htm").write_text("<html>")
    assert read(result.report(folder / "page.htm")).endswith("</html>")


# ---- studies
# -------------------------------------------------------------------------------------------

@pytest.fixture(scope="module")
def loads(base, folder):
    """Six loads and two speeds, from a file whose texts would do harm, with --set."""
    base_text = ra2d.scene("dang2012").text() + "# </pre><script>alert(1)</script>\n"
    (folder / "base of mine.toml").write_text(base_text, newline="\r\n")  # as Windows ends lines
    (folder / "loads-page.toml").write_text(f"""base = "{folder}/base of mine.toml"
seeds = 3
# </pre><script>alert(1)</script>
[set]
"scene.duration" = 0.01
"time.scheme" = "adaptive"
"time.tolerance" = 1e-6
"output.rate" = 1e4
[vary]
load = {{ key = "slider.load", values = [0.2, 0.5, 1, 2, 5, 10] }}
speed = {{ key = "scene.speed", values = [0.1, 0.2] }}
""")
    program.call("study", folder / "loads-page.toml", "-o", folder / "loads-page", "--quiet",
                 "--set", "slider.damping=0.03")
    return ra2d.load_study(folder / "loads-page")


def test_the_page_of_a_study(loads, folder):
    text = page.study_text(loads, "ra2d report loads-page/ -o out.html")
    require_harmless(text)
    law = loads.law()
    for name, e in law.exponents.items():
        assert f"<td>{name}</td><td>{float(e):.3f}</td><td>{e.low:.3f} to {e.high:.3f}</td>" in text
    for row in loads.means().to_dict("records"):
        interval = f"{row['level_low']:.2f} to {row['level_high']:.2f}"
        assert f"<td>3</td><td>{row['level']:.2f}</td><td>{interval}</td>" in text
    assert ("36 runs: 36 done, 0 failed, 0 missing" in text
            and "Intervals by the 3 seeds: runs of one seed share" in text)
    assert "<th>load, N</th><th>speed, m/s</th><th>runs</th>" in text
    assert (text.count("<svg ") == 2 and "Level against load" in text
            and "Level against speed" in text)
    assert "u000D" not in text and "\r" not in text
    assert "slider.damping=0.03" in text and "&lt;/pre&gt;&lt;script&gt;alert" in text
    assert str(folder) not in text and "base = &#34;base of mine.toml&#34;" in text
    assert ("<code>ra2d report loads-page/ -o out.html</code>" in text
            and "<h1>Study: loads-page</h1>" in text)


def test_every_load_is_drawn_and_named_in_its_colour(loads):
    text = page.study_text(loads)
    _, against_speed = re.findall(r"<figure>.*?</figure>", text, re.DOTALL)
    named = re.findall(r'<b style="color:var\((--\w+)\)">▬</b> ([\d.]+)</span>', against_speed)
    assert [name for _, name in named] == ["10", "5", "2", "1", "0.5",
                                           "0.2"] and "load [N]:" in against_speed
    assert len({colour for colour, _ in named}) == 6
    for colour, _ in named:  # its points, its line, in light and in dark
        classes = re.findall(rf"\.(p\d+){{[^}}]*stroke:var\({colour}\)", text)
        assert sum(f'class="{kind}"' in against_speed for kind in classes) >= 3
        assert len(re.findall(rf"{colour}: ?#[0-9a-f]{{6}}", text)) == 2


def test_studies_of_every_kind(base, folder):
    quick = base.change(duration=0.002, rate=1e4)
    words = ra2d.study(quick.without(["time.scheme", "time.tolerance"]),
                       {"scheme": ["backward-euler", "exact"], "load": [1.0]}, seeds=2,
                       folder=folder / "words",
                       show=False)
    text = page.study_text(words)
    assert ("<td>backward-euler</td><td>1</td><td>2</td>" in text
            and ">backward-euler</text>" in text)
    assert text.count("<svg ") == 1  # of the one key with two values
    three = ra2d.study(quick,
                       {"speed": [0.1, 0.2], "load": [0.5, 1.0], "rate": [1e4, 2e4]}, seeds=2,
                       folder=folder / "three", show=False)
    text = page.study_text(three)
    assert text.count("<svg ") == 3 and text.count("● ") >= 3 and text.count("■ ") >= 3
    seeds = ra2d.study(quick, {}, seeds=2, folder=folder / "seeds", show=False)
    text = page.study_text(seeds)
    assert ("<svg " not in text and "no law" in text.lower()
            and "<th>runs</th><th>Lv, dB</th>" in text)


def test_a_page_of_a_study_counts_the_runs_that_warn(base, folder):
    warning = ra2d.study(base.change({"resonator.max_frequency": 2e3, "slider.surface.seed": 5,
                                      "output.microphones": [{"x": 0.1, "y": 0.1, "z": 0.5}]},
                                     duration=0.02),
                         {"speed": [0.1, 0.2]}, folder=folder / "warning", keep_sound=True,
                         show=False)
    text = page.study_text(warning)
    assert "2 of 2 finished runs (the first: speed = 0.1, seed 0): sound pressure: " in text
    assert "Intervals by the runs, each taken for chance of its own." in text or "no law" in text


def test_values_of_keys_stay_text(base, folder):
    names = [EVIL[:40], "a\u202eb\u0001", "$x^2$ $", "\u65e5\u672c\u8a9e", "\\udc"]
    named = ra2d.study(base.change(duration=0.001, rate=1e4),
                       {"scene.name": names, "speed": [0.1, 0.2]}, seeds=2,
                       folder=folder / "<i>named", show=False)
    text = page.study_text(named)
    require_harmless(text)
    assert text.count(r"a\u202Eb\u0001") == 5  # two rows, an axis, a colour, and the study
    assert "<h1>Study: &lt;i&gt;named</h1>" in text


def study_of(folder, name, text, status=0, *options):
    (folder / f"{name}.toml").write_text(text)
    ended = subprocess.run([program.find(), "study", folder / f"{name}.toml", "-o", folder / name,
                            "--quiet", *options],
                           capture_output=True, text=True)
    assert ended.returncode == status, ended.stderr
    return ra2d.load_study(folder / name)


def base_of(folder):
    (folder / "plain.toml").write_text(ra2d.scene("dang2012").text())
    return 'base = "plain.toml"\n'


def test_a_study_without_levels_says_so(folder):
    none = study_of(folder, "none",
                    base_of(folder) + 'keep = ["shocks"]\n[set]\n"scene.duration" = 1e-4\n[vary]\n'
                    'speed = { key = "scene.speed", values = [0.1, 0.2] }\n')
    text = page.study_text(none)
    require_harmless(text)
    assert ("<p>No law: the table holds no v_rms" in text and "<svg" not in text
            and ">Levels<" not in text)
    assert none.means().empty and none.plot().axes


def test_an_unfinished_study_counts_what_is_missing(folder):
    cut = study_of(folder, "unfinished",
                   base_of(folder) + 'seeds = 400\n[set]\n"scene.duration" = 0.5\n'
                   '"time.scheme" = "adaptive"\n"time.tolerance" = 1e-8\n', 5, "--max-wall", "0.5")
    done = cut.attrs["done"]
    text = page.study_text(cut)
    assert f"400 runs: {done} done, 0 failed, {400 - done} missing" in text and done < 400


def test_failed_runs_say_why(folder):
    failed = study_of(folder, "failed",
                      base_of(folder) + 'seeds = 2\n[set]\n"scene.duration" = 0.05\n'
                      '"time.force" = true\n"time.step" = 1e-6\n"output.rate" = 1e4\n[vary]\n'
                      'load = { key = "slider.load", values = [0.5, 1.0] }\n'
                      'scheme = { key = "time.scheme", values = ["backward-euler", '
                      '"explicit-euler"] }\n', 3)
    text = page.study_text(failed)
    assert ("8 runs: 4 done, 4 failed, 0 missing" in text and "<p>4 of 8 runs failed.</p>" in text
            and "unstable" in text)
    # its place on the axis, too
    assert "<p>4: unstable" in text and ">explicit-euler</text>" in text
    assert "<td>explicit-euler</td><td>0</td><td>–</td><td>–</td>" in text
    assert " 4 runs without a level are left out. All values of scheme are taken together." in text


def test_a_long_table_is_cut_with_a_sentence(study, monkeypatch):
    monkeypatch.setattr(page, "MOST_ROWS", 5)
    text = page.study_text(study)
    assert "The first 5 of 6 combinations; the table results.h5 has them all." in text
    assert text.split(">Levels</h2>")[1].split("</table>")[0].count("<tr>") == 6


def test_a_law_that_bends_is_a_doubt(study):
    from ra2d.studies import Law
    law = study.law()
    line = {"fits": False, "says": "a straight line does not fit", "changes": [
        {"of": "rq", "along": "speed", "from": 0.1, "to": 0.4, "exponent_from": 1.05,
         "exponent_to": 0.83}]}
    bent = Law(law.exponents, law.constant, law.deviation, law.r_squared,
               law.about | {"straight_line": line})
    made = page._law(bent)
    assert made["bends"] and made["shape"] == [
        "A straight line does not fit.",
        "The exponent of rq falls from 1.050 at speed = 0.1 to 0.830 at 0.4."]
    assert made["formula"].startswith("v<sub>rms</sub> ∝ speed<sup>")


# ---- in a browser
# ----------------------------------------------------------------------------------------

MEASURE = """<script>addEventListener("load", () => {
  const sounds = [...document.querySelectorAll("audio")].map(a => a.duration.toFixed(3));
  const fetched = performance.getEntriesByType("resource").filter(e => !e.name.startsWith("data:"));
  const small = [...document.querySelectorAll("svg text")].map(t => t.getBoundingClientRect())
    .filter(box => Math.min(box.width, box.height) < 5).length;
  const root = document.documentElement;
  document.querySelector("button[data-copies]").click();
  document.body.dataset.seen = [root.clientWidth, root.scrollWidth, fetched.length, small,
    document.querySelectorAll("svg").length, getSelection().toString().includes("duration = 0.2"),
    ...sounds].join(" ");
});</script>"""

# Windows have a least width; frames do not.
FRAMES = """<!DOCTYPE html>
<iframe src="measured.html" style="width:360px;height:800px;border:0"></iframe>
<iframe src="measured.html" style="width:1200px;height:800px;border:0"></iframe>
<script>addEventListener("load", () => document.body.append([...document.querySelectorAll("iframe")]
  .map(f => f.contentDocument.body.dataset.seen).join("; ")));</script>"""


@pytest.mark.skipif(not CHROMIUM, reason="no Chromium here")
def test_a_page_stands_in_a_browser(base, folder, short):
    wide = ra2d.run(base, {"scene.name": "one long word: " + 150 * "x"}, duration=0.2,
                    output=folder / "wide.h5",
                    show=False)
    text = page.results_text([wide, short[0]])
    place = folder / "browser"
    place.mkdir()
    (place / "measured.html").write_text(text.replace("</body>", MEASURE + "</body>"),
                                         encoding="utf-8")
    (place / "frames.html").write_text(FRAMES)
    shown = subprocess.run(
        [CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars",
         "--enable-logging=stderr",
         "--host-resolver-rules=MAP * ~NOTFOUND", "--allow-file-access-from-files",
         "--window-size=1300,2000",
         "--dump-dom", f"--user-data-dir={place / 'profile'}", f"file://{place / 'frames.html'}"],
        capture_output=True, text=True, timeout=120)
    assert shown.returncode == 0 and "CONSOLE" not in shown.stderr, shown.stderr
    seen = "0 0 12 true 0.200 4.000 0.200 4.000"
    assert f"360 360 {seen}; 1200 1200 {seen}" in shown.stdout, re.findall("360 .*", shown.stdout)


def test_the_scenes_microphones_stand_beside_the_vibration(base, folder):
    places = [{"x": 0.15, "y": 0.1, "z": 0.5}, {"x": 0.0, "y": 0.1, "z": 1.0}]
    heard = ra2d.run(base, {"output.microphones": places, "air.temperature": 25}, duration=0.2,
                     output=folder / "heard.h5", show=False)
    found = heard.analysis()["microphones"]
    text = read(heard.report(folder / "heard.html"))
    assert f"{found[1]['lpa']:.1f} dB(A)" in text and "0, 0.1, 1 m" in text
    figure = heard.plot("bands")
    drawn = figure.axes[1].get_lines()
    assert len(drawn) == 2 and "pressure" in figure.axes[1].get_ylabel()
    assert set(drawn[0].get_ydata()) <= set(found[0]["bands"]["level"]) and len(
        drawn[0].get_ydata()) > 10


def test_microphones_can_be_named_for_a_picture_and_a_page(result, folder):
    with pytest.raises(ra2d.RequestError, match="one microphone or more"):
        result.with_microphones([])
    heard = result.with_microphones([(0.15, 0.1, 0.5), (0, 0.1, 1)], temperature=30)
    found = heard.analysis()["microphones"]
    assert "microphones" not in result.analysis() and len(found) == 2
    assert heard.analysis()["air"]["sound_speed"] == pytest.approx(349, abs=0.5)
    # also where other places are asked for, as an array, too
    elsewhere = heard.analysis(at=np.array([[0.15, 0.1, 0.5]]))
    assert elsewhere["air"] == heard.analysis()["air"]
    assert elsewhere["microphones"][0]["lp"] == pytest.approx(found[0]["lp"], rel=1e-9)
    for wrong in ((0.15, 0.1, 0.5), [(0.15, 0.1)], [(0, 0, 1), (0, 1)], ["0,0,1"], 0.5):
        for use in (result.with_microphones, lambda at: result.analysis(at=at),
                    lambda at: result.listen(at=at)):
            with pytest.raises(ra2d.RequestError, match="expected microphones of three numbers"):
                use(wrong)
    figure = heard.plot("level", start=0.2, stop=0.6)
    line, *_ = figure.axes[1].get_lines()
    history = heard.analysis(start=0.2, stop=0.6)["microphones"][0]["history"]
    levels = 10 * np.log10(np.array(history["mean_square"]).reshape(100,
                                                                    2).mean(axis=1) / 20e-6 ** 2)
    assert line.get_ydata() == pytest.approx(levels) and line.get_label().startswith(
        "pressure at 0.15, 0.1, 0.5 m")
    text = read(heard.report(folder / "at.html"))
    (clip, rate), *velocities = sounds(text)
    assert (len(velocities) == 2 and rate == 48_000
            and "First the sound pressure at a microphone" in text)
    scale = float(re.search(r"Sound pressure at 0.15, 0.1, 0.5 m: .* Full scale is (\S+) Pa",
                            text)[1])
    # some above 22 kHz is left out
    assert scale * np.sqrt((clip ** 2).mean()) == pytest.approx(found[0]["p_rms"], rel=0.02)
    assert heard.listen(at=[(0, 0.1, 1)]).about["sound_speed"] == pytest.approx(349, abs=0.5)
    assert f"{found[1]['lpa']:.1f} dB(A)" in text and text.count(
        "Lines, axis on the right: sound pressure") == 2
    pages = [folder / "line.html", folder / "level.png"]
    for words in (["report", result.path, "-o", pages[0]],
                  ["plot", result.path, "--what", "level", "-o", pages[1]]):
        subprocess.run([ra2d.find(), *words, "--at", "0.15,0.1,0.5", "--temperature", "30",
                        "--quiet"], check=True)
    assert f"{found[0]['lpa']:.1f} dB(A)" in read(
        pages[0]) and "--at 0.15,0.1,0.5 --temperature 30" in read(pages[0])
    assert pages[1].read_bytes()[:4] == b"\x89PNG"
