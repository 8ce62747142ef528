"""Textures by the million on Ray Data.

From files to files, in actors of one processor each::

    import uvgraft.ray

    reports = uvgraft.ray.transfer(
        "s3://faces/2024", "head_to_body.uvpair", "s3://bodies/2024", onto="body.png"
    )
    reports.write_parquet("s3://bodies/reports/")

or as a step of your own pipeline::

    dataset.map_batches(
        uvgraft.ray.Transfer,
        fn_constructor_kwargs={"pair": "/shared/head_to_body.uvpair", "output": "/shared/bodies"},
        batch_size=16, num_cpus=1, compute=ray.data.ActorPoolStrategy(size=64),
    )

Ray restarts actors that die and gives their batches to others; what is done already is skipped.
"""

from __future__ import annotations

import os
from typing import Any

import pyarrow as pa
import ray

from uvgraft._sources import are_tables, as_list, check_distinct, find, in_full
from uvgraft.batch import BatchTransfer

__all__ = ["Transfer", "transfer"]

MEMORY = 1 << 30
"""Memory that `transfer` reserves for an actor, in bytes, unless told otherwise: 1 GiB."""

# Paths in a block, which are minutes of work: Ray keeps track of every block.
_MOST_ROWS = 1024
_ROWS_OF_TABLES = 256


class Transfer(BatchTransfer):
    """A class for ``ray.data.Dataset.map_batches``; parameters are those of `BatchTransfer`.

    The pair is read, the base decoded and the graft built when an actor starts. Batches may be in
    the formats ``"numpy"`` and ``"pyarrow"``, of which the latter copies less. Rows of the result
    are `uvgraft.batch.Report`s.
    """

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self.prepare()


def transfer(
    sources: Any,
    pair: str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    concurrency: int | tuple[int, int] | None = None,
    num_cpus: float | None = None,
    memory: int = MEMORY,
    batch_size: int = 16,
    actor_options: dict[str, Any] | None = None,
    **options: Any,
) -> Any:
    """Transfer textures on a Ray cluster.

    Ray passes paths around, not images: actors read each texture where it is, and put each result
    where it belongs. Only a dataset's own column of bytes travels through Ray's object store, and
    Ray reads no faster than actors take batches.

    Parameters
    ----------
    sources : path, URI, list of those, or ray.data.Dataset
        A folder or bucket with images, searched by the driver with all folders below it; lists of
        images; archives of images (``.tar``), such as WebDataset's shards, alone or in a folder;
        Parquet files (``.parquet``) with a column of paths, or of bytes and names; or any dataset
        with such columns.
    pair, output : path or URI
        See `uvgraft.batch.BatchTransfer`. They and all files among the options are opened on the
        machines of the actors.
    concurrency : int or (int, int), optional
        Number of actors, or the fewest and the most. By default one for each processor of the
        cluster, but for one that reads tables and datasets.
    num_cpus : float, optional
        Processors of an actor. By default the number of its threads.
    memory : int
        Memory that is reserved for an actor, in bytes.
    batch_size : int
        Textures in a batch.
    actor_options : dict, optional
        Further arguments of ``map_batches``, such as ``{"max_task_retries": 5}``.
    **options : Any
        Those of `uvgraft.batch.BatchTransfer`: `format`, `root`, `resume`, `threads`, and those of
        `uvgraft.FileTransfer`.

    Returns
    -------
    ray.data.Dataset
        Its rows are `uvgraft.batch.Report`s. It is lazy: textures are transferred while it is
        written or iterated over, and doing so again checks all outputs again.

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
    cpus = float(num_cpus if num_cpus is not None else max(1, options.get("threads", 1)))
    if isinstance(sources, ray.data.Dataset):
        dataset, spare, rows = sources, 1.0, batch_size
    elif are_tables(names := as_list(sources)):
        wanted = BatchTransfer(**arguments).columns
        dataset = ray.data.read_parquet(names, filesystem=options.get("source_filesystem"))
        # Other columns of a table may be large.
        found = [name for name in wanted if name in dataset.columns()]
        dataset, spare = dataset.select_columns(found), 1.0
        rows = batch_size if wanted[1] in found else _ROWS_OF_TABLES
    else:
        dataset, spare, rows = None, 0.0, 0
    if concurrency is None:
        # Tasks that read need a processor, which actors never give back.
        concurrency = max(1, int((_processors() - spare) // cpus))
    if isinstance(concurrency, int):
        concurrency = (concurrency, concurrency)
    if dataset is None:
        dataset, rows = _dataset_of_paths(names, arguments, 8 * concurrency[1])
        # Ray would join smaller blocks, and leave actors without work at the end.
        batch_size = min(batch_size, rows)
    else:
        dataset = dataset.repartition(target_num_rows_per_block=rows)
    return dataset.map_batches(
        Transfer,
        fn_constructor_kwargs=arguments,
        batch_size=batch_size,
        batch_format="pyarrow",
        num_cpus=cpus,
        memory=memory,
        compute=ray.data.ActorPoolStrategy(min_size=concurrency[0], max_size=concurrency[1]),
        **(actor_options or {}),
    )


def _processors() -> float:
    if not ray.is_initialized():
        ray.init()
    return float(ray.cluster_resources().get("CPU", 1))


def _dataset_of_paths(
    sources: list[str], arguments: dict[str, Any], blocks: int
) -> tuple[Any, int]:
    """Make a dataset of images in a folder or list, and return how many rows its blocks have.

    `arguments` then name the folder as the root.

    Blocks are what Ray hands out. There are at least `blocks` of them, so that all actors are busy
    to the end, but as few as that allows: Ray keeps track of each.
    """
    paths, root = find(sources, arguments.get("source_filesystem"))
    arguments.setdefault("root", root)
    transfer = BatchTransfer(**arguments)
    check_distinct(paths, transfer)
    table = pa.table({transfer.columns[0]: pa.array(paths, pa.string())})
    rows = min(_MOST_ROWS, max(1, table.num_rows // blocks))
    starts = range(0, table.num_rows, rows)
    return ray.data.from_arrow([table.slice(start, rows) for start in starts]), rows
