"""Textures by the million: one class for Ray, Daft, Spark and plain loops.

A `BatchTransfer` takes rows that name textures, or hold them, and gives back rows that say what
became of them::

    from uvgraft.batch import BatchTransfer

    transfer = BatchTransfer("head_to_body.uvpair", "s3://avatars/bodies", onto="body.png")
    for report in transfer.run({"path": path} for path in paths):
        print(report.output, report.status)

`uvgraft.ray` and `uvgraft.daft` run it on clusters. Object storage, Arrow and engines need
pyarrow; a local folder needs nothing.
"""

from __future__ import annotations

import hashlib
import os
import tarfile
import tempfile
import threading
import time
from collections.abc import Iterable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from itertools import islice
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from uvgraft import Error, FileTransfer, TransferOptions, Transferred
from uvgraft._files import below, is_remote, locate, make_folder
from uvgraft._records import Check, Record, Records

if TYPE_CHECKING:
    from typing_extensions import Unpack

Status = Literal["written", "up to date", "failed"]

SPARK_SCHEMA = (
    "source string, output string, status string, error string, boundary_delta_e double, "
    "bytes bigint, ms double, warnings array<string>"
)
"""The columns of a `Report`, as Spark spells them."""

FILE_OPTIONS = ("onto", "skin", "labels", "source_mask", "fill")
"""Options that name files, which workers fetch when they are in object storage."""

IMAGE_EXTENSIONS = (".png", ".jpg", ".jpeg", ".webp", ".tif", ".tiff", ".exr")
"""What the names of images end with, in lower case."""

# Textures of a worker that wait for object storage while another has the processor.
_LANES = 4


class Report(NamedTuple):
    """What became of a texture.

    Attributes
    ----------
    source : str
        Its path or name.
    output : str or None
        Path or URI of the result; None if it has no usable name.
    status : {"written", "up to date", "failed"}
        Failed textures have no new output, and are tried again by the next run.
    error : str or None
        Why it failed.
    boundary_delta_e : float or None
        See `uvgraft.Transferred`; None unless written.
    bytes : int or None
        Length of the encoded result; None unless written.
    ms : float
        Time for reading, transferring and writing, in milliseconds.
    warnings : list of str
        Those of the transfer.
    """

    source: str
    output: str | None
    status: Status
    error: str | None
    boundary_delta_e: float | None
    bytes: int | None
    ms: float
    warnings: list[str]


class _Job(NamedTuple):
    """A texture, and where its result goes.

    Either `data` or `path` is there; `name` is the result's path within the output folder.
    """

    source: str
    path: str | None
    data: bytes | None
    name: str


class BatchTransfer:
    """Transfers textures into a folder or bucket, and reports on each.

    The pair is read, the base decoded and the graft built on first use, once per object; a pickle
    holds the arguments alone. Results are byte for byte those of ``uvgraft transfer``, and appear
    when they are whole. A texture that cannot be used becomes a report, not an exception.

    Parameters
    ----------
    pair : path or URI
        A pair file.
    output : path or URI
        A folder (``bodies``), or a place in object storage (``s3://bucket/bodies``, and whatever
        else pyarrow or fsspec open).
    format : str, optional
        Output format by its extension, such as ``"png"``. By default that of each source's name.
    root : path or URI, optional
        Results are named after the path of their source below this folder. By default after the
        file's name alone, as the command does. Names must be distinct.
    resume : {"content", "size"} or None
        What makes an output count as up to date. ``"content"``: source and output are read, and are
        byte for byte those that were recorded. ``"size"``: the output has the recorded length and
        was made with the same options; neither is read, so a source that was replaced by another
        of the same name goes unnoticed. None: nothing is skipped or recorded.
    threads : int
        Threads for each texture. Workers with one processor each should leave it at 1.
    path_column, bytes_column, name_column : str
        Columns of rows: path or URI of a texture, encoded image, and name of the result. A row
        needs a path, or bytes and a name. A path that ends with ``.tar`` is an archive of images,
        such as a shard of a WebDataset: it is read from beginning to end, and each image in it is
        a texture that is called as in the archive.
    filesystem, source_filesystem : pyarrow.fs.FileSystem or fsspec.AbstractFileSystem, optional
        What `output`, and paths of textures, are paths in; for credentials that URIs cannot hold.
    **options
        Those of `uvgraft.FileTransfer`: `onto`, `size`, `blend` and so on. Files among them may be
        URIs.

    Raises
    ------
    ValueError
        If `resume` is none of these.
    """

    def __init__(
        self,
        pair: str | os.PathLike[str],
        output: str | os.PathLike[str],
        *,
        format: str | None = None,
        root: str | os.PathLike[str] | None = None,
        resume: Check | None = "content",
        threads: int = 1,
        path_column: str = "path",
        bytes_column: str = "bytes",
        name_column: str = "name",
        filesystem: Any = None,
        source_filesystem: Any = None,
        **options: Unpack[TransferOptions],
    ) -> None:
        if resume not in ("content", "size", None):
            raise ValueError(f'resume must be "content", "size" or None, got {resume!r}')
        self._arguments: dict[str, Any] = {
            "pair": os.fspath(pair),
            "output": os.fspath(output),
            "format": format.lstrip(".") if format else None,
            "root": None if root is None else os.fspath(root),
            "resume": resume,
            "threads": threads,
            "path_column": path_column,
            "bytes_column": bytes_column,
            "name_column": name_column,
            "filesystem": filesystem,
            "source_filesystem": source_filesystem,
            **options,
        }
        self._options = options
        self._columns = (path_column, bytes_column, name_column)
        self._format, self._root = self._arguments["format"], self._arguments["root"]
        self._output: str = self._arguments["output"]
        self._source_filesystem = source_filesystem
        self._worker: _Worker | None = None
        self._lock = threading.Lock()

    @property
    def columns(self) -> tuple[str, str, str]:
        """Names of the columns with paths, bytes and names."""
        return self._columns

    def name_of(self, path: str) -> str | None:
        """Return the name of the result of an image file, None if it has no usable one."""
        try:
            return self._checked(_name_below(path, self._root))
        except ValueError:
            return None

    def prepare(self) -> BatchTransfer:
        """Read the pair, the base and the records now rather than with the first texture.

        Raises
        ------
        uvgraft.Error
            For files and options that cannot be used.
        OSError
            If a file does not exist or cannot be read.
        """
        with self._lock:
            if self._worker is None:
                self._worker = _Worker(self._arguments, self._options)
        return self

    def run(self, rows: Iterable[Mapping[str, Any]]) -> Iterator[Report]:
        """Transfer textures one after the other.

        Memory does not grow with their number: at most four are in flight, and only while they wait
        for object storage.

        Parameters
        ----------
        rows : iterable of mapping
            With the columns described above; others are ignored.

        Yields
        ------
        Report
            One for each row, in order.

        Raises
        ------
        uvgraft.Error, OSError
            As `prepare`.
        """
        yield from (report for _, report in self._run(rows))

    def run_by_row(self, rows: Iterable[Mapping[str, Any]]) -> list[list[Report]]:
        """Transfer textures, as `run` does.

        Returns
        -------
        list of list of Report
            For each row the reports on its textures: one, or all those of an archive.
        """
        reports: list[list[Report]] = []
        for index, report in self._run(rows):
            reports.extend([] for _ in range(len(reports), index + 1))
            reports[index].append(report)
        return reports

    def _run(self, rows: Iterable[Mapping[str, Any]]) -> Iterator[tuple[int, Report]]:
        """Transfer textures, and say which row each report is about."""
        self.prepare()
        worker = self._worker
        assert worker is not None

        def done(job: tuple[int, _Job | Report]) -> tuple[int, Report]:
            return job[0], worker.report(job[1])

        jobs = ((index, job) for index, row in enumerate(rows) for job in self._jobs(row))
        try:
            if worker.files.is_local and self._source_filesystem is None:
                yield from map(done, jobs)
                return
            with ThreadPoolExecutor(_LANES) as lanes:
                # Not `map` over all jobs, which would take every job from the iterator at once.
                while some := list(islice(jobs, _LANES)):
                    yield from lanes.map(done, some)
        finally:
            worker.flush()

    def __call__(self, batch: Any) -> Any:
        """Transfer a batch.

        Parameters
        ----------
        batch : pyarrow.Table, pyarrow.RecordBatch, or dict of array_like
            Columns as described above.

        Returns
        -------
        pyarrow.Table
            Its rows are `Report`s, in order.
        """
        from uvgraft import _arrow  # noqa: PLC0415 - needs pyarrow

        return _arrow.table(self.run(_arrow.rows(batch, {*self._columns})))

    def map_in_arrow(self, batches: Iterable[Any]) -> Iterator[Any]:
        """Transfer record batches, as ``pyspark.sql.DataFrame.mapInArrow`` passes them.

        Parameters
        ----------
        batches : iterable of pyarrow.RecordBatch
            Columns as described above.

        Yields
        ------
        pyarrow.RecordBatch
            Rows are `Report`s; the schema is `SPARK_SCHEMA`.
        """
        for batch in batches:
            yield from self(batch).to_batches()

    def _jobs(self, row: Mapping[str, Any]) -> Iterator[_Job | Report]:
        """Yield the textures of a row, and a report on what has none."""
        path_column, bytes_column, name_column = self._columns
        path, data, name = row.get(path_column), row.get(bytes_column), row.get(name_column)
        source = str(path or name or "")
        if data is None and source.lower().partition("?")[0].endswith(".tar"):
            yield from self._members(source)
            return
        try:
            if not path and (data is None or not name):
                columns = f"{path_column!r}, or {bytes_column!r} and {name_column!r}"
                raise ValueError(f"a row must have {columns}")
            name = self._checked(str(name) if name else _name_below(str(path), self._root))
        except ValueError as error:
            yield _failed(source, error)
            return
        # A copy only where they are not bytes already: engines pass views of their own memory.
        data = data if data is None or isinstance(data, bytes) else bytes(data)
        yield _Job(source, str(path) if data is None else None, data, name)

    def _members(self, archive: str) -> Iterator[_Job | Report]:
        """Yield the images of an archive, of which one is in memory at a time."""
        try:
            files, path = locate(archive, self._source_filesystem)
            with files.open(path) as file, tarfile.open(fileobj=file, mode="r|") as members:
                for member in members:
                    if member.isfile() and member.name.lower().endswith(IMAGE_EXTENSIONS):
                        yield self._member(archive, members, member)
        except (OSError, tarfile.TarError) as error:
            yield _failed(archive, error)

    def _member(
        self, archive: str, members: tarfile.TarFile, member: tarfile.TarInfo
    ) -> _Job | Report:
        source = f"{archive}#{member.name}"
        try:
            name = self._checked(member.name.removeprefix("./"))
        except ValueError as error:
            return _failed(source, error)
        content = members.extractfile(member)
        return _Job(source, None, content.read() if content else b"", name)

    def _checked(self, name: str) -> str:
        """Give the name of a result its extension.

        Raises
        ------
        ValueError
            If it leads out of the output folder.
        """
        if self._format:
            name = f"{os.path.splitext(name)[0]}.{self._format}"
        if any(part in ("", ".", "..") for part in name.split("/")) or "\0" in name:
            raise ValueError(f"the name of a result must be a path within the folder, got {name!r}")
        return name

    def __repr__(self) -> str:
        """Name the pair and the output."""
        return f"<uvgraft.batch.BatchTransfer: {self._arguments['pair']} to {self._output}>"

    def __getstate__(self) -> dict[str, Any]:
        """Leave out what is prepared on first use."""
        return self._arguments

    def __setstate__(self, arguments: dict[str, Any]) -> None:
        """Start again from the arguments."""
        BatchTransfer.__init__(self, **arguments)


class _Worker:
    """What a process keeps between textures. Threads may share one."""

    def __init__(self, arguments: Mapping[str, Any], options: Mapping[str, Any]) -> None:
        self._resume: Check | None = arguments["resume"]
        self._output: str = arguments["output"]
        self._source_filesystem = arguments["source_filesystem"]
        with tempfile.TemporaryDirectory(prefix="uvgraft-") as folder:
            local = dict(options)
            for name in FILE_OPTIONS:
                if isinstance(local.get(name), str | os.PathLike):
                    local[name] = _fetched(os.fspath(local[name]), folder, name)
            pair = _fetched(arguments["pair"], folder, "pair")
            self._transfer = FileTransfer(pair, threads=arguments["threads"], **local)
        self.files, self._folder = locate(self._output, arguments["filesystem"])
        if self.files.is_local:
            make_folder(self._folder)
        self._records: Records | None = None
        if self._resume is not None:
            self._records = Records(self.files, self._folder, self._resume)
        # Lanes overlap waiting for storage; a worker computes one texture at a time.
        self._processor = threading.Lock()
        self._folders: set[str] = set()

    def flush(self) -> None:
        """Put records that object storage does not have yet."""
        if self._records is not None:
            self._records.flush()

    def report(self, job: _Job | Report) -> Report:
        """Transfer a texture, unless that was done before; reports are passed through."""
        if isinstance(job, Report):
            return job
        started = time.perf_counter()
        path = below(self._folder, job.name)
        output = below(self._output, job.name)
        error: str | None = None
        done: Transferred | None = None
        try:
            done = self._unless_done(job, path)
        except (Error, OSError, ValueError) as failure:
            error = str(failure)
        status: Status = "failed" if error is not None else "written" if done else "up to date"
        return Report(
            source=job.source,
            output=output,
            status=status,
            error=error,
            boundary_delta_e=done.boundary_delta_e if done else None,
            bytes=done.bytes if done else None,
            ms=1000 * (time.perf_counter() - started),
            warnings=done.warnings if done else [],
        )

    def _unless_done(self, job: _Job, path: str) -> Transferred | None:
        """Transfer a texture; None if the output is up to date."""
        shared = self._transfer.fingerprint
        records = self._records
        if records is None:
            return self._write(job, path)[0]
        if self._resume == "size" and records.is_up_to_date(job.name, path, shared):
            return None
        job = self._read(job)
        source = job.data if job.data is not None else job.path
        assert source is not None
        # Before the work: if a source is replaced meanwhile, its output counts as outdated.
        made_from = self._transfer.made_from(source)
        if self._resume == "content" and records.is_up_to_date(job.name, path, made_from):
            return None
        done, sha256 = self._write(job, path)
        records.add(Record(job.name, made_from, sha256 or "", shared, done.bytes))
        return done

    def _read(self, job: _Job) -> _Job:
        """Fetch a source, unless it is a local file whose result is one too: those are streamed."""
        if job.path is None:
            return job
        files, path = locate(job.path, self._source_filesystem)
        if files.is_local and self.files.is_local:
            return job._replace(path=path)
        return job._replace(path=None, data=files.read(path))

    def _write(self, job: _Job, path: str) -> tuple[Transferred, str | None]:
        """Transfer a texture, and return the SHA-256 of the result if it is to be recorded."""
        job = self._read(job)
        if self.files.is_local:
            self._make_folder_of(path)
        if job.path is not None:
            with self._processor:
                done = self._transfer.to_file(job.path, path)
                return done, self.files.sha256(path) if self._records else None
        assert job.data is not None
        format = os.path.splitext(job.name)[1].lstrip(".")
        with self._processor:
            encoded, done = self._transfer.to_bytes(job.data, name=job.source, format=format)
        self.files.write(path, encoded)
        return done, hashlib.sha256(encoded).hexdigest() if self._records else None

    def _make_folder_of(self, path: str) -> None:
        folder = os.path.dirname(path)
        if folder not in self._folders:
            make_folder(folder)
            self._folders.add(folder)


def _failed(source: str, error: Exception) -> Report:
    return Report(source, None, "failed", str(error), None, None, 0.0, [])


def _name_below(path: str, root: str | None) -> str:
    """Return the path of a source below a folder, or its file name.

    Raises
    ------
    ValueError
        If it is not below that folder.
    """
    path = _bare(path)
    if root is None:
        return path.rpartition("/")[2]
    root = _bare(root).rstrip("/") + "/"
    if not path.startswith(root):
        raise ValueError(f"{path} must be below the root {root}")
    return path[len(root) :]


def _bare(path: str) -> str:
    """Return a URI without its options, and a local path in full."""
    if is_remote(path):
        return path.partition("?")[0]
    return os.path.abspath(locate(path)[1])


def _fetched(path: str, folder: str, name: str) -> str:
    """Return a local path of a file, which is fetched into `folder` if it is elsewhere."""
    if not is_remote(path):
        return locate(path)[1] if path.startswith("file://") else path
    files, remote = locate(path)
    local = os.path.join(folder, name + os.path.splitext(remote)[1])
    with open(local, "wb") as file:
        file.write(files.read(remote))
    return local
