# SPDX-License-Identifier: BSD-3-Clause
"""Sound against closed forms: a sine stays a sine, in amplitude and time, at every rate."""
import io
import json
import math
import pathlib
import types
import wave

import numpy as np
import pytest
import soundfile
import xarray as xr

import ra2d
from ra2d import sound

RATES = [(100e3, 48e3), (100e3, 44.1e3), (100e3, 96e3), (1e6, 48e3), (44.1e3, 48e3), (20e3, 48e3),
         (5e3, 48e3),
         (100e3 / 7, 48e3), (250, 48e3), (51234.5, 48e3), (100000.1, 48e3), (1 / 3e-5, 44.1e3)]


def sine(frequency, amplitude=1.0, phase=0.3):
    return lambda t: amplitude * np.sin(2 * np.pi * frequency * t + phase)


def middle_error(values, motion, rate):
    """Largest error of the middle of a signal: at its ends it begins and ends at once, and
    rings."""
    at = np.arange(values.size // 4, 3 * values.size // 4)
    return np.abs(values[at] - motion(at / rate)).max()


@pytest.mark.parametrize("old, new", RATES)
def test_what_is_below_half_the_rate_keeps_amplitude_and_time(old, new):
    t = np.arange(int(max(4000, 4000 * old / new))) / old
    for share in (0.01, 0.1, 0.5, 0.9):
        motion = sine(share * min(old, new) / 2)
        # as docs/sound.md promises
        assert middle_error(sound.resample(motion(t), old, new), motion, new) < 1e-8


@pytest.mark.parametrize("old, new", RATES)
def test_nothing_passes_from_above_half_the_new_rate(old, new):
    t = np.arange(int(4000 * old / new)) / old
    for share in (1.0, 1.02, 1.2, 1.5, 2.0, 3.3):
        if (frequency := share * new / 2) <= old / 2:
            made = sound.resample(sine(frequency)(t), old, new)
            assert middle_error(made, lambda _: 0, new) < 1e-9  # 180 dB


@pytest.mark.parametrize("frequency", [100, 2000, 2270])
def test_a_higher_rate_makes_no_images(frequency):
    found = sound.resample(sine(frequency)(np.arange(4000) / 5e3), 5e3, 48e3)
    assert middle_error(found, sine(frequency), 48e3) < 1e-8


@pytest.mark.parametrize("old, new", RATES)
def test_it_goes_from_the_first_sample_to_the_last(old, new):
    for count in (1, 2, 3, 10, 1000, 4801):
        last, size = (count - 1) / old, sound.resample(np.ones(count), old, new).size
        assert (size - 1) / new <= last * (1 + 1e-12) + 1e-12
        assert size / new > last * (1 - 1e-12)
    assert sound.resample(np.ones(100001), 100e3, 48e3).size == 48001


def test_a_signal_of_the_same_rate_stays_as_it_is():
    values = sine(777)(np.arange(1234) / 48e3)
    assert np.array_equal(sound.resample(values, 48e3, 48e3), values)


def test_full_scale_is_the_next_round_velocity():
    for peak, scale in ((1, 1), (1.0001, 2), (2, 2), (2.1, 5), (5e-3, 5e-3), (5.1e-3, 1e-2),
                        (9.99e-7, 1e-6), (0, 1),
                        (3e-300, 5e-300), (0.1, 0.1), (1e-3, 1e-3), (720, 1000),
                        (1.7e308, 1.7e308)):
        assert sound.round_full_scale(peak) == scale


# ---- of a probe
# -----------------------------------------------------------------------------------

def moving(*probes, count=100001, rate=100e3, modes=(100, 18.9e3), slider=(), begins=0.0):
    """What sound asks of a result, whose probes move like this [m/s at s]."""
    time = begins + np.arange(count) / rate

    def of(motions, apart):
        return xr.Dataset({"velocity": (("time", "position"),
                                        np.array([m(time) for m in motions]).T.reshape(count, -1))},
                          {"time": time,
                           "position": [apart * (i + 1) for i in range(len(motions))]})

    frequencies = {"resonator": np.array(modes, dtype=float), "slider": np.zeros(1)}
    return types.SimpleNamespace(
        path=pathlib.Path("out.h5"), probes=of(probes, 0.1), slider_probes=of(slider, 0.01),
        rate=float(rate),
        counted_from=0.0, title="hiss", complete=True, attrs={"ended": "complete"},
        modes=lambda body: xr.Dataset({"frequency": ("mode", frequencies[body])}))


def read(made, encoding):
    return soundfile.SoundFile(io.BytesIO(made.encoded(encoding)))


def test_it_is_the_velocity_over_full_scale():
    made = sound.of_probe(moving(sine(1000, 3e-3)))
    assert (made.about["full_scale_m_per_s"] == 5e-3 and made.samples.size == 48001
            and not made.doubts)
    assert middle_error(made.samples, sine(1000, 0.6), 48e3) < 1e-6
    assert "the value 1.0 is 0.005 m/s" in read(made, "wav-24").comment
    assert "the value 1.0 is 0.005 m/s" in read(made, "flac-24").comment


@pytest.mark.parametrize("encoding, bits",
                         [("wav-16", 16), ("wav-24", 24), ("wav-32", 32), ("flac-24", 24)])
def test_files_are_off_by_half_a_step_at_most(encoding, bits):
    made = sound.of_probe(moving(sine(1000, 3e-3)))
    file = read(made, encoding)
    assert file.samplerate == 48000 and file.channels == 1 and file.subtype == f"PCM_{bits}"
    assert np.abs(file.read() - made.samples).max() <= 2.0 ** -bits * (1 + 1e-6)


@pytest.mark.parametrize("bits", [16, 24, 32])
def test_the_reader_of_python_takes_a_wav(bits, tmp_path):
    made = sound.of_probe(moving(sine(1000, 3e-3), count=1001))
    with wave.open(str(made.save(tmp_path / "s.wav", bits))) as file:
        assert (file.getframerate(), file.getsampwidth(),
                file.getnframes()) == (48000, bits // 8, made.samples.size)


def test_a_wav_of_floats_holds_what_is_beyond_full_scale():
    result = moving(sine(1000, 3e-3))
    made = sound.of_probe(result, full_scale=1e-3)
    floats, whole = read(made, "wav-float").read(), read(made, "wav-16").read()
    assert np.abs(floats - made.samples).max() <= 2.0**-24 * np.abs(floats).max()
    assert floats.max() == pytest.approx(3, rel=0.1)
    assert whole.max() == 1 - 2.0**-15 and whole.min() == -1
    share = 1 - 2 / math.pi * math.asin(1 / 3)  # of the time in which a sine of 3 is beyond 1
    assert made.about["beyond_full_scale"] / made.samples.size == pytest.approx(share, abs=1e-2)
    assert f"{made.about['beyond_full_scale']} of 48001 samples are beyond" in made.doubts[0]


@pytest.mark.parametrize("encoding, bits", [("wav-16", 16), ("wav-24", 24), ("wav-32", 32),
                                            ("flac-24", 24)])
def test_what_a_file_is_too_coarse_for_is_said(encoding, bits):
    step = 2.0 ** (1 - bits)
    result = moving(sine(1000, 3e-3), count=1001)
    for share, silent in ((0.4, True), (1.1, False)):  # of a step
        made = sound.of_probe(result, full_scale=3e-3 / (share * step))
        lost = " ".join(made.doubts_in(encoding))
        assert not made.doubts and (read(made, encoding).read() == 0).all() == silent
        assert (f"below a step of {bits} bits, {step:.2g}," in lost) == silent
        assert ("too soft to hear" in lost) == (not silent and bits == 32)
    assert "too soft to hear" in sound.of_probe(result, full_scale=3e5).doubts_in("wav-float")[0]
    assert sound.of_probe(result, full_scale=3e3).doubts_in("wav-float") == ()


def test_of_a_file_that_is_saved_it_is_said(tmp_path):
    made = sound.of_probe(moving(sine(1000, 3e-3), count=1001), full_scale=1e3)
    made.save(tmp_path / "s.wav")
    with pytest.warns(UserWarning, match="below a step of 16 bits"):
        made.save(tmp_path / "s.wav", 16)


def test_what_the_rates_spoil_is_said_of_a_file_and_beside_the_player(tmp_path):
    made = sound.of_probe(moving(sine(1000, 3e-3), modes=(100, 60e3)))
    assert "output.rate is too low" in made._repr_html_()
    with pytest.warns(ra2d.Notice, match="output.rate is too low"):
        made.save(tmp_path / "s.wav")


@pytest.mark.parametrize("rate, fine", [(65535, True), (65536, False), (96001, False),
                                        (96010, True)])
def test_rates_of_a_flac(rate, fine, tmp_path):
    made = sound.of_probe(moving(sine(1000, 3e-3), count=1001), rate=rate)
    if fine:
        assert read(made, "flac-24").samplerate == rate
    else:
        with pytest.raises(ra2d.RequestError, match=f"take {round(rate / 10) * 10}, or a WAV"):
            made.save(tmp_path / "s.flac")
        assert not list(tmp_path.iterdir())


def test_slowed_it_is_longer_and_lower():
    made = sound.of_probe(moving(sine(5000, 3e-3), count=20001), slow=20)
    assert made.samples.size == 192001 and "20 times slower" in read(made, "wav-24").comment
    assert middle_error(made.samples, sine(250, 0.6), 48e3) < 1e-6


def test_a_probe_a_part_and_a_rate():
    second = sine(440, 0.7)
    made = sound.of_probe(moving(sine(1000), second), 2, rate=44100, start=0.25, stop=0.75)
    assert (made.about["position"], made.about["from"], made.about["to"]) == (0.2, 0.25, 0.75)
    assert made.samples.size == 22051
    assert middle_error(made.samples, lambda t: second(t + 0.25), 44.1e3) < 1e-6


def test_a_result_that_begins_later():
    motion = sine(440, 0.7)
    made = sound.of_probe(moving(motion, begins=0.4, count=20001), start=0.45)
    assert made.about["from"] == 0.45 and made.samples.size == 7201
    assert middle_error(made.samples, lambda t: motion(t + 0.45), 48e3) < 1e-6


def test_the_slider_when_asked():
    second = sine(700, 0.3)
    made = sound.of_probe(moving(sine(1000), count=20001, modes=(100, 60e3),
                                 slider=(sine(500), second)), 2, "slider")
    assert made.about["position"] == 0.02 and not made.doubts  # the resonator's modes are not in it
    assert middle_error(made.samples, lambda t: second(t) / 0.5, 48e3) < 1e-6
    assert "velocity of slider probe 2 at 0.02 m" in read(made, "wav-24").comment


def test_normalised_only_when_asked():
    made = sound.of_probe(moving(sine(1000, 3e-3)), normalize=True)
    assert made.about["full_scale_m_per_s"] == made.about["peak_m_per_s"] and np.abs(
        made.samples).max() == 1


def test_the_same_sound_is_the_same_bytes():
    for encoding in ("wav-16", "wav-float", "flac-24"):
        result = moving(sine(1000, 3e-3), count=1001)
        assert sound.of_probe(result).encoded(encoding) == sound.of_probe(result).encoded(encoding)


@pytest.mark.parametrize("title, messages", [("", ""), ("hiss\x1b[2J", "hiss[2J"), ("\u0001", ""),
                                             ("r\u00fch", "r\u00fch")])
def test_titles_from_outside(title, messages):
    result = moving(sine(1000, 3e-3), count=1001)
    result.title = title
    assert read(sound.of_probe(result), "flac-24").title == messages


def test_what_the_rates_leave_out_is_said():
    def doubts(source, modes, **options):
        return " ".join(sound.of_probe(moving(sine(100), count=10001, rate=source, modes=modes),
                                       **options).doubts)

    found = doubts(20e3, (0, 100, 9e3, 12e3, 15e3))
    assert ("2 of the resonator's modes ring above 10000 Hz" in found
            and "output.rate = 44000 or more" in found)
    assert "output.rate = 61000 or more" in doubts(20e3, (0, 30.1e3))
    found = doubts(20e3, (0, 100, 9e3))
    assert "nothing above 9100 Hz is kept" in found and "output.rate = 44000 or more" in found
    assert "nothing above 18200 Hz" in doubts(40e3, (0, 9e3))
    assert doubts(44e3, (0, 9e3)) == doubts(40e3, (0, 9e3), rate=40000) == ""
    assert doubts(100e3, (0, 100, 9e3)) == ""
    assert "1 of the resonator's modes are left out" in doubts(100e3, (0, 100, 9e3), rate=16000)
    assert "silence: the probe at 0.1 m does not move" in " ".join(
        sound.of_probe(moving(lambda t: 0 * t)).doubts)


@pytest.mark.parametrize("options, words", [
    ({"probe": 3}, r"--probe 3: expected 1 to 1 \(at 0.1 m\)"),
    ({"body": "slider"}, r"output.slider_probes = \[0.01\]"),
    ({"slow": 0.5}, "slow is 0.5"), ({"slow": math.nan}, "slow is nan"),
    ({"rate": 100}, "rate is 100"),
    ({"full_scale": -1}, r"full_scale is -1: expected a number above 0 \(m/s\)"),
    ({"full_scale": 1e-300}, "expected a velocity near the peak"),
    ({"full_scale": 1e300}, "expected a velocity near the peak"),
    ({"start": 0.05, "stop": 0.04}, "there is nothing"),
    ({"stop": 7.0}, "the run ends at 1 s"), ({"start": 0.999995}, "there is one sample"),
    ({"start": 0.1, "stop": 0.10002}, "one sample of a sound of 48000 Hz")])
def test_what_cannot_be_heard(options, words):
    with pytest.raises(ra2d.RequestError, match=words):
        sound.of_probe(moving(sine(1000, 3e-3)), **options)


def test_too_long_a_sound_is_refused_before_anything_is_read():
    with pytest.raises(ra2d.RequestError, match="take a part of the run"):
        sound.of_probe(moving(sine(1000, 3e-3)), slow=1e4, rate=384000)


def test_rates_that_are_too_far_apart():
    with pytest.raises(ra2d.RequestError, match="more than a factor of 1e"):
        sound.resample(np.ones(3), 1e12, 48e3)


def test_the_text_beside_it():
    about = json.loads(sound.of_probe(moving(sine(1000, 3e-3), count=10001),
                                      slow=2).about_text("noise.wav"))
    assert about["file"] == "noise.wav" and about["quantity"] == "velocity" and about["slow"] == 2
    assert (about["from"], about["to"], about["source"],
            about["creator"]) == (0, 0.1, "out.h5", "ra2d")


# ---- at microphones
# ---------------------------------------------------------------------------------

def test_it_is_the_pressure_over_full_scale():
    time = np.arange(100001) / 100e3
    motions = sine(1000, 0.3), sine(3000, 0.03)
    heard_at = {"microphones": [[0.1, 0.2, 0.3], [1, 2, 3]], "from": 0.0, "to": 1.0}
    made = sound.of_pressure(moving(), np.array([motion(time) for motion in motions]), heard_at)
    assert made.about["full_scale_pa"] == 0.5 and made.samples.shape == (48001,
                                                                         2) and not made.doubts
    for channel, amplitude, frequency in ((0, 0.6, 1000), (1, 0.06, 3000)):
        assert middle_error(made.samples[:, channel], sine(frequency, amplitude), 48e3) < 1e-6
    for encoding in ("wav-24", "wav-float", "flac-24"):
        assert read(made, encoding).channels == 2
    comment = read(made, "flac-24").comment
    assert "sound pressure at 0.1, 0.2, 0.3 and 1, 2, 3 m, the value 1.0 is 0.5 Pa" in comment
    alone = sound.of_pressure(moving(), motions[0](time)[None, :],
                              {**heard_at, "microphones": [[1, 2, 3]]}, slow=2)
    assert alone.samples.ndim == 1 and "2 times slower" in alone.describe("x.wav")


def test_of_two_microphones_times_beyond_full_scale_are_counted_once():
    pressures = np.ones((2, 1000))
    pressures[1, 500:] = 3
    heard_at = {"microphones": [[0.1, 0.2, 0.3], [1, 2, 3]], "from": 0.0, "to": 1.0}
    made = sound.of_pressure(moving(rate=48e3), pressures, heard_at, full_scale=0.5)
    assert made.about["beyond_full_scale"] == made.about["samples"] == 1000
    assert "1000 of 1000 samples are beyond" in made.doubts[0]
    made = sound.of_pressure(moving(rate=48e3), pressures, heard_at, full_scale=2)
    assert made.about["beyond_full_scale"] == 500
    with pytest.raises(ra2d.RequestError, match="one sample of a sound"):
        sound.of_pressure(moving(), np.ones((1, 2)), heard_at)


def test_silence_is_said():
    made = sound.of_pressure(moving(), np.zeros((1, 1000)),
                             {"microphones": [[1, 2, 3]], "from": 0.0, "to": 0.01})
    assert made.doubts[0].startswith("silence: the resonator")
