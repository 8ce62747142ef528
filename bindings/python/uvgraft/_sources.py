"""Where the textures of a batch come from: folders, lists, tables and archives."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

from uvgraft._files import is_remote, listed, locate
from uvgraft.batch import FILE_OPTIONS, IMAGE_EXTENSIONS, BatchTransfer

TABLE = ".parquet"
ARCHIVE = ".tar"


class Paths(NamedTuple):
    """Images and archives, one by one.

    Attributes
    ----------
    paths : list of str
        Paths or URIs.
    root : str or None
        The folder that they were found in.
    """

    paths: list[str]
    root: str | None


def as_list(sources: Any) -> list[str]:
    """Return paths or URIs as a list.

    Raises
    ------
    TypeError
        If they are something else.
    """
    if isinstance(sources, str | os.PathLike):
        return [os.fspath(sources)]
    if not isinstance(sources, Sequence):
        raise TypeError(f"sources must be paths or a dataset, got {type(sources).__name__}")
    return [os.fspath(source) for source in sources]


def are_tables(sources: Sequence[str]) -> bool:
    """Whether sources are Parquet files, or patterns or folders named like one."""
    return all(source.partition("?")[0].rstrip("/").endswith(TABLE) for source in sources)


def in_full(arguments: dict[str, Any]) -> dict[str, Any]:
    """Return the arguments of a `BatchTransfer` with absolute paths.

    Workers may have another current folder. Colours, which begin with ``#``, are no paths.
    """
    full = dict(arguments)
    for name in ("pair", "output", "root", *FILE_OPTIONS):
        value = full.get(name)
        if value is not None and not str(value).startswith("#"):
            filesystem = {"output": "filesystem", "root": "source_filesystem"}.get(name, "")
            full[name] = _in_full(os.fspath(value), full.get(filesystem))
    return full


def find(sources: Sequence[str], filesystem: Any = None) -> Paths:
    """Find images and archives: a folder is searched with all folders below it.

    Parameters
    ----------
    sources : sequence of str
        One folder, or files.
    filesystem : pyarrow.fs.FileSystem or fsspec.AbstractFileSystem, optional
        What they are paths in.

    Raises
    ------
    ValueError
        If a folder has neither images nor archives, or there is nothing at all.
    FileNotFoundError
        If a local source does not exist.
    """
    if len(sources) != 1 or _is_file(sources[0]):
        if not sources:
            raise ValueError("sources must name at least one texture")
        return Paths([_in_full(source, filesystem) for source in sources], None)
    folder = _in_full(sources[0], filesystem)
    if filesystem is None and not is_remote(folder) and not os.path.isdir(folder):
        raise FileNotFoundError(f"{folder} does not exist")
    paths = [path for path in listed(folder, filesystem) if _is_file(path) and not _is_hidden(path)]
    if not paths:
        wanted = ", ".join((*IMAGE_EXTENSIONS, ARCHIVE))
        raise ValueError(f"{folder} must contain at least one file of these kinds: {wanted}")
    return Paths(paths, folder)


def check_distinct(paths: Iterable[str], transfer: BatchTransfer) -> None:
    """Check that no two images have the same output; archives name their own.

    Raises
    ------
    ValueError
        If two do.
    """
    sources: dict[str, str] = {}
    for path in paths:
        name = None if _is_archive(path) else transfer.name_of(path)
        if name is None:
            continue
        other = sources.setdefault(name, path)
        if other is not path:
            raise ValueError(f"{other} and {path} have the same output {name}")


def _bare(path: str) -> str:
    return path.partition("?")[0] if is_remote(path) else path


def _is_archive(path: str) -> bool:
    return _bare(path).lower().endswith(ARCHIVE)


def _is_file(path: str) -> bool:
    return _bare(path).lower().endswith((*IMAGE_EXTENSIONS, ARCHIVE))


def _is_hidden(path: str) -> bool:
    return _bare(path).rpartition("/")[2].startswith(".")


def _in_full(path: str, filesystem: Any) -> str:
    """Return a path that does not depend on the current folder, which workers do not share."""
    if filesystem is not None or is_remote(path):
        return path
    return os.path.abspath(locate(path)[1])
