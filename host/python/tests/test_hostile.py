# SPDX-License-Identifier: BSD-3-Clause
"""Wrong requests and damaged files: each is an error of this package, in a plain sentence with the
cure."""
import inspect
import math
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import threading
import time
import warnings
from concurrent.futures import ThreadPoolExecutor

import h5py
import numpy as np
import pytest
import seal  # tests/host (conftest.py)

import ra2d
from ra2d import charts, errors, files, program, studies, toml

BENCH = pathlib.Path(__file__).resolve().parents[3] / "bench"


@pytest.fixture(scope="module")
def small(base, folder):
    return ra2d.run(base, duration=0.01, output=folder / "hostile.h5", show=False)


@pytest.fixture
def damaged(small, tmp_path):
    """A copy of a result, opened after something was done to it."""
    def make(damage):
        path = tmp_path / "damaged.h5"
        shutil.copy(small.path, path)
        with h5py.File(path, "r+") as file:
            damage(file)
        return ra2d.load(path)
    return make


def until(condition):
    end = time.monotonic() + 20
    while not condition() and time.monotonic() < end:
        time.sleep(0.01)


def test_the_program_s_cure_is_told_in_python():
    with pytest.raises(ra2d.RequestError, match="right end(?s:.*)In Python: duration=0.9$"):
        ra2d.run("dang2012", speed=0.2, tolerance=1e-6, show=False)
    # the cure cures
    assert ra2d.scene("dang2012").change(speed=0.2, tolerance=1e-6, duration=0.9).plan()


def as_texts_of_table(file):
    shape = file.pop("peak_force_median").shape
    file["peak_force_median"] = np.full(shape, "a", dtype=object)


@pytest.mark.parametrize("damage", [lambda file: file.pop("message"),
                                    lambda file: file.pop("status"),
                                    lambda file: file.attrs.pop("runs"),
                                    lambda file: file.attrs.pop("study"),
                                    as_texts_of_table,
                                    lambda file: file.attrs.update(failed="none")])
def test_a_table_that_lacks_something(study, tmp_path, damage):
    path = tmp_path / "results.h5"
    shutil.copy(study.folder / "results.h5", path)
    with h5py.File(path, "r+") as file:
        damage(file)
    with pytest.raises(ra2d.FileError, match="no table of a study, or is damaged$"):
        ra2d.load_study(path)


@pytest.mark.skipif(not BENCH.is_dir(), reason="the source's tables are not here")
def test_a_chart_says_what_was_not_measured(tmp_path):
    points, long_runs = tmp_path / "a.csv", tmp_path / "a-long.csv"
    points.write_text(re.sub(",state-20,[^,]*,", ",state-20,,",
                             (BENCH / "accuracy.csv").read_text()))
    lines = (BENCH / "accuracy-long.csv").read_text().splitlines(keepends=True)
    heads = sum(line.startswith("#") for line in lines) + 1
    long_runs.write_text("".join(lines[:heads]))
    figure = charts.picture("accuracy", [points, long_runs])
    words = [text.get_text()
             for text in figure.findobj(lambda artist: type(artist).__name__ == "Text")]
    assert words.count("no scheme was measured here") == 1
    assert any("no long runs" in text for text in words)


@pytest.mark.parametrize("chart, tables", [("stability", 3), ("accuracy", 2)])
def test_tables_of_charts_that_are_others(tmp_path, chart, tables):
    """No words of Python."""
    table = tmp_path / "chart.csv"
    with pytest.raises(ra2d.FileError,
                       match=f"^cannot read '{table}': No such file or directory$"):
        charts.picture(chart, [table] * tables)
    table.write_text("scheme,step\nrk4,1\n")
    words = r"is not what 'ra2d chart' writes( \(no '\w+'\))?: make the chart again$"
    with pytest.raises(ra2d.FileError, match=words):
        charts.picture(chart, [table] * tables)
    table.write_bytes(b"\xff\xfe\x80abc")
    with pytest.raises(ra2d.FileError, match="what 'ra2d chart' writes: make the chart again$"):
        charts.picture(chart, [table] * tables)


def test_options_are_told_in_python(base, small):
    with pytest.raises(ra2d.RequestError, match="In Python: .*force=True"):
        ra2d.run(base, duration=0.005, output=small.path, show=False)
    with pytest.raises(ra2d.RequestError, match="In Python: checkpoint=") as fault:
        ra2d.run(base, checkpoint=-1, show=False)
    assert "--help" not in str(fault.value)
    for wrong, words in ((lambda: small.spectrum(segment=3), "--segment 3.*\nIn Python: segment="),
                         (lambda: small.listen(0), "--probe 0: .*\nIn Python: probe="),
                         (lambda: small.listen(start=0, stop=1e-5),
                          "\nIn Python: start=..., stop=..., slow=")):
        with pytest.raises(ra2d.RequestError, match=words) as fault:
            wrong()
        assert "In Python" not in fault.value.args[0]  # which the program's own commands say
    with pytest.warns(ra2d.Notice, match="--full-scale .*\nIn Python: full_scale="):
        small.listen(full_scale=1e6).save(small.path.with_suffix(".wav"))


@pytest.mark.parametrize("command, function", [
    ("run", ra2d.run), ("study", ra2d.study), ("uncertainty", ra2d.uncertainty),
    ("analyze", ra2d.Result.analysis), ("plot", ra2d.Result.plot), ("sound", ra2d.Result.listen),
    ("plot", ra2d.Result.with_microphones)])
def test_every_option_that_is_an_argument_is_named_by_it(command, function):
    for option in re.findall(r"^ +(?:-\w, +)?--([a-z-]+)", program.call(command, "--help"), re.M):
        name = {"from": "start", "to": "stop"}.get(option, option.replace("-", "_"))
        if name in inspect.signature(function).parameters:
            assert f"In Python: {name}=" in errors.for_python(f"--{option} is wrong")


@pytest.mark.parametrize("value", [None, 1j, {1, 2}, object(), "\udcff",
                                   (x for x in [0.1])])
def test_values_that_no_scene_holds(base, value):
    with pytest.raises(ra2d.RequestError, match="a scene holds|cannot stand in a scene"):
        ra2d.run(base, speed=value, show=False)


@pytest.mark.parametrize("source, words", [
    (3, "not int"), (None, "not NoneType"), ({"scene": 3}, "expected a section"),
    ({"speed": 0.1}, "expected a section"),
    ({1: {}}, "keys of a scene are texts"), ("[scene]\nspeed = 1", "write the text to a file"),
    ("", "no such file"), ("dang2012.toml", "'dang2012', without an ending")])
def test_what_is_no_scene(source, words):
    with pytest.raises(ra2d.RequestError, match=words):
        ra2d.scene(source)


def test_a_scene_from_numpy_runs(base, folder):
    content = base.change(duration=1e-3).content()
    content["scene"] |= {"speed": np.float64(0.1), "name": "räuber \"x\"/../\u65e5\n" + "y" * 400}
    content["output"] = {"probes": np.array([0.1, 0.2])}
    content["slider"]["surface"]["seed"] = np.int64(4)
    ran = ra2d.run(content, show=False)
    assert ran.probes.sizes["position"] == 2 and ran.scene["slider.surface.seed"] == 4
    assert ran.path.parent == folder and len(ran.path.name.encode()) < 200


def test_faults_of_a_dict_do_not_name_a_file_that_is_gone():
    with pytest.raises(ra2d.RequestError, match=r"^scene-\w+.toml: 5 faults"):
        ra2d.run({}, show=False)


def test_keys_beyond_emoji_are_toml():
    assert toml.parse(toml.document({"a": {"\U0001f600 x": 1}})) == {"a": {"\U0001f600 x": 1}}


@pytest.mark.parametrize("text", ["a = " + "[" * 100_000, "a = " + "9" * 10_000],
                         ids=["nest", "integer"])
def test_toml_without_end(text):
    with pytest.raises(ra2d.RequestError, match="the scene is no TOML: "):
        toml.parse(text)


def test_scenes_that_cannot_be_read(tmp_path, base):
    bad = tmp_path / "bad.toml"
    bad.write_text("[scene\n")
    with pytest.raises(ra2d.RequestError, match="bad.toml.* is no TOML"):
        ra2d.scene(bad)["speed"]
    bad.write_bytes(b"# \xe9\n")
    with pytest.raises(ra2d.FileError, match="no text in UTF-8"):
        ra2d.scene(bad).text()
    with pytest.raises(KeyError, match="complete"):
        base["time.nodes"]
    with pytest.raises(ra2d.RequestError, match="speed is a value"):
        base.change({"scene.speed.x": 3}).content()


def test_other_alphabets_in_paths(base, tmp_path):
    place = tmp_path / "ünï \u65e5\u672c"
    place.mkdir()
    ran = ra2d.run(base, duration=2e-3, output=place / "é.h5", show=False)
    assert ran.level > 0 and ran.listen().save(place / "é.wav").is_file() and ra2d.load(
        place / "é.h5").complete


def test_folders_that_are_not_there(base, small, tmp_path):
    missing = tmp_path / "no"
    for write in (lambda: ra2d.study(base, {"speed": [0.1]}, folder=missing / "study", show=False),
                  lambda: ra2d.surface.array([0, 1e-6], 1e-6, missing / "x.csv"),
                  lambda: small.report(missing / "x.html"),
                  lambda: small.listen().save(missing / "x.wav")):
        with pytest.raises(ra2d.FileError, match="there is no folder .* Make it first"):
            write()
    with pytest.raises(ra2d.FileError, match="no folder 'no'"):
        ra2d.run(base, output="no/x.h5", show=False)


def test_a_folder_that_cannot_be_written():
    with pytest.raises(ra2d.FileError, match="cannot write '/proc/x.toml'"):
        files.write(pathlib.Path("/proc/x.toml"), "")


@pytest.mark.parametrize("vary, words",
                         [({"speed": 0.1}, "list of values"), ({"speed": "0.1"}, "list of values"),
                          (["speed"], "expected keys with their values")])
def test_wrong_variations(base, vary, words):
    with pytest.raises(ra2d.RequestError, match=words):
        ra2d.study(base, vary, show=False)


@pytest.mark.parametrize("damage", [
    lambda file: file.attrs.__delitem__("format"), lambda file: file.attrs.__delitem__("scene"),
    lambda file: file.attrs.__delitem__("complete"),
    lambda file: file.attrs.__setitem__("scene", "[x"),
    lambda file: file.attrs.__setitem__("scene", "scene = 5"),
    lambda file: file.attrs.__setitem__("scene", ""),
    lambda file: file.attrs.__setitem__("scene", file.attrs["scene"] + "\n[[output]]"),
    lambda file: file.attrs.__setitem__("scene", re.sub("from = .*", 'from = "a"',
                                                        str(file.attrs["scene"]))),
    lambda file: file.attrs.__setitem__("scene", re.sub("speed = .*", "speed = []",
                                                        str(file.attrs["scene"]))),
    lambda file: file.attrs.__setitem__("scene", re.sub("start = .*", "start = nan",
                                                        str(file.attrs["scene"]))),
    lambda file: file.attrs.__setitem__("format", [3, 3]),
    lambda file: file.attrs.__setitem__("complete", [1, 1])])
def test_damaged_headers(damaged, damage):
    with pytest.raises(ra2d.FileError, match="is damaged|has format None"):
        damaged(damage)


def scalar_probes(file):
    del file["probes"]
    file["probes"] = 3


def short_probes(file):
    del file["probes/velocity"]
    file["probes/velocity"] = np.zeros((3, 4))


@pytest.mark.parametrize("damage", [scalar_probes, short_probes])
def test_damaged_groups(damaged, damage):
    with pytest.raises(ra2d.FileError, match="'ra2d check' says what of it"):
        damaged(damage).probes


def without(name):
    return lambda file: file.__delitem__(name)


def as_texts(name):
    def replace(file):
        size = file[name].shape[0]
        del file[name]
        file[name] = ["a"] * size
    return replace


def time_with(value):
    return lambda file: file["time"].__setitem__(100, value)


def filled(name, value):
    return lambda file: file[name].__setitem__(..., value)


def elsewhere(name):
    """Its numbers are bytes of another file, which no seal covers."""
    def replace(file):
        size = file[name].shape[0]
        del file[name]
        file.create_dataset(name, (size,), float, external=[(sys.executable, 0, 8 * size)])
    return replace


@pytest.mark.parametrize("damage, read", [
    (without("resonator/shape"), lambda result: result.field(0.001)),
    (without("resonator/frequency"), lambda result: result.listen()),
    (as_texts("resonator/frequency"), lambda result: result.listen()),
    (without("probes/velocity"), lambda result: result.listen()),
    (as_texts("probes/position"), lambda result: result.listen()),
    (without("surface/slider/height"), lambda result: result.profile("slider")),
    (without("contact/force"), lambda result: result.contact),
    (without("energy/kinetic"), lambda result: result.energy),
    (as_texts("resonator/displacement"), lambda result: result.field(0.001)),
    (time_with(math.nan), lambda result: result.field(0.001)),
    (time_with(1e300), lambda result: result.field(slice(0.001, 0.002))),
    (time_with(0.0), lambda result: result.field(0.001)),
    (time_with(0.0), lambda result: result.contact),
    (filled("resonator/shape", math.nan), lambda result: result.field(0.001)),
    (filled("energy/kinetic", math.inf), lambda result: result.energy.load()),
    (filled("resonator/velocity", 1e300), lambda result: result.field(0.001, what="velocity")),
    (filled("surface/slider/height", math.nan), lambda result: result.profile("slider").load()),
    (filled("surface/resonator/position", 0.0), lambda result: result.profile()),
    (filled("resonator/position", 1.0), lambda result: result.modes()),
    (elsewhere("contact/force"), lambda result: result.contact)])
def test_damaged_series(damaged, damage, read):
    with pytest.raises(ra2d.FileError, match="'ra2d check' says what of it"):
        read(damaged(damage))


@pytest.fixture
def forged(small, tmp_path):
    """As `damaged`, with a seal that fits."""
    def make(damage):
        path = tmp_path / "forged.h5"
        path.write_bytes(seal.without_seal(small.path.read_bytes()))
        with h5py.File(path, "r+") as file:
            damage(file)
        path.write_bytes(path.read_bytes() + seal.seal_of(path.read_bytes()))
        return ra2d.load(path)
    return make


def test_a_link_to_another_file_is_not_followed(forged, small):
    def link(file):
        del file["contact/force"]
        file["contact/force"] = h5py.ExternalLink(str(small.path), "/contact/force")

    for use in (lambda result: result.level, ra2d.Result.check):
        with pytest.raises(ra2d.FileError, match="/contact/force is missing"):
            use(forged(link))


def linked(name, make):
    def replace(file):
        del file[name]
        file[name] = make(name)
    return replace


def virtual(name, source):
    """Its numbers are those of another file, over which h5py waited without end."""
    def replace(file):
        shape = file[name].shape
        units = file[name].attrs["units"]
        del file[name]
        layout = h5py.VirtualLayout(shape=shape, dtype="f8")
        layout[...] = h5py.VirtualSource(str(source), name, shape=shape)
        file.create_virtual_dataset(name, layout)
        file[name].attrs["units"] = units
    return replace


READ = """
import sys
import ra2d
result = ra2d.load(sys.argv[1])
for read in (lambda: result.shocks, lambda: result.summary, lambda: result.duration,
             lambda: result.height_hash(), lambda: result.contact.load()):
    try:
        read()
    except ra2d.FileError as fault:
        print(fault)
"""


def test_every_number_is_one_of_the_file_s_own(forged, small):
    """In a process of its own, which can be ended."""
    places = ("shocks/impulse", "summary/energy_closure", "time", "surface/resonator/height",
              "contact/force")
    for damages, words in (
            ([virtual(name, small.path) for name in places], "is kept in other files"),
            ([elsewhere(name) for name in places if "summary" not in name],
             "is kept in other files"),
            ([linked(name, lambda name: h5py.ExternalLink(str(small.path), name))
              for name in places], "is a link to something else"),
            ([linked(name, lambda name: h5py.SoftLink("/" + name)) for name in places],
             "is a link to something else")):
        path = forged(lambda file: [damage(file) for damage in damages]).path
        said = subprocess.run([sys.executable, "-c", READ, str(path)], capture_output=True,
                              text=True, check=True, timeout=60).stdout.splitlines()
        assert len(said) == len(damages), said
        assert all(words in line and "'ra2d check' says" in line for line in said), said


def reshaped(name, *shape, **options):
    """Chunks of which none is written."""
    def replace(file):
        of, units = file[name].dtype, file[name].attrs["units"]
        del file[name]
        file.create_dataset(name, shape, of, chunks=(min(shape[0], 1024),), **options)
        file[name].attrs["units"] = units
    return replace


@pytest.mark.parametrize("name, read", [
    ("summary/nodes_evaluated", lambda result: result.summary),
    ("summary/lv", lambda result: result._repr_html_() and result.summary),
    ("shocks/duration", lambda result: result.shocks),
    ("shocks/shock", lambda result: result.shocks), ("time", lambda result: result.energy),
    ("time", lambda result: result.duration), ("contact/force", lambda result: result.contact),
    ("resonator/position", lambda result: result.field(0.001)),
    ("probes/velocity", lambda result: result.listen()),
    ("surface/slider/height", lambda result: result.profile("slider"))])
def test_numbers_that_the_file_has_no_room_for(forged, name, read):
    """They ended with Python's MemoryError, or filled the memory."""
    for shape, options in (((2**40,), {}), ((10**9,), {"compression": "gzip"})):
        result = forged(reshaped(name, *shape, **options))
        with pytest.raises(ra2d.FileError,
                           match=f"/{name} should hold more numbers than the file has room for"):
            read(result)


def test_figures_and_columns_of_another_shape(forged):
    with pytest.raises(ra2d.FileError, match=r"/summary/lv is of the shape \(3,\), not of 0 axes"):
        forged(reshaped("summary/lv", 3)).summary
    result = forged(reshaped("shocks/duration", 3))
    with pytest.raises(ra2d.FileError, match="'shock'"):
        result.shocks


def test_energies_over_a_time_of_another_length(forged):
    def shorten(file):
        del file["time"]
        file["time"] = [0.0, 0.1, 0.2]

    with pytest.raises(ra2d.FileError, match="'time'(?s:.*)'ra2d check' says"):
        forged(shorten).energy


def test_a_table_of_a_study_of_another_shape(study, tmp_path):
    table = tmp_path / "results.h5"
    for shape, words in (((2**40,), "/v_rms should hold more numbers than the file has room for"),
                         ((3,), "'ra2d check' says")):
        table.write_bytes(seal.without_seal((study.folder / "results.h5").read_bytes()))
        with h5py.File(table, "r+") as file:
            reshaped("v_rms", *shape)(file)
        table.write_bytes(table.read_bytes() + seal.seal_of(table.read_bytes()))
        with pytest.raises(ra2d.FileError, match=words):
            studies._table(table)


def test_a_table_of_a_study_with_lists(study, tmp_path):
    """Of another length each: its text ended with an error of xarray."""
    table = tmp_path / "results.h5"
    shutil.copy(study.folder / "results.h5", table)
    with h5py.File(table, "r+") as file:
        shape = file["speed"].shape
        del file["speed"]
        file.create_dataset("speed", shape, h5py.vlen_dtype("f8"))
    with pytest.raises(ra2d.FileError, match="/speed has neither numbers nor texts"):
        studies._table(table)


def last_time(value):
    return lambda file: file["time"].__setitem__(-1, value)


@pytest.mark.parametrize("damage", [filled("time", 0.0), without("time"), last_time(math.nan),
                                    last_time(math.inf), last_time(1e-320)])
def test_ends_of_a_run_that_are_none(forged, damage):
    result = forged(damage)
    for read in (lambda: result.rate, lambda: result.duration, lambda: result.samples):
        with pytest.raises(ra2d.FileError, match="/time (does not rise|is missing). 'ra2d check'"):
            read()
    assert "is damaged" in repr(result)


def test_a_table_whose_numbers_stand_in_another_file(study, tmp_path):
    table = tmp_path / "results.h5"
    table.write_bytes(seal.without_seal((study.folder / "results.h5").read_bytes()))
    with h5py.File(table, "r+") as file:
        shape = file["v_rms"].shape
        del file["v_rms"]
        file.create_dataset("v_rms", shape, float, external=[(sys.executable, 0, 8 * 1000)])
    table.write_bytes(table.read_bytes() + seal.seal_of(table.read_bytes()))
    for use in (lambda: program.call("analyze", tmp_path), lambda: ra2d.load_study(tmp_path)):
        with pytest.raises(ra2d.FileError, match="/v_rms is kept in other files"):
            use()


def test_pictures_of_places_that_do_not_rise(forged):
    for name, what in (("surface/resonator/position", "overview"), ("resonator/position", "motion"),
                       ("surface/slider/position", "profiles")):
        with pytest.raises(ra2d.FileError, match=f"{name} does not rise. 'ra2d check' says"):
            forged(filled(name, 0.0)).plot(what)
        with pytest.raises(ra2d.FileError, match=f"{name} does not rise: it is damaged"):
            forged(filled(name, 0.0)).check()


def test_results_of_programs_whose_faces_were_linear_by_default(damaged):
    def forget(file):
        file.attrs["scene"] = re.sub('faces = "[a-z]+"\n', "", str(file.attrs["scene"]))
    assert damaged(forget).scene["faces"] == "linear"


def read_all(result):
    repr(result)
    for data in (result.summary, result.probes, result.slider_probes, result.contact,
                 result.energy, result.modes(), result.modes("slider"), result.profile(),
                 result.profile("slider")):
        data.load()
    return result.shocks, result.height_hash(), result.height_hash("slider")


def test_every_byte_that_is_read_is_compared_with_the_seal(small, tmp_path):
    whole, path = small.path.read_bytes(), tmp_path / "flipped.h5"
    sealed = int(whole[-64:][12:30])
    read_all(small)
    # where HDF5 has its addresses a wrong byte would end the interpreter
    marks = [found.start() for found in re.finditer(b"OHDR|TREE|HEAP|FRHP|FHDB|BTHD|BTLF|OCHK",
                                                    whole[:sealed])]
    random = np.random.default_rng(3)
    for _ in range(60):
        at = int(random.choice(marks)) + int(random.integers(0, 160))
        path.write_bytes(whole[:at] + bytes([whole[at] ^ int(random.integers(1, 256))])
                         + whole[at + 1:])
        with pytest.raises(ra2d.FileError, match="is damaged|its bytes from"):
            read_all(ra2d.load(path))
    # where it cannot be opened at all, the interpreter ends well
    path.write_bytes(whole[:600] + bytes([whole[600] ^ 1]) + whole[601:])
    done = subprocess.run([sys.executable, "-c", f"import ra2d\ntry: ra2d.load({str(path)!r})\n"
                           "except ra2d.FileError as fault: kept = fault"], check=False)
    assert done.returncode == 0
    # the seal itself
    path.write_bytes(whole[:sealed] + bytes([whole[sealed] ^ 1]) + whole[sealed + 1:])
    with pytest.raises(ra2d.FileError, match="its seal does not fit"):
        ra2d.load(path)


def test_of_a_file_without_a_seal_it_is_said(small, tmp_path):
    """Its last bytes cut off, it opens: nothing tells then whether a number is the run's."""
    path = tmp_path / "cut.h5"
    path.write_bytes(small.path.read_bytes()[:-64])
    with pytest.warns(ra2d.Notice, match="has no seal at its end(?s:.*)run its scene again"):
        ra2d.load(path)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ra2d.load(small.path)


def test_flipped_bits_and_cut_files(small, tmp_path):
    whole, path = small.path.read_bytes(), tmp_path / "flipped.h5"
    refused = 0
    for at in range(0, 4000, 97):
        path.write_bytes(whole[:at] + bytes([whole[at] ^ 255]) + whole[at + 1:])
        try:
            ra2d.load(path).probes.load()
        except ra2d.FileError:
            refused += 1
    assert refused > 10
    middle = len(whole) // 2
    path.write_bytes(whole[:middle] + bytes([whole[middle] ^ 1]) + whole[middle + 1:])
    with pytest.raises(ra2d.FileError, match="damaged"):
        ra2d.load(path).check()
    path.write_bytes(whole[:middle])
    with pytest.raises(ra2d.FileError, match="truncated"):
        ra2d.load(path)


def test_a_file_that_was_deleted_or_replaced(base, small, tmp_path):
    """Never the numbers of another run."""
    path = tmp_path / "moving.h5"
    shutil.copy(small.path, path)
    opened = ra2d.load(path)
    lazy = opened.probes
    ra2d.run(base, duration=0.005, output=path, force=True, show=False)
    for use in (lambda: opened.level, lambda: lazy.velocity.load(), lambda: opened.shocks,
                opened.listen):
        with pytest.raises(ra2d.FileError,
                           match="has been replaced since it was opened: open it again"):
            use()
    path.unlink()
    with pytest.raises(ra2d.FileError, match="there is no such file"):
        opened.probes


def test_wrong_parts_of_a_result(small, monkeypatch):
    for use in (lambda: small.modes("table"), lambda: small.field(0, body="table"),
                lambda: small.profile("table"),
                lambda: small.listen(body="table"), lambda: small.field(0, what="table")):
        with pytest.raises(ra2d.RequestError, match="'table': expected '"):
            use()
    for time_ in (99.0, -1.0, float("nan"), [0.001, 0.02]):
        with pytest.raises(ra2d.RequestError, match="the samples go from 0 to 0.01 s"):
            small.field(time_)
    for time_ in (slice(0.002, 0.001), slice(5, 6), slice(float("nan"), None)):
        with pytest.raises(ra2d.RequestError, match="there is no sample, they go from 0 to 0.01 s"):
            small.field(time_)
    for time_ in (slice("a", "b"), slice(0, 0.01, 10)):
        with pytest.raises(ra2d.RequestError, match="expected a slice of two numbers"):
            small.field(time_)
    with pytest.raises(ra2d.RequestError, match="expected numbers"):
        small.field("now")
    monkeypatch.setattr("os.sysconf", lambda name: 1000)
    with pytest.raises(ra2d.RequestError, match="ask for a shorter time"):
        small.field(slice(None))


def test_threads_write_into_one_folder(tmp_path, monkeypatch):
    """Each its own file: a face of one thread had the heights of another."""
    both, write = threading.Barrier(2, timeout=20), pathlib.Path.write_bytes

    def write_and_wait(path, data):
        write(path, data)
        both.wait()

    monkeypatch.setattr(pathlib.Path, "write_bytes", write_and_wait)
    with ThreadPoolExecutor(2) as pool:
        list(pool.map(lambda name: files.write(tmp_path / name, name), "ab"))
    assert {file.name: file.read_text() for file in tmp_path.iterdir()} == {"a": "a", "b": "b"}


def test_threads_keep_their_notices_apart(base):
    """Those of one were taken for the other's, or Notices were ignored from then on."""
    both, scene = threading.Barrier(2, timeout=20), base.change(speed="100 mm/s")

    def keep(text):
        with errors.kept_notices() as kept:
            both.wait()
            errors.notice(text)
            both.wait()
        return kept

    before = list(warnings.filters)
    with ThreadPoolExecutor(2) as pool:
        assert list(pool.map(keep, "ab")) == [["a"], ["b"]]
        assert set(pool.map(lambda _: scene["speed"], range(12))) == {0.1}
    assert warnings.filters == before
    with pytest.warns(ra2d.Notice, match="afterwards"):
        errors.notice("afterwards")


def test_sounds_and_pictures_that_cannot_be(small):
    for name, bits, words in (("x.mp9", 24, "ends in .wav or .flac"),
                              ("x.wav", 99, "expected 16, 24, 32 or 'float'")):
        with pytest.raises(ra2d.RequestError, match=words):
            small.listen().save(name, bits)
    for options, words in (({"rate": 44100.5}, "rate is 44100.5: expected a whole number"),
                           ({"probe": 1.5}, "expected 1 to 1"), ({"probe": "1"}, "expected 1 to 1"),
                           ({"start": "0.001"}, "start is '0.001': expected a time"),
                           ({"start": -1}, "from -1 s: the run begins at 0 s"),
                           ({"stop": np.nan}, "stop is nan: expected a time"),
                           ({"full_scale": 1, "normalize": True}, "give one of them")):
        with pytest.raises(ra2d.RequestError, match=words):
            small.listen(**options)
    made = small.listen(np.int64(1), rate=np.int64(44100), slow=np.float32(2),
                        full_scale=np.float32(0.5))
    assert made.rate == 44100 and '"full_scale_m_per_s": 0.5' in made.about_text("x.wav")
    for wrong in ([], ["hostile.h5"]):
        with pytest.raises(ra2d.RequestError, match="one or more results"):
            ra2d.plot(wrong)
    assert ra2d.plot(small, "bands").axes


@pytest.mark.parametrize("name, value", [("temperature", 2000), ("temperature", -51),
                                         ("temperature", "warm"), ("pressure", 9999.0),
                                         ("pressure", 1.1e6)])
def test_air_that_the_program_would_refuse_is_refused_at_once(small, name, value):
    with pytest.raises(ra2d.RequestError) as said:
        program.call("analyze", small.path, "--at", "0,0,1", f"--{name}", value)
    with pytest.raises(ra2d.RequestError, match=re.escape(str(said.value))):
        small.with_microphones([(0, 0, 1)], **{name: value})
    assert small.with_microphones([(0, 0, 1)], temperature=-50, pressure=1e6).analysis()


def test_heights_that_are_none():
    for heights, spacing, words in ((["a", "b"], 1e-6, "row of heights"),
                                    ([0, 1j], 1e-6, "row of heights"),
                                    (np.array([0, 1j]), 1e-6, "complex"),
                                    (np.ma.masked_greater([0, 1e-6, 5.0], 1), 1e-6, "masked"),
                                    ([0, 1e-6], "a", "spacing is 'a'"),
                                    ([0, 1e-6], np.inf, "spacing is inf")):
        with pytest.raises(ra2d.RequestError, match=words):
            ra2d.surface.array(heights, spacing)
    face = ra2d.surface.gaussian(rq=1e-6, rsm=1e-3, seed=1)
    for sizes, words in (({"width": 0}, "width is 0: expected a number > 0"),
                         ({"width": 0.001, "spacing_y": 0}, "spacing_y is 0"),
                         ({"spacing": "8 um"}, "spacing is '8 um'"),
                         ({"spacing_y": 1e-4}, "give its width, too")):
        with pytest.raises(ra2d.RequestError, match=words):
            face.heights(**{"length": 0.01, "spacing": 1e-4, **sizes})


def test_a_table_that_is_damaged(tmp_path):
    with h5py.File(tmp_path / "results.h5", "w") as file:
        file.attrs["study_format"] = 1
    with pytest.raises(ra2d.FileError, match="no table of a study"):
        ra2d.load_study(tmp_path)
    with h5py.File(tmp_path / "results.h5", "w") as file:
        file.attrs["study_format"], file.attrs["dimensions"] = 2, "speed seed"
    with pytest.raises(ra2d.FileError, match="has format 2, this package reads 1"):
        ra2d.load_study(tmp_path)


def children():
    """Process numbers of the children of this process; libraries may have some of their own."""
    found = set()
    for file in pathlib.Path("/proc").glob("[0-9]*/stat"):
        try:
            parent = file.read_text().rpartition(")")[2].split()[1]
        except OSError:  # it has ended
            continue
        if int(parent) == os.getpid():
            found.add(file.parent.name)
    return found


def test_an_interrupted_study_ends_in_order(folder):
    """KeyboardInterrupt is raised, and no program is left behind."""
    place = folder / "interrupted"

    def interrupt():
        until(place.is_dir)
        os.kill(os.getpid(), signal.SIGINT)

    slow = ra2d.scene("dang2012").change(duration=0.9)  # backward Euler: seconds
    interrupter = threading.Thread(target=interrupt)
    before, others = os.times().children_user, children()
    interrupter.start()
    with pytest.raises(KeyboardInterrupt):
        ra2d.study(slow, {"speed": [0.1, 0.11]}, folder=place, threads=1, show=False)
    interrupter.join()
    assert os.times().children_user - before < 1.5  # it did not run to its end
    assert children() <= others


def test_an_interrupt_while_the_program_begins(folder, monkeypatch):
    """As above: it is handed on to a program that has only just been made."""
    popen, begun = subprocess.Popen, []

    def begin(*args, **kwargs):
        child = popen(*args, **kwargs)
        signal.raise_signal(signal.SIGINT)
        begun.append(child)
        return child

    monkeypatch.setattr(subprocess, "Popen", begin)
    slow = ra2d.scene("dang2012").change(duration=0.9)
    others = children()
    with pytest.raises(KeyboardInterrupt):
        ra2d.run(slow, output=folder / "begins.h5", show=False)
    assert [child.returncode is not None for child in begun] == [True]
    assert children() <= others


def test_a_second_interrupt_reaches_the_program(tmp_path, monkeypatch):
    """A program that ends in order takes its time; the second Ctrl-C is handed on, too."""
    slow = tmp_path / "slow-ra2d"
    slow.write_text("""#!/bin/sh
[ "$1" = --version ] && echo "ra2d 0.1.0 (x)" && exit
trap 'n=x$n; touch "$2/$n"; [ $n = xx ] && exit 130' INT
touch "$2/ready"
while :; do sleep 0.02; done
""")
    slow.chmod(0o755)
    monkeypatch.setenv("RA2D", str(slow))

    def interrupt():
        for sign in ("ready", "x"):
            until((tmp_path / sign).exists)
            os.kill(os.getpid(), signal.SIGINT)

    interrupter = threading.Thread(target=interrupt)
    interrupter.start()
    with pytest.raises(KeyboardInterrupt):
        program.follow(["run", tmp_path], lambda text: None)
    interrupter.join()
    assert (tmp_path / "xx").exists()
