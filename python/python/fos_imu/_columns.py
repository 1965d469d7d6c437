"""Takes tables of others apart: dictionaries of arrays, pandas, polars, pyarrow, whatever speaks Arrow's stream.

None of these packages is imported unless an object of theirs, or one that needs them, is given. A column that is NumPy's
already, or that its owner shows as NumPy's, is not copied here.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterable, Mapping
from typing import Any, cast

import numpy as np
import numpy.typing as npt

from .errors import RecordingError

Array = npt.NDArray[Any]

TAKEN = ("f8", "f4", "i8", "i4", "i2", "u8", "u4", "u2", "u1", "b1")


def columns_of(table: object) -> list[tuple[str, Array]]:
    """Names and values of the columns of a table, in their order."""
    if isinstance(table, Mapping):
        items = cast("Mapping[str, object]", table).items()
        return [(str(name), values_of(str(name), column)) for name, column in items]
    fields = getattr(getattr(table, "dtype", None), "names", None)
    if fields is not None:
        structured = cast("Array", table)
        return [(name, values_of(name, structured[name])) for name in cast("tuple[str, ...]", fields)]
    names = getattr(table, "column_names", None)
    if names is None:
        names = getattr(table, "columns", None)
    if names is not None and hasattr(table, "__getitem__"):
        indexed = cast("Any", table)
        return [(str(name), values_of(str(name), indexed[name])) for name in cast("Iterable[object]", names)]
    if hasattr(table, "__arrow_c_stream__"):
        return columns_of(_of_stream(table))
    raise RecordingError(
        f"{type(table).__name__} is no table",
        remedy="give a dict of arrays, a DataFrame of pandas or polars, or a table of pyarrow",
    )


def _of_stream(table: object) -> object:
    """A table that is known only by Arrow's stream, by whichever package here reads one."""
    for package, function in (("pyarrow", "table"), ("polars", "from_arrow")):
        try:
            module = importlib.import_module(package)
        except ImportError:
            continue
        return getattr(module, function)(table)
    raise RecordingError(
        f"{type(table).__name__} comes as a stream of Arrow, and no package here reads one",
        remedy="install pyarrow or polars, or give a dict of arrays",
    )


def values_of(name: str, column: object) -> Array:
    """One column as a one-dimensional array of numbers; of times as seconds since 1970."""
    values = _as_array(column)
    if values.ndim != 1:
        raise RecordingError(
            f"{name}: an array of {values.ndim} dimensions", remedy="one column, one dimension", column=name
        )
    if values.dtype.kind == "M":
        missing = np.isnat(values)
        # nanoseconds since 1970 do not fit the 53 bits of a float: from the first on they do
        first = values[~missing][0].astype("M8[s]") if not missing.all() else np.datetime64(0, "s")
        seconds = (values - first) / np.timedelta64(1, "s") + first.astype(np.int64)
        return np.where(missing, np.nan, seconds)
    if values.dtype.kind == "m":
        return values / np.timedelta64(1, "s")
    if values.dtype.str[1:] in TAKEN and values.dtype.isnative:
        return values
    try:
        return values.astype(np.float64)
    except (TypeError, ValueError) as error:
        raise RecordingError(
            f"{name}: no column of numbers: {error}", remedy="leave it out, or convert it first", column=name
        ) from None


def unmasked(values: object) -> Any:  # noqa: ANN401
    """A masked array of NumPy as a plain one, NaN (or no time) where a cell is masked; everything else as it is."""
    if not isinstance(values, np.ma.MaskedArray):
        return values
    # the types of NumPy know of no fill value that is a time
    masked: Any = values
    if masked.dtype.kind in "mM":
        return masked.filled(np.array("NaT", masked.dtype))
    if not np.ma.getmaskarray(masked).any():
        return masked.data
    return masked.astype(np.float64).filled(np.nan)


def _as_array(column: object) -> Array:
    if isinstance(column, np.ndarray):
        return cast("Array", unmasked(column))
    # nullable columns of pandas give objects, unless asked for floats; without gaps others give their own type
    dtype = getattr(column, "dtype", None)
    if hasattr(dtype, "na_value") and getattr(dtype, "kind", "O") in "fiub" and hasattr(column, "to_numpy"):
        return cast("Array", cast("Any", column).to_numpy(dtype=np.float64, na_value=np.nan))
    if type(column).__module__.startswith("pyarrow"):
        # an array with nulls cannot be shown without a copy
        return np.asarray(cast("Any", column).to_numpy(zero_copy_only=False))
    if hasattr(column, "to_numpy"):
        return np.asarray(cast("Any", column).to_numpy())
    return np.asarray(column)
