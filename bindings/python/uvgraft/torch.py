"""Transfers in PyTorch: differentiable, on any device.

A plain transfer is linear: with the texels of a texture in a vector, it is a product with a matrix
``H``, whose gradient is the product with ``Hᵀ``::

    import uvgraft, uvgraft.torch

    pair = uvgraft.Pair("head.obj", "body.obj", vertex_map="ids.npy")
    transfer = uvgraft.torch.Transfer(uvgraft.Graft(pair), source_size=256, size=512)
    body = transfer(head)  # (N, C, 256, 256) to (N, C, 512, 512)
    (body - wanted).square().mean().backward()

`Transfer` has the filter, the averaging and the padding of its graft. `grid` gives positions for
``torch.nn.functional.grid_sample``, which takes one bilinear sample for each texel.
"""

# Without PyTorch's types its classes and decorators are of type Any.
# mypy: allow-subclassing-any, allow-untyped-decorators

from __future__ import annotations

import itertools
import warnings
import weakref
from contextlib import AbstractContextManager, nullcontext
from typing import Any

import numpy as np

try:
    import torch
except ImportError as error:
    raise ImportError("uvgraft.torch needs PyTorch: pip install 'uvgraft[torch]'") from error

from uvgraft import _grids
from uvgraft._rows import Rows
from uvgraft._uvgraft import Graft, SamplingMap

__all__ = ["Transfer", "grid"]

Size = int | tuple[int, int]


class Transfer(torch.nn.Module):
    """The linear part of a graft as a module without parameters.

    Forward is ``H``, backward its exact transpose ``Hᵀ``. Gradients of gradients, forward-mode
    gradients, ``torch.func`` and ``torch.compile`` work.

    The work is done where the tensor is: on CPUs by uvgraft's own code, with CUDA as a product with
    a sparse matrix, which is made when it is first needed. On other devices, tensors take the way
    through the CPU. 16-bit floats are computed in float32 and rounded once, at the end;
    float64 is computed in float64, with the sparse matrix. Results have the dtype of the input,
    also under ``torch.autocast``.

    Parameters
    ----------
    graft : Graft
        The transfer. Of its blend only the region and the feather are used, and only with a base;
        colours are not adapted, since that is not linear. Where islands overlap, the one that owns
        a texel is read, whatever ``overlap`` says, and values are averaged as they are.
    source_size : int or (int, int)
        Size of the textures, a side or ``(height, width)``.
    size : int or (int, int), optional
        Size of the results, by default the graft's.

    Attributes
    ----------
    source_shape, target_shape : (int, int)
        ``(height, width)`` of textures and of results.
    coverage : torch.Tensor of uint8, shape (height, width)
        255 where a base is replaced, less in a feather, 0 where it shows. As `Graft.apply` does, a
        graft without a region replaces the gutter as well. Not a part of ``state_dict``.
    """

    coverage: Any

    def __init__(self, graft: Graft, *, source_size: Size, size: Size | None = None) -> None:
        """Prepare a transfer."""
        super().__init__()
        self._product = _Product(graft, source_size, size)
        self.source_shape: tuple[int, int] = self._product.shapes[0]
        self.target_shape: tuple[int, int] = self._product.shapes[1]
        coverage = torch.from_numpy(_coverage(graft, self.target_shape))
        self.register_buffer("coverage", coverage, persistent=False)

    def forward(self, texture: Any, base: Any = None) -> Any:
        """Transfer textures.

        Parameters
        ----------
        texture : torch.Tensor of float, shape (..., height, width)
            Textures of the source size, such as ``(N, C, H, W)`` or ``(C, H, W)``; values of any
            range. Every plane is transferred by itself, so colours with an alpha channel have to be
            premultiplied.
        base : torch.Tensor of float, shape (..., height, width), optional
            What shows where nothing is transferred, of the target's size; other axes are broadcast.
            By default 0.

        Returns
        -------
        torch.Tensor, shape (..., height, width)
            Results of the target's size, with the dtype and on the device of ``texture``.

        Raises
        ------
        TypeError
            If a texture is not a tensor of floats.
        ValueError
            If a size differs.
        """
        _check("texture", texture, self.source_shape)
        if torch.compiler.is_compiling():
            result = _compiled_product(texture, self._product.handle, False)
        else:
            result = _Apply.apply(texture, self._product, False)
        if base is None:
            return result
        _check("base", base, self.target_shape)
        base = base.to(result)
        share = self.coverage.to(result) / 255
        return share * result + (1 - share) * base

    def extra_repr(self) -> str:
        """Return what ``repr`` shows of this module."""
        return f"{self.source_shape} to {self.target_shape}, filter={self._product.graft.filter!r}"


def grid(
    graft_or_map: Graft | SamplingMap,
    size: Size | None = None,
    *,
    device: Any = None,
    dtype: Any = torch.float32,
    gutter: bool = True,
) -> Any:
    """Return where each texel comes from, for ``torch.nn.functional.grid_sample``.

    Positions follow ``align_corners=False``: -1 and 1 are the outer edges of the first and the last
    texel, so one grid serves textures of every size::

        grid = uvgraft.torch.grid(graft, 512)
        body = torch.nn.functional.grid_sample(head, grid, align_corners=False)

    ``padding_mode="zeros"`` gives 0 where nothing is transferred; ``"border"`` repeats the texels
    at the edge of the texture, as uvgraft does, and needs a mask. ``grid_sample`` takes one sample
    for each texel and knows no islands, so where a texture is minified it aliases, and at the
    borders of islands it mixes in what is beside them; `Transfer` does neither.

    Parameters
    ----------
    graft_or_map : Graft or SamplingMap
        The transfer.
    size : int or (int, int), optional
        Size of the result, a side or ``(height, width)``; by default that of the graft or the map.
    device : str or torch.device, optional
        Where the grid shall be, by default in the memory of the CPU.
    dtype : torch.dtype
        A float. 16 bits are too few for positions in textures of more than some hundred texels.
    gutter : bool
        Whether the gutter around islands is filled.

    Returns
    -------
    torch.Tensor, shape (1, height, width, 2)
        x and y from -1 to 1; -3 where nothing is transferred.

    Raises
    ------
    ValueError
        If ``size`` is not that of a map that was given.
    """
    if isinstance(graft_or_map, SamplingMap):
        wanted = (size, size) if isinstance(size, int) else size
        if wanted is not None and tuple(wanted) != graft_or_map.shape:
            raise ValueError(f"size must be the map's, {graft_or_map.shape}, got {wanted}")
        map = graft_or_map
    else:
        map = graft_or_map.map(size=size)
    values = _grids.grid(map, "cpu", gutter=gutter)
    return values.to(device=device, dtype=dtype).unsqueeze(0)


# Compiled graphs can hold numbers but no objects, so they name a product by its handle.
_HANDLES = itertools.count()
_PRODUCTS: weakref.WeakValueDictionary[int, _Product] = weakref.WeakValueDictionary()


class _Product:
    """Products with ``H`` and ``Hᵀ`` on any device.

    Nothing but the caches changes after it is made, so copies of a module share it.
    """

    def __init__(self, graft: Graft, source_size: Size, size: Size | None) -> None:
        self.graft = graft
        self.sizes = (source_size, size)
        self.operator = graft.operator(source_size=source_size, size=size)
        self.shapes = (self.operator.source_shape, self.operator.target_shape)
        self.handle = next(_HANDLES)
        self._rows: dict[bool, Rows] = {}
        self._matrices: dict[tuple[Any, Any, bool], Any] = {}
        _PRODUCTS[self.handle] = self

    def __reduce__(self) -> tuple[type[_Product], tuple[Graft, Size, Size | None]]:
        return _Product, (self.graft, *self.sizes)

    def __deepcopy__(self, memo: dict[int, Any]) -> _Product:
        return self

    def __call__(self, texture: Any, transposed: bool) -> Any:
        """Multiply all planes of a tensor, outside of autograd."""
        shape_in, shape_out = reversed(self.shapes) if transposed else self.shapes
        shape = (*texture.shape[:-2], *shape_out)
        if texture.device.type == "meta":
            return texture.new_empty(shape)
        planes = texture.detach().reshape(-1, *shape_in)
        if texture.device.type == "cuda" or texture.dtype == torch.float64:
            result = self._sparse(planes, transposed)
        else:
            result = self._native(planes, transposed)
        return result.to(device=texture.device, dtype=texture.dtype).reshape(shape)

    def _native(self, planes: Any, transposed: bool) -> Any:
        values = planes.to(torch.float32).numpy(force=True)
        product = self.operator._adjoint_planes if transposed else self.operator._forward_planes
        return torch.from_numpy(product(values))

    def _sparse(self, planes: Any, transposed: bool) -> Any:
        dtype = torch.promote_types(planes.dtype, torch.float32)
        matrix = self._matrix(planes.device, dtype, transposed)
        with _full_precision(planes.device.type):
            return (matrix @ planes.flatten(1).to(dtype).t()).t()

    def _matrix(self, device: Any, dtype: Any, transposed: bool) -> Any:
        key = (device, dtype, transposed)
        if key not in self._matrices:
            if transposed not in self._rows:
                rows = Rows.of(self.operator)
                self._rows[transposed] = rows.transposed() if transposed else rows
            self._matrices[key] = _csr(self._rows[transposed], device, dtype)
        return self._matrices[key]


class _Apply(torch.autograd.Function):
    """``H`` or ``Hᵀ``, each of which is the other's gradient."""

    @staticmethod
    def forward(texture: Any, product: _Product, transposed: bool) -> Any:
        return product(texture, transposed)

    @staticmethod
    def setup_context(ctx: Any, inputs: tuple[Any, _Product, bool], output: Any) -> None:
        _, ctx.product, ctx.transposed = inputs

    @staticmethod
    def backward(ctx: Any, grad: Any) -> tuple[Any, None, None]:
        return _Apply.apply(grad, ctx.product, not ctx.transposed), None, None

    @staticmethod
    def jvp(ctx: Any, tangent: Any, *_: None) -> Any:
        return _Apply.apply(tangent, ctx.product, ctx.transposed)

    @staticmethod
    def vmap(
        info: Any,
        in_dims: tuple[int, None, None],
        texture: Any,
        product: _Product,
        transposed: bool,
    ) -> tuple[Any, int]:
        return _Apply.apply(texture.movedim(in_dims[0], 0), product, transposed), 0


@torch.library.custom_op("uvgraft::product", mutates_args=())
def _compiled_product(texture: torch.Tensor, handle: int, transposed: bool) -> torch.Tensor:
    product = _PRODUCTS.get(handle)
    if product is None:
        raise RuntimeError("the Transfer that this graph was compiled from no longer exists")
    return product(texture, transposed)


@_compiled_product.register_fake
def _(texture: Any, handle: int, transposed: bool) -> Any:
    shape = _PRODUCTS[int(handle)].shapes[0 if transposed else 1]
    return texture.new_empty((*texture.shape[:-2], *shape))


@_compiled_product.register_vmap
def _(info: Any, in_dims: Any, texture: Any, handle: int, transposed: bool) -> tuple[Any, int]:
    return _compiled_product(texture.movedim(in_dims[0], 0), handle, transposed), 0


def _set_up(ctx: Any, inputs: tuple[Any, int, bool], output: Any) -> None:
    _, ctx.handle, ctx.transposed = inputs


def _differentiated(ctx: Any, grad: Any) -> tuple[Any, None, None]:
    return _compiled_product(grad, ctx.handle, not ctx.transposed), None, None


_compiled_product.register_autograd(_differentiated, setup_context=_set_up)


def _full_precision(device_type: str) -> AbstractContextManager[Any]:
    """Keep autocast from lowering the precision of a product."""
    if torch.is_autocast_enabled(device_type):
        return torch.autocast(device_type, enabled=False)  # type: ignore[no-any-return]
    return nullcontext()


def _csr(rows: Rows, device: Any, dtype: Any) -> Any:
    """Make a sparse tensor."""
    # Half the memory, and what libraries for sparse matrices expect.
    narrow = len(rows.values) < 2**31
    starts = rows.starts.astype(np.int32 if narrow else np.int64)
    columns = rows.columns.astype(starts.dtype, copy=False)
    parts = [torch.from_numpy(part).to(device) for part in (starts, columns, rows.values)]
    with warnings.catch_warnings():
        # PyTorch says once that they are in beta, about which users of textures can do nothing.
        warnings.filterwarnings("ignore", "Sparse CSR tensor support", UserWarning)
        return torch.sparse_csr_tensor(
            parts[0], parts[1], parts[2].to(dtype), size=rows.shape, check_invariants=False
        )


def _coverage(graft: Graft, size: tuple[int, int]) -> Any:
    mask, map = graft.mask(size=size), graft.map(size=size)
    if np.array_equal(mask, map.mask()):
        mask[map.faces(gutter=True) >= 0] = 255
    return mask


def _check(what: str, given: Any, shape: tuple[int, int]) -> None:
    if not isinstance(given, torch.Tensor):
        raise TypeError(f"{what} must be a tensor, got {type(given).__name__}")
    if not given.is_floating_point():
        raise TypeError(f"{what} must hold floats, got {given.dtype}")
    if tuple(given.shape[-2:]) != shape:
        height, width = shape
        raise ValueError(
            f"{what} must have shape (..., {height}, {width}), got {tuple(given.shape)}"
        )
