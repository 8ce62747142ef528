"""Transfers and grids in PyTorch."""

import copy
import io
import pickle
import runpy
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest
from scenes import noise, real_data
from sheets import HIGH, LOW, sheets

import uvgraft

torch = pytest.importorskip("torch")
import uvgraft.torch  # noqa: E402 (needs PyTorch)

pytestmark = pytest.mark.torch

SOURCE, TARGET = (7, 6), (9, 11)


@pytest.fixture(scope="module")
def graft():
    return uvgraft.Graft(sheets(), filter="lanczos3")


@pytest.fixture(scope="module")
def small(graft):
    return uvgraft.torch.Transfer(graft, source_size=SOURCE, size=TARGET)


def textures(*leading, dtype=torch.float32, size=SOURCE, seed=0):
    values = torch.rand(*leading, *size, generator=torch.Generator().manual_seed(seed))
    return values.to(dtype)


def test_a_transfer_is_what_apply_gives(graft):
    face, base = noise(40, 30, 3), noise(64, 48, 3, seed=2)
    transfer = uvgraft.torch.Transfer(graft, source_size=(40, 30), size=(64, 48))
    planes = [torch.from_numpy(image).movedim(-1, 0).float() for image in (face, base)]
    result = transfer(*planes).clamp(0, 255).round().movedim(0, -1).numpy()
    wanted = graft.apply(face, base)
    assert np.abs(result - wanted).max() <= 1
    outside = graft.map(size=(64, 48)).faces(gutter=True) < 0
    np.testing.assert_array_equal(result[outside], base[outside])
    np.testing.assert_array_equal(transfer(planes[0]).movedim(0, -1)[outside], 0)


def test_a_base_shows_through_a_feather():
    pair = sheets()
    half = uvgraft.Region.vertices(range(28))
    graft = uvgraft.Graft(pair, region=half, blend="feather", feather=0.2, filter="bilinear")
    transfer = uvgraft.torch.Transfer(graft, source_size=40, size=64)
    face, base = noise(40, 40, 3), noise(64, 64, 3, seed=2)
    planes = [torch.from_numpy(image).movedim(-1, 0).float() for image in (face, base)]
    result = transfer(*planes).round().movedim(0, -1).numpy()
    mask = graft.mask(size=64)
    assert ((mask > 20) & (mask < 235)).sum() > 50
    inside = graft.map(size=64).mask() > 0
    # The feather is rounded to 8 bits in the mask.
    assert np.abs(result - graft.apply(face, base))[inside].max() <= 2
    np.testing.assert_array_equal(result[mask == 0], base[mask == 0])


@pytest.mark.parametrize("filter", ["nearest", "bilinear", "lanczos3"])
def test_gradients(filter):
    graft = uvgraft.Graft(sheets(), filter=filter)
    # Small, since every derivative is compared with a difference.
    sizes = (4, 5), (5, 6)
    transfer = uvgraft.torch.Transfer(graft, source_size=sizes[0], size=sizes[1])
    texture = textures(2, dtype=torch.float64, size=sizes[0]).requires_grad_()
    base = textures(1, dtype=torch.float64, size=sizes[1]).requires_grad_()
    with warnings.catch_warnings():
        # PyTorch's own: its forward mode is written in TorchScript.
        warnings.simplefilter("ignore", FutureWarning)
        assert torch.autograd.gradcheck(transfer, (texture,), check_forward_ad=True)
        assert torch.autograd.gradcheck(transfer, (texture, base))
        assert torch.autograd.gradgradcheck(transfer, (texture,), check_fwd_over_rev=True)


def test_backward_is_the_transpose(small):
    texture = textures(2, 3).requires_grad_()
    weights = textures(2, 3, size=TARGET, seed=1)
    result = small(texture)
    (grad,) = torch.autograd.grad(result, texture, weights)
    forth, back = (result * weights).sum(), (texture * grad).sum()
    assert forth > 1
    torch.testing.assert_close(forth, back)


def test_the_sparse_matrix_is_the_same_operator(small):
    texture = textures(2, 3)
    np.testing.assert_allclose(small(texture), small(texture.double()), atol=2e-6)
    single, double = texture.clone().requires_grad_(), texture.double().requires_grad_()
    small(single).square().sum().backward()
    small(double).square().sum().backward()
    np.testing.assert_allclose(single.grad, double.grad, atol=1e-5)


def test_matrices_are_kept_and_of_the_precision_that_is_asked_for(small):
    product = small._product
    rows = product._sparse(textures(5).bfloat16(), False)
    assert rows.dtype == torch.float32
    matrix = product._matrix(torch.device("cpu"), torch.float32, False)
    assert matrix is product._matrix(torch.device("cpu"), torch.float32, False)
    torch.testing.assert_close(rows.reshape(5, *TARGET), small(textures(5).bfloat16().float()))


@pytest.mark.parametrize("dtype", [torch.float16, torch.bfloat16])
def test_short_floats_are_rounded_once(small, dtype):
    texture = textures(3, dtype=dtype).requires_grad_()
    result = small(texture)
    assert result.dtype == dtype
    assert torch.equal(result, small(texture.detach().float()).to(dtype))
    (grad,) = torch.autograd.grad(result, texture, torch.ones_like(result))
    assert grad.dtype == dtype
    assert (grad != 0).any()


def test_autocast_changes_nothing(small):
    texture = textures(3, dtype=torch.float64).requires_grad_()
    with torch.autocast("cpu", dtype=torch.bfloat16):
        # A product of matrices is what autocast lowers.
        lowered = torch.ones(2, 2) @ torch.ones(2, 2)
        result = small(texture)
        short = small(texture.detach().float())
    assert (lowered.dtype, result.dtype, short.dtype) == (
        torch.bfloat16,
        torch.float64,
        torch.float32,
    )
    assert torch.equal(result, small(texture))
    assert torch.equal(short, small(texture.detach().float()))


def test_any_leading_axes(small):
    texture = textures(2, 3, 4)
    result = small(texture)
    assert result.shape == (2, 3, 4, *TARGET)
    assert torch.equal(small(texture[1, 2, 3]), result[1, 2, 3])
    assert torch.equal(small(texture[0]), result[0])
    assert small(texture[:0]).shape == (0, 3, 4, *TARGET)
    strided = texture.transpose(0, 2)
    assert not strided.is_contiguous()
    assert torch.equal(small(strided), result.transpose(0, 2))


def test_functional_transforms(small):
    texture = textures(2, 3)
    result = small(texture)
    assert torch.equal(torch.vmap(small, in_dims=1, out_dims=1)(texture), result)
    assert torch.equal(torch.func.jvp(small, (texture,), (2 * texture,))[1], small(2 * texture))
    _, pull = torch.func.vjp(small, texture)
    (twice,) = pull(result)

    def energy(texture):
        return small(texture).square().sum() / 2

    torch.testing.assert_close(torch.func.grad(energy)(texture), twice)
    torch.testing.assert_close(torch.vmap(torch.func.grad(energy))(texture), twice)
    # HᵀH, whose product with the texture is the gradient.
    hessian = torch.func.hessian(energy)(texture[0, 0])
    torch.testing.assert_close(torch.einsum("ijkl,kl->ij", hessian, texture[0, 0]), twice[0, 0])


def test_compiled(graft, small):
    # Two modules of one class must not be taken for each other.
    for transfer in (small, uvgraft.torch.Transfer(graft, source_size=SOURCE, size=8)):
        compiled = torch.compile(transfer, backend="aot_eager", fullgraph=True)
        base = textures(3, size=transfer.target_shape, seed=2)
        results = []
        for call in (transfer, compiled):
            texture = textures(2, 3).requires_grad_()
            result = call(texture, base)
            result.square().sum().backward()
            results.append((result, texture.grad))
        assert torch.equal(results[0][0], results[1][0])
        assert torch.equal(results[0][1], results[1][1])


def test_copies_and_pickles(small):
    file = io.BytesIO()
    torch.save(small, file)
    file.seek(0)
    copies = [
        copy.deepcopy(small),
        pickle.loads(pickle.dumps(small)),
        torch.load(file, weights_only=False),
    ]
    texture, base = textures(3), textures(3, size=TARGET)
    for other in copies:
        assert torch.equal(other(texture, base), small(texture, base))
    assert copies[0]._product is small._product
    assert copies[1]._product is not small._product


def test_the_module_has_no_state(small):
    assert not small.state_dict()
    assert not list(small.parameters())
    model = torch.nn.Sequential(copy.deepcopy(small))
    model.load_state_dict({})
    assert model.half()(textures(3)).dtype == torch.float32
    assert model.to("meta")(textures(3).to("meta")).shape == (3, *TARGET)
    assert "(7, 6) to (9, 11)" in repr(model)


def test_wrong_textures(small):
    with pytest.raises(ValueError, match=r"\(\.\.\., 7, 6\), got \(3, 6, 7\)"):
        small(textures(3).transpose(1, 2))
    with pytest.raises(ValueError, match=r"base must have shape \(\.\.\., 9, 11\)"):
        small(textures(3), textures(3))
    with pytest.raises(TypeError, match=r"floats, got torch\.uint8"):
        small(textures(3).to(torch.uint8))
    with pytest.raises(TypeError, match="tensor, got ndarray"):
        small(textures(3).numpy())


def sampled(image, grid, padding_mode):
    planes = torch.from_numpy(image).movedim(-1, 0)[None].float()
    result = torch.nn.functional.grid_sample(
        planes, grid, padding_mode=padding_mode, align_corners=False
    )
    return result[0].movedim(0, -1).numpy()


def test_grids_by_hand():
    pair = sheets()
    # Every texel of the layout that is read comes from itself, texel centre for texel centre.
    graft = uvgraft.Graft(uvgraft.Pair(pair.source, pair.source, by="faces"), gutter=0)
    grid = uvgraft.torch.grid(graft, (10, 20))
    assert grid.shape == (1, 10, 20, 2)
    assert grid.dtype == torch.float32
    centres = (np.arange(20) + 0.5) / 20
    inside = (centres > LOW) & (centres < HIGH)
    row = grid[0, 5].numpy()
    np.testing.assert_allclose(row[inside, 0], 2 * centres[inside] - 1, atol=1e-6)
    np.testing.assert_allclose(row[inside, 1], 2 * 0.55 - 1, atol=1e-6)
    assert (row[~inside] == -3).all()
    assert (~inside).any()


def test_ramps_are_exact():
    # Where a picture is linear, so is every bilinear sample of it.
    graft = uvgraft.Graft(sheets(), size=96, filter="bilinear")
    height, width = 24, 40
    ramp = np.zeros((height, width, 2), np.float32)
    ramp[..., 0] = (np.arange(width) + 0.5) / width
    ramp[..., 1] = ((np.arange(height) + 0.5) / height)[:, None]
    map = graft.map()
    covered = map.faces() >= 0
    found = sampled(ramp, uvgraft.torch.grid(graft), "border")[covered]
    assert len(found) > 1000
    np.testing.assert_allclose(found, map.uv()[covered], atol=1e-5)


def test_zeros_where_nothing_is_transferred(graft):
    ones = np.ones((5, 4, 1), np.float32)
    for gutter in (True, False):
        grid = uvgraft.torch.grid(graft, 64, gutter=gutter)
        nowhere = graft.map(size=64).faces(gutter=gutter) < 0
        assert (sampled(ones, grid, "zeros")[nowhere] == 0).all()
        assert (grid[0].numpy()[nowhere] == -3).all()
        assert (grid[0].numpy()[~nowhere] > -2).all()


def test_grids_of_maps_and_of_grafts(graft):
    grid = uvgraft.torch.grid(graft, (30, 20), dtype=torch.float64)
    assert grid.dtype == torch.float64
    map = graft.map(size=(30, 20))
    assert torch.equal(uvgraft.torch.grid(map).double(), grid)
    assert torch.equal(uvgraft.torch.grid(map, (30, 20)).double(), grid)
    with pytest.raises(ValueError, match=r"size must be the map's, \(30, 20\), got \(30, 30\)"):
        uvgraft.torch.grid(map, 30)
    plain = graft.grid((30, 20))
    assert (type(plain), plain.dtype, plain.shape) == (np.ndarray, np.float32, (30, 20, 2))
    for device in ("cpu", torch.device("cpu")):
        given = graft.grid((30, 20), device=device)
        assert isinstance(given, torch.Tensor)
        np.testing.assert_array_equal(given.numpy(), plain)
    np.testing.assert_array_equal(grid[0].float().numpy(), plain)


def test_grid_sample_on_real_meshes():
    data = real_data()
    ids = data / "smplx_flame_vertex_ids.npy"
    meshes = (data / "flame_head_template.obj", data / "smplx_addon.obj")
    pair = uvgraft.Pair(*meshes, vertex_map=ids)
    graft = uvgraft.Graft(pair, size=1024, filter="bilinear")
    face = uvgraft.read_image(data / "flame_face_texture.png")[1::2, ::2, :3].copy()
    grid = uvgraft.torch.grid(graft)
    found = sampled(face, grid, "border")
    wanted = graft.apply(face, np.zeros((1024, 1024, 3), np.uint8)).astype(float)
    # `grid_sample` knows no islands and takes single samples, so only where all four texels are on
    # an island, and where texels of the result are closer to each other than those of the source.
    island = uvgraft.SamplingMap(pair, size=256, reverse=True, gutter=0).mask()
    interior = sampled(island[..., None], grid, "zeros")[1:-1, 1:-1, 0] > 254.999
    uv, faces = graft.map().uv() * 256, graft.map().faces()
    centre, right, below = np.s_[1:-1, 1:-1], np.s_[1:-1, 2:], np.s_[2:, 1:-1]
    is_one_face = (faces[centre] == faces[right]) & (faces[centre] == faces[below])
    steps = np.hypot(*(np.linalg.norm(uv[there] - uv[centre], axis=-1) for there in (right, below)))
    comparable = interior & is_one_face & (faces[centre] >= 0) & (steps < 1)
    assert comparable.sum() > 100_000
    difference = np.abs(found - wanted)[centre][comparable]
    # Half a level is the rounding of the result.
    assert difference.max() < 0.6


def test_the_example(capsys, monkeypatch):
    example = Path(__file__).parents[3] / "examples" / "fit_by_gradient_descent.py"
    monkeypatch.setattr(sys, "argv", [str(example), "--steps", "80"])
    runpy.run_path(str(example), run_name="__main__")
    lines = capsys.readouterr().out.splitlines()
    psnr = {line.rsplit(None, 2)[0].strip(): float(line.split()[-2]) for line in lines[-3:]}
    sampled, descent, fitted = psnr.values()
    # Least squares is the limit of any other way to the same aim.
    assert sampled + 5 < descent < fitted
