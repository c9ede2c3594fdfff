#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""full_disk.py RA2D: a run and a study on a disk that is full, and on one that can no longer be
written; then there is room again, and the same line goes on to the bits of one that was left alone.

The disk is a small tmpfs in a mount namespace of this test's own; only root may have one. Ends with
9 where it may not.
"""
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/bits"))
from same_bits import compare_results  # noqa: E402

SKIPPED = 9
SCENE = ROOT / "scenes/dang2012-pinned.toml"
# a second of steps, some 20 MB of samples; a checkpoint every few hundredths of a second
RUN = ["--set", "time.scheme=backward-euler", "--set", "time.step=1e-8", "--set",
       "scene.duration=0.5", "--set",
       "output.rate=1e5", "--checkpoint", "0.001"]
STUDY = f"""base = "{SCENE}"
seeds = 3
keep = ["files"]
[set]
"time.scheme" = "backward-euler"
"time.step" = 1e-8
"scene.duration" = 0.15
"output.rate" = 2e4
"""


def mount(*words):
    subprocess.run(["mount", *words], check=True)


def ra2d(*words):
    done = subprocess.run([sys.argv[1], *map(str, words)], capture_output=True, text=True,
                          check=False, timeout=300)
    return done.returncode, done.stderr


def expect(condition, what):
    if not condition:
        raise SystemExit(f"full_disk: {what}")


def refused(words, cure, options):
    """Ends with 4 and says what to do, when the disk is as `options` say."""
    mount("-o", f"remount,{options}", str(words[-1].parent))
    status, said = ra2d(*words)
    expect(status == 4 and cure in said, f"{options}: ended with {status}: {said}")


def a_run(disk, whole):
    expect(ra2d("run", SCENE, *RUN, "-o", whole)[0] == 0, "the run that is left alone failed")
    words = ["run", SCENE, *RUN, "-o", disk / "out.h5"]
    size = whole.stat().st_size
    refused(words, "lower output.rate", f"size={2 * size // 3}")  # foreseen
    expect(not any(disk.iterdir()), "a run that was refused left something")
    # what is foreseen leaves out the checkpoint and that segments become one file
    refused(words, "Free some space", f"size={102 * size // 100}")
    expect(not (disk / "out.h5").exists(), "what is not whole has the name of a result")
    expect((disk / "out.h5.checkpoint").exists(), "no checkpoint was left")
    kept = sorted(path.name for path in disk.rglob("*") if path.suffix != ".lock")
    refused(words, "Read-only file system", "ro")
    expect(sorted(path.name for path in disk.rglob("*") if path.suffix != ".lock") == kept,
           "it lost what it had")
    mount("-o", "remount,rw,size=256m", str(disk))
    status, said = ra2d(*words)
    expect(status == 0, f"with room again it ended with {status}: {said}")
    expect("on from" in said, f"it did not go on from there: {said}")
    differences = compare_results(whole, disk / "out.h5", attributes=False)
    expect(not differences, f"other bits: {differences}")
    (disk / "out.h5").unlink()


def a_study(disk, folder):
    study = folder / "study.toml"
    study.write_text(STUDY)
    status, said = ra2d("study", study, "-o", folder / "whole")
    expect(status == 0, f"the study that is left alone ended with {status}: {said}")
    size = sum(path.stat().st_size for path in (folder / "whole").rglob("*") if path.is_file())
    words = ["study", study, "--checkpoint", "0.0005", "-o", disk / "study"]
    refused(words, "Free some space", f"size={size // 2}")
    mount("-o", "remount,size=256m", str(disk))
    status, said = ra2d(*words)
    expect(status == 0, f"with room again the study ended with {status}: {said}")
    results = sorted((folder / "whole/runs").glob("*.h5"))
    expect(len(results) == 3, "the study kept no results")
    for result in results:
        differences = compare_results(result, disk / "study/runs" / result.name, attributes=False)
        expect(not differences, f"{result.name}: other bits: {differences}")
    status, said = ra2d("check", disk / "study")
    expect(status == 0, f"check: {said}")


def main():
    if sys.argv[2:] != ["--inside"]:
        if subprocess.run(["unshare", "--mount", "true"], stderr=subprocess.DEVNULL,
                          check=False).returncode != 0:
            print("no mount namespace may be made here")
            return SKIPPED
        own = subprocess.run(["unshare", "--mount", sys.executable, __file__, sys.argv[1],
                              "--inside"], check=False)
        return own.returncode
    with tempfile.TemporaryDirectory(prefix="ra2d_full_disk_") as folder:
        folder = pathlib.Path(folder)
        disk = folder / "disk"
        disk.mkdir()
        try:
            mount("-t", "tmpfs", "-o", "size=256m", "ra2d", str(disk))
        except subprocess.CalledProcessError:
            print("no tmpfs may be mounted here")
            return SKIPPED
        try:
            a_run(disk, folder / "whole.h5")
            a_study(disk, folder)
        finally:
            subprocess.run(["umount", str(disk)], check=False)
    return 0


if __name__ == "__main__":
    sys.exit(main())
