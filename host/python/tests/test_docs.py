# SPDX-License-Identifier: BSD-3-Clause
"""Every public name says what it is, with an example that the tests run."""
import inspect

import pytest
import xarray as xr

import ra2d


def public_names():
    for name in ra2d.__all__:
        thing = getattr(ra2d, name)
        yield name, thing
        if inspect.isclass(thing) and not issubclass(thing, (BaseException, float)):
            for member, value in vars(thing).items():
                if not member.startswith("_") and (callable(value) or isinstance(value, property)):
                    yield f"{name}.{member}", value
        if inspect.ismodule(thing):
            for member, value in vars(thing).items():
                if inspect.isfunction(
                    value) and value.__module__ == thing.__name__ and not member.startswith("_"):
                    yield f"{name}.{member}", value


NAMES = dict(public_names())


@pytest.mark.parametrize("name", NAMES)
def test_a_public_name_has_words_and_an_example(name):
    words = inspect.getdoc(NAMES[name])
    assert words and (words[0].isupper() or words.startswith("ra2d") or words[0] == "`")
    if not (inspect.isclass(NAMES[name]) and issubclass(NAMES[name], (Exception, Warning))):
        assert ">>>" in words


def test_the_list_of_public_names_is_whole():
    assert {"Result.level", "Scene.change", "Study.law", "surface.read", "Sound.save",
            "run"} <= set(NAMES)
    assert sorted(ra2d.__all__) == sorted(set(ra2d.__all__))
    assert issubclass(ra2d.Study, xr.Dataset)
