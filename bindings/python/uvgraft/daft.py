"""Textures by the million on Daft.

From files to files, in processes of one thread each::

    import uvgraft.daft

    reports = uvgraft.daft.transfer(
        "s3://faces/2024/*.png", "head_to_body.uvpair", "s3://bodies/2024", onto="body.png"
    )
    reports.write_parquet("s3://bodies/reports/")

or as a step of your own query, here with images that Daft downloads::

    from daft import col
    from daft.functions import unnest

    transfer = uvgraft.daft.transfer_udf("head_to_body.uvpair", "bodies", onto="body.png")
    report = transfer(None, col("url").download(), col("id") + ".png")
    frame.select(report.alias("report")).explode("report").select(unnest(col("report")))
"""

from __future__ import annotations

import os
from typing import Any

import daft
import pyarrow as pa
from daft import DataType, col
from daft.functions import unnest

from uvgraft import _arrow
from uvgraft._sources import are_tables, as_list, check_distinct, find, in_full
from uvgraft.batch import BatchTransfer

__all__ = ["transfer", "transfer_udf"]

_REPORTS = pa.list_(pa.struct(list(_arrow.SCHEMA)))


def transfer_udf(
    pair: str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    concurrency: int | None = None,
    cpus: float | None = None,
    batch_size: int = 16,
    **options: Any,
) -> Any:
    """Make a function of Daft expressions that transfers textures.

    Parameters
    ----------
    pair, output : path or URI
        See `uvgraft.batch.BatchTransfer`. They and all files among the options are opened where
        the processes run.
    concurrency : int, optional
        Number of processes, in each of which the pair is read, the base decoded and the graft built
        once. By default one for each processor that Python may use here.
    cpus : float, optional
        Processors that Daft reserves for a process. By default the number of its threads.
    batch_size : int
        Textures that are handed to a process at a time.
    **options : Any
        Those of `uvgraft.batch.BatchTransfer`: `format`, `root`, `resume`, `threads`, and those of
        `uvgraft.FileTransfer`.

    Returns
    -------
    callable
        Takes expressions ``(path, bytes, name)``, of which the last two may be left out and any may
        be None, and returns an expression: a list of `uvgraft.batch.Report`s for each row, with one
        report for an image and several for an archive.
    """
    arguments = in_full({"pair": pair, "output": output, **options})
    threads = max(1, int(options.get("threads", 1)))

    def call(self: Any, path: Any, data: Any = None, name: Any = None) -> Any:
        return _run(self.transfer, (path, data, name))

    @daft.cls(
        cpus=float(threads if cpus is None else cpus),
        use_process=True,
        max_concurrency=concurrency or max(1, len(os.sched_getaffinity(0)) // threads),
    )
    class Transfer:
        def __init__(self, arguments: dict[str, Any]) -> None:
            self.transfer = BatchTransfer(**arguments).prepare()

        __call__ = daft.method.batch(
            return_dtype=DataType.from_arrow_type(_REPORTS), batch_size=batch_size
        )(call)

    return Transfer(arguments)


def transfer(
    sources: Any,
    pair: str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    concurrency: int | None = None,
    cpus: float | None = None,
    batch_size: int = 16,
    **options: Any,
) -> Any:
    """Transfer textures with Daft.

    Daft passes paths around, not images: processes read each texture where it is, and put each
    result where it belongs. Only a data frame's own column of bytes goes through Daft.

    Parameters
    ----------
    sources : path, URI, pattern, list of paths or URIs, or daft.DataFrame
        A folder or bucket with images, searched with all folders below it; a pattern such as
        ``s3://faces/**/*.png``; lists of images; archives of images (``.tar``), such as
        WebDataset's shards, alone or in a folder; Parquet files (``.parquet``) with a column of
        paths, or of bytes and names; or any data frame with such columns.
    pair, output, concurrency, cpus, batch_size, **options
        As those of `transfer_udf`.

    Returns
    -------
    daft.DataFrame
        Its rows are `uvgraft.batch.Report`s. It is lazy: textures are transferred while it is
        written, collected or iterated over, and doing so again checks all outputs again.

    Raises
    ------
    TypeError
        If `sources` is something else.
    ValueError
        If there are no images in a folder, or two of a folder or list have the same output.
    FileNotFoundError
        If a local source does not exist.
    """
    arguments = in_full({"pair": pair, "output": output, **options})
    frame = _frame(sources, arguments, batch_size)
    function = transfer_udf(**arguments, concurrency=concurrency, cpus=cpus, batch_size=batch_size)
    columns = BatchTransfer(**arguments).columns
    given = [col(name) if name in frame.column_names else None for name in columns]
    reports = frame.select(function(*given).alias("report"))
    return reports.explode("report").select(unnest(col("report")))


def _frame(sources: Any, arguments: dict[str, Any], batch_size: int) -> Any:
    """Make a data frame of whatever names textures; `arguments` then name a folder as the root."""
    columns = BatchTransfer(**arguments).columns
    if isinstance(sources, daft.DataFrame):
        frame = sources
    elif are_tables(names := as_list(sources)):
        frame = daft.read_parquet(names)
    elif any("*" in name for name in names):
        frame = daft.from_glob_path(names).select(col("path").alias(columns[0]))
    else:
        paths, root = find(names, arguments.get("source_filesystem"))
        arguments.setdefault("root", root)
        check_distinct(paths, BatchTransfer(**arguments))
        frame = daft.from_arrow(pa.table({columns[0]: pa.array(paths, pa.string())}))
    # Other columns of a table may be large.
    frame = frame.select(*(name for name in columns if name in frame.column_names))
    return frame.into_batches(batch_size)


def _run(transfer: BatchTransfer, columns: tuple[Any, Any, Any]) -> Any:
    """Transfer the textures of three columns, of which some may be None."""
    found = {
        name: series.to_arrow()
        for name, series in zip(transfer.columns, columns, strict=True)
        if series is not None
    }
    length = len(next(iter(found.values()), ()))
    rows = ({name: it[index].as_py() for name, it in found.items()} for index in range(length))
    reports = [[report._asdict() for report in some] for some in transfer.run_by_row(rows)]
    return pa.array(reports, _REPORTS)
