"""Transfers in JAX."""

import numpy as np
import pytest
from sheets import sheets

import uvgraft

jax = pytest.importorskip("jax")
import jax.numpy as jnp  # noqa: E402 (needs JAX)
from jax.test_util import check_grads  # noqa: E402

import uvgraft.jax  # noqa: E402

pytestmark = pytest.mark.torch

SOURCE, TARGET = (7, 6), (9, 11)


@pytest.fixture(scope="module")
def graft():
    return uvgraft.Graft(sheets(), filter="lanczos3")


@pytest.fixture(scope="module")
def transfer(graft):
    return uvgraft.jax.transfer(graft, source_size=SOURCE, size=TARGET)


def textures(*leading, size=SOURCE):
    values = np.random.default_rng(3).random((*leading, *size))
    return jnp.asarray(values, jnp.float32)


def test_a_transfer_is_the_operator(graft, transfer):
    texture = textures(2, 3)
    operator = graft.operator(source_size=SOURCE, size=TARGET)
    wanted = operator.forward(np.moveaxis(np.asarray(texture[1]), 0, -1))
    np.testing.assert_array_equal(np.moveaxis(transfer(texture)[1], 0, -1), wanted)
    np.testing.assert_array_equal(jax.jit(transfer)(texture), transfer(texture))
    assert (wanted != 0).any()


def test_gradients(transfer):
    # H is linear, so differences of any length are exact but for rounding.
    check_grads(transfer, (textures(2),), order=2, modes=["rev"], atol=1e-3, rtol=1e-3, eps=0.5)
    with jax.enable_x64(True):
        check_grads(transfer, (textures(2).astype(jnp.float64),), order=2, modes=["rev"])


def test_gradients_in_jit_and_vmap(transfer):
    def energy(texture):
        return (transfer(texture) ** 2).sum() / 2

    texture = textures(4, 3)
    wanted = jax.grad(energy)(texture)
    np.testing.assert_allclose(jax.jit(jax.grad(energy))(texture), wanted, rtol=1e-6)
    np.testing.assert_allclose(jax.jit(jax.vmap(jax.grad(energy)))(texture), wanted, rtol=1e-6)
    moved = jax.vmap(transfer, in_axes=1, out_axes=1)(texture)
    np.testing.assert_array_equal(moved, transfer(texture))


def test_dtypes(transfer):
    texture = textures(3)
    for dtype in (jnp.float16, jnp.bfloat16):
        short = texture.astype(dtype)
        result = transfer(short)
        assert result.dtype == dtype
        assert (result == transfer(short.astype(jnp.float32)).astype(dtype)).all()
    with jax.enable_x64(True):
        double = transfer(texture.astype(jnp.float64))
        assert double.dtype == jnp.float64
        np.testing.assert_allclose(double, transfer(texture), atol=2e-6)


def test_the_matrix(graft, transfer):
    matrix = uvgraft.jax.as_bcoo(graft, source_size=SOURCE, size=TARGET)
    assert matrix.shape == (99, 42)
    texture = textures(3)
    texels = texture.reshape(3, 42).T
    result = (matrix @ texels).T.reshape(3, *TARGET)
    np.testing.assert_allclose(result, transfer(texture), atol=2e-6)

    def energy(texels):
        return ((matrix @ texels) ** 2).sum() / 2

    def same(texture):
        return (transfer(texture) ** 2).sum() / 2

    wanted = jax.grad(same)(texture).reshape(3, 42).T
    np.testing.assert_allclose(jax.jit(jax.grad(energy))(texels), wanted, rtol=1e-4, atol=1e-5)
    # What the function has no rule for.
    along = jax.jvp(lambda texels: matrix @ texels, (texels,), (texels,))[1]
    np.testing.assert_allclose(along, matrix @ texels, rtol=1e-6)


def test_wrong_textures(transfer):
    with pytest.raises(ValueError, match=r"\(\.\.\., 7, 6\), got \(3, 6, 7\)"):
        transfer(jnp.zeros((3, 6, 7)))
    with pytest.raises(TypeError, match="floats, got int32"):
        transfer(jnp.zeros(SOURCE, jnp.int32))


def test_grids_on_devices(graft):
    plain = graft.grid(16)
    for device in (jax.devices()[0], jax.sharding.SingleDeviceSharding(jax.devices()[0])):
        grid = graft.grid(16, device=device)
        assert isinstance(grid, jax.Array)
        np.testing.assert_array_equal(grid, plain)
