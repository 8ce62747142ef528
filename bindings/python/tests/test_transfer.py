"""Transfers in one call."""

import inspect
import re

import numpy as np
import pytest
from scenes import ASIDE, UPRIGHT, noise, square

import uvgraft

OF_TRANSFER = {"source", "target", "texture", "base", "onto", "out", "threads"}


def test_meshes_or_a_pair(pair, tmp_path):
    face, base = noise(16, 16, 3), noise(32, 32, 3, seed=2)
    meshes, path = (square(UPRIGHT), square(ASIDE)), tmp_path / "a.uvpair"
    pair.save(path)
    wanted = uvgraft.Graft(pair, filter="bilinear").apply(face, base)
    options = {"filter": "bilinear"}
    for found in [
        uvgraft.transfer(pair, face, base, **options),
        uvgraft.transfer(path, face, base, **options),
        uvgraft.transfer(str(path), face, base=base, **options),
        uvgraft.transfer(pair, texture=face, base=base, **options),
        uvgraft.transfer(pair, face, onto=base, **options),
        uvgraft.transfer(*meshes, face, base, vertex_map=range(4), **options),
        uvgraft.transfer(*meshes, face, onto=base, vertex_map=range(4), threads=1, **options),
        uvgraft.transfer(
            source=meshes[0], target=meshes[1], texture=face, base=base, by="faces", **options
        ),
    ]:
        np.testing.assert_array_equal(found, wanted)
    out = np.empty_like(base)
    assert uvgraft.transfer(pair, face, base, out=out, **options) is out
    np.testing.assert_array_equal(out, wanted)


def test_files_and_several_textures(demo):
    meshes = [demo / "head.obj", demo / "body.obj"]
    options = {"vertex_map": demo / "head_to_body.npy", "blend": "membrane"}
    files = [demo / "face.png", demo / "body_base.png"]
    wanted = uvgraft.Graft(uvgraft.Pair(*meshes, vertex_map=options["vertex_map"]),
                           blend="membrane").apply(*files)  # fmt: skip
    np.testing.assert_array_equal(uvgraft.transfer(*meshes, *files, **options), wanted)
    several = uvgraft.transfer(*meshes, [files[0]] * 2, files[1], **options)
    assert len(several) == 2
    np.testing.assert_array_equal(several[1], wanted)


def test_options_are_those_of_pairs_and_grafts():
    def names(function):
        return {it.name for it in inspect.signature(function).parameters.values()}

    of_grafts = uvgraft.GraftOptions.__annotations__.keys()
    of_pairs = uvgraft.PairingOptions.__annotations__.keys() - of_grafts
    assert of_grafts == names(uvgraft.Graft) - {"pair", "threads"}
    # A note is kept with a pair, and this one is not kept.
    assert of_pairs == names(uvgraft.Pair) - {"source", "target", "note", "threads"}
    assert names(uvgraft.transfer) == OF_TRANSFER | {"options"}
    others = uvgraft.transfer.__doc__.split("Other Parameters")[1].split("Returns")[0]
    assert of_grafts | of_pairs <= set(re.findall(r"\w+", others))


def test_calls_are_checked(pair, tmp_path):
    face, base, mesh = noise(16, 16, 3), noise(32, 32, 3), square(UPRIGHT)
    for arguments, options, error, message in [
        ((pair,), {}, TypeError, "texture is missing"),
        ((mesh, mesh), {}, TypeError, "texture is missing"),
        ((mesh,), {"texture": face}, TypeError, "target is missing"),
        ((pair, mesh, face, base), {}, TypeError, "takes a pair, a texture and a base"),
        ((mesh, face, base), {}, TypeError, "target must be a Mesh, .*, got ndarray"),
        ((3, mesh, face), {}, TypeError, "source must be a Mesh, .*, got int"),
        ((pair, face, base), {"onto": base}, TypeError, "either base or onto, got both"),
        ((pair, face, base), {"tabel": "x"}, TypeError, "unexpected keyword argument 'tabel'"),
        ((pair, face, base), {"by": "faces"}, TypeError, "by is for two meshes"),
        ((pair, face), {}, ValueError, "must have a size, such as size=2048"),
        ((tmp_path / "none.uvpair", face), {}, FileNotFoundError, "none.uvpair"),
        ((tmp_path / "none.obj", mesh, face), {}, FileNotFoundError, "none.obj"),
    ]:
        with pytest.raises(error, match=message):
            uvgraft.transfer(*arguments, **options)
