# SPDX-License-Identifier: BSD-3-Clause
"""`ra2d plot`, `sound` and `report`: the program reads the line, this package answers it. Each
command is tried with a Python of its own (`environment={}`), and all that is asked of it beside
that with one that starts quickly."""
import errno
import io
import json
import os
import pathlib
import shutil
import signal
import subprocess
import time
import warnings

import pytest
import soundfile

from ra2d import commands, program


WARM = {}


@pytest.fixture(scope="module", autouse=True)
def _warm(warm):
    WARM.update(warm)


def ra2d(folder, *words, environment=None, shell=None, text=True):
    command = ["/bin/sh", "-c", shell, str(program.find()),
               *words] if shell else [program.find(), *words]
    if environment is None:
        environment = {} if shell else WARM
    return subprocess.run(command, cwd=folder, capture_output=True, text=text,
                          env=os.environ | environment)


@pytest.fixture
def place(small, tmp_path):
    shutil.copy(small.path, tmp_path / "out.h5")
    return tmp_path


@pytest.fixture(scope="session")
def small(base, folder):
    import ra2d as package
    return package.run(base, {"output.probes": [0.15]}, duration=0.01,
                       output=folder / "small.h5", show=False)


def names(place):
    return sorted(file.name for file in place.iterdir())


def test_sound_of_a_run(place):
    said = ra2d(place, "sound", "out.h5", "--slow", "2", environment={})
    assert said.returncode == 0 and said.stderr == ""
    assert ("m/s" in said.stdout and "20 ms, 961 samples" in said.stdout
            and "out.wav.json" in said.stdout)
    assert soundfile.info(place / "out.wav").frames == 961
    assert json.loads((place / "out.wav.json").read_text())["file"] == "out.wav"
    before = (place / "out.wav").read_bytes()
    assert ra2d(place, "sound", "out.h5", "--slow", "2", "--quiet").stdout == ""
    assert (place / "out.wav").read_bytes() == before
    assert ra2d(place, "sound", "out.h5", "--bits", "float", "-o", "f.WAV").returncode == 0
    assert soundfile.info(place / "f.WAV").subtype == "FLOAT"
    coarse = ra2d(place, "sound", "out.h5", "--bits", "16", "--full-scale", "1e3", "-o", "f.WAV")
    assert coarse.returncode == 0 and "below a step of 16 bits" in coarse.stderr
    for wrong in (("--bits", "16", "-o", "x.flac"), ("--rate", "96001", "-o", "x.flac"),
                  ("--bits", "8"), ("-o", "x.mp3"),
                  ("--probe", "2"), ("--rate", "1"),
                  ("--full-scale", "1", "--normalize"), ("--probe", "99999999999999999999"),
                  ("--to", "7")):
        said = ra2d(place, "sound", "out.h5", *wrong)
        assert said.returncode == 2 and said.stdout == "" and wrong[1] in said.stderr or wrong[
            0] in said.stderr
    assert names(place) == ["f.WAV", "f.WAV.json", "out.h5", "out.wav", "out.wav.json"]
    # of other sources: none takes the name of another
    for more in (("--at", "0.15,0.1,0.5"), ("--at", "0,0,0.1", "--at", "0.3,0,-0.2")):
        assert ra2d(place, "sound", "out.h5", *more).returncode == 0
    assert (place / "out.wav").read_bytes() == before
    made = [name for name in names(place) if "-at-" in name and name.endswith(".wav")]
    assert made == ["out-at-0,0,0.1-at-0.3,0,-0.2.wav", "out-at-0.15,0.1,0.5.wav"]


def test_a_sound_is_made_where_nobody_can_be_told_of_doubts(place):
    """As other commands do; it ended with 4, and with no file."""
    said = ra2d(place, "sound", "out.h5", "--bits", "16", "--full-scale", "1e3", "-o", "full.wav",
                shell='exec "$0" "$@" 2>/dev/full')
    assert said.returncode == 0 and "full.wav.json" in said.stdout
    assert names(place) == ["full.wav", "full.wav.json", "out.h5"]
    # a message that is lost is no other exit status
    said = ra2d(place, "sound", "out.h5", "--rate", "65537", "-o", "x.flac",
                shell='exec "$0" "$@" 2>/dev/full')
    assert said.returncode == 2


def test_names_of_sounds_are_printed_in_one_line(place):
    said = ra2d(place, "sound", "out.h5", "-o", "a\nb.wav")
    assert said.returncode == 0 and r"a\u000Ab.wav.json" in said.stdout
    assert len(said.stdout.splitlines()) == 7


def test_a_sound_that_cannot_be_written_leaves_nothing(place):
    for name in ("noise.wav", "noise.flac"):
        said = ra2d(place, "sound", "out.h5", "-o", name, "--slow", "100",
                    shell='ulimit -f 8; trap "" XFSZ; exec "$0" "$@"')
        assert said.returncode == 4 and "File too large" in said.stderr and name in said.stderr
        assert names(place) == ["out.h5"]
    (place / "noise.wav.json").mkdir()
    assert ra2d(place, "sound", "out.h5", "-o", "noise.wav").returncode == 2
    assert names(place) == ["noise.wav.json", "out.h5"]


def test_no_output_is_the_result_itself(place):
    shutil.copy(place / "out.h5", place / "x.wav")
    shutil.copy(place / "out.h5", place / "y.wav.json")
    for words in (("sound", "x.wav", "-o", "x.wav"), ("sound", "y.wav.json", "-o", "y.wav"),
                  ("sound", "out.h5", "-o", "x.wav"), ("plot", "out.h5", "-o", "out.h5"),
                  ("report", "out.h5", "-o", "out.h5")):
        assert ra2d(place, *words).returncode == 2
    assert len({(place / name).read_bytes() for name in names(place)}) == 1


def test_a_damaged_result_is_refused_before_anything_is_drawn(place):
    whole = bytearray((place / "out.h5").read_bytes())
    for at in (len(whole) // 3, len(whole) // 2, len(whole) - 3):
        flipped = whole.copy()
        flipped[at] ^= 1
        (place / "out.h5").write_bytes(flipped)
        for command in ("plot", "sound", "report"):
            said = ra2d(place, command, "out.h5")
            assert said.returncode == 4 and "out.h5" in said.stderr and names(place) == ["out.h5"]


def test_a_damaged_table_is_refused_before_anything_is_drawn(study, tmp_path):
    shutil.copy(study.folder / "results.h5", tmp_path / "table.h5")
    assert ra2d(tmp_path, "plot", "table.h5", "-o", "law.png").returncode == 0
    whole = bytearray((tmp_path / "table.h5").read_bytes())
    for at in range(len(whole) // 9, len(whole), len(whole) // 9):
        flipped = whole.copy()
        flipped[at] ^= 4
        (tmp_path / "table.h5").write_bytes(flipped)
        for command, made in (("plot", "x.png"), ("report", "x.html")):
            said = ra2d(tmp_path, command, "table.h5", "-o", made)
            assert said.returncode == 4 and "table.h5" in said.stderr
    assert names(tmp_path) == ["law.png", "table.h5"]


def test_a_page(place):
    said = ra2d(place, "report", "out.h5", environment={})
    assert said.returncode == 0 and said.stderr == "" and "out.html" in said.stdout
    assert (place / "out.html").read_text().startswith("<!DOCTYPE html>")


def test_a_name_that_is_no_utf_8(place):
    name = b"\xff\xfe$x^$.h5"
    os.rename(place / "out.h5", os.fsencode(place) + b"/" + name)
    for words in ((b"plot", name, b"-o", b"\xff.svg"), (b"sound", name, b"-o", b"\xff.wav"),
                  (b"report", name, b"-o", b"\xff.html")):
        said = ra2d(place, *words, text=False)
        assert said.returncode == 0, said.stderr
    assert sorted(os.listdir(os.fsencode(place))) == [b"\xff.html", b"\xff.svg", b"\xff.wav",
                                                      b"\xff.wav.json", name]


@pytest.mark.parametrize("library, package, commands",
                         [("matplotlib", "python3-matplotlib", ["sound", "report"]),
                          ("soundfile", "python3-soundfile", ["plot"])])
def test_without_a_library_nothing_is_left_but_the_cure(place, library, package, commands):
    (place / f"{library}.py").write_text("raise ImportError\n")
    for command in commands:
        said = ra2d(place, command, "out.h5",
                    environment={"PYTHONPATH": str(place), "PYTHONDONTWRITEBYTECODE": "1"})
        assert said.returncode == 4 and f"apt-get install {package}" in said.stderr
        assert said.stderr.count("\n") == 1 and names(place) == sorted([f"{library}.py", "out.h5"])


def test_files_of_the_current_folder_are_no_modules(place):
    for name in ("numpy", "json", "ra2d"):
        (place / f"{name}.py").write_text("raise RuntimeError('this file was imported')\n")
    assert ra2d(place, "plot", "out.h5", "--what", "level", environment={}).returncode == 0


@pytest.mark.parametrize("locale", [{"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"},
                                    {"PYTHONIOENCODING": "ascii"}])
def test_every_locale_reads_and_prints_alike(place, locale):
    assert ra2d(place, "sound", "out.h5", "-o", "r\u00fch.wav", environment=locale).returncode == 0
    assert (place / "r\u00fch.wav").exists()
    said = ra2d(place, "compare", "out.h5", "out.h5", environment=locale)
    assert said.returncode == 0 and "\u00b5N s" in said.stdout


@pytest.mark.parametrize("script, words",
                         [("kill -9 $$", "signal 9 ended Python"),
                          ("exit 1", "ended with status 1")])
def test_python_that_ends_without_a_word(place, script, words):
    (place / "python3").write_text(f"#!/bin/sh\n{script}\n")
    (place / "python3").chmod(0o755)
    for command, made in (("plot", "x.png"), ("sound", "x.wav"), ("report", "x.html")):
        said = ra2d(place, command, "out.h5", "-o", made,
                    environment={"PATH": f"{place}:{os.environ['PATH']}"})
        assert said.returncode == 4 and words in said.stderr and names(place) == [
            "out.h5", "python3"]


def test_scenes_by_name(place):
    said = ra2d(place, "compare", "dang2012", "dang2012-pinned")
    assert said.returncode == 0 and "slider.support" in said.stdout
    for command in (("compare", "dang2013", "out.h5"), ("uncertainty", "dang2013")):
        said = ra2d(place, *command)
        assert said.returncode == 4 and "did you mean 'dang2012'" in said.stderr


def test_what_the_system_refuses_is_told_without_words_of_python(capsys, monkeypatch):
    def refused(request):
        raise PermissionError(errno.EACCES, "Permission denied", "there/results.h5")

    monkeypatch.setitem(commands.COMMANDS, "compare", refused)
    with warnings.catch_warnings():  # of which main() has its own way
        assert commands.main(io.StringIO('{"command": "compare"}')) == 4
    assert capsys.readouterr().err == ("ra2d: the answer was not made: cannot read or write "
                                       "'there/results.h5': Permission denied\n")


def test_a_full_disk_and_a_fault_of_ours_say_a_cure(monkeypatch, capsys):
    def full(request):
        commands._write(pathlib.Path("/dev/full"), b"x")

    def wrong(request):
        return [][0]

    for answer, words in ((full, "No space left on device. Free some space"),
                          (wrong, "IndexError: list index out of range (test_commands.py")):
        monkeypatch.setitem(commands.COMMANDS, "compare", answer)
        with warnings.catch_warnings():
            assert commands.main(io.StringIO('{"command": "compare"}')) == 4
        said = capsys.readouterr().err
        assert words in said
    assert "if none is, this is a fault of ra2d: please report it" in said


def test_names_of_files_that_were_not_made_are_printed_in_one_line(capsys, monkeypatch):
    monkeypatch.setitem(commands.COMMANDS, "compare", lambda request: [][0])
    with warnings.catch_warnings():
        assert commands.main(io.StringIO('{"command": "compare", "made": "a\\nb.wav"}')) == 4
    assert capsys.readouterr().err.startswith(r"ra2d: a\u000Ab.wav was not made: ")


def test_without_python(place):
    said = ra2d(place, "plot", "out.h5", "--what", "level", environment={"PATH": str(place)})
    # Debian's own is found all the same
    assert said.returncode == (0 if pathlib.Path("/usr/bin/python3").exists() else 4)


# ---- uncertainty and compare
# --------------------------------------------------------------------------

SMALL = ("--set", "time.scheme=adaptive", "--set", "time.tolerance=1e-6", "--set",
         "scene.duration=0.02", "--set",
         "output.rate=1e4")


@pytest.fixture(scope="session")
def dang():
    from ra2d import scenes
    return str(scenes._named("dang2012"))


def test_uncertainty_prints_the_packages_budget(place, dang):
    said = ra2d(place, "uncertainty", dang, "--seeds", "3", "--csv", "table.csv", "--quiet", *SMALL,
                environment={})
    assert said.returncode == 0 and said.stderr == ""
    import ra2d as package
    same = package.uncertainty(package.scene("dang2012").change(duration=0.02, tolerance=1e-6,
                                                                rate=1e4), seeds=3,
                               folder=place / "again", show=False)
    assert said.stdout == same.text() + "\n" and (place / "table.csv").read_text() == same.csv()
    assert (place / "dang2012-uncertainty" / "results.h5").is_file()
    messages = ra2d(place, "uncertainty", dang, "--seeds", "3", "--json", "--threads", "1", *SMALL)
    assert json.loads(messages.stdout) == json.loads(same.to_json())
    # doubts of the scene, told by the program
    assert "stiffness" in messages.stderr and messages.stderr.count("half-spaces") <= 2


def test_uncertainty_refuses_what_is_wrong(place, dang):
    shutil.copy(dang, place / "s.toml")
    before = names(place)
    for words, status, said in ((("s.toml", "--seeds", "1"), 2, "from 2 to 1000"),
                                (("no.toml",), 4, "no.toml"),
                                (("s.toml", "--set", "scene.speed=fast"), 2, "number >= 0"),
                                (("s.toml", "--csv", "s.toml"), 2, "name another file with --csv"),
                                (("s.toml", "-o", "no/folder"), 4, "Make it first"),
                                (("s.toml", "--set", 'slider.surface={kind="flat"}', "--set",
                                  'resonator.surface={kind="flat"}'), 2, "neither face")):
        ended = ra2d(place, "uncertainty", *words)
        assert ended.returncode == status and said in ended.stderr and ended.stdout == "", words
    assert names(place) == before and (place / "s.toml").read_text() == pathlib.Path(
        dang).read_text()


def test_an_interrupted_uncertainty_says_what_continues_it(place, dang):
    words = [program.find(), "uncertainty", dang, "--set", "scene.duration=1.5", "--quiet"]
    with subprocess.Popen(words, cwd=place, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          text=True) as process:
        while process.poll() is None and not (place / "dang2012-uncertainty").exists():
            time.sleep(0.01)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=60)
    assert process.returncode == 130 and out == ""
    assert err == "ra2d: interrupted: what is finished is kept; the same command continues\n"


def test_compare_prints_the_packages_comparison(place, result, study):
    import ra2d as package
    said = ra2d(place, "compare", result.path, "out.h5", environment={})
    assert said.returncode == 0 and said.stderr == ""
    assert said.stdout == package.compare(result, place / "out.h5").text() + "\n"
    assert "scene.duration [s]" in said.stdout and "the run is too short" in said.stdout
    messages = json.loads(ra2d(place, "compare", result.path, "out.h5", "--json").stdout)
    assert messages == json.loads(package.compare(result, place / "out.h5").to_json())
    (place / "broken.h5").write_bytes((place / "out.h5").read_bytes()[:5000])
    for other, status in (("no.h5", 4), ("broken.h5", 4), (str(study.folder), 2), (".", 2)):
        ended = ra2d(place, "compare", "out.h5", other)
        assert ended.returncode == status and ended.stderr.startswith(
            "ra2d: ") and "Traceback" not in ended.stderr
        assert ended.stdout == "", other
    (place / "text.h5").write_text("no result")
    assert ra2d(place, "compare", "out.h5", "text.h5").stderr.startswith(
        "ra2d: cannot read 'text.h5': it is no HDF5 file")


def test_plot_takes_a_stretch_and_a_shock(place, result):
    shutil.copy(result.path, place / "long.h5")
    for words in (("--what", "waterfall", "--from", "0.2", "--to", "0.4"),
                  ("--what", "shock", "--shock", "7")):
        ended = ra2d(place, "plot", "long.h5", *words, "-o", "x.png")
        assert ended.returncode == 0 and ended.stderr == "", ended.stderr
        assert (place / "x.png").read_bytes().startswith(b"\x89PNG")
    shown = package_picture(result, what="force", start=0.2, stop=0.3)
    assert ra2d(place, "plot", "long.h5", "--what", "force", "--from", "0.2", "--to", "0.3", "-o",
                "f.svg").returncode == 0
    assert (place / "f.svg").read_bytes() == shown.replace(b"cube.h5", b"long.h5")
    (place / "x.png").unlink()
    for words, said in ((("--from", "5"), "there is nothing"), (("--shock", "3"), "--what shock"),
                        (("--what", "shock", "--shock", "999999"), "numbers 0 to"),
                        (("--what", "shock", "--shock", "-1"), "--shock"),
                        (("--from", "-1"), "--from")):
        ended = ra2d(place, "plot", "long.h5", *words, "-o", "x.png")
        assert ended.returncode == 2 and said in ended.stderr and not (place / "x.png").exists()


def package_picture(of, **words):
    return of.plot(**words).drawn("svg")


def test_stretches_are_refused_where_there_is_no_time(place, study, profile):
    for files, words in (((profile, "--x-unit", "mm", "--z-unit", "um"), ("--from", "0.1")),
                         ((study.folder,), ("--to", "1")),
                         ((study.folder,), ("--shock", "1"))):
        ended = ra2d(place, "plot", *files, *words, "-o", "x.png")
        assert ended.returncode == 2 and f"{words[0]} is of results" in ended.stderr
