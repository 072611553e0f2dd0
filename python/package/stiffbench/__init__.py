"""Stiffness of robots with its uncertainty, fits of beam models, diagnoses, and a batched pose solver.

>>> import stiffbench
>>> result = stiffbench.stiffness("my-session")
>>> result["data"]["cells"][0]["stiffness_regression"]

`stiffness`, `fit` and `diagnose` return the object that the command of the same name prints with ``--json``. Their keyword arguments are
the options of the command, with ``_`` for ``-``. `tables` and `readings` give measurements as data frames. `Robot` solves a robot in
many poses at once.
"""

from __future__ import annotations

import json
import os
from typing import TYPE_CHECKING, Any, Union

import numpy

from . import _native
from ._error import StiffbenchError
from ._native import Robot

if TYPE_CHECKING:
    import pandas

    PathLike = Union[str, os.PathLike[str]]

__all__ = ["Robot", "StiffbenchError", "diagnose", "fit", "readings", "stiffness", "tables"]
__version__: str = _native.__version__


def stiffness(data: PathLike, **options: Any) -> dict[str, Any]:
    """Stiffness of every cell with its uncertainty, as `stiffbench stiffness DATA --json`.

    Parameters
    ----------
    data : path
        Session folder, readings file, or gauge log.
    **options
        Options of the command: ``branches="both"``, ``force_u="0.1N"``. A switch is True, an option that may be repeated a list.

    Returns
    -------
    dict
        The result; ``result["data"]["cells"]`` holds the cells, ``result["warnings"]`` what to know before using them.

    Raises
    ------
    StiffbenchError
        If the command fails.
    """
    return _run("stiffness", [data], options)


def fit(data: PathLike, *further: PathLike, **options: Any) -> dict[str, Any]:
    """Factors or joint springs fitted to measurements, as `stiffbench fit DATA... --json`.

    Parameters
    ----------
    data, *further : path
        Session folders, readings files, load cases or a list of stiffness values.
    **options
        Options of the command: ``train=["P1", "P3"]``, ``robot="hp-robot"``, ``bootstrap=1000``.

    Returns
    -------
    dict
        The result.

    Raises
    ------
    StiffbenchError
        If the command fails.
    """
    return _run("fit", [data, *further], options)


def diagnose(data: PathLike, *further: PathLike, **options: Any) -> dict[str, Any]:
    """What the model leaves out, as `stiffbench diagnose DATA... --json`.

    As the command does, it writes the page, the data and the figures: into the folder ``diagnosis`` of the session, or into ``out``.

    Parameters
    ----------
    data, *further : path
        Session folders, readings files or load cases.
    **options
        Options of the command: ``robot="hp-robot"``, ``seed=1``, ``out="my-diagnosis"``, ``no_figures=True``.

    Returns
    -------
    dict
        The result; ``result["data"]["verdict"]`` is the verdict.

    Raises
    ------
    StiffbenchError
        If the command fails.
    """
    return _run("diagnose", [data, *further], options)


def tables(data: PathLike, *, arrays: bool = False, **options: Any) -> dict[str, Any]:
    """The tables of measurements as data frames, as `stiffbench export` writes them.

    Parameters
    ----------
    data : path
        Session folder, readings file, load cases, or gauge log.
    arrays : bool
        Dictionaries of NumPy arrays instead of data frames; pandas is then not needed.
    **options
        Options of `stiffbench export`: ``branches="both"``.

    Returns
    -------
    dict of str to pandas.DataFrame
        By name: ``readings``, ``stiffness``, ``budget``, ``loads``, ``flags``. ``frame.attrs`` holds ``title``, ``units`` and ``meanings``
        of the columns.

    Raises
    ------
    StiffbenchError
        If the data cannot be read.
    """
    found = _native.tables(_words([data], options))
    make = _arrays if arrays else _frame
    return {name: make(title, columns) for name, title, columns in found}


def readings(data: PathLike, *, arrays: bool = False, **options: Any) -> pandas.DataFrame:
    """The readings of a session, or the load cases, as one data frame: the first of `tables`.

    Rejected and superseded readings are in it; ``frame[frame.status == "accepted"]`` are those that count.
    """
    return next(iter(tables(data, arrays=arrays, **options).values()))


def _run(command: str, data: list[PathLike], options: dict[str, Any]) -> dict[str, Any]:
    return json.loads(_native.command([command, *_words(data, options)]))


def _words(data: list[PathLike], options: dict[str, Any]) -> list[str]:
    """Options and data as words of a command line."""
    words = []
    for name, value in options.items():
        option = "--" + name.replace("_", "-")
        if value is True:
            words.append(option)
        elif value is not None and value is not False:
            values = value if isinstance(value, (list, tuple)) else [value]
            words.extend(f"{option}={os.fspath(one) if isinstance(one, os.PathLike) else one}" for one in values)
    return [*words, "--", *(os.fspath(path) for path in data)]


def _arrays(title: str, columns: list[tuple[str, str, str, str, list[str]]]) -> dict[str, numpy.ndarray]:
    """The columns of a table as arrays: a missing number is NaN, a missing time NaT, a missing text empty."""
    return {name: _array(kind, fields) for name, kind, _, _, fields in columns}


def _array(kind: str, fields: list[str]) -> numpy.ndarray:
    if kind == "integer" and all(fields):
        return numpy.array([int(field) for field in fields], dtype=numpy.int64)
    if kind in ("integer", "number"):
        return numpy.array([float(field or "nan") for field in fields], dtype=numpy.float64)
    if kind == "datetime":
        # NumPy's times have no zone; all of these are UTC.
        return numpy.array([field.rstrip("Z") or "NaT" for field in fields], dtype="datetime64[ns]")
    return numpy.array(fields, dtype=object)


def _frame(title: str, columns: list[tuple[str, str, str, str, list[str]]]) -> pandas.DataFrame:
    try:
        import pandas
    except ImportError as error:
        raise ImportError(
            "data frames need pandas: pip install 'stiffbench[pandas]', or name arrays=True for NumPy arrays"
        ) from error
    frame = pandas.DataFrame(_arrays(title, columns))
    for name, kind, _, _, _ in columns:
        if kind == "datetime":
            frame[name] = frame[name].dt.tz_localize("UTC")
    frame.attrs = {
        "title": title,
        "units": {name: unit for name, _, unit, _, _ in columns if unit},
        "meanings": {name: meaning for name, _, _, meaning, _ in columns},
    }
    return frame
