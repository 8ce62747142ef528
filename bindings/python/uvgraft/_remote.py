"""Whole files in object storage, through pyarrow or fsspec."""

from __future__ import annotations

import contextlib
import hashlib
import importlib
import os
from collections.abc import Iterator
from typing import Any

from pyarrow.fs import FileSelector, FileSystem, FSSpecHandler, PyFileSystem

# Schemes that pyarrow opens itself; all others are fsspec's.
_OF_PYARROW = {"s3", "gs", "gcs", "abfs", "abfss", "hdfs", "viewfs"}

# Object storage: what is put appears when it is whole, and renaming would copy it.
_PUT_ATOMICALLY = {"s3", "s3a", "gs", "gcs", "abfs", "abfss", "az", "adl", "oci", "oss", "memory"}

# Bytes of a request of a stream.
_STREAMED = 8 << 20


class RemoteFiles:
    """Files of a file system of pyarrow or fsspec. Threads may share one.

    Parameters
    ----------
    filesystem : pyarrow.fs.FileSystem or fsspec.AbstractFileSystem
        Where they are.
    """

    is_local = False

    def __init__(self, filesystem: Any) -> None:
        self._fsspec: Any = None
        protocol: Any
        if isinstance(filesystem, FileSystem):
            protocol = filesystem.type_name
        else:
            self._fsspec, protocol = filesystem, filesystem.protocol
            filesystem = PyFileSystem(FSSpecHandler(filesystem))
        self._files = filesystem
        protocols = {protocol} if isinstance(protocol, str) else set(protocol)
        self._puts_atomically = bool(protocols & _PUT_ATOMICALLY)

    def read(self, path: str) -> bytes:
        """Return what a file contains."""
        if self._fsspec is not None:
            return bytes(self._fsspec.cat_file(path))
        # In one request: streams make one for each quarter of a megabyte.
        with self._files.open_input_file(path) as file:
            return bytes(file.read_at(file.size(), 0))

    def open(self, path: str) -> Any:
        """Open a file, to be read from beginning to end."""
        return self._files.open_input_stream(path, buffer_size=_STREAMED)

    def write(self, path: str, data: bytes) -> None:
        """Put an object at once, or write to a temporary file and rename it."""
        if self._puts_atomically:
            self._put(path, data)
            return
        folder = path.rpartition("/")[0]
        self._files.create_dir(folder, recursive=True)
        temporary = f"{folder}/.uvgraft-{os.urandom(8).hex()}.tmp"
        try:
            self._put(temporary, data)
            self._files.move(temporary, path)
        except BaseException:
            with contextlib.suppress(Exception):
                self._files.delete_file(temporary)
            raise

    def _put(self, path: str, data: bytes) -> None:
        # A whole object in one call: closing a stream after a failed write could leave half of it.
        if self._fsspec is not None:
            self._fsspec.pipe_file(path, data)
            return
        with self._files.open_output_stream(path) as file:
            file.write(data)

    def size(self, path: str) -> int | None:
        """Return a file's length in bytes, None if it does not exist."""
        size: int | None = self._files.get_file_info(path).size
        return size

    def sha256(self, path: str) -> str:
        """Return the SHA-256 of a file in hexadecimal digits."""
        return hashlib.sha256(self.read(path)).hexdigest()

    def walk(self, folder: str) -> Iterator[str]:
        """Yield the paths of all files below a folder; none if it does not exist."""
        selector = FileSelector(folder, recursive=True, allow_not_found=True)
        infos = self._files.get_file_info(selector)
        yield from sorted(info.path for info in infos if info.is_file)


def opened(scheme: str, host: str, query: str) -> tuple[RemoteFiles, str]:
    """Open a file system.

    Parameters
    ----------
    scheme, host : str
        Those of a URI: ``s3``, and the bucket's name.
    query : str
        Its options, such as ``region=eu-central-1``; pyarrow's alone have any.

    Returns
    -------
    RemoteFiles
        The file system.
    str
        The path of its root.

    Raises
    ------
    ImportError
        If the scheme is not pyarrow's, and fsspec or its module for the scheme is not installed.
    """
    if scheme in _OF_PYARROW:
        if scheme == "s3" and "allow_delayed_open" not in query:
            # Small objects are then put in one request in place of three.
            query = f"{query}&allow_delayed_open=true".lstrip("&")
        root = f"{scheme}://{host}/" + (f"?{query}" if query else "")
        filesystem, path = FileSystem.from_uri(root)
    else:
        core = importlib.import_module("fsspec.core")
        filesystem, path = core.url_to_fs(f"{scheme}://{host}/")
    return RemoteFiles(filesystem), str(path).rstrip("/")
