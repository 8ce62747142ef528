"""Reads the triangles of GLB, VRM and glTF files with NumPy alone, by the text of glTF 2.0.

Draco, meshopt and KTX2 need decoders of their own and raise `PeerError`.
"""

import base64
import json
import struct
from typing import NamedTuple
from urllib.parse import unquote

import numpy as np

from peers.outcome import PeerError

_TYPES = {5120: "i1", 5121: "u1", 5122: "i2", 5123: "u2", 5125: "u4", 5126: "f4"}
_COUNTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
_TRIANGLES, _STRIP, _FAN = 4, 5, 6
_COMPRESSIONS = ("KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression")
_INSTANCES = "EXT_mesh_gpu_instancing"
_TRANSFORM = "KHR_texture_transform"


class Drawn(NamedTuple):
    """A primitive where its node places it at rest.

    `positions` is `(n, 3)` in world space, `faces` `(m, 3)` with their fronts counter-clockwise,
    `uv` `(n, 2)` from the top left or None, `material` the JSON object.
    """

    positions: np.ndarray
    faces: np.ndarray
    uv: np.ndarray | None
    material: dict


def primitives(path):
    """Return what the scene of a file draws."""
    return Document(path).drawn()


class Document:
    """A file and its buffers."""

    def __init__(self, path):
        self.folder = path.parent
        data = path.read_bytes()
        binary = None
        if data[:4] == b"glTF":
            data, binary = _chunks(data)
        self.json = json.loads(data.rstrip(b"\0 ").decode("utf-8-sig"))
        required = set(self.json.get("extensionsRequired", ()))
        for name in _COMPRESSIONS:
            if name in required:
                raise PeerError(f"{name} needs a decoder")
        self.buffers = [self._buffer(entry, binary) for entry in self.json.get("buffers", ())]

    def _buffer(self, entry, binary):
        uri = entry.get("uri")
        if uri is None:
            return binary
        if uri.startswith("data:"):
            return base64.b64decode(uri.partition(",")[2])
        return (self.folder / unquote(uri)).read_bytes()

    def accessor(self, index):
        """Return an accessor as `(count, components)` of float64 or int64."""
        entry = self.json["accessors"][index]
        kind, count = np.dtype("<" + _TYPES[entry["componentType"]]), entry["count"]
        components = _COUNTS[entry["type"]]
        values = np.zeros((count, components), kind)
        if "bufferView" in entry:
            offset = entry.get("byteOffset", 0)
            values = self._view(entry["bufferView"], offset, kind, count, components).copy()
        if "sparse" in entry:
            sparse = entry["sparse"]
            where, what = sparse["indices"], sparse["values"]
            wide = np.dtype("<" + _TYPES[where["componentType"]])
            offset, number = where.get("byteOffset", 0), sparse["count"]
            rows = self._view(where["bufferView"], offset, wide, number, 1)[:, 0]
            offset = what.get("byteOffset", 0)
            values[rows] = self._view(what["bufferView"], offset, kind, number, components)
        if kind.kind == "f":
            return values.astype(float)
        if entry.get("normalized"):
            return np.maximum(values / np.iinfo(kind).max, -1.0)
        return values.astype(int)

    def _view(self, index, offset, kind, count, components):
        view = self.json["bufferViews"][index]
        stride = view.get("byteStride") or kind.itemsize * components
        start = view.get("byteOffset", 0) + offset
        needed = stride * (count - 1) + kind.itemsize * components if count else 0
        data = self.buffers[view["buffer"]]
        if data is None or start + needed > len(data):
            raise PeerError("a buffer is too short")
        shape, strides = (count, components), (stride, kind.itemsize)
        return np.ndarray(shape, kind, data, start, strides)

    def drawn(self):
        """Return the primitives of all nodes in the scene."""
        worlds = self._worlds()
        return [one for index in worlds for one in self._of_node(index, worlds)]

    def _worlds(self):
        """Return the matrix from each node in the scene to the world, turned for VRM 0.x."""
        nodes, scenes = self.json.get("nodes", []), self.json.get("scenes")
        if scenes:
            roots = scenes[self.json.get("scene", 0)].get("nodes", [])
        else:
            below = {child for node in nodes for child in node.get("children", ())}
            roots = [index for index in range(len(nodes)) if index not in below]
        # VRM 0.x looks along -Z.
        is_old = "VRM" in self.json.get("extensions", {})
        start = np.diag([-1.0, 1.0, -1.0, 1.0]) if is_old else np.eye(4)
        worlds, open_nodes = {}, [(index, start) for index in roots]
        while open_nodes:
            index, parent = open_nodes.pop()
            if index in worlds:
                raise PeerError("a node with two parents")
            worlds[index] = parent @ _local(nodes[index])
            open_nodes += [(child, worlds[index]) for child in nodes[index].get("children", ())]
        return dict(sorted(worlds.items()))

    def _of_node(self, index, worlds):
        node = self.json["nodes"][index]
        if "mesh" not in node:
            return
        mesh = self.json["meshes"][node["mesh"]]
        weights = node.get("weights", mesh.get("weights", ()))
        joints = self._joints(node["skin"], worlds) if "skin" in node else None
        for primitive in mesh["primitives"]:
            faces = self._faces(primitive)
            if faces is None:
                continue
            material = (
                self.json["materials"][primitive["material"]] if "material" in primitive else {}
            )
            uv = self._uv(primitive, material)
            local = self._positions(primitive, weights)
            if joints is not None and "JOINTS_0" in primitive["attributes"]:
                yield Drawn(self._skinned(primitive, local, joints), faces, uv, material)
                continue
            for instance in self._instances(node):
                matrix = worlds[index] @ instance
                turned = faces[:, ::-1] if np.linalg.det(matrix[:3, :3]) < 0 else faces
                yield Drawn(local @ matrix[:3, :3].T + matrix[:3, 3], turned, uv, material)

    def _faces(self, primitive):
        mode = primitive.get("mode", _TRIANGLES)
        attributes = primitive["attributes"]
        if mode not in (_TRIANGLES, _STRIP, _FAN) or "POSITION" not in attributes:
            return None
        if "indices" in primitive:
            corners = self.accessor(primitive["indices"])[:, 0]
        else:
            corners = np.arange(self.json["accessors"][attributes["POSITION"]]["count"])
        if mode == _TRIANGLES:
            return corners[: len(corners) // 3 * 3].reshape(-1, 3)
        first = corners[:-2] if mode == _STRIP else np.full(max(len(corners) - 2, 0), corners[0])
        faces = np.c_[first, corners[1:-1], corners[2:]]
        if mode == _STRIP:
            faces[1::2] = faces[1::2, ::-1]
        return faces

    def _positions(self, primitive, weights):
        positions = self.accessor(primitive["attributes"]["POSITION"]).astype(float)
        for weight, target in zip(weights, primitive.get("targets", ()), strict=False):
            if weight and "POSITION" in target:
                positions = positions + weight * self.accessor(target["POSITION"])
        return positions

    def _uv(self, primitive, material):
        texture = _base_color(material)
        transform = texture.get("extensions", {}).get(_TRANSFORM, {})
        name = f"TEXCOORD_{transform.get('texCoord', texture.get('texCoord', 0))}"
        if name not in primitive["attributes"]:
            return None
        uv = self.accessor(primitive["attributes"][name]).astype(float)
        turn = transform.get("rotation", 0.0)
        rotation = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
        uv = uv * transform.get("scale", [1.0, 1.0])
        return uv @ rotation.T + transform.get("offset", [0.0, 0.0])

    def _joints(self, index, worlds):
        """Return the matrices of a skin's joints at rest, from mesh to world."""
        skin = self.json["skins"][index]
        count = len(skin["joints"])
        inverse = np.tile(np.eye(4), (count, 1, 1))
        if "inverseBindMatrices" in skin:
            # Stored by column.
            inverse = self.accessor(skin["inverseBindMatrices"]).reshape(-1, 4, 4).swapaxes(1, 2)
        if any(joint not in worlds for joint in skin["joints"]):
            raise PeerError("joints outside of the scene")
        return np.stack([worlds[joint] for joint in skin["joints"]]) @ inverse[:count]

    def _skinned(self, primitive, positions, joints):
        attributes = primitive["attributes"]
        sets = [name.removeprefix("JOINTS_") for name in attributes if name.startswith("JOINTS_")]
        which = np.hstack([self.accessor(attributes[f"JOINTS_{number}"]) for number in sets])
        weights = np.hstack([self.accessor(attributes[f"WEIGHTS_{number}"]) for number in sets])
        weights = weights / np.maximum(weights.sum(1, keepdims=True), 1e-12)
        result = np.zeros((len(positions), 3))
        for column in range(which.shape[1]):
            matrices = joints[np.where(weights[:, column] == 0, 0, which[:, column])]
            moved = np.einsum("nij,nj->ni", matrices[:, :3, :3], positions) + matrices[:, :3, 3]
            result += weights[:, column, None] * moved
        return result

    def _instances(self, node):
        """Return the matrices of a node's instances, the identity if it has none."""
        extension = node.get("extensions", {}).get(_INSTANCES)
        if extension is None:
            return [np.eye(4)]
        values = {name: self.accessor(at) for name, at in extension["attributes"].items()}
        count = max(map(len, values.values()))
        keys = {"TRANSLATION": "translation", "ROTATION": "rotation", "SCALE": "scale"}
        return [
            _local({key: values[name][at] for name, key in keys.items() if name in values})
            for at in range(count)
        ]


def _chunks(data):
    """Return the JSON and the first binary chunk of a GLB file."""
    found, at = {}, 12
    while at + 8 <= len(data):
        length, kind = struct.unpack("<I4s", data[at : at + 8])
        found.setdefault(kind, data[at + 8 : at + 8 + length])
        at += 8 + length
    if b"JSON" not in found:
        raise PeerError("a GLB file without JSON")
    return found[b"JSON"], found.get(b"BIN\0")


def _base_color(material):
    """Return the reference to the texture of a material's base colour."""
    if texture := material.get("pbrMetallicRoughness", {}).get("baseColorTexture"):
        return texture
    old = material.get("extensions", {}).get("KHR_materials_pbrSpecularGlossiness", {})
    return old.get("diffuseTexture", {})


def _local(node):
    """Return the matrix of a node, from itself to its parent."""
    if "matrix" in node:
        return np.array(node["matrix"], float).reshape(4, 4).T
    x, y, z, w = np.array(node.get("rotation", (0, 0, 0, 1)), float)
    length = x * x + y * y + z * z + w * w
    double = 2 / length if length else 0.0
    turn = np.array(
        [
            [1 - double * (y * y + z * z), double * (x * y - w * z), double * (x * z + w * y)],
            [double * (x * y + w * z), 1 - double * (x * x + z * z), double * (y * z - w * x)],
            [double * (x * z - w * y), double * (y * z + w * x), 1 - double * (x * x + y * y)],
        ]
    )
    matrix = np.eye(4)
    matrix[:3, :3] = turn * np.array(node.get("scale", (1, 1, 1)), float)
    matrix[:3, 3] = node.get("translation", (0, 0, 0))
    return matrix
