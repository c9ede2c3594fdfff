# SPDX-License-Identifier: BSD-3-Clause
"""Results of a run: read lazily from their HDF5 file; what is computed from it, the program
computes."""
from __future__ import annotations

import copy
import html
import json
import math
import os
import pathlib
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt
import pandas as pd
import xarray as xr

from . import program, stored, toml
from .errors import FileError, RequestError, notice
from .estimate import Estimate
from .scenes import Scene

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .sound import Sound

Body = Literal["resonator", "slider"]
BODIES: tuple[Body, ...] = ("resonator", "slider")
Motion = Literal["displacement", "velocity"]
MOTIONS: tuple[Motion, ...] = ("displacement", "velocity")
FORMATS = (2, 3, 5)  # of the file, that this package reads
AT_REST = "the resonator did not vibrate"
AREAL_FORMAT = 5     # of areal scenes: maps for profiles, numbers of half waves for shapes

_SAMPLED: dict[str, tuple[str, ...]] = {"time": ("time",)}
_PROBES = {**_SAMPLED, "position": ("position",), "displacement": ("time", "position"),
           "velocity": ("time", "position")}
_AREAL_PROBES = {**_SAMPLED, "probe": ("probe",), "position": ("probe",), "y": ("probe",),
                 "displacement": ("time", "probe"), "velocity": ("time", "probe")}
_MODES = {**_SAMPLED, "mode": ("mode",), "position": ("position",), "y": ("y",),
          "frequency": ("mode",),
          "mean_square": ("mode",), "mode_x": ("mode",), "mode_y": ("mode",),
          "shape": ("mode", "position"),
          "shape_x": ("mode", "position"), "shape_y": ("mode", "y"),
          "displacement": ("time", "mode"),
          "velocity": ("time", "mode")}
_RISING = ("time", "mode", "probe", "position", "y")
# numbers of a scene that pictures and comparisons take from it, where it has them
_PLACES = (("scene", "start"), ("scene", "speed"), ("scene", "spacing"), ("slider", "length"),
           ("slider", "width"), ("resonator", "length"), ("resonator", "width"))
_SUMMARY = ("lv", "lv_low", "lv_high", "v_rms", "shock_rate", "shock_rate_low", "shock_rate_high",
            "shock_duration_median", "shock_duration_90", "peak_force_median", "peak_force_90",
            "contact_share", "nodes_evaluated", "energy_residual", "energy_turnover",
            "energy_closure", "step_seconds", "wall_seconds")
_SHOCKS = ("start", "duration", "peak_force", "impulse", "position")
# In these a window may differ from its run: its samples, and what the program takes for no other
# run (without_origins in host/scene/scene.cpp).
_WINDOW_KEYS = (("scene", "name"), ("output", "rate"), ("output", "window"),
                ("output", "microphones"))


def _one_of(name: str, given: str, allowed: tuple[str, ...]) -> str:
    if given not in allowed:
        raise RequestError(f"{name} is {given!r}: expected {' or '.join(map(repr, allowed))}")
    return given


def _require_within(time: Any, samples: xr.DataArray) -> None:
    """The nearest sample to a time outside of the run would be another time's."""
    try:
        times = np.asarray(time, dtype=float)
    except (TypeError, ValueError) as fault:
        raise RequestError(f"time is {time!r}: expected numbers (s), or a slice of two") from fault
    half = float(samples[1] - samples[0]) / 2 if samples.size > 1 else math.inf
    low, high = float(samples[0]), float(samples[-1])
    if not times.size or not ((times >= low - half) & (times <= high + half)).all():
        raise RequestError(f"time is {time!r}: the samples go from {low:g} to {high:g} s")


def _numbers(time: slice, samples: xr.DataArray) -> slice:
    """A slice of times, in which there are samples."""
    try:
        ends = [None if end is None else float(end) for end in (time.start, time.stop)]
    except (TypeError, ValueError) as fault:
        raise RequestError(f"time is {time!r}: expected a slice of two numbers (s)") from fault
    if time.step is not None:
        raise RequestError(f"time is {time!r}: expected a slice of two numbers (s), without a step")
    found = slice(*ends)
    if not samples.sel(time=found).size:
        raise RequestError(f"time is {time!r}: there is no sample, they go from "
                           f"{float(samples[0]):g} to {float(samples[-1]):g} s")
    return found


def _require_room(times: int, places: int) -> None:
    """A field that does not fit into half of the memory is refused before anything is read."""
    room = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") // 2
    if 8 * times * places > room:
        raise RequestError(
            f"a field at {times} times and {places} places takes {8e-9 * times * places:.3g} GB, "
            "more "
                           f"than half of the memory, {room / 1e9:.3g} GB: ask for a shorter time, "
                           "as slice(0, 0.1)")


def _rows(values: list[list[float | None]], rows: int, columns: int) -> npt.NDArray[np.float64]:
    """A table with a row for each probe, also where there is none, or nothing of them; None is
    NaN."""
    return np.array(values, dtype=float).reshape(rows, columns)


def _without_absent_probes(found: xr.Dataset) -> xr.Dataset:
    """Without the dimensions of probes that a scene does not name: a table over them has no
    row."""
    return found.drop_dims([name for name, size in found.sizes.items()
                            if size == 0 and name != "frequency"])


def _figure(value: float) -> str:
    return f"{value:.5g}" if math.isfinite(value) else "none"


def _places(at: npt.ArrayLike) -> tuple[str, ...]:
    """The program's options for microphones; none where there is none."""
    try:
        places = np.asarray(at, dtype=float)
    except (TypeError, ValueError):
        places = np.empty(())  # no numbers, or not as many in each row
    if places.shape == (0,):
        return ()
    if places.ndim != 2 or places.shape[1] != 3:
        raise RequestError(f"at is {at!r}: expected microphones of three numbers each, x, y and z "
                           "in m, as [(0.15, 0.1, 0.5)]")
    return tuple(word for place in places.tolist() for word in ("--at", ",".join(map(repr, place))))


def _air_options(temperature: float | None, pressure: float | None) -> tuple[str, ...]:
    """The program's options for the air. What it would refuse later is refused here, in its
    words."""
    for name, value, low, high in (("temperature", temperature, -50, 100),
                                   ("pressure", pressure, 10_000, 1_000_000)):
        try:
            is_right = value is None or low <= float(value) <= high
        except (TypeError, ValueError):
            is_right = False
        if not is_right:
            raise RequestError(f"--{name}: '{value}': expected from {low} to {high}")
    return tuple(program.options({"--temperature": temperature, "--pressure": pressure}))


class Result:
    """A result of `ra2d run`: one HDF5 file. Opening reads nothing but its header; each property
    reads what it shows. A file that has been replaced since then is an error.

    - `title`: the scene's name, that of the file where it has none
    - `complete`: False where the run was cut short; `attrs["ended"]` says why
    - `attrs`: the attributes of the file, as docs/results.md lists them

    >>> result = getfixture("result")
    >>> result                                               # doctest: +ELLIPSIS
    <ra2d.Result cube.h5: 1 s of 'roughness noise', 116... dB re 1 nm/s>
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = pathlib.Path(path).resolve()
        self._file = stored.File(self.path)
        self.attrs = self._file.attributes()  # of the file, as docs/results.md lists them
        if any(isinstance(value, np.ndarray) for value in self.attrs.values()):
            raise FileError(f"{str(path)!r} is damaged: one of its attributes is an array")
        if self.attrs.get("creator") != "ra2d" or "steps" not in self.attrs:
            raise FileError(f"{str(path)!r} is no result of 'ra2d run'")
        if self.attrs.get("format") not in FORMATS:
            raise FileError(f"{str(path)!r} has format {self.attrs.get('format')}, this package "
                            "reads "
                            f"{', '.join(map(str, FORMATS))}: take the package that came with the "
                            "program")
        try:
            self._scene = toml.parse(str(self.attrs["scene"]))
            # as programs wrote it whose faces were linear by default
            self._scene["scene"].setdefault("faces", "linear")
            self.title = str(self._scene["scene"].get("name") or self.path.stem)
            # False: cut short; attrs["ended"] says why
            self.complete = bool(self.attrs["complete"])
            self._counted_from = float(self._scene.get("output", {}).get("from", 0.0))
            for section, key in _PLACES:
                number = self._scene.get(section, {}).get(key, 0.0)
                if not isinstance(number, int | float) or not math.isfinite(number):
                    raise ValueError(f"its scene has {section}.{key} = {number!r}, which is no "
                                     "number")
        except (AttributeError, KeyError, TypeError, ValueError, RequestError) as fault:
            raise FileError(f"{str(path)!r} is damaged: {fault}") from fault
        self._analyses: dict[tuple[str, ...], str] = {}  # in JSON
        self._hears: tuple[str, ...] = ()  # options of with_microphones()

    # ---- numbers
    # ----------------------------------------------------------------------------------

    def analysis(self, *, start: float | None = None, stop: float | None = None,
                 resolution: float | None = None,
                 segment: int | None = None, a_weighting: bool = False,
                 at: npt.ArrayLike = (),
                 power: bool = False) -> dict[str, Any]:
        """All that `ra2d analyze --json` says (docs/analysis.md), in SI units; None for what does
        not exist. The program is asked once for each set of options.

        - `start`, `stop` [s]: the stretch of the run; from `output.from` to the end
        - `resolution` [Hz] or `segment` [samples]: of the spectrum
        - `a_weighting`: also weigh the bands as ears do
        - `at`: microphones, each (x, y, z) [m], in the air of `with_microphones` or the scene;
          `power`: the sound power (docs/sound.md)

        >>> getfixture("result").analysis()["contact_share"] < 1
        True
        >>> heard = getfixture("result").analysis(at=[(0.15, 0.1, 0.5)])["microphones"]
        >>> 50 < heard[0]["lpa"] < 80
        True
        """
        options = tuple(program.options({"--from": start, "--to": stop, "--resolution": resolution,
                                         "--segment": segment,
                                         "--a-weighting": bool(a_weighting),
                                         "--power": bool(power)}))
        places = _places(at)
        options += places + self._air() if places else self._hears
        self._file.require_unchanged()
        if options not in self._analyses:
            self._analyses[options] = program.call("analyze", self.path, *options, "--json")
        # each call its own: what is changed in an answer changes no other
        answer: dict[str, Any] = json.loads(self._analyses[options])
        return answer

    def with_microphones(self, at: npt.ArrayLike, *, temperature: float | None = None,
                         pressure: float | None = None) -> Result:
        """This result with microphones at these places, each (x, y, z) [m], instead of its scene's:
        its analysis, plots ("bands", "level") and page have the pressure there (docs/sound.md).
        `temperature` [degrees Celsius] and `pressure` [Pa] are those of the air.

        >>> heard = getfixture("result").with_microphones([(0.15, 0.1, 0.5)])
        >>> len(heard.plot("bands").axes)
        2
        """
        places = _places(at)
        if not places:
            raise RequestError("at: expected one microphone or more, each (x, y, z) in m")
        hearing = copy.copy(self)
        hearing._hears = places + _air_options(temperature, pressure)
        return hearing

    def _air(self) -> tuple[str, ...]:
        """The program's options for the air of with_microphones()."""
        pairs = zip(self._hears[::2], self._hears[1::2])
        return tuple(word for name, value in pairs if name != "--at" for word in (name, value))

    @property
    def level(self) -> Estimate:
        """Vibration level of the resonator [dB re 1 nm/s] with its 95 % interval: chance within
        this run, not the choice of seed.

        >>> getfixture("result").level                           # doctest: +ELLIPSIS
        116... dB re 1 nm/s (95 %: 11... to 11...)
        """
        found = self.analysis()
        note = AT_REST if found["v_rms"] == 0 else found["no_interval"]
        return Estimate.of(found["lv"], found["lv_interval"], "dB re 1 nm/s",
                           note or "chance within this run, with these surfaces")

    @property
    def shock_rate(self) -> Estimate:
        """Shocks a second [1/s], with a 95 % interval as that of `level`.

        >>> getfixture("result").shock_rate.unit
        '1/s'
        """
        found = self.analysis()
        return Estimate.of(found["shocks"]["rate"], found["shocks"]["rate_interval"], "1/s",
                           found["no_interval"] or "chance within this run, with these surfaces")

    @property
    def summary(self) -> xr.Dataset:
        """The figures of the report as scalars with units (docs/results.md, group `summary`).

        >>> getfixture("result").summary.v_rms.units
        'm s-1'
        """
        return self._file.scalars("summary", _SUMMARY)

    def spectrum(self, **options: Any) -> xr.Dataset:
        """One-sided power spectral densities over `frequency` [Hz]. Options: those of `analysis`.

        - `density` [(m/s)^2/Hz]: of the velocity, mean over the resonator
        - `density_probe` (position, frequency), `density_slider_probe` (slider_position,
          frequency): of the probes' velocity; of an areal scene (probe, frequency) and
          (slider_probe, frequency), as `probes`; left out where there are no such probes
        - `density_force` [N^2/Hz]: of the total contact force

        Of a run with `output.modes = "none"` `density` is NaN, and its attribute `note` says why.
        `attrs`: `resolution` [Hz], `segments`, and `low`, `high`: a density times these holds the
        true one with probability 0.95, for stationary noise.

        >>> getfixture("result").spectrum(resolution=25.0).sizes["frequency"] > 1000
        True
        """
        found = self.analysis(**options)
        s = found["spectrum"]
        velocity, force = {"units": "m2 s-2 Hz-1"}, {"units": "N2 Hz-1",
                                                     "long_name": "density of the contact force"}
        lines = len(s["frequency"])
        along, places = self._probe_places(found["probes"])
        slider_along, slider_places = self._probe_places(found["slider_probes"], "slider")
        return _without_absent_probes(xr.Dataset(
            {"density": ("frequency", np.array(s["psd_mean"], dtype=float),
                         {**velocity, "long_name": "density of the resonator's velocity",
                          **self._no_modes()}),
             "density_probe": ((along, "frequency"),
                               _rows(s["psd_probe"], len(found["probes"]), lines),
                               {**velocity, "long_name": "density of the velocity at the probes"}),
             "density_slider_probe": ((slider_along, "frequency"),
                                      _rows(s["psd_slider_probe"], len(found["slider_probes"]),
                                            lines),
                                      {**velocity,
                                       "long_name":
                                       "density of the velocity at the slider's probes"}),
             "density_force": ("frequency", s["psd_force"], force)},
            {"frequency": ("frequency", s["frequency"], {"units": "Hz", "long_name": "frequency"}),
             **places, **slider_places},
            {"resolution": s["resolution"], "segments": s["segments"],
             "low": s["confidence"]["low"],
             "high": s["confidence"]["high"]}))

    def bands(self, **options: Any) -> xr.Dataset:
        """Third octaves over their midband `frequency` [Hz]. Options: those of `analysis`.

        - `level` [dB re 1 nm/s]: of the resonator's elastic velocity; `level_probe` (position,
          frequency): at the probes, if there are any; with `a_weighting=True` also `level_a`
        - `spread` [dB]: standard deviation by the finite length of the run, for stationary noise
        - `above_last_mode`: True where a band lies above the last mode, and says nothing

        >>> bands = getfixture("result").bands()
        >>> float(bands.level.sel(frequency=1000, method="nearest")) > 80
        True
        """
        found = self.analysis(**options)
        b = found["bands"]
        along, places = self._probe_places(found["probes"])
        decibels = {"units": "dB", "long_name": "level re 1 nm/s"}
        data = {"level": ("frequency", np.array(b["level"], dtype=float),
                          {**decibels, **self._no_modes()}),
                "spread": ("frequency", np.array(b["spread"], dtype=float),
                           {"units": "dB", "long_name": "standard deviation by the finite length"}),
                "above_last_mode": ("frequency", b["above_last_mode"]),
                "level_probe": ((along, "frequency"), _rows(
                    b["level_probe"], len(found["probes"]), len(b["centre"])), decibels)}
        if "level_a" in b:
            data["level_a"] = ("frequency", np.array(b["level_a"], dtype=float),
                               {"units": "dB", "long_name": "A-weighted level re 1 nm/s"})
        return _without_absent_probes(xr.Dataset(
            data,
            {"frequency": ("frequency", b["centre"],
                           {"units": "Hz", "long_name": "midband frequency"}),
             "nominal": ("frequency", b["nominal"]), **places},
            {"last_mode": b["last_mode"]}))

    def _no_modes(self) -> dict[str, str]:
        """Attributes of what is made of the modes' motion: why it is NaN; nothing where it is
        not."""
        if self._scene.get("output", {}).get("modes") != "none":
            return {}
        return {"note": 'not known: the file has no motion of the modes (output.modes = "none")'}

    def _probe_places(self, places: list[Any], body: str = "") -> tuple[str, dict[str, Any]]:
        """The dimension of an analysis' probes, and their coordinates."""
        prefix, on = (f"{body}_", body) if body else ("", "resonator")
        along = {"units": "m", "long_name": f"place on the {on}"}
        if not self.is_areal:
            return f"{prefix}position", {f"{prefix}position": (f"{prefix}position", places, along)}
        probe = f"{prefix}probe"
        x, y = zip(*places) if places else ((), ())
        return probe, {probe: (probe, np.arange(1, len(places) + 1)),
                       f"{prefix}position": (probe, np.array(x, dtype=float), along),
                       f"{prefix}y": (probe, np.array(y, dtype=float),
                                      {"units": "m", "long_name": f"place across the {on}"})}

    @property
    def shocks(self) -> pd.DataFrame:
        """Every shock, in order of start; its index is its number. Columns: `start` [s], `duration`
        [s], `peak_force` [N], `impulse` [N s], `position` [m, on the resonator], of an areal scene
        also `y` [m, across the resonator]; `attrs["units"]` names the units.

        >>> getfixture("result").shocks.columns.tolist()
        ['start', 'duration', 'peak_force', 'impulse', 'position']
        """
        names = [*_SHOCKS, *(["y"] if self.is_areal else [])]
        dims = {name: ("shock",) for name in (*names, "shock", "serial")}
        found = self._file.read("shocks", dims, names, ("shock",)).load()
        number = found["serial" if "serial" in found else "shock"]  # from 0 where there is neither
        table = pd.DataFrame({name: found[name].values for name in names},
                             index=pd.Index(number.values.astype(np.int64), name="shock"))
        table.attrs["units"] = {name: found[name].attrs.get("units", "") for name in names}
        return table

    def check(self) -> None:
        """Compares the whole file with its seal and its hashes (`ra2d check`); FileError names what
        is damaged. What is read is compared with the seal at each reading, if there is one.

        >>> getfixture("result").check()
        """
        self._file.require_unchanged()
        program.call("check", self.path)

    # ---- series
    # -----------------------------------------------------------------------------------

    @property
    def probes(self) -> xr.Dataset:
        """`displacement` [m] and `velocity` [m/s] of the resonator, dimensions (time, position). Of
        an areal scene (time, probe): probes have numbers from 1 and the coordinates `position` and
        `y`.

        >>> getfixture("result").probes.velocity.sel(position=0.15).dims
        ('time',)
        """
        return self._probes("probes")

    @property
    def slider_probes(self) -> xr.Dataset:
        """Displacement and velocity at the slider's probes; `position` [m] counts from its left
        end.

        >>> getfixture("result").slider_probes.sizes["position"]
        0
        """
        return self._probes("slider_probes")

    def _probes(self, group: str) -> xr.Dataset:
        if not self.is_areal:
            return self._file.read(group, _PROBES, _PROBES, _SAMPLED)  # places in any order
        return self._file.read(group, _AREAL_PROBES, _AREAL_PROBES,
                               _RISING).set_coords(["position", "y"])

    @property
    def is_areal(self) -> bool:
        """Whether its scene is areal: a plate, a block and height maps.

        >>> getfixture("result").is_areal
        False
        """
        return bool(self.attrs["format"] == AREAL_FORMAT)

    @property
    def contact(self) -> xr.Dataset:
        """`force` [N], total normal force, and `nodes`, number in contact, over `time` [s].

        >>> float(getfixture("result").contact.force.min()) >= 0
        True
        """
        dims: dict[str, tuple[str, ...]] = {**_SAMPLED, "force": ("time",), "nodes": ("time",)}
        return self._file.read("contact", dims, dims, _RISING)

    @property
    def energy(self) -> xr.Dataset:
        """Energies over `time` [s], in J: `kinetic`, `elastic`, `contact`; since t = 0
        `damping_loss`, `sliding_work`, `load_work`.

        >>> getfixture("result").energy.kinetic.units
        'J'
        """
        names = ("kinetic", "elastic", "contact", "damping_loss", "sliding_work", "load_work")
        series = self._file.read("energy", {name: ("time",) for name in names}, names)
        time = self._file.read("/", _SAMPLED, _SAMPLED, _RISING)
        with self._file.opened():  # where the time has another length, the file is damaged
            return series.assign_coords(time.coords)

    def modes(self, body: Body = "resonator") -> xr.Dataset:
        """The modes of a body: `frequency` [Hz], `shape` (mode, position) [m^-1/2], and over
        (time, mode) the modal `displacement` [m^3/2] and `velocity` [m^3/2/s], which a run with
        `output.modes = "none"` does not keep. Of an areal scene the shape is the product of
        `shape_x` (mode, position) [1/m] and `shape_y` (mode, y), displacements are in m^2, and the
        resonator has the half waves `mode_x` and `mode_y`.

        >>> getfixture("result").modes("slider").sizes["mode"]
        2
        """
        shapes = ("shape_x", "shape_y", "y") if self.is_areal else ("shape",)
        return self._file.read(_one_of("body", body, BODIES), _MODES,
                               ("mode", "position", "frequency", *shapes), _RISING)

    def field(self, time: float | slice | Any, body: Body = "resonator",
              what: Motion = "displacement") -> xr.DataArray:
        """Displacement [m] or velocity [m/s] along a body: modes times shapes. `time` [s]: an
        instant (the nearest sample is taken), several, or a slice. Dimensions: (position), or
        (time, position); up to 1001 places. Of an areal scene a map: (y, position), or
        (time, y, position).

        >>> getfixture("result").field(0.1).dims
        ('position',)
        >>> getfixture("result").field(slice(0.1, 0.11)).sizes["time"]
        1001
        """
        modes = self.modes(body)
        if _one_of("what", what, MOTIONS) not in modes:
            raise RequestError(
                f"{str(self.path)!r} has no motion of the modes, of which a field is made: its "
                "scene has "
                               "output.modes = \"none\"")
        series = modes[what]
        if series.dtype.kind != "f":
            raise FileError(f"{str(self.path)!r} is damaged: its {what} is no series of numbers. "
                            "'ra2d check' says what of it is damaged")
        if isinstance(time, slice):
            time = _numbers(time, modes.time)
        else:
            _require_within(time, modes.time)
        chosen = series.sel(time=time, method=None if isinstance(time, slice) else "nearest")
        across = modes.sizes["y"] if self.is_areal else 1
        _require_room(math.prod(chosen.sizes[name] for name in chosen.dims if name != "mode"),
                      across * max(modes.sizes["position"], modes.sizes["mode"]) if self.is_areal
                      else modes.sizes["position"])
        amplitude = chosen.load()
        if self.is_areal:
            found: xr.DataArray = (amplitude * modes["shape_y"].load()).dot(
                modes["shape_x"].load(), "mode")
        else:
            found = amplitude.dot(modes["shape"].load())
        found.attrs = {"units": "m" if what == "displacement" else "m s-1",
                       "long_name": f"{what} of the {body}"}
        return found.rename(what)

    def profile(self, body: Body = "resonator") -> xr.DataArray:
        """Heights [m] of a face over `position` [m], as the run used them; positive towards the
        other body. Of an areal scene a map over (y, position), of the resonator under the slider.

        >>> getfixture("result").profile("slider").sizes["position"]
        2501
        """
        dims = {"position": ("position",), "y": ("y",), "height": ("y", "position") if self.is_areal
                else ("position",)}
        needed = [*dims] if self.is_areal else ["position", "height"]
        return self._file.read(f"surface/{_one_of('body', body, BODIES)}", dims,
                               needed, _RISING)["height"]

    def height_hash(self, body: Body = "resonator") -> str:
        """The `xxh3_128` of a face's heights, by which a profile is recognised.

        >>> len(getfixture("result").height_hash("slider"))
        32
        """
        path = f"surface/{_one_of('body', body, BODIES)}/height"
        with self._file.opened() as file:
            height = stored.required(file, path, 2 if self.is_areal else 1)
            return str(height.attrs["xxh3_128"])

    # ---- what it was
    # --------------------------------------------------------------------------------

    @property
    def scene(self) -> Scene:
        """The complete scene of this run. It runs again: `ra2d.run(result.scene, speed=0.2)`.

        >>> getfixture("result").scene["contact.law"]
        'penalty'
        """
        return Scene(self._scene)

    def zoom(self, number: int = 1) -> Result:
        """A window of this run that `ra2d run --zoom` has sampled far more often (docs/results.md):
        the file OUT.zoom-1.h5 beside OUT.h5.

        >>> getfixture("result").zoom(1)
        Traceback (most recent call last):
        ra2d.errors.FileError: ... 'ra2d run --zoom' makes it
        """
        path = self.path.with_suffix(f".zoom-{number}{self.path.suffix}")
        if not path.exists():
            raise FileError(f"there is no window {number} of this run, {str(path)!r}: 'ra2d run "
                            "--zoom' makes it")
        window = Result(path)
        if window._run() != self._run():
            raise FileError(f"{str(path)!r} is a window of another run than {str(self.path)!r}: "
                            "remove it, and have 'ra2d run --zoom' make it again")
        return window

    def _run(self) -> tuple[Any, ...]:
        """Equal for a run and its windows."""
        scene = copy.deepcopy(self._scene)
        for section, key in _WINDOW_KEYS:
            scene.get(section, {}).pop(key, None)
        scene.pop("air", None)
        for body in BODIES:
            scene[body].get("surface", {}).pop("path", None)  # its heights tell more
            if not self.is_areal:
                scene[body].pop("poisson", None)
        return scene, *map(self.height_hash, BODIES)

    # ---- looking and listening
    # ----------------------------------------------------------------------

    def plot(self, what: str = "overview", *, start: float | None = None, stop: float | None = None,
             shock: int | None = None, time: float | None = None) -> Figure:
        """A picture as a matplotlib Figure: the whole page, or one panel of docs/pictures.md:
        "profiles", "force", "displacement", "spectrum", "probe-spectra", "shocks", "level",
        "energy", "bands", "spectrogram" (or "waterfall"), "shock", "motion".

        - `start`, `stop` [s]: of this stretch of the run alone
        - `shock`: which one is shown as "shock", by its number in `shocks`; the strongest without
          it
        - `time` [s]: of "motion"; that of the largest contact force without it

        >>> getfixture("result").plot("bands").axes[0].get_xlabel()
        'midband frequency [Hz]'
        >>> getfixture("result").plot("force", start=0.2, stop=0.21).axes[0].get_xlabel()
        'time after 200 ms [ms]'
        """
        from . import plots

        return plots.result(self, what, start=start, stop=stop, shock=shock, time=time)

    def listen(self, probe: int = 1, *, body: Body = "resonator", slow: float = 1,
               full_scale: float | None = None,
               normalize: bool = False, rate: int = 48000, start: float | None = None,
               stop: float | None = None, at: npt.ArrayLike = ()) -> Sound:
        """The velocity of a probe (from 1) as sound, which a notebook plays; with `at` the sound
        pressure at one microphone, or two for stereo, each (x, y, z) [m], in the air of
        `with_microphones` or the scene. `slow`: times longer and lower; `full_scale` [m/s; Pa]:
        what the value 1 stands for, or `normalize`: the peak; `rate`: samples a second of the
        sound; `start`, `stop` [s] of the run.

        >>> sound = getfixture("result").listen(slow=2)
        >>> sound.rate, sound.samples.ndim
        (48000, 1)
        >>> getfixture("result").listen(at=[(0.15, 0.1, 0.5)]).about["quantity"]
        'sound pressure'
        """
        from .sound import of_microphones, of_probe

        if normalize and full_scale is not None:
            raise RequestError(f"full_scale is {full_scale!r} and normalize True: both say what "
                               "the value 1 stands for, give one of them")
        if places := _places(at):
            if probe != 1 or body != "resonator":
                raise RequestError(
                    "probe and body are of a velocity; with at the sound is a pressure: give one "
                    "of them")
            return of_microphones(self, places + self._air(), slow=slow, rate=rate,
                                  full_scale=full_scale, normalize=normalize,
                                  start=start, stop=stop)
        return of_probe(self, probe, _one_of("body", body, BODIES), slow=slow, rate=rate,
                        full_scale=full_scale,
                        normalize=normalize, start=start, stop=stop)

    def report(self, path: str | os.PathLike[str] | None = None) -> pathlib.Path:
        """Writes one page to keep or to send, complete in itself: figures, pictures, sound, scene.
        Without a path it stands beside the result. Returns where it is.

        >>> getfixture("result").report("cube.html").name
        'cube.html'
        """
        from . import page

        return page.of_results([self], pathlib.Path(path or self.path.with_suffix(".html")))

    def _headline(self) -> str:
        lv = float(self.summary.get("lv", math.nan))
        if math.isinf(lv):
            return f"no level: {AT_REST}"
        return "no level" if math.isnan(lv) else f"{lv:.1f} dB re 1 nm/s"

    @property
    def samples(self) -> int:
        """How many samples there are.

        >>> getfixture("result").samples
        100001
        """
        return self._ends()[0]

    @property
    def rate(self) -> float:
        """Samples a second [1/s]; NaN of fewer than two.

        >>> getfixture("result").rate
        100000.0
        """
        samples, first, last = self._ends()
        if samples < 2:
            return math.nan
        rate = (samples - 1) / (last - first)
        whole = float(round(rate))
        return whole if abs(rate - whole) < 1e-9 * rate else rate  # roundings of the last time

    @property
    def counted_from(self) -> float:
        """Time [s] from which on levels and shocks are counted: `output.from` of the scene.

        >>> getfixture("result").counted_from
        0.0
        """
        return self._counted_from

    @property
    def duration(self) -> float:
        """Time of the last sample [s].

        >>> getfixture("result").duration
        1.0
        """
        return self._ends()[2]

    def _ends(self) -> tuple[int, float, float]:
        """How many samples there are, the time of the first and that of the last [s]."""
        with self._file.opened() as file:
            time = stored.required(file, "time", 1)
            if not time.size:
                return 0, 0.0, 0.0
            first, last = float(time[0]), float(time[-1])
            if not (0 <= first <= last < stored.LARGEST
                    and (time.size == 1 or last - first > time.size / stored.LARGEST)):
                raise ValueError("/time does not rise")
            return time.size, first, last

    def __repr__(self) -> str:
        cut = "" if self.complete else f", cut short: {self.attrs.get('ended')}"
        try:
            said = f"{self.duration:g} s of {self.title!r}, {self._headline()}{cut}"
        except FileError:  # a debugger and a notebook show what there was
            said = f"of {self.title!r}, its file is gone, was replaced or is damaged{cut}"
        return f"<ra2d.Result {self.path.name}: {said}>"

    def _repr_html_(self) -> str:
        left = "<td style='text-align:left'>"
        try:
            summary = dict(self.summary.items())
        except FileError:
            summary = {}
        figures = "".join(f"<tr>{left}{html.escape(of.attrs.get('long_name', str(name)))}</td>"
                          f"<td>{_figure(float(of))}</td>"
                          f"{left}{html.escape(of.attrs.get('units', ''))}</td></tr>"
                          for name, of in summary.items())
        return f"<b>{html.escape(repr(self)[1:-1])}</b><table>{figures}</table>"


def load(path: str | os.PathLike[str]) -> Result:
    """A result of `ra2d run`, by its file. A file of any size opens at once. A Notice says of one
    without a seal that what is read of it cannot be compared.

    >>> import ra2d
    >>> ra2d.load("cube.h5").complete
    True
    """
    path = pathlib.Path(path)
    if path.is_dir():
        raise RequestError(f"{str(path)!r} is a folder: ra2d.load_study reads a study")
    result = Result(path)
    if not result._file.is_sealed:
        notice(f"{str(path)!r} has no seal at its end that this package reads: it was cut short, "
               "or changed since ra2d wrote it, or an older ra2d wrote it. Nothing tells whether "
               "its numbers are right: run its scene again, or ask 'ra2d check'")
    return result


def report(results: Result | Sequence[Result], path: str | os.PathLike[str]) -> pathlib.Path:
    """Writes one page of several results side by side, with their means. Returns where it is.

    >>> import ra2d
    >>> slow, fast = [ra2d.run("dang2012", speed=v, duration=0.02, tolerance=1e-6)
    ...               for v in (0.1, 0.2)]
    >>> ra2d.report([slow, fast], "speeds.html").name
    'speeds.html'
    """
    from . import page

    many = [results] if isinstance(results, Result) else list(results)
    if not all(isinstance(result, Result) for result in many):
        raise RequestError("a page takes one or more results of ra2d.run or ra2d.load")
    return page.of_results(many, pathlib.Path(path))
