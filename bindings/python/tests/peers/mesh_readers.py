"""Reads texture coordinates of OBJ, PLY and glTF files with NumPy alone."""

import itertools
import struct
from typing import NamedTuple

import numpy as np

from peers import gltf
from peers.outcome import PeerError

_NUMBERS = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2",
    "ushort": "u2", "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4",
    "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
}  # fmt: skip
_U_NAMES = (("s", "t"), ("u", "v"), ("texture_u", "texture_v"))


class Layout(NamedTuple):
    """The triangles of a mesh that have texture coordinates.

    `vertices` is how many positions the file has, None where readers may join them; `uv` is
    `(m, 3, 2)` from the top left.
    """

    vertices: int | None
    uv: np.ndarray


def layout(path):
    """Read a file by its content."""
    data = path.read_bytes()
    if data[:4] == b"glTF" or data.lstrip(b"\xef\xbb\xbf \r\n\t")[:1] == b"{":
        return _gltf(path)
    return _ply(data) if data[:3] == b"ply" else _obj(data)


def _gltf(path):
    parts = [part for part in gltf.primitives(path) if part.uv is not None]
    uv = [part.uv[part.faces] for part in parts]
    return Layout(None, np.concatenate(uv) if uv else np.empty((0, 3, 2)))


def _obj(data):
    text = data.decode("latin-1").replace("\\\r\n", " ").replace("\\\n", " ")
    vertices, coordinates, polygons = 0, [], []
    for line in text.splitlines():
        keyword, *words = line.partition("#")[0].split() or [""]
        if keyword == "v":
            vertices += 1
        elif keyword == "vt":
            coordinates.append([float(word) for word in (*words, "0")[:2]])
        elif keyword == "f":
            parts = [word.split("/") for word in words]
            if all(len(part) > 1 and part[1] for part in parts):
                # Relative to what there is so far.
                numbers = [int(part[1]) for part in parts]
                polygons.append([n - 1 if n > 0 else len(coordinates) + n for n in numbers])
    return Layout(vertices, _from_below(np.array(coordinates).reshape(-1, 2), polygons))


def _from_below(coordinates, polygons):
    """Return the triangles of polygons as fans, with V turned over."""
    fans = [
        (polygon[0], polygon[at], polygon[at + 1])
        for polygon in polygons
        for at in range(1, len(polygon) - 1)
    ]
    uv = coordinates[np.array(fans, int).reshape(-1, 3)]
    return np.stack([uv[..., 0], 1 - uv[..., 1]], -1)


def _ply(data):
    head, end, body = data.partition(b"end_header")
    if not end:
        raise PeerError("a PLY file without the end of its header")
    body = body.partition(b"\n")[2]
    form, elements = "ascii", []
    for line in head.decode("latin-1").splitlines():
        words = line.split()
        if words[:1] == ["format"]:
            form = words[1]
        elif words[:1] == ["element"]:
            elements.append((words[1], int(words[2]), []))
        elif words[:1] == ["property"]:
            elements[-1][2].append(words[1:])
    if form == "ascii":
        # A row is a line, whatever follows on it.
        lines = (line.split() for line in body.splitlines() if line.strip())
        readers = (_words(line) for line in lines)
    else:
        readers = itertools.repeat(_numbers(body, "<" if "little" in form else ">"))
    rows = {
        name: [_row(properties, next(readers)) for _ in range(count)]
        for name, count, properties in elements
    }
    return Layout(len(rows["vertex"]), _ply_uv(rows["vertex"], rows.get("face", [])))


def _words(line):
    words = iter(line)
    return lambda kind: (float if kind[0] == "f" else int)(next(words))


def _numbers(body, order):
    at = 0

    def read(kind):
        nonlocal at
        code = {
            "i1": "b",
            "u1": "B",
            "i2": "h",
            "u2": "H",
            "i4": "i",
            "u4": "I",
            "f4": "f",
            "f8": "d",
        }[kind]
        (value,) = struct.unpack_from(order + code, body, at)
        at += int(kind[1])
        return value

    return read


def _row(properties, read):
    row = {}
    for words in properties:
        if words[0] == "list":
            count = read(_NUMBERS[words[1]])
            row[words[3]] = [read(_NUMBERS[words[2]]) for _ in range(count)]
        else:
            row[words[1]] = read(_NUMBERS[words[0]])
    return row


def _ply_uv(vertices, faces):
    polygons = [face.get("vertex_indices", face.get("vertex_index")) for face in faces]
    if faces and "texcoord" in faces[0]:
        flat = np.array([value for face in faces for value in face["texcoord"]]).reshape(-1, 2)
        starts = np.cumsum([0, *map(len, polygons)])
        at_corners = [
            list(range(start, start + len(polygon)))
            for start, polygon, face in zip(starts, polygons, faces, strict=False)
            if face["texcoord"]
        ]
        return _from_below(flat, at_corners)
    for u, v in _U_NAMES:
        if vertices and u in vertices[0]:
            return _from_below(np.array([[row[u], row[v]] for row in vertices]), polygons)
    return np.empty((0, 3, 2))
