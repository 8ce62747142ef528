"""Rows of Arrow tables and NumPy batches, and tables of reports."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

import pyarrow as pa

if TYPE_CHECKING:
    from uvgraft.batch import Report

SCHEMA = pa.schema(
    [
        ("source", pa.string()),
        ("output", pa.string()),
        ("status", pa.string()),
        ("error", pa.string()),
        ("boundary_delta_e", pa.float64()),
        ("bytes", pa.int64()),
        ("ms", pa.float64()),
        ("warnings", pa.list_(pa.string())),
    ]
)


def table(reports: Iterable[Report]) -> Any:
    """Make a table of reports, whose types do not depend on which values there are."""
    return pa.Table.from_pylist([report._asdict() for report in reports], schema=SCHEMA)


def rows(batch: Any, columns: set[str]) -> Iterator[dict[str, Any]]:
    """Yield the rows of a batch, one by one, so that few encoded images are copied at a time.

    Parameters
    ----------
    batch : pyarrow.Table, pyarrow.RecordBatch, or dict of array_like
        Columns of equal length.
    columns : set of str
        The columns to take, as far as they exist.

    Yields
    ------
    dict
        Values by column; None where one is missing.
    """
    is_arrow = isinstance(batch, pa.Table | pa.RecordBatch)
    names = batch.schema.names if is_arrow else list(batch)
    found = {name: batch[name] for name in names if name in columns}
    length = batch.num_rows if is_arrow else len(next(iter(batch.values()), ()))
    for index in range(length):
        row = {name: column[index] for name, column in found.items()}
        if is_arrow:
            row = {name: value.as_py() for name, value in row.items()}
        # NumPy's columns have NaN where a value is missing.
        yield {name: None if isinstance(it, float) else it for name, it in row.items()}
