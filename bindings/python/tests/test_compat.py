"""The functions of the reference implementation."""

import inspect

import numpy as np
import pytest
from scenes import command, noise, real_data
from sheets import sheet_arrays

import uvgraft
from uvgraft.compat import fastflame2smplx as ftx

SOURCE, TARGET = (30, 40), (80, 60)  # width and height


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """A head and a body that share a sheet, the vertex map, and a texture of each."""
    folder = tmp_path_factory.mktemp("files")
    positions, faces, head, body = sheet_arrays()
    obj(folder / "head.obj", positions, head, faces)
    # Other vertices in front, and other faces among which the shared ones are.
    front = [[9, 9, 9], [9, 9, 8]]
    faces_of_body = np.r_[[[0, 1, 2]], faces[::-1] + 2]
    obj(folder / "body.obj", np.r_[front, positions], np.r_[[[0, 0]] * 2, body], faces_of_body)
    np.save(folder / "ids.npy", np.arange(len(positions)) + 2)
    uvgraft.write_image(folder / "head.png", noise(*SOURCE[::-1], 3))
    uvgraft.write_image(folder / "body.png", noise(*TARGET[::-1], 3, seed=2))
    return folder


def obj(path, positions, uv, faces):
    lines = [f"v {x} {y} {z}" for x, y, z in positions]
    lines += [f"vt {u:.9f} {1 - v:.9f}" for u, v in uv]
    lines += ["f " + " ".join(f"{corner}/{corner}" for corner in face) for face in faces + 1]
    path.write_text("\n".join(lines) + "\n")


def to_body(files, **options):
    meshes = [files / name for name in ("head.obj", "body.obj", "ids.npy")]
    return ftx.flame_smplx_texture_combine(
        files / "head.png",
        files / "body.png",
        *meshes,
        **{"src_size": SOURCE, "tgt_size": TARGET, **options},
    )


def to_head(files, **options):
    meshes = [files / name for name in ("body.obj", "head.obj", "ids.npy")]
    return ftx.smplx_flame_texture_combine(
        files / "body.png",
        files / "head.png",
        *meshes,
        **{"src_size": TARGET, "tgt_size": SOURCE, **options},
    )


def bgr(path):
    return uvgraft.read_image(path)[..., ::-1]


def reference(source, base, grid, faces):
    """What the reference does with a grid: samples with aligned corners, truncated."""
    size = np.array(source.shape[1::-1])
    at = (grid[0].astype(np.float64) + 1) / 2 * (size - 1)
    low = np.floor(at).astype(int)
    values = 0.0
    for step in np.ndindex(2, 2):
        texel = low + step
        weight = np.prod(1 - np.abs(at - texel), axis=-1)
        x, y = np.moveaxis(np.minimum(texel, size - 1), -1, 0)
        values = values + weight[..., None] * source[y, x]
    return np.where((faces >= 0)[..., None], np.floor(values), base)


def test_arguments_are_those_of_the_reference():
    def arguments(function):
        given = inspect.signature(function).parameters.values()
        return [
            (one.name, None if one.default is one.empty else one.default)
            for one in given
            if one.kind is one.POSITIONAL_OR_KEYWORD
        ]

    rest = [("smplx_flame_vertex_ids", None), ("smplx_face_indexes", None)]
    rest += [("uv_grid_load_path", None), ("uv_grid_save_path", None)]
    assert arguments(ftx.flame_smplx_texture_combine) == [
        ("flame_texture_path", None),
        ("smplx_texture_path", None),
        ("flame_obj", None),
        ("smplx_obj", None),
        *rest,
        ("src_size", (2048, 2048)),
        ("tgt_size", (4096, 4096)),
    ]
    assert arguments(ftx.smplx_flame_texture_combine) == [
        ("smplx_texture_path", None),
        ("flame_texture_path", None),
        ("smplx_obj", None),
        ("flame_obj", None),
        *rest,
        ("src_size", (4096, 4096)),
        ("tgt_size", (2048, 2048)),
    ]


@pytest.mark.parametrize("way", [to_body, to_head])
def test_pixels_are_those_of_the_reference(files, tmp_path, way):
    saved = tmp_path / "grid.npz"
    result = way(files, uv_grid_load_path=saved, uv_grid_save_path=saved)
    with np.load(saved) as file:
        grid, faces = file["uv_grid"], file["pix_to_face"]
    source, base = (bgr(files / name) for name in ("head.png", "body.png"))
    if way is to_head:
        source, base = base, source
    assert (grid.dtype, grid.shape) == (np.dtype(np.float32), (1, *base.shape[:2], 2))
    assert (faces.dtype, faces.shape) == (np.dtype(np.int64), base.shape[:2])
    assert (result.dtype, result.shape) == (np.dtype(np.uint8), base.shape)
    wanted = reference(source, base, grid, faces)
    # The values of single floats, truncated.
    assert np.abs(result - wanted).max() <= 1
    assert (result == wanted).mean() > 0.99
    assert 0.2 < (faces >= 0).mean() < 0.9
    np.testing.assert_array_equal(result[faces < 0], base[faces < 0])
    # From the grid alone.
    images = ["head.png", "body.png"][:: 1 if way is to_body else -1]
    combine = ftx.flame_smplx_texture_combine if way is to_body else ftx.smplx_flame_texture_combine
    sizes = {"src_size": source.shape[1::-1], "tgt_size": base.shape[1::-1]}
    again = combine(*(str(files / name) for name in images), uv_grid_load_path=str(saved), **sizes)
    np.testing.assert_array_equal(again, result)


@pytest.mark.torch
def test_grid_sample_gives_the_same_pixels(files, tmp_path):
    torch = pytest.importorskip("torch")
    result = to_body(files, uv_grid_save_path=tmp_path / "grid")
    with np.load(tmp_path / "grid.npz") as file:
        grid, faces = torch.from_numpy(file["uv_grid"]), file["pix_to_face"]
    source = torch.from_numpy(bgr(files / "head.png").copy()).movedim(-1, 0)[None] / 255
    sampled = torch.nn.functional.grid_sample(source, grid, align_corners=True)
    wanted = (sampled[0].movedim(0, -1).numpy() * 255).astype(np.uint8)[faces >= 0]
    difference = np.abs(result[faces >= 0].astype(int) - wanted)
    assert difference.max() <= 1
    assert (difference == 0).mean() > 0.99


def test_the_grid_by_hand(tmp_path):
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    uv = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    obj(tmp_path / "head.obj", square, 0.5 * uv, faces)
    obj(tmp_path / "body.obj", square, uv, faces)
    np.save(tmp_path / "ids.npy", np.arange(4))
    texture = np.full((4, 4, 3), 200, np.uint8)
    uvgraft.write_image(tmp_path / "head.png", texture)
    uvgraft.write_image(tmp_path / "body.png", texture)
    sizes = {"src_size": (4, 4), "tgt_size": (4, 4), "uv_grid_save_path": tmp_path / "grid.npz"}
    to_body(tmp_path, **sizes)
    with np.load(tmp_path / "grid.npz") as file:
        grid, found = file["uv_grid"][0], file["pix_to_face"]
    # The centres on the diagonal are on both triangles, and the last one has them.
    np.testing.assert_array_equal(found, 1 - np.triu(np.ones((4, 4), int), 1))
    u = (np.arange(4) + 0.5) / 4
    np.testing.assert_allclose(grid[..., 0], np.tile(u - 1, (4, 1)), atol=1e-6)
    np.testing.assert_allclose(grid[..., 1], np.tile(u - 1, (4, 1)).T, atol=1e-6)


def test_a_region(files, tmp_path):
    np.save(tmp_path / "region.npy", np.arange(2, 30))
    result = to_body(files, smplx_face_indexes=tmp_path / "region.npy")
    base = bgr(files / "body.png")
    changed = (result != base).any(-1)
    everything = (to_body(files) != base).any(-1)
    assert 0.2 * everything.sum() < changed.sum() < 0.8 * everything.sum()
    assert not (changed & ~everything).any()


@pytest.mark.parametrize("way", [to_body, to_head])
def test_exact_is_our_own_transfer(files, tmp_path, way):
    saved = tmp_path / "grid.npz"
    # The size of the source does not matter, and grids are written but not read.
    options = {"src_size": (5, 5), "uv_grid_load_path": saved, "uv_grid_save_path": saved}
    result = way(files, convention="exact", **options)
    ids = np.load(files / "ids.npy")
    pair = uvgraft.Pair(files / "head.obj", files / "body.obj", vertex_map=ids)
    images = [files / "head.png", files / "body.png"]
    graft = uvgraft.Graft(pair, reverse=way is to_head)
    wanted = graft.apply(*(images if way is to_body else images[::-1]))
    np.testing.assert_array_equal(result, wanted[..., ::-1])
    with np.load(saved) as file:
        faces = file["pix_to_face"]
    np.testing.assert_array_equal(faces, graft.map(size=result.shape[:2]).faces(gutter=True))
    np.testing.assert_array_equal(way(files, convention="exact", **options), result)


def test_exact_samples_of_grids(files, tmp_path):
    pair, grids = tmp_path / "sheet.uvpair", [tmp_path / "own.npz", tmp_path / "exact.npz"]
    meshes = (files / "head.obj", files / "body.obj")
    uvgraft.Pair(*meshes, vertex_map=files / "ids.npy").save(pair)
    size = ["--size", f"{TARGET[0]}x{TARGET[1]}", "--gutter", "0"]
    command("map", pair, *size, "-o", grids[0])
    exact = ["--convention", "exact", "--source-size", f"{SOURCE[0]}x{SOURCE[1]}"]
    command("map", pair, *size, *exact, "-o", grids[1])
    # A picture whose levels are positions.
    x, y = (np.arange(side) for side in SOURCE)
    ramp = np.zeros((*SOURCE[::-1], 3), np.uint8)
    ramp[..., 0], ramp[..., 1] = 8 * x, 6 * y[:, None]
    uvgraft.write_image(tmp_path / "ramp.png", ramp)
    images = (tmp_path / "ramp.png", files / "body.png")
    map = uvgraft.SamplingMap(uvgraft.Pair.load(pair), size=TARGET[::-1], gutter=0)
    covered = map.faces() >= 0
    wanted = (map.uv()[covered] * SOURCE - 0.5) * (8, 6)
    for grid in grids:
        options = {"uv_grid_load_path": grid, "tgt_size": TARGET}
        result = ftx.flame_smplx_texture_combine(*images, convention="exact", **options)
        found = result[..., ::-1][covered][:, :2]
        np.testing.assert_allclose(found, wanted, atol=0.51)
        off = ftx.flame_smplx_texture_combine(*images, src_size=SOURCE, **options)
        error = np.abs(off[..., ::-1][covered][:, :2] - wanted).max()
        # Up to half a texel, except for files that already make up for it; and truncation.
        assert error > 2 if grid is grids[0] else error < 1.01


def test_images_are_read_as_opencv_reads_them(files, tmp_path):
    wide = noise(*SOURCE[::-1], 3, np.uint16)
    textures = {
        "grey": (noise(*SOURCE[::-1], 1), lambda image: image.repeat(3, -1)),
        "alpha": (noise(*SOURCE[::-1], 4), lambda image: image[..., :3]),
        "wide": (wide, lambda image: (image // 256).astype(np.uint8)),
    }
    results = {}
    for name, (image, plain) in textures.items():
        for kind, texture in ((name, image), (name + "_plain", plain(image))):
            folder = tmp_path / kind
            folder.mkdir()
            for file in files.iterdir():
                (folder / file.name).write_bytes(file.read_bytes())
            uvgraft.write_image(folder / "head.png", texture)
            results[kind] = to_body(folder)
    for name in textures:
        np.testing.assert_array_equal(results[name], results[name + "_plain"])
    assert (results["grey"] != results["alpha"]).any()


def test_sizes_are_changed_as_opencv_changes_them():
    grey = np.array([[0, 50, 255], [100, 7, 30]], np.uint8)
    image = np.stack([grey, 255 - grey, grey // 2], -1)
    # The results of cv2.resize of OpenCV 5.0.0, for widths and heights.
    wanted = {
        (2, 2): [[[13, 243, 6], [204, 51, 102]], [[77, 178, 38], [24, 231, 12]]],
        (5, 3): [
            [[0, 255, 0], [20, 235, 10], [50, 205, 25], [173, 82, 86], [255, 0, 127]],
            [[50, 205, 25], [41, 214, 20], [29, 227, 14], [97, 158, 48], [143, 113, 71]],
            [[100, 155, 50], [63, 192, 31], [7, 248, 3], [21, 234, 10], [30, 225, 15]],
        ],
    }
    for size, values in wanted.items():
        np.testing.assert_array_equal(ftx._resized(image, size), values)
    assert ftx._resized(image, (3, 2)) is image


def test_the_target_is_resized(files):
    result = to_body(files, tgt_size=(33, 21))
    assert result.shape == (21, 33, 3)
    assert to_body(files, tgt_size=(33, 21), convention="exact").shape == (21, 33, 3)


def test_errors(files, tmp_path):
    textures = (files / "head.png", files / "body.png")
    with pytest.raises(ValueError, match=r"flame_obj, smplx_obj .*none\.npz does not exist"):
        ftx.flame_smplx_texture_combine(*textures, uv_grid_load_path=tmp_path / "none.npz")
    with pytest.raises(ValueError, match="convention must be"):
        to_body(files, convention="exakt")
    np.save(tmp_path / "short.npy", np.arange(3))
    options = {"smplx_flame_vertex_ids": tmp_path / "short.npy"}
    meshes = {"flame_obj": files / "head.obj", "smplx_obj": files / "body.obj"}
    with pytest.raises(FileNotFoundError):
        ftx.flame_smplx_texture_combine(tmp_path / "none.png", textures[1], **meshes, **options)
    with pytest.raises(ValueError, match=r"must be 49 integers, .* got int64 of shape \(3,\)"):
        ftx.flame_smplx_texture_combine(*textures, **meshes, **options)
    np.save(tmp_path / "no.npy", np.full(49, -1))
    options = {"smplx_flame_vertex_ids": tmp_path / "no.npy"}
    with pytest.raises(uvgraft.Error, match="no face of flame_obj"):
        ftx.flame_smplx_texture_combine(*textures, **meshes, **options)
    np.savez(tmp_path / "other.npz", uv_grid=np.zeros((1, 4, 4, 2)))
    with pytest.raises(ValueError, match="must have the array 'pix_to_face'"):
        ftx.flame_smplx_texture_combine(*textures, uv_grid_load_path=tmp_path / "other.npz")
    np.savez(tmp_path / "other.npz", uv_grid=np.zeros((4, 4, 2)), pix_to_face=np.zeros((4, 4)))
    with pytest.raises(ValueError, match=r"uv_grid \(1, H, W, 2\)"):
        ftx.flame_smplx_texture_combine(*textures, uv_grid_load_path=tmp_path / "other.npz")
    to_body(files, uv_grid_save_path=tmp_path / "grid.npz")
    with pytest.raises(ValueError, match=r"the grid is for \(60, 80\), the base is \(4096, 4096\)"):
        ftx.flame_smplx_texture_combine(*textures, uv_grid_load_path=tmp_path / "grid.npz")
    assert sorted(path.name for path in tmp_path.iterdir() if path.name.startswith(".")) == []


def test_real_meshes():
    data = real_data()
    textures = (data / "flame_face_texture.png", data / "body_medium.jpg")
    meshes = ("flame_head_template.obj", "smplx_addon.obj", "smplx_flame_vertex_ids.npy")
    sizes = {"src_size": (512, 512), "tgt_size": (512, 512)}
    results = [
        ftx.flame_smplx_texture_combine(
            *textures, *(data / name for name in meshes), convention=convention, **sizes
        ).astype(float)
        for convention in ("reference", "exact")
    ]
    base = ftx._resized(ftx._read(textures[1]), (512, 512))
    changed = (results[0] != base).any(-1)
    # The head's share of the layout.
    assert 0.2 < changed.mean() < 0.25
    assert np.abs(results[0] - results[1])[changed].mean() < 5
