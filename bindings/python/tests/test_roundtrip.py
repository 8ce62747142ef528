"""Round trips against the command."""

import json

import numpy as np
import pytest
from scenes import command, noise

import uvgraft

METRICS = ["l1", "psnr", "ssim", "ssim-uniform", "ssimulacra2"]


@pytest.mark.parametrize("fit", [False, True])
@pytest.mark.parametrize("side", ["source", "target"])
def test_figures_are_those_of_the_command(demo, side, fit):
    pair = demo / "head_to_body.uvpair"
    texture = demo / ("face.png" if side == "source" else "body_with_face.png")
    words = ["--from", side, "--via", "192x160", "--repeats", "1", "--filter", "bilinear"]
    words += ["--metrics", ",".join(METRICS), "--json", *(["--fit"] if fit else [])]
    report = json.loads(command("roundtrip", pair, texture, *words).stdout)
    whole, linked = report["outcomes"][-1]["regions"]
    options = {"via": (160, 192), "side": side, "filter": "bilinear", "fit": fit}
    found = uvgraft.roundtrip(uvgraft.Pair.load(pair), texture, metrics=METRICS, **options)
    assert found.whole == whole["scores"]
    assert found.linked == linked["scores"]
    assert np.count_nonzero(found.mask) == report["linked"] == linked["texels"]
    original = uvgraft.read_image(texture)
    assert found.via.shape == (160, 192, 3)
    assert found.back.shape == original.shape
    np.testing.assert_array_equal(found.back[found.mask == 0], original[found.mask == 0])


def test_a_square_comes_back(pair):
    texture = noise(40, 40, 1)[..., 0]
    found = uvgraft.roundtrip(pair, texture, via=40, filter="nearest", metrics=["l1", "psnr"])
    assert found.linked == {"l1": 0.0, "psnr": float("inf")}
    assert found.via.shape == (40, 40)
    for dtype, half in ((np.uint16, 32768), (np.float32, 0.5)):
        found = uvgraft.roundtrip(pair, noise(8, 8, 3, dtype), via=(9, 50), gutter=0)
        assert found.via.dtype == dtype
        assert (found.via[0, 0] == half).all()


def test_refusals(pair):
    texture = noise(8, 8, 3)
    with pytest.raises(ValueError, match="texture must have no alpha"):
        uvgraft.roundtrip(pair, noise(8, 8, 4), via=8)
    with pytest.raises(ValueError, match="side must be"):
        uvgraft.roundtrip(pair, texture, via=8, side="left")
    with pytest.raises(ValueError, match="size must be 1 to"):
        uvgraft.roundtrip(pair, texture, via=0)
    with pytest.raises(ValueError, match="filter must be"):
        uvgraft.roundtrip(pair, texture, via=8, filter="box")
    with pytest.raises(TypeError, match="dtype"):
        uvgraft.roundtrip(pair, texture.astype(np.int64), via=8)
