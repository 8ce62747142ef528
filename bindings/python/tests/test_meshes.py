"""Meshes from arrays, files and other packages, and files of any kind."""

import os
import pathlib
import re
import types

import numpy as np
import pytest
from scenes import ASIDE, FACES, POSITIONS, UPRIGHT, noise, real_data, square

import uvgraft


def test_meshes():
    below = uvgraft.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], [[0, 0.25]] * 3,
                         uv_origin="bottom-left")  # fmt: skip
    np.testing.assert_array_equal(below.uv, [[0, 0.75]] * 3)
    assert below.faces.dtype == np.uint32
    for arguments, error, message in [
        (([[0, 0]], [[0, 0, 0]], [[0, 0]]), ValueError, r"positions must have shape \(n, 3\)"),
        (([[0, 0, 0]], [[0, 0, 1]], [[0, 0]]), uvgraft.Error, "vertex"),
        (([[0, 0, 0]], [[0, 0, -1]], [[0, 0]]), ValueError, "-1 is not an index"),
        (([[0, 0, 0]], [[0.5, 0, 0]], [[0, 0]]), TypeError, "faces"),
        (([[np.nan, 0, 0]], [[0, 0, 0]], [[0, 0]]), uvgraft.Error, "finite"),
        (([["a", 0, 0]], [[0, 0, 0]], [[0, 0]]), TypeError, "positions"),
    ]:
        with pytest.raises(error, match=message):
            uvgraft.Mesh(*arguments, uv_origin="top-left")
    with pytest.raises(TypeError):
        uvgraft.Mesh([[0, 0, 0]], [[0, 0, 0]], [[0, 0]])


def test_a_mesh_is_made_of_whatever_is_one(demo):
    path = demo / "head.obj"
    loaded = uvgraft.Mesh.load(path)
    for same in (uvgraft.Mesh(path), uvgraft.Mesh(os.fspath(path)), uvgraft.Mesh(loaded)):
        assert same.name == "head.obj"
        for name in ("positions", "faces", "uv", "uv_faces"):
            np.testing.assert_array_equal(getattr(same, name), getattr(loaded, name))
    assert uvgraft.Mesh(path, name="mine").name == "mine"
    for arguments, options, error, message in [
        (("none.obj",), {}, FileNotFoundError, "none.obj"),
        ((3,), {}, TypeError, "path, a mesh of trimesh, or positions, .*; faces is missing"),
        ((POSITIONS, FACES, UPRIGHT), {}, TypeError, "uv_origin is missing"),
        ((path,), {"uv_origin": "top-left"}, TypeError, "uv_origin is for arrays .* head.obj has"),
        ((loaded, FACES), {}, TypeError, "faces is for arrays of positions; head.obj has"),
    ]:
        with pytest.raises(error, match=message):
            uvgraft.Mesh(*arguments, **options)


def foreign(uv=UPRIGHT, **others):
    """Make an object with what a mesh of trimesh has; V is up."""
    up = None if uv is None else np.array(uv) * [1, -1] + [0, 1]
    visual = types.SimpleNamespace(uv=up)
    given = {"vertices": np.array(POSITIONS), "faces": np.array(FACES), "visual": visual}
    return types.SimpleNamespace(**given | others)


def scene(*parts):
    """Make an object with what a scene of trimesh has."""
    return types.SimpleNamespace(geometry={}, dump=lambda: list(parts))


def test_scenes_are_the_meshes_in_them():
    beside = foreign(ASIDE, vertices=np.add(POSITIONS, [2, 0, 0]))
    both = uvgraft.Mesh(scene(foreign(), beside))
    np.testing.assert_array_equal(both.faces, FACES + [[a + 4 for a in face] for face in FACES])
    np.testing.assert_array_equal(both.uv, np.concatenate(
        [uvgraft.Mesh(foreign()).uv, uvgraft.Mesh(beside).uv]))  # fmt: skip
    assert both.positions[4:, 0].min() == 2
    with pytest.warns(UserWarning, match="mesh: 1 of 2 parts of the scene have no UV coordinates"):
        one = uvgraft.Mesh(scene(foreign(None), beside))
    np.testing.assert_array_equal(one.positions, uvgraft.Mesh(beside).positions)


def test_scenes_of_trimesh(demo):
    trimesh = pytest.importorskip("trimesh")
    for name in ("head.obj", "avatar.glb"):
        loaded = trimesh.load(demo / name)
        assert isinstance(loaded, trimesh.Scene)
        found, wanted = uvgraft.Mesh(loaded), uvgraft.Mesh(demo / name)
        assert found.name == name
        # Of the same corners, whose triangles are in the order of parts.
        corners = [
            np.concatenate([mesh.positions[mesh.faces], mesh.uv[mesh.uv_faces]], axis=2)
            for mesh in (found, wanted)
        ]
        corners = [np.sort(it.reshape(-1, 5).round(4), axis=0) for it in corners]
        np.testing.assert_allclose(*corners, atol=2e-4)


def test_objects_of_other_packages():
    mesh = uvgraft.Mesh(foreign())
    np.testing.assert_allclose(mesh.uv, UPRIGHT, atol=1e-7)
    np.testing.assert_array_equal(mesh.positions, np.float32(POSITIONS))
    named = [{"metadata": {"file_name": "a/b.obj"}},
             {"source": types.SimpleNamespace(file_path=pathlib.Path("a/b.obj"))}]  # fmt: skip
    assert [uvgraft.Mesh(foreign(**it)).name for it in named] == ["b.obj"] * 2
    pair = uvgraft.Pair(foreign(), foreign(ASIDE), vertex_map=range(4))
    assert (pair.source.name, pair.target.name) == ("source", "target")
    wanted = uvgraft.Pair(square(UPRIGHT), square(ASIDE), vertex_map=range(4))
    found = uvgraft.Graft(pair).map(size=32).uv()
    np.testing.assert_allclose(found, uvgraft.Graft(wanted).map(size=32).uv(), atol=1e-6)
    for given, error, message in [
        (foreign(None), uvgraft.Error, r"mesh: a mesh must have UV coordinates \(visual.uv\)"),
        (foreign(visual=types.SimpleNamespace()), uvgraft.Error, "must have UV coordinates"),
        (foreign(UPRIGHT[:3]), uvgraft.Error, "mesh: "),
        (foreign(faces=[[0, 1, 2, 3]]), ValueError, r"mesh.faces must have shape \(n, 3\)"),
        (foreign(faces=[[0, 1, -1]]), ValueError, "mesh.faces: -1 is not an index"),
        (foreign(vertices="abc"), TypeError, "mesh.vertices must hold numbers"),
        (foreign(faces=[[0, 1, 4]]), uvgraft.Error, "vertex 4 does not exist; there are 4"),
        (scene(foreign(None), types.SimpleNamespace()), uvgraft.Error, "must have UV coordinates"),
    ]:
        with pytest.raises(error, match=message):
            uvgraft.Mesh(given)


def with_seam(path):
    """Write a grid whose layout is cut in two."""
    lines = [f"v {x} {y} {x * y / 9}" for y in range(4) for x in range(5)]
    lines += [f"vt {x / 10} {y / 4 + 0.01}" for y in range(4) for x in range(5)]
    lines += [f"vt {x / 10 + 0.3} {y / 4 + 0.01}" for y in range(4) for x in range(5)]
    for y in range(3):
        for x in range(4):
            at = 5 * y + x + 1
            corners = [at, at + 1, at + 6, at + 5]
            words = [f"{it}/{it + (20 if x > 1 else 0)}" for it in corners]
            lines += [f"f {words[0]} {words[a]} {words[a + 1]}" for a in (1, 2)]
    path.write_text("\n".join(lines))
    return path


def maps_of(source, target, **options):
    """Return the map of a pair that trimesh's meshes are in, and of one from the paths."""
    trimesh = pytest.importorskip("trimesh")
    pairs = [uvgraft.Pair(source, target, **options)]
    pairs.append(uvgraft.Pair(trimesh.load(source), target, **options))
    pairs.append(uvgraft.Pair(source, trimesh.load(target), **options))
    assert [it.source.name for it in pairs] == [source.name] * 3
    return [uvgraft.Graft(pair).map(size=256).uv() for pair in pairs]


@pytest.mark.filterwarnings("ignore:vertex_map. taken for a map of")
@pytest.mark.filterwarnings("ignore:100 % of the linked area is mirrored")
def test_meshes_of_trimesh_give_the_maps_of_their_files(tmp_path):
    path = with_seam(tmp_path / "grid.obj")
    turned = tmp_path / "turned.obj"
    turned.write_text(re.sub(r"vt (\S+) (\S+)", r"vt \2 \1", path.read_text()))
    # trimesh splits vertices at seams, and numbers them in another way.
    for options in ({"vertex_map": range(20)}, {"by": "topology"}):
        wanted, *found = maps_of(path, turned, **options)
        assert np.isfinite(wanted).any()
        for it in found:
            np.testing.assert_array_equal(it, wanted)


@pytest.mark.filterwarnings("ignore:vertex_map. taken for a map of")
def test_real_meshes_of_trimesh(tmp_path):
    data = real_data()
    source, target = data / "flame_head_template.obj", data / "smplx_addon.obj"
    wanted, *found = maps_of(source, target, vertex_map=data / "smplx_flame_vertex_ids.npy")
    for it in found:
        # Of the same triangles, whose corners begin with another one.
        np.testing.assert_array_equal(np.isnan(it), np.isnan(wanted))
        np.testing.assert_allclose(it, wanted, atol=1e-6)


def test_what_is_assumed_of_meshes_is_warned_of(tmp_path):
    lines = ["v 0 0 0", "v 1 0 0", "v 1 1 0", "v 0 1 0", "vt 0 0", "vt 1 0", "vt 1 1", "vt 0 1"]
    sheet = [*lines, "f 1/1 2/2 3/3 4/4"]
    path = tmp_path / "part.obj"
    path.write_text("\n".join([*sheet, "o hair", "f 1 2 3"]))
    with pytest.warns(UserWarning, match="1 of 2 polygons has no UV coordinates"):
        assert len(uvgraft.Mesh.load(path).faces) == 2
    path.write_text("\n".join([*sheet, "v 5 5 5"]))
    (tmp_path / "target.obj").write_text("\n".join([*sheet, "v 5 5 5", "v 6 5 5"]))
    with pytest.warns(UserWarning, match=r"a map of the first 4 vertices \(1 after them"):
        pair = uvgraft.Pair(path, tmp_path / "target.obj", vertex_map=range(4))
    assert pair.method == "vertex-map"


def test_files_of_any_kind(demo, tmp_path):
    np.testing.assert_array_equal(
        uvgraft.load(demo / "face.png"), uvgraft.read_image(demo / "face.png")
    )
    assert uvgraft.load(demo / "head_to_body.uvpair") == uvgraft.Pair(demo / "head_to_body.uvpair")
    for name in ("head.obj", "avatar.glb"):
        found, wanted = uvgraft.load(demo / name), uvgraft.Mesh.load(demo / name)
        assert isinstance(found, uvgraft.Mesh)
        np.testing.assert_array_equal(found.uv, wanted.uv)
    # The content says what a file is, whatever it is called.
    for name, kind in [("face.png", np.ndarray), ("head_to_body.uvpair", uvgraft.Pair),
                       ("head.obj", uvgraft.Mesh), ("avatar.glb", uvgraft.Mesh)]:  # fmt: skip
        path = tmp_path / "file.bin"
        path.write_bytes((demo / name).read_bytes())
        assert isinstance(uvgraft.load(path), kind), name
    with pytest.raises(uvgraft.Error, match=r'head\.obj: no object.*"hat"'):
        uvgraft.load(f"{demo / 'head.obj'}#hat")


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.bin", b"\0\1\2", r"a mesh \(OBJ.*\) or a pair file, got a file that begins with"),
        ("a.txt", b"hello", "not an OBJ file"),
        ("a.png", b"abc\0", "not a supported image"),
        ("a.PNG", b"\x89PNG\r\n\x1a\n", r"a\.PNG: "),
        ("a.uvpair", b"zz\0", "not a pair file"),
        ("a.obj", b"\0\1\2", "not an OBJ file"),
        ("a.npy", b"\x93NUMPY\1\0", "got a NumPy array; numpy.load reads these"),
        ("a", b"", r"a: the file is empty"),
    ],
)
def test_files_that_are_nothing_are_refused(tmp_path, name, content, message):
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(uvgraft.Error, match=message):
        uvgraft.load(path)


def test_what_is_no_file(tmp_path):
    with pytest.raises(uvgraft.Error, match="got no file"):
        uvgraft.load(tmp_path)
    with pytest.raises(FileNotFoundError, match=r"none\.png"):
        uvgraft.load(tmp_path / "none.png")
    with pytest.raises(TypeError):
        uvgraft.load(noise(4, 4, 3))
