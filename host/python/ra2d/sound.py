# SPDX-License-Identifier: BSD-3-Clause
"""Sounds of a result: `ra2d sound` resamples, a notebook plays."""
from __future__ import annotations

import base64
import dataclasses
import io
import json
import os
import pathlib
from typing import Any

import numpy as np
import numpy.typing as npt
import soundfile

from . import program
from .errors import FileError, RequestError


@dataclasses.dataclass(frozen=True, repr=False)
class Sound:
    """A sound. A notebook shows it with a player.

    - `samples`: 1-D, velocity over full scale
    - `rate` [1/s]
    - `about`: what `ra2d sound` says of it (docs/sound.md): `full_scale_m_per_s`, `peak_m_per_s`, ...

    >>> getfixture("result").listen()
    <ra2d.Sound of the resonator at 0.15 m, 1 s; full scale 0.01 m/s>
    """

    samples: npt.NDArray[np.float64]
    rate: int
    about: dict[str, Any]

    def save(self, path: str | os.PathLike[str], subtype: str | None = None) -> pathlib.Path:
        """Writes WAV or FLAC, by the ending. `subtype` as in soundfile; 24 bit without it.

        >>> getfixture("result").listen().save("cube.flac").name
        'cube.flac'
        """
        try:
            soundfile.write(path, self.samples, self.rate, subtype=subtype or "PCM_24")
        except (TypeError, ValueError) as fault:
            raise RequestError(f"cannot write {str(path)!r}: {fault}. Expected a name that ends in .wav or .flac, and "
                               "a subtype such as PCM_16 or PCM_24") from fault
        except (OSError, RuntimeError) as fault:
            raise FileError(f"cannot write {str(path)!r}: {fault}. Is there such a folder, and may you write there?"
                            ) from fault
        return pathlib.Path(path)

    def wav(self) -> bytes:
        """A WAV of 16 bits, which every browser plays.

        >>> getfixture("result").listen(stop=0.1).wav()[:4]
        b'RIFF'
        """
        out = io.BytesIO()
        soundfile.write(out, np.clip(self.samples, -1, 1), self.rate, format="WAV", subtype="PCM_16")
        return out.getvalue()

    def source(self) -> str:
        """The WAV as an address that a page holds in itself.

        >>> getfixture("result").listen(stop=0.1).source()[:22]
        'data:audio/wav;base64,'
        """
        return "data:audio/wav;base64," + base64.b64encode(self.wav()).decode()

    def __repr__(self) -> str:
        a = self.about
        return (f"<ra2d.Sound of the {a['body']} at {a['position']:g} m, {len(self.samples) / self.rate:.3g} s; "
                f"full scale {a['full_scale_m_per_s']:g} m/s>")

    def _repr_html_(self) -> str:
        return f'<audio controls src="{self.source()}"></audio><br><code>{repr(self)[1:-1]}</code>'


def of_probe(result: pathlib.Path, probe: int, body: str, options: dict[str, float | None]) -> Sound:
    """The velocity of a probe, resampled by the program; options that are None are left out."""
    words = program.options({"--slider-probe" if body == "slider" else "--probe": probe, **options})
    with program.scratch() as folder:
        file = folder / "sound.wav"
        program.call("sound", result, "-o", file, *words)
        samples, rate = soundfile.read(file, dtype="float64")
        return Sound(samples, rate, json.loads(file.with_name("sound.wav.json").read_text()))
