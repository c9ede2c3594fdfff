# SPDX-License-Identifier: BSD-3-Clause
"""Sound: the pressure at microphones, or the velocity of a probe, resampled, scaled, and written as
WAV or FLAC (docs/sound.md)."""
from __future__ import annotations

import base64
import dataclasses
import functools
import html
import io
import json
import math
import os
import pathlib
import tempfile
from collections.abc import Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt
import soundfile

from . import files, program
from .errors import FileError, RequestError, for_python, kept_notices, notice
from .page_words import printable
from .stretch import seconds
from .style import quantity

if TYPE_CHECKING:
    from .results import Result

Array = npt.NDArray[np.float64]
Encoding = Literal["wav-16", "wav-24", "wav-32", "wav-float", "flac-24"]

RATES, MOST_SLOW = (8000, 384000), 1e4
AUDIBLE = 20e3               # Hz, that the young hear
# of half the lower rate: kept below the first, taken off above the second
PASSED, STOPPED = 0.91, 1.0
ENOUGH = 44e3                # Hz, a rate of samples of which all that is audible is kept
STOP_BAND = 180.0            # dB
MOST_PHASES = 2000           # of a resampler whose rates are in the ratio of two whole numbers
# times the old rate, between whose samples splines go, for other ratios
FINER = 8
SPLINE_BLOCK, SPLINE_MARGIN = 1 << 16, 100  # samples
LARGEST_RATIO = 1e6          # of rates: beyond, a sound is one sample or an endless line
WAV_BYTES = 2**32 - 2**13    # that its header can count
PRESSURE = "sound pressure"
# and the names of a scale and a peak
_UNITS = {"velocity": ("m/s", "m_per_s"), PRESSURE: ("Pa", "pa")}
_BITS: dict[str, int] = {"wav-16": 16, "wav-24": 24, "wav-32": 32, "flac-24": 24}
SOFTEST = 2.0**-23           # of full scale: what is below is too soft for players of 24 bits
FLAC_ANY, FLAC_STEP = 65535, 10  # Hz: rates that a FLAC can have, and of which multiples above


# ---- resampling
# ------------------------------------------------------------------------------------

@functools.lru_cache(maxsize=4)
def _filter(up: int, ratio: Fraction) -> Array:
    """A low pass of linear phase at `up` times the old rate, for a new rate of `ratio` old ones.
    Kaiser's window: its error is that of the stop band on both sides."""
    from scipy.signal import firwin, kaiser_beta  # half a second, which pictures do without

    middle, width = (PASSED + STOPPED) / 2, (STOPPED - PASSED) * math.pi
    # samples of the lower rate on either side
    half = math.ceil((STOP_BAND - 7.95) / (2.285 * width) / 2)
    lower = float(up / min(ratio, Fraction(1)))
    taps: Array = firwin(2 * math.ceil(half * lower) + 1, middle / lower,
                         window=("kaiser", kaiser_beta(STOP_BAND)))
    return taps


def _between_samples(finer: Array, at: Array) -> Array:
    """Values at places that are counted in samples, by splines of degree 7. Of samples at eight
    times the rate they are off by 1e-9. In blocks: far samples do not matter."""
    from scipy.interpolate import make_interp_spline

    found = np.empty(at.size)
    for begin in range(0, at.size, SPLINE_BLOCK):
        part = slice(begin, begin + SPLINE_BLOCK)
        first = max(0, int(at[part][0]) - SPLINE_MARGIN)
        piece = finer[first:int(at[part][-1]) + SPLINE_MARGIN + 1]
        found[part] = make_interp_spline(np.arange(piece.size), piece, 7)(at[part] - first)
    return found


def resample(samples: npt.ArrayLike, old: float, new: float) -> Array:
    """Samples of `old` Hz at `new` Hz: the first is at the same time, the last not after the old
    last one. Up to 0.91 of half the lower rate amplitude and time are kept.

    >>> t = np.arange(4000) / 8000
    >>> y = resample(np.sin(2 * np.pi * 440 * t), 8000, 48000)
    >>> bool(abs(y[12000] - np.sin(2 * np.pi * 440 * 12000 / 48000)) < 1e-6)
    True
    """
    from scipy.signal import resample_poly

    x = np.asarray(samples, dtype=float)
    if not (old <= LARGEST_RATIO * new and new <= LARGEST_RATIO * old):
        raise RequestError(
            f"samples of {old:g} Hz cannot become a sound of {new:g} Hz: the rates differ by more "
            "than "
                           f"a factor of {LARGEST_RATIO:g} (slow, rate, or output.rate of the "
                           "scene)")
    if old == new or not x.size:
        return x
    count = math.floor((x.size - 1) * (new / old) * (1 + 1e-15) + 1e-9) + 1
    ratio = Fraction(new / old).limit_denominator(MOST_PHASES)
    if ratio.numerator <= MOST_PHASES and abs(float(ratio) * old / new - 1) < 1e-14:
        made: Array = resample_poly(x, ratio.numerator, ratio.denominator,
                                    window=_filter(ratio.numerator, ratio))
        found: Array = np.pad(made, (0, max(0, count - made.size)))[:count]
        return found
    finer = resample_poly(x, FINER, 1,
                          window=_filter(FINER, Fraction(new / old).limit_denominator(10**6)))
    return _between_samples(finer, np.arange(count) * (FINER * old / new))


def round_full_scale(peak: float) -> float:
    """The smallest of 1, 2, 5 times a power of ten that is not below; 1 for 0.

    >>> round_full_scale(0.0033)
    0.005
    """
    if not peak > 0:
        return 1.0
    decade = math.floor(math.log10(peak))
    steps = (float(f"{digit}e{power}") for power in range(decade - 1, 309) for digit in (1, 2, 5))
    return next((step for step in steps if peak <= step < math.inf), peak)


# ---- the sound
# ---------------------------------------------------------------------------------------

@dataclasses.dataclass(frozen=True, repr=False)
class Sound:
    """A sound. A notebook shows it with a player.

    - `samples`: velocity or sound pressure over full scale; of two microphones with a column each
    - `rate` [1/s]
    - `about`: what docs/sound.md says of it: `full_scale_m_per_s` or `full_scale_pa`, ...
    - `doubts`: what a listener should know; the player shows it, and `save` warns of it

    >>> getfixture("result").listen()
    <ra2d.Sound of the resonator at 0.15 m, 1 s; full scale 0.01 m/s>
    """

    samples: Array
    rate: int
    about: dict[str, Any]
    doubts: tuple[str, ...] = ()

    def save(self, path: str | os.PathLike[str],
             bits: Literal[16, 24, 32, "float"] = 24) -> pathlib.Path:
        """Writes WAV or FLAC, by the ending; FLAC has 24 bits. A WAV of 16, 24 or 32 bits clips
        what is beyond full scale, one of "float" holds it.

        >>> getfixture("result").listen().save("cube.flac").name
        'cube.flac'
        """
        path = pathlib.Path(path)
        encoding = encoding_of(path, bits)
        files.write_bytes(path, self.encoded(encoding))
        for doubt in (*self.doubts, *self.doubts_in(encoding)):
            notice(doubt)
        return path

    def encoded(self, encoding: Encoding = "wav-24") -> bytes:
        """The bytes of a file.

        >>> getfixture("result").listen(stop=0.1).encoded("flac-24")[:4]
        b'fLaC'
        """
        out = io.BytesIO()
        if encoding == "wav-float":  # not libsndfile's: it writes the time of day into such files
            from scipy.io import wavfile

            wavfile.write(out, self.rate, self.samples.astype(np.float32))
            return out.getvalue()
        if encoding == "flac-24":
            _require_flac_rate(self.rate)
        bits = _BITS[encoding]
        steps = 2.0 ** (bits - 1)
        whole = np.clip(np.rint(self.samples * steps), -steps, steps - 1) * 2.0 ** (32 - bits)
        with soundfile.SoundFile(out, "w", self.rate, self.samples.ndim, f"PCM_{bits}",
                                 format=encoding.split("-")[0].upper()) as file:
            # an empty one is refused
            if title := "".join(c for c in self.about["title"] if c.isprintable()):
                file.title = title
            file.comment = self._comment()
            file.software = f"ra2d {self.about['version']}"
            file.write(whole.astype(np.int32))
        return out.getvalue()

    def doubts_in(self, encoding: Encoding) -> tuple[str, ...]:
        """What gets lost in a file of this encoding.

        >>> getfixture("result").listen(stop=0.1, full_scale=1e3).doubts_in("wav-float")
        ()
        """
        peak, scale = self._peak(), self.full_scale()
        step = 2.0 ** (1 - _BITS[encoding]) if encoding in _BITS else 0.0
        if not 0 < peak < max(step, SOFTEST) * scale:
            return ()
        lost = (f"below a step of {_BITS[encoding]} bits, {step:.2g}, so that nothing, or hardly "
                "anything, is left in the file" if peak < step * scale else "too soft to hear")
        return (f"the peak, {peak:.4g} {self._unit()}, is {peak / scale:.3g} of --full-scale "
                f"{scale:g} {self._unit()}: {lost}. Take a full scale near the peak",)

    def source(self) -> str:
        """A WAV of 16 bits, which every browser plays, as an address that a page holds in itself.

        >>> getfixture("result").listen(stop=0.1).source()[:22]
        'data:audio/wav;base64,'
        """
        return "data:audio/wav;base64," + base64.b64encode(self.encoded("wav-16")).decode()

    def _unit(self) -> str:
        return _UNITS[self.about["quantity"]][0]

    def full_scale(self) -> float:
        """What the value 1 stands for [m/s; Pa].

        >>> getfixture("result").listen().full_scale()
        0.01
        """
        return float(self.about[f"full_scale_{_UNITS[self.about['quantity']][1]}"])

    def _peak(self) -> float:
        return float(self.about[f"peak_{_UNITS[self.about['quantity']][1]}"])

    def place(self) -> str:
        """What is heard, and where.

        >>> getfixture("result").listen().place()
        'probe 1 at 0.15 m'
        """
        a = self.about
        if a["quantity"] == PRESSURE:
            return " and ".join(", ".join(f"{x:g}" for x in place)
                                for place in a["microphones"]) + " m"
        return f"{'slider ' if a['body'] == 'slider' else ''}probe {a['probe']} at {_at(a)} m"

    def _comment(self) -> str:
        a = self.about
        slower = f"; {a['slow']:g} times slower" if a["slow"] != 1 else ""
        return (f"{a['quantity']} {self._of()}{self.place()}, the value 1.0 is "
                f"{self.full_scale():g} {self._unit()}; "
                f"{a['from']:g} s to {a['to']:g} s{slower}")

    def _of(self) -> str:
        return "at " if self.about["quantity"] == PRESSURE else "of "

    def about_text(self, name: str) -> str:
        """The text that stands beside the file `name` (docs/sound.md).

        >>> "full_scale_m_per_s" in getfixture("result").listen(stop=0.1).about_text("cube.wav")
        True
        """
        return json.dumps({"file": name, **self.about}, indent=2) + "\n"

    def describe(self, name: str) -> str:
        """The lines that `ra2d sound` prints of the file `name`.

        >>> print(getfixture("result").listen(stop=0.1).describe("cube.wav").splitlines()[0])
        velocity of probe 1 at 0.15 m, from 0 s to 0.1 s
        """
        a, name = self.about, printable(name)
        lines = [("length",
                  f"{quantity(len(self.samples) / self.rate, 's')}, {len(self.samples)} samples at "
                            f"{self.rate} Hz"),
                 ("full scale", f"1.0 in the file is {self.full_scale():g} {self._unit()}")]
        if (peak := self._peak()) > 0:
            lines.append(("peak",
                          f"{peak:.4g} {self._unit()}, "
                          f"{20 * math.log10(peak / self.full_scale()):.1f} dB of full "
                                  "scale"))
        lines += [("file", name), ("beside it", f"{name}.json")]
        lines.append(("left out", a["left_out"]) if a["quantity"] == PRESSURE else
                     ("what it is",
                      "a velocity, no sound pressure: --at X,Y,Z plays what a microphone hears"))
        slower = f", {a['slow']:g} times slower" if a["slow"] != 1 else ""
        head = (f"{a['quantity']} {self._of()}{self.place()}, from {a['from']:g} s to {a['to']:g} "
                f"s{slower}\n")
        return head + "".join(f"  {what:<17}{text}\n" for what, text in lines)

    def __repr__(self) -> str:
        a = self.about
        place = f"at {self.place()}" if a[
            "quantity"] == PRESSURE else f"of the {a['body']} at {_at(a)} m"
        return (f"<ra2d.Sound {place}, {len(self.samples) / self.rate:.3g} s; full scale "
                f"{self.full_scale():g} "
                f"{self._unit()}>")

    def _repr_html_(self) -> str:
        doubts = "".join(f"<br>{html.escape(for_python(doubt))}" for doubt in self.doubts)
        return (f'<audio controls src="{self.source()}"></audio><br><code>{repr(self)[1:-1]}</code>'
                f"{doubts}")


def encoding_of(path: pathlib.Path, bits: int | str = 24) -> Encoding:
    """The encoding that a name asks for by its ending."""
    ending = path.suffix.lower()
    if ending == ".flac":
        return "flac-24"
    if ending != ".wav":
        raise RequestError(f"{str(path)!r}: expected a name that ends in .wav or .flac")
    found = f"wav-{bits}"
    if found not in ("wav-16", "wav-24", "wav-32", "wav-float"):
        raise RequestError(f"bits = {bits!r}: expected 16, 24, 32 or 'float'")
    return found  # type: ignore[return-value]


# ---- what is heard
# -----------------------------------------------------------------------------------

def _at(about: dict[str, Any]) -> str:
    """Where a probe is [m]."""
    return f"{about['position']:g}" + (f", {about['y']:g}" if "y" in about else "")


def _require(name: str, value: float, low: float, high: float) -> None:
    if not (isinstance(value, int | float | np.number) and low <= value <= high):
        raise RequestError(f"{name} is {value!r}: expected a number from {low:g} to {high:g}")


def _choose_probe(result: Result, body: str, probe: int) -> Any:
    """The velocity of the probe, not read yet."""
    positions = result.probes.position.values, result.slider_probes.position.values
    slider = body == "slider"
    here, others = positions[::-1] if slider else positions
    words = (("probes", "0.15", "--probe"), ("slider_probes", "0.01", "--slider-probe"))
    mine, other = words[::-1] if slider else words
    if not here.size:
        there = f" (there {'is' if others.size == 1 else 'are'} {others.size} of the " \
                f"{'resonator' if slider else 'slider'}: {other[2]} 1)" if others.size else ""
        raise RequestError(
            f"{result.path.name}: it has no {'slider ' if slider else ''}probe to listen to: name "
            "a "
                           f"place on the {body} in the scene, as output.{mine[0]} = [{mine[1]}], "
                           "and run it again"
                           f"{there}")
    if not (isinstance(probe, int | np.integer) and 1 <= probe <= here.size):
        places = ", ".join(f"{place:g}" for place in here[:8]) + (", ..." if here.size > 8 else "")
        raise RequestError(
            f"{result.path.name}: {mine[2]} {probe}: expected 1 to {here.size} (at {places} m)")
    velocity = (result.slider_probes if slider else result.probes).velocity
    return velocity.isel({velocity.dims[1]: probe - 1})


def _choose_stretch(result: Result, time: Array, start: float | None, stop: float | None) -> slice:
    """The samples from `start` to `stop` [s]; from output.from to the end without them."""
    end = float(time[-1]) if time.size else 0.0
    apart = end / (time.size - 1) if time.size > 1 else math.inf
    begin = result.counted_from if start is None else start
    if begin < 0:
        raise RequestError(f"{result.path.name}: from {begin:g} s: the run begins at 0 s")
    if stop is not None and not stop <= end * (1 + 1e-12) + 1e-6 * apart:
        raise RequestError(f"{result.path.name}: to {stop:g} s: the run ends at {end:g} s")
    first = int(np.searchsorted(time, begin - 1e-6 * apart))
    beyond = int(np.searchsorted(time, (end if stop is None else stop) + 1e-6 * apart,
                                 side="right"))
    if beyond - first < 2:
        found = {0: "is no sample", 1: "is one sample"}.get(beyond - first, "is nothing")
        raise RequestError(
            f"{result.path.name}: from {begin:g} s to {end if stop is None else stop:g} s there "
            f"{found} "
                           "to listen to: expected a stretch of two samples or more")
    return slice(first, beyond)


def _require_flac_rate(rate: int) -> None:
    if rate > FLAC_ANY and rate % FLAC_STEP:
        raise RequestError(f"rate is {rate}: above {FLAC_ANY} Hz a FLAC has multiples of "
                           f"{FLAC_STEP} Hz alone: take {round(rate / FLAC_STEP) * FLAC_STEP}, or "
                           "a WAV")


def _require_two_samples(heard: Array, about: dict[str, Any]) -> None:
    if len(heard) < 2:
        raise RequestError(
            f"{about['source']}: from {about['from']:g} s to {about['to']:g} s is one sample of a "
            f"sound of {about['rate']} Hz: expected a stretch of two samples or more (--from, --to)"
            ", or a larger --slow")


def _between(modes: Array, low: float, high: float) -> int:
    return int(((modes > low) & (modes <= high)).sum())


def _doubt_rates(about: dict[str, Any], modes: Array) -> list[str]:
    doubts, body, rate, source = [], about["body"], about["rate"], about["source_rate"]
    carried = source / 2
    heard = min(carried, PASSED * rate / 2 * about["slow"])
    is_whole = about["quantity"] != PRESSURE and source >= rate * about["slow"]
    kept = carried if is_whole else PASSED * carried
    highest = float(modes.max(initial=0))
    wanted = max(ENOUGH, 1e3 * math.ceil(2 * highest / 1e3))
    if above := _between(modes, carried, math.inf):
        doubts.append(f"output.rate is too low: {above} of the {body}'s modes ring above "
                      f"{carried:g} Hz, half the rate "
                      f"of the samples, the highest at {highest:.4g} Hz. They are heard at "
                      "frequencies that are not "
                      f"theirs. Run with output.rate = {wanted:g} or more")
    elif kept < AUDIBLE:
        doubts.append(f"output.rate is low: nothing above {kept:g} Hz is kept of samples at "
                      f"{source:g} Hz, and ears go to {AUDIBLE:g} Hz. Run with output.rate = "
                      f"{wanted:g} or more")
    if lost := _between(modes, heard, min(carried, AUDIBLE)):
        doubts.append(f"--rate {rate} passes what is below {heard:.4g} Hz: {lost} of the {body}'s "
                      "modes are left out. "
                      "Take --rate 48000")
    return doubts


def _doubt_scale(about: dict[str, Any], name: str) -> list[str]:
    unit, key = _UNITS[about["quantity"]]
    peak, scale, beyond = about[f"peak_{key}"], about[f"full_scale_{key}"], about[
        "beyond_full_scale"]
    if not peak > 0 and about["quantity"] == PRESSURE:
        return [f"silence: the resonator does not move from {about['from']:g} s to {about['to']:g} "
                "s"]
    if not peak > 0:
        support = "; at a support there is nothing to hear" if about["position"] == 0 and about[
            "body"] == "resonator" \
            else ""
        return [f"silence: the {name} does not move from {about['from']:g} s to {about['to']:g} "
                f"s{support}"]
    doubts = []
    if beyond:
        doubts.append(f"{beyond} of {about['samples']} samples are beyond --full-scale {scale:g} "
                      f"{unit}, the peak is "
                      f"{peak:.4g} {unit}: whole numbers clip them; in a WAV of floats they stand, "
                      "and players clip them")
    return doubts


def _full_scale(peak: float, wanted: float | None, normalize: bool, unit: str = "m/s") -> float:
    """The velocity or pressure that the value 1 stands for."""
    if wanted is None:
        return peak if normalize and peak > 0 else round_full_scale(peak)
    if not (isinstance(wanted, int | float | np.number) and 0 < wanted < 1.7e308):
        raise RequestError(f"full_scale is {wanted!r}: expected a number above 0 ({unit})")
    share, limits = peak / wanted, np.finfo(np.float32)
    if peak > 0 and not limits.tiny <= share <= limits.max:
        raise RequestError(
            f"--full-scale {wanted:g}: the peak is {peak:.4g} {unit}, {share:.3g} times that, and "
            "the "
                           f"numbers of a sound file go from {limits.tiny:.3g} to "
                           f"{limits.max:.3g}: expected a "
                           f"{'pressure' if unit == 'Pa' else 'velocity'} near the peak")
    return float(wanted)


def _require_room(count: int, source: float, rate: int, result: Result) -> None:
    """A sound that does not fit into a quarter of the memory is refused before anything is read."""
    frames = count * rate / source
    room = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 4
    if 32 * frames > room or 4 * frames > WAV_BYTES:
        raise RequestError(
            f"{result.path.name}: the sound would last {frames / rate:.4g} s: take a part of the "
            "run "
                           "with --from and --to")


def _origin(result: Result) -> dict[str, Any]:
    """What a sound says of the result and the program."""
    version, _, commit = program.call("--version").strip().partition(" ")[2].partition(" ")
    return {"source": result.path.name, "source_rate": result.rate, "title": result.title,
            "complete": result.complete, "ended": str(result.attrs.get("ended", "")),
            "creator": "ra2d",
            "version": version, "commit": commit.strip("()")}


def of_pressure(result: Result, pressures: Array, heard_at: dict[str, Any], *, slow: float = 1,
                rate: int = 48000,
                full_scale: float | None = None, normalize: bool = False) -> Sound:
    """The pressure [Pa] at one microphone or two as sound: a row of samples for each, at the
    result's rate. `heard_at` says where, when and in what air."""
    source = result.rate
    _require_room(pressures.size, source / slow, rate, result)
    heard = np.stack([resample(row, source / slow, rate) for row in pressures], axis=-1)
    peak = float(np.abs(heard).max(initial=0))
    scale = _full_scale(peak, full_scale, normalize, "Pa")
    modes = result.modes("resonator").frequency.values
    left_out = (f"the slider's own sound; modes above {quantity(modes.max(), 'Hz')}, which were "
                "not kept")
    about = {"body": "resonator", "quantity": PRESSURE, **heard_at, "left_out": left_out,
             "full_scale_pa": scale,
             "peak_pa": peak, "beyond_full_scale": int((np.abs(heard) > scale).any(axis=1).sum()),
             "rate": int(rate),
             "samples": len(heard), "slow": float(slow), **_origin(result)}
    _require_two_samples(heard, about)
    doubts = _doubt_scale(about, "") + _doubt_rates(about, modes)
    return Sound((heard[:, 0] if len(pressures) == 1 else heard) / scale, int(rate), about,
                 tuple(doubts))


def of_microphones(result: Result, places: Sequence[str], *, slow: float = 1, rate: int = 48000,
                   full_scale: float | None = None, normalize: bool = False,
                   start: float | None = None,
                   stop: float | None = None) -> Sound:
    """The pressure at microphones as sound, by `ra2d sound` with these options for their places."""
    from scipy.io import wavfile

    with tempfile.TemporaryDirectory() as folder, kept_notices() as messages:
        made = pathlib.Path(folder) / "heard.wav"
        words = program.options({"--slow": slow, "--rate": rate, "--full-scale": full_scale,
                                 "--normalize": bool(normalize),
                                 "--from": start, "--to": stop})
        program.call("sound", result.path, *places, *words, "--bits", "float", "-o", made)
        about = json.loads(made.with_name("heard.wav.json").read_text("utf-8"))
        found, samples = wavfile.read(made)
    del about["file"]
    return Sound(samples.astype(float), int(found), about, tuple(messages))


def of_probe(result: Result, probe: int = 1, body: str = "resonator", *, slow: float = 1,
             rate: int = 48000,
             full_scale: float | None = None, normalize: bool = False, start: float | None = None,
             stop: float | None = None) -> Sound:
    """The velocity of a probe as sound. `Result.listen` says what the options are."""
    _require("slow", slow, 1, MOST_SLOW)
    _require("rate", rate, *RATES)
    if rate != int(rate):
        raise RequestError(f"rate is {rate!r}: expected a whole number (Hz)")
    start, stop = seconds("start", start), seconds("stop", stop)
    velocity = _choose_probe(result, body, probe)
    time = velocity.time.values
    part = _choose_stretch(result, time, start, stop)
    source = result.rate
    _require_room(part.stop - part.start, source / slow, rate, result)
    values = velocity.isel(time=part).values
    if not np.isfinite(values).all():
        raise FileError(f"{result.path.name}: the velocity of the probe has values that are no "
                        "numbers. 'ra2d check' "
                        "says what of the file is damaged")
    heard = resample(values, source / slow, rate)
    peak = float(np.abs(heard).max(initial=0))
    scale = _full_scale(peak, full_scale, normalize)
    about = {"body": body, "probe": int(probe), "position": float(velocity.position),
             "quantity": "velocity",
             "full_scale_m_per_s": scale, "peak_m_per_s": peak,
             "beyond_full_scale": int((np.abs(heard) > scale).sum()),
             "rate": int(rate), "samples": heard.size, "slow": float(slow),
             "from": float(time[part.start]),
             "to": float(time[part.stop - 1]), **_origin(result)}
    _require_two_samples(heard, about)
    if "y" in velocity.coords:
        about["y"] = float(velocity.y)
    modes = result.modes("slider" if body == "slider" else "resonator").frequency.values
    name = f"{'slider ' if body == 'slider' else ''}probe at {_at(about)} m"
    doubts = _doubt_scale(about, name)
    doubts = (doubts if not peak else []) + _doubt_rates(about, modes) + (doubts if peak else [])
    return Sound(heard / scale, int(rate), about, tuple(doubts))
