"""Transfers between arrays."""

import pathlib
import pickle
import warnings

import numpy as np
import pytest
from PIL import Image
from scenes import ASIDE, UPRIGHT, command, noise, square
from scipy import sparse

import uvgraft


def test_a_square_is_turned(pair):
    face = np.zeros((40, 40, 3), np.uint8)
    face[..., 0] = np.arange(40) * 6
    face[..., 1] = np.arange(40)[:, None] * 6
    graft = uvgraft.Graft(pair, filter="nearest", gutter=0)
    result = graft.apply(face, np.full((40, 40, 3), 7, np.uint8))
    # The upright square's top left corner is at the top right of the other.
    inside = slice(4, 36)
    wanted = np.rot90(face[inside, inside], -1)
    np.testing.assert_array_equal(result[inside, inside], wanted)
    assert (result[:4] == 7).all()
    assert (result[:, 36:] == 7).all()


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
@pytest.mark.parametrize("channels", [1, 2, 3, 4])
def test_formats(pair, dtype, channels):
    face = noise(32, 32, channels, dtype)
    if channels in (2, 4):
        face[..., -1] = 1 if dtype is np.float32 else np.iinfo(dtype).max
    base = noise(64, 64, channels, dtype, seed=2)
    graft = uvgraft.Graft(pair, content="data", filter="bilinear")
    result = graft.apply(face, base)
    assert (result.dtype, result.shape) == (np.dtype(dtype), base.shape)
    outside = graft.map(size=64).faces(gutter=True) < 0
    np.testing.assert_array_equal(result[outside], base[outside])
    assert (result[~outside] != base[~outside]).mean() > 0.9


def test_the_result_has_the_channels_and_the_depth_of_both(pair):
    graft = uvgraft.Graft(pair)
    grey, rgba = noise(16, 16, 1)[..., 0], noise(16, 16, 4, np.uint16)
    assert graft.apply(grey, rgba).shape == (16, 16, 4)
    assert graft.apply(grey, rgba).dtype == np.uint16
    assert graft.apply(grey, grey).shape == (16, 16)
    assert graft.apply(grey[..., None], grey).shape == (16, 16, 1)


def test_bases(pair):
    face = noise(16, 16, 3)
    graft = uvgraft.Graft(pair, size=(20, 10), gutter=0)
    clear = graft.apply(face)
    assert clear.shape == (20, 10, 4)
    assert clear[0, 0, 3] == 0
    grey = graft.apply(face, "#808080")
    assert grey.shape == (20, 10, 3)
    assert (grey[0, 9] == 128).all()
    data = uvgraft.Graft(pair, content="data", size=8).apply(face)
    assert data.shape == (8, 8, 3)
    with pytest.raises(ValueError, match=r"base must have the graft's size, \(20, 10\)"):
        graft.apply(face, noise(20, 20, 3))
    with pytest.raises(ValueError, match="must have a size"):
        uvgraft.Graft(pair).apply(face)
    with pytest.raises(uvgraft.Error, match="#12345"):
        graft.apply(face, "#12345")


@pytest.mark.parametrize("blend", [None, "membrane"])
def test_out(pair, blend):
    face, base = noise(16, 16, 3), noise(32, 32, 3, seed=2)
    graft = uvgraft.Graft(pair, blend=blend, tone="none" if blend else "base")
    wanted = graft.apply(face, base)
    out = np.empty_like(base)
    assert graft.apply(face, base, out=out) is out
    np.testing.assert_array_equal(out, wanted)
    onto_itself = base.copy()
    assert graft.apply(face, onto_itself, out=onto_itself) is onto_itself
    np.testing.assert_array_equal(onto_itself, wanted)
    with_alpha = np.empty((32, 32, 4), np.uint8)
    wanted = graft.apply(noise(16, 16, 4), base)
    np.testing.assert_array_equal(graft.apply(noise(16, 16, 4), base, out=with_alpha), wanted)


def test_out_is_checked(pair):
    face, base = noise(16, 16, 3), noise(32, 32, 3)
    graft = uvgraft.Graft(pair)
    with pytest.raises(ValueError, match=r"out must have shape \(32, 32, 3\), got \(32, 32, 4\)"):
        graft.apply(face, base, out=np.empty((32, 32, 4), np.uint8))
    with pytest.raises(TypeError, match="out must have dtype uint8"):
        graft.apply(face, base, out=np.empty((32, 32, 3), np.uint16))
    with pytest.raises(ValueError, match="C-contiguous"):
        graft.apply(face, base, out=np.empty((64, 32, 3), np.uint8)[::2])
    locked = np.empty((32, 32, 3), np.uint8)
    locked.flags.writeable = False
    with pytest.raises(ValueError, match="writeable"):
        graft.apply(face, base, out=locked)
    with pytest.raises(TypeError, match="out must be a NumPy array, got list"):
        graft.apply(face, base, out=[1])


def test_layouts_of_memory_do_not_matter(pair):
    graft = uvgraft.Graft(pair)
    face, base = noise(16, 24, 3, np.uint16), noise(32, 32, 3)
    wanted = graft.apply(face, base)
    unaligned = np.zeros(face.nbytes + 1, np.uint8)[1:].view(np.uint16).reshape(face.shape)
    unaligned[:] = face
    for same in [
        np.asfortranarray(face),
        np.repeat(face, 2, axis=1)[:, ::2],
        np.flip(np.flip(face, 0).copy(), 0),
        unaligned,
    ]:
        np.testing.assert_array_equal(graft.apply(same, base), wanted)


def test_other_sources(pair, tmp_path):
    face, base = noise(16, 16, 3), noise(32, 32, 3)
    graft = uvgraft.Graft(pair)
    wanted = graft.apply(face, base)
    np.testing.assert_array_equal(graft.apply(Image.fromarray(face), base), wanted)
    path = tmp_path / "face.png"
    Image.fromarray(face).save(path)
    np.testing.assert_array_equal(graft.apply(path, base), wanted)
    np.testing.assert_array_equal(graft.apply(str(path), base), wanted)
    with pytest.raises(ValueError, match=r"got P; convert it first"):
        graft.apply(Image.fromarray(face).convert("P"), base)


@pytest.mark.parametrize(
    ("texture", "error", "message"),
    [
        (
            np.zeros((4, 4), int),
            TypeError,
            "float64 or bool .*, got int64; values from 0 to 255 fit",
        ),
        (np.zeros((4, 4), ">u2"), TypeError, "native byte order"),
        (np.zeros((4, 4), complex), TypeError, "dtype"),
        (np.zeros((4, 4), object), TypeError, "dtype"),
        (np.zeros((4,), np.uint8), ValueError, r"got \(4,\)"),
        (np.zeros((4, 4, 5), np.uint8), ValueError, r"got \(4, 4, 5\)"),
        (np.zeros((4, 4, 0), np.uint8), ValueError, "channels"),
        (np.zeros((0, 4, 3), np.uint8), ValueError, "1 to 32768 texels"),
        (np.zeros((1, 40000), np.uint8), ValueError, "1 to 32768 texels"),
        (np.zeros((4, 8, 8), np.uint8), ValueError, r"got \(4, 8, 8\); the channels come last"),
        (np.zeros((0, 4, 4, 3), np.uint8), ValueError, "at least one item"),
        (np.zeros((2, 1, 4, 4, 3), np.uint8), ValueError, r"got \(2, 1, 4, 4, 3\)"),
        (None, TypeError, "got NoneType"),
        (3, TypeError, "got int"),
        ([[1, 2]], TypeError, r"texture\[0\] must be .*, got list"),
        (np.ma.masked_array(np.zeros((4, 4), np.uint8)), TypeError, "masked array"),
        (pathlib.Path("none.png"), FileNotFoundError, "none.png"),
    ],
)
def test_textures_are_checked(pair, texture, error, message):
    with pytest.raises(error, match=message):
        uvgraft.Graft(pair, size=8).apply(texture)


def test_options_are_checked(pair):
    for options, error, message in [
        ({"filter": "cubic"}, ValueError, '"catmull-rom" or "lanczos3", got "cubic"'),
        ({"filtr": "bilinear"}, TypeError, "unexpected keyword argument 'filtr'"),
        ({"gutter": 300}, ValueError, "0 to 256"),
        ({"gutter": -1}, OverflowError, None),
        ({"size": 0}, ValueError, "1 to 32768 texels a side, got 0"),
        ({"size": "x"}, TypeError, "size must be"),
        ({"threads": -1}, ValueError, "threads must be"),
        ({"feather": -1.0}, ValueError, "feather"),
        ({"feather": float("nan")}, ValueError, "feather"),
        ({"tone": "source"}, ValueError, "tone needs"),
        ({"region": 3}, TypeError, "uvgraft.Region"),
        ({"reverse": "yes"}, TypeError, None),
    ]:
        with pytest.raises(error, match=message):
            uvgraft.Graft(pair, **options)


def test_not_finite_values_show_the_base(pair):
    face = noise(16, 16, 3, np.float32)
    face[8, 8] = np.nan
    base = np.full((16, 16, 3), 0.25, np.float32)
    with pytest.warns(UserWarning, match="1 texel is NaN or infinite; showing the base there"):
        result = uvgraft.Graft(pair, filter="nearest").apply(face, base)
    assert np.isfinite(result).all()


def test_warnings_name_textures_and_are_not_repeated(pair, tmp_path):
    face, base = noise(16, 16, 3), noise(32, 32, 3)
    names = [str(tmp_path / name) for name in ("a.png", "b.png")]
    for name in names:
        uvgraft.write_image(name, face)
    graft = uvgraft.Graft(pair, blend="membrane")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("default")
        for _ in range(3):
            for texture in (*names, face):
                graft.apply(texture, base)
    said = "the region has no boundary: it covers the whole surface; colours left unchanged"
    assert [str(it.message) for it in caught] == [f"{it}: {said}" for it in (*names, "texture")]
    assert {it.filename for it in caught} == {__file__}
    # Whoever asks for errors gets one each time.
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for _ in range(2):
            with pytest.raises(UserWarning, match=r"a\.png: the region has no boundary"):
                graft.apply(names[0], base)


def test_images_of_pil_are_called_by_their_file(pair, tmp_path):
    path = str(tmp_path / "face.png")
    uvgraft.write_image(path, noise(16, 16, 3))
    graft = uvgraft.Graft(pair, blend="membrane")
    with Image.open(path) as opened, pytest.warns(UserWarning, match=r"face\.png: the region"):
        graft.apply(opened, noise(32, 32, 3))
    with pytest.warns(UserWarning, match="^texture: the region"):
        graft.apply(Image.fromarray(noise(16, 16, 3)), noise(32, 32, 3))


def test_encoding_options_of_other_formats(tmp_path):
    face = noise(8, 8, 3)
    for name, options in [("a.png", {"quality": 80}), ("a.webp", {"quality": 95})]:
        with pytest.raises(ValueError, match="`quality` is for JPEG files only"):
            uvgraft.write_image(tmp_path / name, face, **options)
    for name in ("a.jpg", "a.webp"):
        with pytest.raises(ValueError, match="`compress` is for PNG, TIFF and EXR files only"):
            uvgraft.write_image(tmp_path / name, face, compress=True)
    assert not list(tmp_path.iterdir())
    uvgraft.write_image(tmp_path / "a.jpg", face, quality=80)


def test_regions(pair):
    face, base = np.full((16, 16, 3), 255, np.uint8), np.zeros((64, 64, 3), np.uint8)
    whole = uvgraft.Graft(pair, gutter=0).apply(face, base)[..., 0] > 0
    half = uvgraft.Region.vertices([0, 1, 2])

    def of(region):
        return uvgraft.Graft(pair, gutter=0, region=region).apply(face, base)[..., 0] > 0

    shown = of(half)
    assert 0.4 < shown.sum() / whole.sum() < 0.6
    other = of(uvgraft.Region() - half)
    assert ((shown | other) == whole).mean() > 0.99
    assert (of(half | uvgraft.Region.vertices([0, 2, 3])) == whole).all()
    assert of(half.grown(0.2)).sum() > shown.sum() > of(half.grown(-0.1)).sum()
    assert (of(half.grown(rings=1)) == whole).all()
    mask = np.zeros((32, 32), bool)
    mask[:16] = True
    painted = of(uvgraft.Region.mask(mask, side="source"))
    assert 0.4 < painted.sum() / whole.sum() < 0.6
    with pytest.raises(ValueError, match="vertex 9 does not exist"):
        of(uvgraft.Region.vertices([9]))
    with pytest.raises(uvgraft.Error, match="region is empty"):
        of(half - half)
    with pytest.raises(TypeError, match="either a length or rings"):
        half.grown()
    # The half is a triangle with a corner 0.707 from the boundary.
    for region in (half.grown(-10), half.grown(-0.8), half.grown(rings=-1), half.grown(rings=-9)):
        with pytest.raises(ValueError, match=r"Region.grown\(\) leaves nothing .* is 0.7071 from"):
            of(region)
    for length in (10.0, 0.8):
        with pytest.raises(ValueError, match=r"Region.grown\(\) must be at most 0.7071"):
            of(half.grown(length))
    for length in (float("nan"), float("inf"), float("-inf")):
        with pytest.raises(ValueError, match="length must be finite"):
            of(half.grown(length))
    with pytest.warns(UserWarning, match=r"Region.grown\(\) leaves only 0\..* % of the region"):
        of(half.grown(-0.67))
    for feather in (10.0, 0.8, 1e9):
        with pytest.raises(ValueError, match=r"feather must be at most 0\.7071"):
            uvgraft.Graft(pair, region=half, blend="feather", feather=feather)
    with pytest.warns(UserWarning, match="feather has no effect: the region has no boundary"):
        uvgraft.Graft(pair, blend="feather")
    with pytest.raises(ValueError, match='side must be "source" or "target"'):
        of(uvgraft.Region.vertices([0], side="left"))


def test_a_fit_reads_back_better(pair):
    face = noise(48, 48, 3)
    graft = uvgraft.Graft(pair, filter="bilinear", size=48)
    steps = []
    fitted = graft.fit(face, "#808080", steps=4, progress=lambda *step: steps.append(step))
    assert fitted.fitted_rms < fitted.sampled_rms
    assert [step for step, _, _ in steps] == list(range(fitted.steps + 1))
    assert fitted.texture.shape == (48, 48, 3)
    with pytest.raises(ZeroDivisionError):
        graft.fit(face, "#808080", progress=lambda *_: 1 / 0)
    with pytest.raises(uvgraft.Error, match="nearest"):
        uvgraft.Graft(pair, filter="nearest", size=8).fit(face)


def test_pickles(pair):
    face, base = noise(16, 16, 3), noise(32, 32, 3)
    region = uvgraft.Region.vertices([0, 1, 2]).grown(0.1)
    graft = uvgraft.Graft(pair, region=region, blend="feather", feather=0.05, threads=1)
    again = pickle.loads(pickle.dumps(graft))
    np.testing.assert_array_equal(again.apply(face, base), graft.apply(face, base))
    assert again.pair == pair
    mesh = pickle.loads(pickle.dumps(pair.source))
    np.testing.assert_array_equal(mesh.uv, pair.source.uv)
    assert mesh.name == "upright"


def textures(count):
    return [noise(16, 24, 3, seed=seed) for seed in range(count)]


def test_several_textures_are_as_good_as_single_ones(pair, tmp_path):
    graft, faces, base = uvgraft.Graft(pair), textures(3), noise(32, 32, 3, seed=9)
    bases = [noise(32, 32, 3, seed=seed) for seed in (7, 8, 9)]
    path = tmp_path / "base.png"
    uvgraft.write_image(path, base)
    for given, of_each in [(base, [base] * 3), (path, [base] * 3), (bases, bases),
                           (np.stack(bases), bases), (tuple(bases), bases)]:  # fmt: skip
        wanted = [graft.apply(*each) for each in zip(faces, of_each, strict=True)]
        found = graft.apply(faces, given)
        assert isinstance(found, list)
        np.testing.assert_array_equal(np.stack(found), np.stack(wanted))
        stacked = graft.apply(np.stack(faces), given)
        assert isinstance(stacked, np.ndarray)
        np.testing.assert_array_equal(stacked, np.stack(wanted))
        out = np.empty_like(stacked)
        assert graft.apply(faces, given, out=out) is out
        np.testing.assert_array_equal(out, wanted)
        outs = [np.empty_like(base) for _ in faces]
        assert graft.apply(np.stack(faces), given, out=outs) is outs
        np.testing.assert_array_equal(np.stack(outs), wanted)
    # Lists may be of anything that a texture can be.
    image = tmp_path / "face.png"
    uvgraft.write_image(image, faces[0])
    mixed = graft.apply([image, Image.fromarray(faces[1]), noise(8, 8, 4)], base)
    np.testing.assert_array_equal(mixed[0], graft.apply(faces[0], base))
    assert [it.shape for it in mixed] == [(32, 32, 3), (32, 32, 3), (32, 32, 4)]
    assert uvgraft.Graft(pair, size=8).apply(np.stack(faces)).shape == (3, 8, 8, 4)
    assert graft.apply([]) == []


def test_several_textures_are_checked(pair):
    graft, faces, base = uvgraft.Graft(pair), textures(2), noise(32, 32, 3)
    for arguments, error, message in [
        ((faces, [base]), ValueError, "base must be one, or one for each of 2 textures, got 1"),
        ((faces[0], [base]), TypeError, "base must be a single one for a single texture"),
        ((faces[0], base[None]), TypeError, "base must be a single one for a single texture"),
        ((np.stack(faces), [base, noise(8, 8, 3)]), ValueError, r"\(8, 8, 3\) for base\[1\]"),
        ((np.stack(faces), [base, noise(32, 32, 3, np.uint16)]), ValueError, "got uint16"),
        (([faces[0], 3], base), TypeError, r"texture\[1\] must be .*, got int"),
        ((faces, [base, 3]), TypeError, r"base\[1\] must be .*, got int"),
    ]:  # fmt: skip
        with pytest.raises(error, match=message):
            graft.apply(*arguments)
    with pytest.raises(ValueError, match="out must be a list of arrays"):
        graft.apply(faces, base, out=np.empty_like(base))
    for call in (graft.fit, graft.tone):
        with pytest.raises(TypeError, match=r"texture must be .*, got list"):
            call(faces, base)


def test_warnings_name_items(pair):
    graft = uvgraft.Graft(pair)
    faces = [noise(8, 8, 3, np.float32), np.full((8, 8, 3), np.nan, np.float32)]
    with pytest.warns(UserWarning, match=r"^texture\[1\]: ") as caught:
        graft.apply(faces, noise(8, 8, 3, np.float32))
    assert not [it for it in caught if "texture[0]" in str(it.message)]


def test_a_graft_is_a_function(pair):
    face, base = noise(16, 16, 3), noise(32, 32, 3)
    graft, out = uvgraft.Graft(pair), np.empty((32, 32, 3), np.uint8)
    wanted = graft.apply(face, base)
    np.testing.assert_array_equal(graft(face, base), wanted)
    assert graft(texture=face, base=base, out=out, threads=1) is out
    np.testing.assert_array_equal(out, wanted)


@pytest.mark.parametrize("dtype", [np.float64, np.float16])
def test_other_floats_are_converted_to_float32(pair, dtype):
    graft = uvgraft.Graft(pair)
    face, base = noise(16, 16, 3, np.float32).astype(dtype), noise(32, 32, 3, np.float32)
    wanted = graft.apply(face.astype(np.float32), base)
    for given in [(face, base), (face, base.astype(np.float64))]:
        found = graft.apply(*given)
        assert found.dtype == np.float32
        np.testing.assert_array_equal(found, wanted)
    # Beyond the range of float32 there is nothing to show.
    if dtype is np.float64:
        face[8, 8] = 1e300
        with pytest.warns(UserWarning, match="1 texel is NaN or infinite"):
            graft.apply(face, base)


def test_booleans_are_white_where_true(pair):
    mask = noise(16, 16, 1)[..., 0] > 128
    white = np.where(mask, 255, 0).astype(np.uint8)
    graft = uvgraft.Graft(pair, content="data", filter="nearest", size=32)
    found = graft.apply(mask)
    assert (found.dtype, found.shape) == (np.uint8, (32, 32))
    assert set(np.unique(found)) == {0, 255}
    np.testing.assert_array_equal(found, graft.apply(white))
    np.testing.assert_array_equal(graft.apply(mask[None, ..., None]), found[None, ..., None])


def test_floats_from_0_to_255_are_warned_of(pair, recwarn):
    face, base = noise(16, 16, 3), noise(32, 32, 3, np.float32)
    graft = uvgraft.Graft(pair)
    with pytest.warns(UserWarning, match="^texture: most values are above 2, where 1.0 is white"):
        graft.apply(face.astype(np.float64), base)
    with pytest.warns(UserWarning, match="divided by 255"):
        graft.apply(face.astype(np.float32), base, out=base.copy())
    with pytest.warns(UserWarning, match="^base: most values"):
        graft.apply(face, noise(32, 32, 3).astype(np.float32))
    recwarn.clear()
    # Lights, and what is no colour, may have any values.
    lit = np.where(face < 64, 100.0, 0.5).astype(np.float32)
    graft.apply(lit, base)
    uvgraft.Graft(pair, content="data").apply(face.astype(np.float32), base)
    assert not [it for it in recwarn if "most values" in str(it.message)]


def test_operators(pair):
    graft = uvgraft.Graft(pair, size=24, filter="catmull-rom")
    operator = graft.operator(source_size=16)
    assert (operator.source_shape, operator.target_shape) == ((16, 16), (24, 24))
    random = np.random.default_rng(3)
    x, y = random.random((16, 16), np.float32), random.random((24, 24), np.float32)
    forward, adjoint = operator.forward(x), operator.adjoint(y)
    assert np.vdot(forward, y) == pytest.approx(np.vdot(x, adjoint), rel=1e-5)
    (data, indices, indptr), shape = operator.csr()
    dense = np.zeros(shape, np.float32)
    rows = np.repeat(np.arange(shape[0]), np.diff(indptr))
    np.add.at(dense, (rows, indices), data)
    np.testing.assert_allclose(dense @ x.ravel(), forward.ravel(), atol=1e-5)
    np.testing.assert_allclose(dense.T @ y.ravel(), adjoint.ravel(), atol=1e-5)
    planes = random.random((7, 16, 16), np.float32)
    done = operator._forward_planes(planes)
    for plane, result in zip(planes, done, strict=True):
        np.testing.assert_array_equal(operator.forward(plane), result)
    with pytest.raises(ValueError, match=r"must have shape \(16, 16\)"):
        operator.forward(y)
    with pytest.raises(TypeError, match="float32"):
        operator.forward(np.zeros((16, 16), complex))


def test_maps_hold_positions(pair):
    face, base = noise(32, 32, 3), noise(32, 32, 3)
    graft = uvgraft.Graft(pair, filter="nearest", gutter=0)
    sampling = graft.map(size=32, source_size=32)
    uv = sampling.uv()
    inside = ~np.isnan(uv[..., 0])
    np.testing.assert_array_equal(inside, sampling.mask() == 255)
    np.testing.assert_array_equal(inside, sampling.faces() >= 0)
    at = np.floor(uv[inside] * 32).astype(int)
    result = graft.apply(face, base)
    np.testing.assert_array_equal(result[inside], face[at[:, 1], at[:, 0]])
    x, y = sampling.remap(32)
    np.testing.assert_allclose(x[inside], uv[inside][:, 0] * 32 - 0.5, atol=1e-5)
    np.testing.assert_allclose(y[inside], uv[inside][:, 1] * 32 - 0.5, atol=1e-5)
    assert sampling.stats["linked"] == inside.sum()


def test_pairs(pair, tmp_path):
    path = tmp_path / "a.uvpair"
    pair.save(path)
    assert uvgraft.Pair.load(path) == pair
    assert hash(uvgraft.Pair.load(path)) == hash(pair)
    assert pair.method == "vertex-map"
    assert uvgraft.Pair(square(UPRIGHT), square(ASIDE)).method == "faces"
    assert "licences hold" in pair.note
    with pytest.raises(FileNotFoundError):
        uvgraft.Pair.load(tmp_path / "none.uvpair")
    path.write_bytes(path.read_bytes()[:-9])
    with pytest.raises(uvgraft.Error, match=r"a\.uvpair"):
        uvgraft.Pair.load(path)
    with pytest.raises(OSError):
        pair.save(tmp_path / "none" / "a.uvpair")
    with pytest.raises(
        TypeError, match="source must be a Mesh, a path or a mesh of trimesh, got int"
    ):
        uvgraft.Pair(3, square(ASIDE))
    with pytest.raises(uvgraft.Error, match="vertex"):
        uvgraft.Pair(square(UPRIGHT), square(ASIDE), vertex_map=[0, 1])
    with pytest.raises(ValueError, match="reach must be from 0 to 1"):
        uvgraft.Pair(square(UPRIGHT), square(ASIDE), reach=2)
    with pytest.raises(ValueError, match='flip_v must be "source" or "target", got "up"'):
        uvgraft.Pair(square(UPRIGHT), square(ASIDE), flip_v="up")
    with pytest.raises(TypeError, match='flip_u must be "source", "target" or a sequence'):
        uvgraft.Pair(square(UPRIGHT), square(ASIDE), flip_u=3)


@pytest.mark.filterwarnings("ignore:100 % of the linked area is mirrored")
def test_one_mesh_or_both_may_be_flipped():
    def flipped(sides):
        return uvgraft.Pair(square(UPRIGHT), square(ASIDE), flip_v=sides)

    assert flipped("source") == flipped(["source"])
    assert flipped("source") != flipped(("source", "target"))


def test_a_pair_file_is_as_good_as_its_pair(pair, tmp_path):
    path, face, base = tmp_path / "a.uvpair", noise(16, 16, 3), noise(32, 32, 3)
    pair.save(path)
    assert uvgraft.Pair(path) == uvgraft.Pair(str(path)) == pair
    wanted = uvgraft.Graft(pair)(face, base)
    np.testing.assert_array_equal(uvgraft.Graft(path)(face, base), wanted)
    assert uvgraft.Graft(path).pair == pair
    assert uvgraft.SamplingMap(path, size=8).stats == uvgraft.SamplingMap(pair, size=8).stats
    assert uvgraft.seams(path, base).rim == uvgraft.seams(pair, base).rim
    for arguments, options, message in [
        ((pair.source,), {}, "target is missing"),
        ((tmp_path / "a.obj",), {}, "target is missing, and .*a.obj is not a pair file"),
        ((path,), {"by": "surface"}, "by is for two meshes, which .*a.uvpair has linked"),
        ((path,), {"vertex_map": [0]}, "vertex_map is for two meshes"),
    ]:
        (tmp_path / "a.obj").write_text("v 0 0 0")
        with pytest.raises(TypeError, match=message):
            uvgraft.Pair(*arguments, **options)
    with pytest.raises(FileNotFoundError):
        uvgraft.Graft(tmp_path / "none.uvpair")
    with pytest.raises(TypeError, match="pair must be a Pair or a path, got Mesh"):
        uvgraft.Graft(pair.source)


def test_tables_are_those_of_the_command(demo, tmp_path):
    meshes = [demo / name for name in ("head.obj", "body.obj")]
    ids = np.load(demo / "head_to_body.npy")
    # Each vertex of the head is that of the body with all the weight.
    table = tmp_path / "table.npz"
    linked = np.flatnonzero(ids >= 0)
    sparse.save_npz(table, sparse.csr_array(
        (np.ones(len(linked), np.float32), (linked, ids[linked])),
        shape=(len(ids), len(uvgraft.Mesh(meshes[1]).positions))))  # fmt: skip
    command("pair", *meshes, "--table", table, "-o", tmp_path / "a.uvpair", "--outside=clamp")
    made = uvgraft.Pair(*meshes, table=table, outside="clamp")
    assert made.method == "table"
    assert made.to_bytes() == uvgraft.Pair(*meshes, table=table, by="table").to_bytes()
    theirs = uvgraft.Pair.load(tmp_path / "a.uvpair")
    assert made.piece_count == theirs.piece_count
    size = {"size": 64}
    np.testing.assert_array_equal(
        uvgraft.Graft(made).map(**size).uv(), uvgraft.Graft(theirs).map(**size).uv()
    )
    for options, error, message in [
        ({"table": tmp_path / "none"}, FileNotFoundError, "none"),
        ({"table": demo / "face.png"}, uvgraft.Error, r"face\.png: "),
        ({"table": table, "vertex_map": ids}, TypeError, "either vertex_map or table"),
        ({"table": table, "by": "faces"}, ValueError, 'table is used only with by="table" or'),
        ({"by": "table"}, ValueError, 'by="table" needs table'),
        ({"by": "vertex-map"}, ValueError, 'by="vertex-map" needs vertex_map'),
    ]:
        with pytest.raises(error, match=message):
            uvgraft.Pair(*meshes, **options)
    with pytest.raises(uvgraft.Error, match=r"table\.npz: "):
        uvgraft.Pair(square(UPRIGHT), square(ASIDE), table=table)


def test_images(tmp_path):
    for dtype, name in [(np.uint8, "a.png"), (np.uint16, "a.png"), (np.float32, "a.exr")]:
        image = noise(5, 7, 3, dtype)
        encoding = "linear" if dtype is np.float32 else "srgb"
        uvgraft.write_image(tmp_path / name, image, encoding=encoding)
        read = uvgraft.read_image(tmp_path / name)
        np.testing.assert_array_equal(read, image)
    with pytest.raises(uvgraft.Error, match="alpha"):
        uvgraft.write_image(tmp_path / "a.jpg", noise(4, 4, 4))
    with pytest.raises(uvgraft.Error):
        uvgraft.write_image(tmp_path / "a.xyz", noise(4, 4, 3))
    (tmp_path / "b.png").write_bytes(b"\x89PNG")
    with pytest.raises(uvgraft.Error, match=r"b\.png"):
        uvgraft.read_image(tmp_path / "b.png")
    with pytest.raises(uvgraft.Error, match="must be a file"):
        uvgraft.read_image(tmp_path)
