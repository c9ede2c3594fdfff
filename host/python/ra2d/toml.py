# SPDX-License-Identifier: BSD-3-Clause
"""Values and scenes as TOML, as far as scenes and studies need it."""
from __future__ import annotations

import json
import os
import re
import tomllib
from collections.abc import Mapping
from typing import Any

import numpy as np

from .errors import RequestError


def value(given: Any) -> str:
    """One value: a number, a text, a path, a list or an inline table.

    >>> value({"kind": "gaussian", "rq": 8e-6, "seed": 2})
    '{ kind = "gaussian", rq = 8e-06, seed = 2 }'
    """
    if isinstance(given, np.generic | np.ndarray):
        given = given.tolist()
    if isinstance(given, bool):
        return "true" if given else "false"
    if isinstance(given, int | float):
        return repr(given) if isinstance(given, int) else _number(given)
    # counts from the current folder; a text, from the scene's file
    if isinstance(given, os.PathLike):
        given = os.path.abspath(given)
    if isinstance(given, str):
        return _text(given)
    if isinstance(given, Mapping):
        return "{ " + ", ".join(f"{key(k)} = {value(v)}" for k, v in given.items()) + " }"
    if isinstance(given, list | tuple | range):
        return "[" + ", ".join(map(value, given)) + "]"
    raise RequestError(
        f"a scene holds numbers, texts, lists and tables, not {type(given).__name__}: {given!r}")


def _text(given: str) -> str:
    """A text in quotes. TOML is UTF-8: names of files in another encoding have no place in it."""
    try:
        given.encode()
    except UnicodeEncodeError as fault:
        raise RequestError(
            f"{given!r} cannot stand in a scene, which is UTF-8: rename the file") from fault
    return json.dumps(given, ensure_ascii=False).replace("\x7f", "\\u007F")


def _number(given: float) -> str:
    """As Python writes it: it always has a point or an exponent, and comes back to the same
    bits."""
    return repr(float(given))


def key(name: str) -> str:
    """A key, in quotes where it needs them."""
    if not isinstance(name, str):
        raise RequestError(f"the keys of a scene are texts, not {type(name).__name__}: {name!r}")
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else _text(name)


def document(sections: Mapping[str, Mapping[str, Any]]) -> str:
    """A document of sections, in their order.

    >>> print(document({"scene": {"speed": 0.1}}), end="")
    [scene]
    speed = 0.1
    """
    for name, keys in sections.items():
        if not isinstance(keys, Mapping):
            raise RequestError(
                f"{name}: expected a section, as {{{name!r}: {{...}}}}, not {keys!r}")
    return "\n".join(f"[{key(name)}]\n" + "".join(f"{key(k)} = {value(v)}\n"
                                                  for k, v in keys.items())
                     for name, keys in sections.items())


def parse(text: str, name: str = "the scene") -> dict[str, Any]:
    """A document as nested dicts. `name`: what an error calls it.

    >>> parse("[scene]\\nspeed = 0.1")
    {'scene': {'speed': 0.1}}
    """
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as fault:  # also an integer or a nest without end
        raise RequestError(f"{name} is no TOML: {fault}") from fault
