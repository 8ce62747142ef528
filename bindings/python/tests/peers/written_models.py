"""GLB files with what fewer programs write, by hand."""

import json
import struct

import numpy as np

from peers.case import Case

_FLOAT, _SHORT, _BYTE, _UNSIGNED_SHORT = 5126, 5122, 5121, 5123
_CODES = {"f4": _FLOAT, "i2": _SHORT, "u1": _BYTE, "u2": _UNSIGNED_SHORT}
_KINDS = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}


def cases():
    return [
        Case("plain.glb", _model({})),
        Case("instances.glb", _instances),
        Case("no_keys.glb", _no_keys),
        Case("some_without_uv.glb", _some_without_uv),
        Case("other_tile.glb", _other_tile),
        Case("quantized.glb", _quantized),
        Case("sparse.glb", _sparse),
        Case("mirrored.glb", _model({"scale": [-1, 1, 1], "rotation": [0.2, 0, 0, 0.98]})),
        Case("skin.glb", _skin),
        Case("morph.glb", _morph),
        Case("strip.glb", _strip),
    ]


def mesh_cases():
    """Return those whose layout is compared too."""
    chosen = {
        "plain.glb",
        "instances.glb",
        "some_without_uv.glb",
        "mirrored.glb",
        "sparse.glb",
        "strip.glb",
    }
    return [case for case in cases() if case.name in chosen]


class _Builder:
    """Collects the arrays of a GLB file."""

    def __init__(self):
        self.json = {"asset": {"version": "2.0"}, "bufferViews": [], "accessors": []}
        self.binary = b""

    def view(self, array):
        data = np.ascontiguousarray(array).tobytes()
        entry = {"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(data)}
        self.json["bufferViews"].append(entry)
        self.binary += data + bytes(-len(data) % 4)
        return len(self.json["bufferViews"]) - 1

    def accessor(self, array, **entries):
        array = np.asarray(array)
        count, width = array.reshape(len(array), -1).shape if array.size else (0, 1)
        entry = {
            "componentType": _CODES[array.dtype.str[1:]],
            "count": count,
            "type": _KINDS[width],
        }
        entry |= {"bufferView": self.view(array)} if array.size else {}
        if array.dtype.kind == "f" and width == 3:
            entry |= {"min": array.min(0).tolist(), "max": array.max(0).tolist()}
        self.json["accessors"].append(entry | entries)
        return len(self.json["accessors"]) - 1

    def write(self, path):
        self.json["buffers"] = [{"byteLength": len(self.binary)}]
        text = json.dumps(self.json).encode()
        text += b" " * (-len(text) % 4)
        length = 12 + 8 + len(text) + 8 + len(self.binary)
        head = struct.pack("<4sII", b"glTF", 2, length)
        chunks = struct.pack("<I4s", len(text), b"JSON") + text
        chunks += struct.pack("<I4s", len(self.binary), b"BIN\0") + self.binary
        path.write_bytes(head + chunks)


def _box():
    """Return positions, texture coordinates and indices of a box of six islands."""
    positions, uv, indices = [], [], []
    for side in range(6):
        axis, sign = side // 2, 1 - 2 * (side % 2)
        for at, (a, b) in enumerate(((-1, -1), (1, -1), (1, 1), (-1, 1))):
            point = np.zeros(3)
            point[axis], point[(axis + 1) % 3], point[(axis + 2) % 3] = sign, a * sign, b
            positions.append(point * [0.5, 0.7, 0.4])
            island = np.array([side % 3, side // 3]) / [3, 2]
            uv.append(island + [0.02, 0.02] + np.array([a > 0, b > 0]) * [0.28, 0.42])
            indices.append(4 * side + at)
    quads = np.array(indices, "<u2").reshape(6, 4)
    return np.array(positions, "<f4"), np.array(uv, "<f4"), quads[:, [0, 1, 2, 0, 2, 3]].ravel()


def _scene(builder, node, primitives):
    builder.json |= {
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, **node}],
        "meshes": [{"primitives": primitives}],
    }


def _primitive(builder, positions, uv, indices, **entries):
    attributes = {"POSITION": builder.accessor(positions)}
    if uv is not None:
        attributes["TEXCOORD_0"] = builder.accessor(uv)
    return {"attributes": attributes, "indices": builder.accessor(indices), **entries}


def _model(node):
    """Return what writes the box below a node."""

    def write(path):
        builder = _Builder()
        _scene(builder, node, [_primitive(builder, *_box())])
        builder.write(path)

    return write


def _instances(path):
    builder = _Builder()
    places = np.array([[0, 0, 0], [2, 0.5, 0], [-1, 2, 1]], "<f4")
    turns = np.array([[0, 0, 0, 1], [0, 0.6, 0, 0.8], [0.6, 0, 0, 0.8]], "<f4")
    sizes = np.array([[1, 1, 1], [0.5, 1.5, 1], [2, 0.5, 1]], "<f4")
    named = {"TRANSLATION": places, "ROTATION": turns, "SCALE": sizes}
    attributes = {name: builder.accessor(array) for name, array in named.items()}
    name = "EXT_mesh_gpu_instancing"
    node = {"extensions": {name: {"attributes": attributes}}}
    builder.json |= {"extensionsUsed": [name], "extensionsRequired": [name]}
    _scene(builder, node, [_primitive(builder, *_box())])
    builder.write(path)


def _no_keys(path):
    """An animation whose channel has no keys, as exporters write for what does not move."""
    builder = _Builder()
    _scene(builder, {}, [_primitive(builder, *_box())])
    times = builder.accessor(np.empty(0, "<f4"))
    values = builder.accessor(np.empty(0, "<f4"), type="VEC3")
    sampler = {"input": times, "output": values}
    channel = {"sampler": 0, "target": {"node": 0, "path": "translation"}}
    builder.json["animations"] = [{"samplers": [sampler], "channels": [channel]}]
    builder.write(path)


def _some_without_uv(path):
    builder = _Builder()
    positions, uv, indices = _box()
    bare = _primitive(builder, positions + np.array([0, 1.6, 0], "<f4"), None, indices)
    _scene(builder, {}, [_primitive(builder, positions, uv, indices), bare])
    builder.write(path)


def _other_tile(path):
    builder = _Builder()
    positions, uv, indices = _box()
    _scene(builder, {}, [_primitive(builder, positions, uv + np.array([3, -2], "<f4"), indices)])
    builder.write(path)


def _quantized(path):
    builder = _Builder()
    positions, _, indices = _box()
    # Each vertex has 8 bytes, of which the last two are padding.
    shorts = np.zeros((len(positions), 4), "<i2")
    shorts[:, :3] = np.rint(positions * 32767)
    builder.json |= {
        "extensionsUsed": ["KHR_mesh_quantization"],
        "extensionsRequired": ["KHR_mesh_quantization"],
    }
    view = builder.view(shorts)
    builder.json["bufferViews"][view]["byteStride"] = 8
    low, high = shorts[:, :3].min(0).tolist(), shorts[:, :3].max(0).tolist()
    entry = {"componentType": _SHORT, "type": "VEC3", "count": len(shorts), "normalized": True}
    builder.json["accessors"].append(entry | {"bufferView": view, "min": low, "max": high})
    primitive = {"attributes": {"POSITION": 0}, "indices": builder.accessor(indices)}
    _scene(builder, {"scale": [2, 1, 1]}, [primitive])
    builder.write(path)


def _sparse(path):
    """A box of which one side is pulled out by a sparse accessor."""
    builder = _Builder()
    positions, uv, indices = _box()
    primitive = _primitive(builder, positions, uv, indices)
    rows = np.arange(4, dtype="<u2")
    entry = builder.json["accessors"][primitive["attributes"]["POSITION"]]
    entry["sparse"] = {
        "count": len(rows),
        "indices": {"bufferView": builder.view(rows), "componentType": _UNSIGNED_SHORT},
        "values": {"bufferView": builder.view(positions[rows] + np.array([1, 0.3, 0], "<f4"))},
    }
    entry["max"] = [1.5, 1.0, 0.4]
    _scene(builder, {}, [primitive])
    builder.write(path)


def _skin(path):
    """A box whose upper half follows a joint that is turned."""
    builder = _Builder()
    positions, uv, indices = _box()
    primitive = _primitive(builder, positions, uv, indices)
    joints = np.zeros((len(positions), 4), "<u1")
    joints[:, 0] = positions[:, 1] > 0
    weights = np.zeros((len(positions), 4), "<f4")
    weights[:, 0] = 1
    primitive["attributes"] |= {
        "JOINTS_0": builder.accessor(joints),
        "WEIGHTS_0": builder.accessor(weights),
    }
    _scene(builder, {"skin": 0, "translation": [9, 9, 9]}, [primitive])
    turned = {"translation": [0.4, 0, 0], "rotation": [0, 0, 0.3826834, 0.9238795]}
    builder.json["nodes"] += [{"children": [2]}, turned]
    builder.json["scenes"] = [{"nodes": [0, 1]}]
    matrices = np.tile(np.eye(4, dtype="<f4"), (2, 1, 1))
    builder.json["skins"] = [{"joints": [1, 2], "inverseBindMatrices": builder.accessor(matrices)}]
    builder.write(path)


def _morph(path):
    builder = _Builder()
    positions, uv, indices = _box()
    moved = np.where(positions[:, 1:2] > 0, np.array([0.8, 0.4, 0]), 0).astype("<f4")
    primitive = _primitive(builder, positions, uv, indices)
    primitive["targets"] = [{"POSITION": builder.accessor(moved)}]
    _scene(builder, {}, [primitive])
    builder.json["meshes"][0]["weights"] = [0.75]
    builder.write(path)


def _strip(path):
    builder = _Builder()
    positions, uv, _ = _box()
    order = np.array([0, 1, 3, 2], "<u2")
    builder.json["materials"] = [{"doubleSided": True}]
    _scene(builder, {}, [_primitive(builder, positions, uv, order, mode=5, material=0)])
    builder.write(path)
