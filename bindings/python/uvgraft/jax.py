"""Transfers in JAX: differentiable, within ``jit`` and ``vmap``.

A plain transfer is linear: with the texels of a texture in a vector, it is a product with a matrix
``H``, whose gradient is the product with ``Hᵀ``::

    import jax, uvgraft, uvgraft.jax

    transfer = uvgraft.jax.transfer(uvgraft.Graft(pair), source_size=256, size=512)
    loss = lambda head: ((transfer(head) - wanted) ** 2).mean()
    gradient = jax.jit(jax.grad(loss))(head)

`transfer` works on the CPU by uvgraft's own code and calls back from other devices; `as_bcoo` gives
the matrix itself, for work that has to stay on a device or needs forward-mode gradients.
"""

# Without JAX's types its decorators are of type Any.
# mypy: allow-untyped-decorators

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

try:
    import jax
    import jax.numpy as jnp
    from jax.experimental import sparse
except ImportError as error:
    raise ImportError("uvgraft.jax needs JAX: pip install 'uvgraft[jax]'") from error

from uvgraft._rows import Rows
from uvgraft._uvgraft import Graft, Operator

__all__ = ["as_bcoo", "transfer"]

Size = int | tuple[int, int]


def transfer(
    graft: Graft, *, source_size: Size, size: Size | None = None
) -> Callable[[Any], jax.Array]:
    """Return the linear part of a graft as a function.

    Its gradient is the exact transpose ``Hᵀ``. ``jit``, ``vmap``, ``grad`` and ``vjp`` work, also
    nested; ``jvp`` does not, since JAX has no forward mode for functions with their own gradient.

    Parameters
    ----------
    graft : Graft
        The transfer, without its blend. Where islands overlap, the one that owns a texel is read,
        whatever ``overlap`` says, and values are averaged as they are.
    source_size : int or (int, int)
        Size of the textures, a side or ``(height, width)``.
    size : int or (int, int), optional
        Size of the results, by default the graft's.

    Returns
    -------
    callable
        Takes an array of float of shape ``(..., height, width)`` and the source size, and returns
        one of the target's size and the same dtype, 0 where nothing is transferred. Every plane is
        transferred by itself. float64 is computed in float64; 16-bit floats are computed in float32
        and rounded once, at the end. Raises `TypeError` for other dtypes and `ValueError` for
        another size.
    """
    operator = graft.operator(source_size=source_size, size=size)
    forward, adjoint = (_product(operator, transposed) for transposed in (False, True))

    @jax.custom_vjp
    def differentiable(texture: Any) -> Any:
        return forward(texture)

    # H is linear, so the way back needs nothing of the way there. Its own gradient is H again.
    differentiable.defvjp(
        lambda texture: (differentiable(texture), None), lambda _, grad: (transposed(grad),)
    )

    @jax.custom_vjp
    def transposed(grad: Any) -> Any:
        return adjoint(grad)

    transposed.defvjp(
        lambda grad: (transposed(grad), None), lambda _, grad: (differentiable(grad),)
    )

    def apply(texture: Any) -> jax.Array:
        texture = jnp.asarray(texture)
        _check(texture, operator.source_shape)
        exact = jnp.promote_types(texture.dtype, jnp.float32)
        return differentiable(texture.astype(exact)).astype(texture.dtype)

    return apply


def as_bcoo(graft: Graft, *, source_size: Size, size: Size | None = None) -> sparse.BCOO:
    """Return the matrix of a transfer.

    Parameters
    ----------
    graft, source_size, size
        As for `transfer`.

    Returns
    -------
    jax.experimental.sparse.BCOO of float32, shape (target texels, source texels)
        Texels are counted row by row. Rows of texels that nothing reaches are empty. For a texture
        of shape ``(height, width, channels)``, ``matrix @ texture.reshape(-1, channels)`` is the
        result's texels.
    """
    rows = Rows.of(graft.operator(source_size=source_size, size=size))
    row_of_entry = np.repeat(np.arange(rows.shape[0], dtype=np.int32), np.diff(rows.starts))
    indices = np.stack([row_of_entry, rows.columns], axis=1)
    parts = (jnp.asarray(rows.values), jnp.asarray(indices))
    return sparse.BCOO(parts, shape=rows.shape, indices_sorted=True, unique_indices=True)


def _product(operator: Operator, transposed: bool) -> Callable[[Any], Any]:
    """Return the product of float32 or float64 planes with ``H`` or ``Hᵀ``, within JAX."""
    shape_in, shape_out = operator.source_shape, operator.target_shape
    native = operator._forward_planes
    if transposed:
        shape_in, shape_out, native = shape_out, shape_in, operator._adjoint_planes

    @cache
    def rows() -> Rows:
        found = Rows.of(operator)
        return found.transposed() if transposed else found

    def on_host(texture: Any) -> NDArray[Any]:
        values = np.asarray(texture)
        planes = values.reshape(-1, *shape_in)
        if values.dtype == np.float64:
            result = rows().product(planes.reshape(len(planes), -1))
        else:
            result = native(planes)
        return result.reshape(*values.shape[:-2], *shape_out)

    def product(texture: Any) -> Any:
        result = jax.ShapeDtypeStruct((*texture.shape[:-2], *shape_out), texture.dtype)
        # Axes that `vmap` adds are planes like any others.
        return jax.pure_callback(on_host, result, texture, vmap_method="broadcast_all")

    return product


def _check(texture: Any, shape: tuple[int, int]) -> None:
    if not jnp.issubdtype(texture.dtype, jnp.floating):
        raise TypeError(f"texture must hold floats, got {texture.dtype}")
    if texture.shape[-2:] != shape:
        height, width = shape
        raise ValueError(f"texture must have shape (..., {height}, {width}), got {texture.shape}")
