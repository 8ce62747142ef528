"""Whole files on disks and in object storage, by path or URI."""

from __future__ import annotations

import contextlib
import functools
import hashlib
import os
from collections.abc import Iterator
from typing import Any, Protocol
from urllib.parse import unquote

_CHUNK = 1 << 20


class Files(Protocol):
    """Files that are read and written as a whole. Threads may share one."""

    is_local: bool

    def read(self, path: str) -> bytes:
        """Return what a file contains."""
        ...

    def open(self, path: str) -> Any:
        """Open a file, to be read from beginning to end."""

    def write(self, path: str, data: bytes) -> None:
        """Write a file, which appears when it is whole, and the folders above it."""

    def size(self, path: str) -> int | None:
        """Return a file's length in bytes, None if it does not exist."""

    def sha256(self, path: str) -> str:
        """Return the SHA-256 of a file in hexadecimal digits."""
        ...

    def walk(self, folder: str) -> Iterator[str]:
        """Yield the paths of all files below a folder; none if it does not exist."""
        ...


class LocalFiles:
    """Files of the system: disks, and network folders that are mounted."""

    is_local = True

    def read(self, path: str) -> bytes:
        """Return what a file contains."""
        with open(path, "rb") as file:
            return file.read()

    def open(self, path: str) -> Any:
        """Open a file, to be read from beginning to end."""
        return open(path, "rb")

    def write(self, path: str, data: bytes) -> None:
        """Write to a temporary file beside the target, and rename it."""
        make_folder(os.path.dirname(path))
        # Named like those of the command, so that one pattern finds what killed processes leave.
        temporary = os.path.join(os.path.dirname(path), f".uvgraft-{os.urandom(8).hex()}.tmp")
        try:
            with open(temporary, "xb") as file:
                file.write(data)
            os.replace(temporary, path)
        except BaseException:
            with contextlib.suppress(OSError):
                os.unlink(temporary)
            raise

    def size(self, path: str) -> int | None:
        """Return a file's length in bytes, None if it does not exist."""
        try:
            return os.stat(path).st_size
        except (FileNotFoundError, NotADirectoryError):
            return None

    def sha256(self, path: str) -> str:
        """Return the SHA-256 of a file in hexadecimal digits."""
        digest = hashlib.sha256()
        with open(path, "rb") as file:
            while chunk := file.read(_CHUNK):
                digest.update(chunk)
        return digest.hexdigest()

    def walk(self, folder: str) -> Iterator[str]:
        """Yield the paths of all files below a folder; none if it does not exist."""
        for parent, folders, names in os.walk(folder):
            folders.sort()
            yield from (os.path.join(parent, name) for name in sorted(names))


_LOCAL = LocalFiles()


def locate(uri: str, filesystem: Any = None) -> tuple[Files, str]:
    """Find where a path or URI leads.

    Parameters
    ----------
    uri : str
        A path, ``file://...``, ``s3://bucket/key?region=...``, or any other URI that pyarrow or
        fsspec know.
    filesystem : pyarrow.fs.FileSystem or fsspec.AbstractFileSystem, optional
        What `uri` is a path in; it then has no scheme.

    Returns
    -------
    Files
        Where the file is.
    str
        Its path there.

    Raises
    ------
    ImportError
        If the path is not local, and pyarrow or the module for its scheme is not installed.
    """
    if filesystem is not None:
        from uvgraft._remote import RemoteFiles  # noqa: PLC0415 - needs pyarrow

        return RemoteFiles(filesystem), uri.rstrip("/")
    scheme, separator, rest = uri.partition("://")
    if not separator:
        return _LOCAL, uri
    if scheme == "file":
        # Some engines encode what is no letter and others do not; Daft's paths may be relative.
        path = rest.removeprefix("localhost")
        return _LOCAL, path if os.path.exists(path) else unquote(path)
    rest, _, query = rest.partition("?")
    host, _, path = rest.partition("/")
    files, root = _opened(scheme, host, query)
    return files, f"{root}/{path}".rstrip("/")


@functools.lru_cache(maxsize=64)
def _opened(scheme: str, host: str, query: str) -> tuple[Files, str]:
    """Open the root of a file system: connections are then shared by all paths in it."""
    from uvgraft._remote import opened  # noqa: PLC0415 - needs pyarrow

    return opened(scheme, host, query)


def is_remote(path: str) -> bool:
    """Whether a path is a URI of anything but a local file."""
    return "://" in path and not path.startswith("file://")


def listed(folder: str, filesystem: Any = None) -> Iterator[str]:
    """Yield the paths or URIs of all files below a folder, sorted, as `locate` takes them."""
    files, path = locate(folder, filesystem)
    if files.is_local or filesystem is not None:
        yield from files.walk(path)
        return
    yield from (below(folder, found[len(path) :].lstrip("/")) for found in files.walk(path))


def below(folder: str, name: str) -> str:
    """Return the path or URI of a file below a folder, with the options of the folder's URI."""
    base, separator, query = folder.partition("?") if is_remote(folder) else (folder, "", "")
    return f"{base.rstrip('/')}/{name}{separator}{query}" if base else name


def make_folder(folder: str) -> None:
    """Make a local folder and those above it."""
    if folder:
        os.makedirs(folder, exist_ok=True)
