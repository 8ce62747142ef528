"""Records of what outputs were made from, so that a run that was killed goes on where it stopped.

They are those of ``uvgraft transfer --skip-existing``: a line of JSON for each output, with its
name, the fingerprint of everything it was made from and the SHA-256 of its content. Two keys are
added, ``transfer`` (the fingerprint of what all outputs share) and ``bytes``. A line is only
written once its output is in place, so an output without a line is merely made again.

Workers never write to the same file. In a local folder each appends to a
``.uvgraft-manifest-<id>.jsonl`` of its own, beside the outputs, where the command finds it too.
Object storage cannot append: there a worker puts an object of up to `SEGMENT` lines again as it
grows, in the folder ``.uvgraft-manifest/``, which is listed without listing the outputs.
"""

from __future__ import annotations

import array
import hashlib
import json
import os
import threading
from collections.abc import Iterator
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from uvgraft._files import Files

Check = Literal["content", "size"]

_START, _END = ".uvgraft-manifest", ".jsonl"

SEGMENT = 4096
"""Lines of an object: about a megabyte, a fraction of one output, so putting it again is cheap."""


class Record(NamedTuple):
    """What an output was made from, and what it contains.

    Attributes
    ----------
    output : str
        Its path within the output folder, with ``/`` between its parts.
    made_from, sha256, transfer : str
        64 hexadecimal digits each.
    bytes : int
        Length of the output.
    """

    output: str
    made_from: str
    sha256: str
    transfer: str
    bytes: int


class Records:
    """The records of an output folder. Threads may share one.

    Of each record 16 bytes are kept in memory, so that every worker can hold those of ten million
    outputs: a 64-bit hash of the output's name and of what it was made from, and 64 bits of what
    it must contain.

    Parameters
    ----------
    files : Files
        Where the folder is.
    folder : str
        Its path.
    check : {"content", "size"}
        What proves that an output is up to date: the fingerprint of its source and the SHA-256 of
        its content, or the fingerprint of the transfer and its length.
    """

    def __init__(self, files: Files, folder: str, check: Check) -> None:
        self._files = files
        self._folder = folder
        self._check = check
        self._keys, self._values = _index(_lines(files, folder), check)
        self._lock = threading.Lock()
        self._pending: list[str] = []
        self._is_dirty = False
        self._worker = os.urandom(8).hex()
        self._segment = 0

    def is_up_to_date(self, output: str, path: str, made_from: str) -> bool:
        """Whether an output is in place, unchanged, and made from certain inputs.

        Parameters
        ----------
        output : str
            Its path within the folder.
        path : str
            Its full path.
        made_from : str
            With "content" the fingerprint of the source and of the transfer, with "size" that of
            the transfer alone.
        """
        key = np.uint64(_hash(output, made_from))
        first = int(np.searchsorted(self._keys, key, "left"))
        last = int(np.searchsorted(self._keys, key, "right"))
        recorded = self._values[first:last].tolist()
        if not recorded:
            return False
        size = self._files.size(path)
        if size is None:
            return False
        return (size if self._check == "size" else _prefix(self._files.sha256(path))) in recorded

    def add(self, record: Record) -> None:
        """Record an output that is in place; in object storage, at the next `flush`."""
        line = json.dumps(record._asdict(), ensure_ascii=False, separators=(",", ":")) + "\n"
        with self._lock:
            if self._files.is_local:
                # A single write, so that a killed process cuts its last line at most.
                path = os.path.join(self._folder, f"{_START}-{self._worker}{_END}")
                with open(path, "ab", buffering=0) as file:
                    file.write(line.encode())
                return
            self._pending.append(line)
            self._is_dirty = True

    def flush(self) -> None:
        """Put the records that object storage does not have yet."""
        with self._lock:
            if not self._is_dirty:
                return
            name = f"{self._worker}-{self._segment:06}{_END}"
            self._files.write(f"{self._folder}/{_START}/{name}", "".join(self._pending).encode())
            self._is_dirty = False
            if len(self._pending) >= SEGMENT:
                self._pending.clear()
                self._segment += 1


def _lines(files: Files, folder: str) -> Iterator[bytes]:
    """Yield the lines of all manifests of a folder, those of the command included."""
    if not files.is_local:
        for path in files.walk(f"{folder}/{_START}"):
            yield from files.read(path).splitlines()
        return
    try:
        with os.scandir(folder) as entries:
            names = [entry.name for entry in entries if entry.name.startswith(_START)]
    except FileNotFoundError:
        return
    for name in sorted(name for name in names if name.endswith(_END)):
        with open(os.path.join(folder, name), "rb") as file:
            yield from file


def _index(lines: Iterator[bytes], check: Check) -> tuple[NDArray[np.uint64], NDArray[np.uint64]]:
    """Index lines by what they are looked up by; those that are cut or foreign are left out."""
    keys, values = array.array("Q"), array.array("Q")
    for line in lines:
        try:
            record = json.loads(line)
            key, value = _entry(record, check)
        except (ValueError, KeyError, TypeError, OverflowError):
            continue
        keys.append(key)
        values.append(value)
    order = np.argsort(np.frombuffer(keys, np.uint64), kind="stable")
    return np.frombuffer(keys, np.uint64)[order], np.frombuffer(values, np.uint64)[order]


def _entry(record: dict[str, Any], check: Check) -> tuple[int, int]:
    if check == "size":
        size = int(record["bytes"])
        if not 0 <= size < 1 << 63:
            raise ValueError(size)
        return _hash(record["output"], record["transfer"]), size
    return _hash(record["output"], record["made_from"]), _prefix(record["sha256"])


def _hash(output: str, made_from: str) -> int:
    digest = hashlib.blake2b(f"{made_from} {output}".encode(), digest_size=8)
    return int.from_bytes(digest.digest(), "big")


def _prefix(sha256: str) -> int:
    return int(sha256[:16], 16)
