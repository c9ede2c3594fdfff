# SPDX-License-Identifier: BSD-3-Clause
"""Calls of the program: where it is found, its errors, progress and interrupts."""
import os
import pathlib
import signal
import subprocess
import sys
import time

import pytest

import ra2d
from ra2d import program, progress

LONG = """
import sys, ra2d
ra2d.run("dang2012", duration=0.3, output=sys.argv[1], checkpoint=0.002)
"""


@pytest.fixture
def fake(tmp_path, monkeypatch):
    """A program that says a version and then does what it is told."""
    def make(version, does="true"):
        path = tmp_path / "fake-ra2d"
        path.write_text(f'#!/bin/sh\n[ "$1" = --version ] && echo "{version}" && exit\n{does}\n')
        path.chmod(0o755)
        monkeypatch.setenv("RA2D", str(path))
        program._require_version.cache_clear()
        return path
    return make


def test_a_missing_program_is_an_error_with_the_cure(monkeypatch, tmp_path):
    monkeypatch.setenv("RA2D", str(tmp_path / "nowhere"))
    with pytest.raises(ra2d.ProgramError, match="RA2D names .*nowhere.*export RA2D"):
        ra2d.find()
    monkeypatch.delenv("RA2D")
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr(program, "__file__", str(tmp_path / "a/b/c/ra2d/program.py"))
    with pytest.raises(ra2d.ProgramError,
                       match="neither beside the package nor on the PATH.*install ra2d"):
        ra2d.find()


def test_a_program_that_is_too_old_is_named(fake):
    path = fake("ra2d 0.0.9 (abc)")
    with pytest.raises(ra2d.ProgramError,
                       match=f"{path} is 0.0.9, this package needs 0.1.0 or later: install"):
        ra2d.find()
    broken = fake("something else")
    with pytest.raises(ra2d.ProgramError, match="does not say a version"):
        ra2d.find()
    broken.write_bytes(b"\x7fELF")
    program._require_version.cache_clear()
    with pytest.raises(ra2d.ProgramError, match="does not start: Exec format error"):
        ra2d.find()


def test_a_program_beside_is_not_looked_for_on_the_path(fake, monkeypatch):
    path = fake("ra2d 0.1.0 (x)")
    monkeypatch.chdir(path.parent)
    monkeypatch.setenv("RA2D", path.name)
    assert ra2d.find() == path


@pytest.mark.parametrize("status, kind", [(2, ra2d.RequestError), (3, ra2d.SimulationError),
                                          (4, ra2d.FileError),
                                          (5, ra2d.OutOfTime), (143, ra2d.Interrupted),
                                          (1, ra2d.ProgramError)])
def test_each_exit_status_is_an_exception(fake, status, kind):
    fake("ra2d 0.1.0 (x)",
         "echo 'ra2d: a doubt' >&2; echo 'ra2d: two faults\nand the second line' >&2; exit "
         f"{status}")
    for call in (lambda: program.call("x"), lambda: program.follow(["x"], lambda text: None)):
        with (pytest.raises(kind, match="two faults\nand the second line"),
              pytest.warns(ra2d.Notice, match="a doubt")):
            call()


def test_a_crash_is_told(fake):
    for signal, kind, words in (("SEGV", ra2d.ProgramError, "crashed: signal 11, Segm"),
                                ("KILL", ra2d.Interrupted, "signal 9 ended the program")):
        fake("ra2d 0.1.0 (x)", f"kill -{signal} $$")
        for call in (lambda: program.call("x"), lambda: program.follow(["x"], lambda text: None)):
            with pytest.raises(kind, match=words):
                call()


def test_a_fault_of_the_scene_has_the_programs_words():
    with pytest.raises(ra2d.RequestError,
                       match=r"scene.spede: unknown key \(did you mean `speed`\?\)"):
        ra2d.run("dang2012", {"scene.spede": 2}, show=False)
    with pytest.raises(ra2d.RequestError, match="did you mean `tolerance`"):
        ra2d.run("dang2012", tolerence=1e-6, show=False)


def test_progress_is_shown_in_its_place(folder):
    seen = []
    scene = ra2d.scene("dang2012").change(duration=1)  # backward Euler: a second or two
    program.follow(["run", scene.file(folder), *scene.options(), "-o", folder / "progress.h5"],
                   seen.append)
    shares = [progress._share(text) for text in seen]
    assert len(seen) > 2 and shares == sorted(shares) and 0 < shares[-1] <= 1
    assert all("steps/s" in text for text in seen)


def test_the_same_call_returns_what_is_there(base, folder):
    first = ra2d.run(base, duration=0.02, output=folder / "same.h5", show=False)
    stamp = first.path.stat().st_mtime_ns
    assert ra2d.run(base, duration=0.02, output=folder / "same.h5",
                    show=False).path.stat().st_mtime_ns == stamp
    with pytest.raises(ra2d.RequestError, match="force"):
        ra2d.run(base, duration=0.03, output=folder / "same.h5", show=False)
    assert ra2d.run(base, duration=0.03, output=folder / "same.h5", force=True,
                    show=False).duration == 0.03


def until(condition, seconds=20.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "it took too long"
        time.sleep(0.02)


def started(output):
    """A Python that runs the paper's own scheme, for seconds, with its first checkpoint written."""
    python = subprocess.Popen([sys.executable, "-c", LONG, output],
                              stderr=subprocess.PIPE, text=True,
                              env={**os.environ,
                                   "PYTHONPATH": str(pathlib.Path(ra2d.__file__).parents[1])})
    until(lambda: pathlib.Path(f"{output}.checkpoint").exists())
    return python


def test_an_interrupt_leaves_result_and_checkpoint(folder):
    output = folder / "interrupted.h5"
    python = started(output)
    python.send_signal(signal.SIGINT)
    assert "KeyboardInterrupt: interrupted at t = " in python.communicate(timeout=20)[1]
    assert python.returncode != 0
    cut = ra2d.load(output)
    assert not cut.complete and cut.attrs["ended"] == "interrupted" and 0 < cut.duration < 0.3
    assert pathlib.Path(f"{output}.checkpoint").exists()
    with pytest.warns(ra2d.Notice, match="goes on|going on|from t ="):
        whole = ra2d.run("dang2012", duration=0.3, output=output, show=False)
    assert whole.complete and not pathlib.Path(f"{output}.checkpoint").exists()


def test_the_program_ends_in_order_when_python_is_killed(folder):
    output = folder / "orphan.h5"
    python = started(output)
    python.kill()
    python.communicate()
    until(output.exists)  # under its final name, in order
    assert ra2d.load(output).attrs["ended"] == "interrupted"


def test_max_wall_is_an_exception(folder):
    with pytest.raises(ra2d.OutOfTime, match="--max-wall"):
        ra2d.run("dang2012", output=folder / "late.h5", max_wall=0.2, show=False)
    assert not ra2d.load(folder / "late.h5").complete


def test_warnings_of_the_report_are_notices(folder):
    with pytest.warns(ra2d.Notice, match="^[0-9]+ % of the energy is unaccounted for: steps of"):
        ra2d.run("drop", {"time.step": 5e-6}, output=folder / "drop.h5", show=False)


def test_a_failed_simulation_is_an_exception_and_a_file(folder):
    with pytest.raises(ra2d.SimulationError):
        ra2d.run("dang2012", {"time.scheme": "explicit-euler", "time.step": 5e-6,
                              "time.force": True,
                              "scene.duration": 0.05}, output=folder / "unstable.h5", show=False)
    assert not ra2d.load(folder / "unstable.h5").complete


def test_a_terminal_shows_one_line_and_clears_it(capsys, monkeypatch):
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    with progress.shown(True) as show:
        show("7.5 %  of the run")
    assert capsys.readouterr().err == "\r7.5 %  of the run\x1b[K\r\x1b[K"


def test_a_notebook_shows_a_bar_and_clears_it(monkeypatch):
    display = pytest.importorskip("IPython.display")
    seen = []

    class Handle:
        def update(self, html):
            seen.append(html.data)

    monkeypatch.setattr(progress, "_in_notebook", lambda: True)
    monkeypatch.setattr(display, "display", lambda html, display_id: Handle())
    with pytest.raises(KeyboardInterrupt), progress.shown(True) as show:
        show("3 of 12 runs   <failed>")
        raise KeyboardInterrupt
    assert 'value="0.2500"' in seen[0] and "&lt;failed&gt;" in seen[0] and seen[-1] == ""


def test_nothing_is_shown_where_nobody_looks(capsys):
    with progress.shown(True) as show:
        show("7.5 %")
    assert capsys.readouterr().err == ""


def test_a_result_without_its_file_is_still_shown(base, folder):
    gone = ra2d.run(base, duration=1e-3, output=folder / "gone.h5", show=False)
    gone.path.unlink()
    assert repr(gone) == ("<ra2d.Result gone.h5: of 'roughness noise', its file is gone, was "
                          "replaced or is damaged>")
    assert "its file is gone" in gone._repr_html_()
    with pytest.raises(ra2d.FileError, match="no such file"):
        print(gone.level)


def test_a_run_at_rest_has_no_level(base, folder):
    flat = {"kind": "flat"}
    rest = ra2d.run(base, {"slider.surface": flat, "resonator.surface": flat, "scene.gap": 1e-3,
                           "scene.initial": "rest"}, load=0.0, duration=1e-3,
                    output=folder / "rest.h5", show=False)
    assert "no level: the resonator did not vibrate>" in repr(rest)
    assert repr(rest.level) == "none: the resonator did not vibrate"
    assert "<td>none</td>" in rest._repr_html_() and "inf" not in rest._repr_html_()


def test_what_needs_the_modes_says_that_they_are_missing(base, folder, result):
    bare = ra2d.run(base, {"output.modes": "none"}, duration=1e-2, output=folder / "bare1.h5",
                    show=False)
    for missing, there in ((bare.spectrum().density, bare.spectrum().density_force),
                      (bare.bands().level, bare.bands().level_probe)):
        assert missing.isnull().all() and "output.modes" in missing.attrs["note"]
        assert "note" not in there.attrs
    assert "note" not in result.spectrum().density.attrs
