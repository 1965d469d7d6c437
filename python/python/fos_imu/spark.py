"""Rows of units by Spark, where one machine is not enough: `pip install 'fos-imu[spark]'`.

Spark places, retries and moves; what is here turns a log into a row, and rows into populations. Whatever the partitions,
and whichever executors were lost meanwhile, the populations are those of `fos fleet`, to the last bit.
"""

from __future__ import annotations

import functools
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any
from urllib.parse import unquote, urlparse

import pyarrow
from pyspark import StorageLevel
from pyspark.sql.types import ArrayType, StringType, StructField, StructType

from . import fleet
from .errors import FleetError
from .fleet import Fleet, UnitRow

if TYPE_CHECKING:
    from pyspark.sql import DataFrame

AT_ONCE = 100_000
"""Units whose rows come to the driver at once: 250 MB of six axes."""

SCHEMA = StructType(
    [
        StructField("unit", StringType(), nullable=False),
        StructField("part", StringType(), nullable=False),
        StructField("lot", StringType()),
        StructField("sha256", StringType(), nullable=False),
        StructField("failed", ArrayType(StringType(), containsNull=False), nullable=False),
        StructField("row", StringType(), nullable=False),
    ]
)
"""Columns of `unit_rows`; `row` is `UnitRow.to_json()`."""

_ARROW = pyarrow.schema(
    [
        ("unit", pyarrow.string()),
        ("part", pyarrow.string()),
        ("lot", pyarrow.string()),
        ("sha256", pyarrow.string()),
        ("failed", pyarrow.list_(pyarrow.string())),
        ("row", pyarrow.string()),
    ]
)


def unit_rows(
    frame: DataFrame,
    *,
    regressors: Sequence[str] = ("temp_c",),
    diagnose: bool = False,
    largest_bytes: int | None = None,
    **reading: Any,  # noqa: ANN401
) -> DataFrame:
    """A row for each unit, in tasks of Spark; a log that cannot be read is a row that says why in `failed`.

    A task has one log in memory at a time. Logs that come as bytes are read from Spark in batches of
    `spark.sql.execution.arrow.maxRecordsPerBatch` rows: set it to 1 for these.

    Args:
        frame: With columns `log`, a path that executors can read or an array of such, or `path` and `content`, as Spark's
            source `binaryFile` gives them; and, where they are known, `unit`, `part`, `lot`. A unit without a name has that
            of its (first) file, without the ending.
        regressors: As of `fos_imu.unit_row`.
        diagnose: As of `fos_imu.unit_row`.
        largest_bytes: A larger file is a row that says so, and is not read: Spark gives up a job whose worker ran out of
            memory four times.
        reading: What else `fos_imu.unit_row` takes for a file: `map`, `rate_hz`, `format`, ….

    Raises:
        FleetError: The frame has neither `log` nor `path` and `content`.
    """
    columns = set(frame.columns)
    if "log" not in columns and not {"path", "content"} <= columns:
        raise FleetError(
            f"a frame of columns {', '.join(frame.columns)} has no logs",
            remedy="a column `log` with paths, or `path` and `content` as of spark.read.format('binaryFile')",
        )
    taken = ("unit", "part", "lot", *(("log",) if "log" in columns else ("path", "content")))
    asked = {"regressors": tuple(regressors), "diagnose": diagnose, "largest_bytes": largest_bytes, **reading}
    ask = functools.partial(_rows, asked=asked)
    return frame.select(*(name for name in taken if name in columns)).mapInArrow(ask, SCHEMA)


def population(rows: DataFrame, *, effects: Sequence[str] = ()) -> Fleet:
    """The populations behind rows of `unit_rows`, however they were kept. The driver gathers them in whatever order they come.

    Args:
        rows: With a column `row`.
        effects: As of `fos_imu.population`.

    Raises:
        FleetError: As of `fos_imu.population`.
    """
    # Spark computes a frame again on each use, and an iterator asks for one partition after the other: all are made
    # before, at once
    made = rows.select("row").persist(StorageLevel.DISK_ONLY)
    try:
        partitions = max(1, -(-made.count() // AT_ONCE))
        texts = (row[0] for row in made.coalesce(partitions).toLocalIterator())
        return fleet.population(texts, effects=effects)
    finally:
        made.unpersist()


def _rows(batches: Iterator[Any], asked: Mapping[str, Any]) -> Iterator[Any]:
    """Batches of Arrow in, a batch of one row out for each log: no more than one is in memory."""
    for batch in batches:
        for place in range(batch.num_rows):
            row = _row({name: batch.column(name)[place].as_py() for name in batch.schema.names}, asked)
            cells = (row.unit, row.part, row.lot, row.sha256, list(row.failed), row.to_json())
            yield pyarrow.RecordBatch.from_arrays(
                [pyarrow.array([cell], kind) for cell, kind in zip(cells, _ARROW.types, strict=True)], schema=_ARROW
            )


def _row(cells: Mapping[str, Any], asked: Mapping[str, Any]) -> UnitRow:
    content = cells.get("content")
    given = cells["path" if "path" in cells else "log"]
    where = [_local(path) for path in ([given] if isinstance(given, str) else given or [""])]
    name = PurePosixPath(where[0])
    named = {"unit": cells.get("unit") or name.stem, "part": cells.get("part") or "", "lot": cells.get("lot")}
    # the format is recognised by the content, and tables by the ending of the name: a log of bytes needs a file of its name
    with tempfile.TemporaryDirectory() as folder:
        logs = [Path(path) for path in where] if content is None else [Path(folder, name.name)]
        if content is not None:
            logs[0].write_bytes(content)
        return fleet.unit_row(logs, **named, **asked, shown_as=where)


def _local(path: str) -> str:
    """The path of a `file:` URL; any other as it is."""
    return unquote(urlparse(path).path) if path.startswith("file:") else path
