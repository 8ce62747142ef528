"""The loss of transferring a texture there and back."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from uvgraft._uvgraft import Graft, Pair, compare, read_image


class RoundTrip(NamedTuple):
    """A texture that was transferred to the other layout and back, and what it lost.

    Attributes
    ----------
    via : ndarray
        The texture in the other layout, on grey.
    back : ndarray
        The texture that came back, laid over the original.
    mask : ndarray of uint8, shape (height, width)
        255 for texels that were transferred there and back.
    whole, linked : dict of str to float
        `compare` of the original and `back`, over the whole image and over the mask.
    """

    via: NDArray[Any]
    back: NDArray[Any]
    mask: NDArray[np.uint8]
    whole: dict[str, float]
    linked: dict[str, float]


def roundtrip(
    pair: Pair,
    texture: Any,
    *,
    via: int | tuple[int, int],
    side: Literal["source", "target"] = "target",
    filter: Literal["nearest", "bilinear", "catmull-rom", "lanczos3"] = "lanczos3",
    gutter: int = 16,
    fit: bool = False,
    metrics: str | Iterable[str] | None = None,
    encoding: Literal["srgb", "linear"] = "srgb",
    threads: int | None = None,
) -> RoundTrip:
    """Transfer a texture to the other layout and back, as the command ``uvgraft roundtrip``.

    Parameters
    ----------
    pair : Pair
        The meshes.
    texture : ndarray, PIL image or path
        Grey or RGB; metrics compare colours only.
    via : int or (int, int)
        Size in the other layout: a side in texels, or ``(height, width)``.
    side : {"source", "target"}
        The mesh in whose layout the texture is.
    filter : {"nearest", "bilinear", "catmull-rom", "lanczos3"}
        Interpolation filter, in both directions.
    gutter : int
        Width of the gutter around UV islands in the other layout, in texels.
    fit : bool
        Fit the texture in the other layout, in place of sampling it.
    metrics : str or iterable of str, optional
        As in `compare`.
    encoding : {"srgb", "linear"}
        Encoding of the texture's colours, also of a file's.
    threads : int, optional
        Number of threads, 0 for one per processor; see `set_threads`.

    Returns
    -------
    RoundTrip
        Both textures, and the metrics.

    Raises
    ------
    TypeError, ValueError, OSError
        As `Graft.apply` and `compare`; and for textures with alpha.
    uvgraft.Error
        If nothing can be transferred.
    """
    original = _opaque(texture)
    size = (original.shape[0], original.shape[1])
    is_reversed = _side(side) == "target"
    there = Graft(
        pair,
        size=via,
        reverse=is_reversed,
        filter=filter,
        gutter=gutter,
        encoding=encoding,
        threads=threads,
    )
    # A gutter would overwrite the original around its islands.
    back = Graft(
        pair, reverse=not is_reversed, filter=filter, gutter=0, encoding=encoding, threads=threads
    )
    grey = _grey(via, original)
    carried = there.fit(original, grey).texture if fit else there.apply(original, grey)
    returned = back.apply(carried, original)
    mask = back.map(size=size, source_size=via).mask()
    common: dict[str, Any] = {"metrics": metrics, "encoding": encoding, "threads": threads}
    whole = compare(original, returned, **common)
    return RoundTrip(
        carried, returned, mask, whole, compare(original, returned, mask=mask, **common)
    )


def _side(side: str) -> str:
    if side not in ("source", "target"):
        raise ValueError(f'side must be "source" or "target", got {side!r}')
    return side


def _opaque(texture: Any) -> NDArray[Any]:
    """Return a texture as an array without alpha."""
    is_path = isinstance(texture, str | os.PathLike)
    values: NDArray[Any] = read_image(texture) if is_path else np.asarray(texture)
    if values.ndim == 3 and values.shape[2] in (2, 4):
        raise ValueError(f"texture must have no alpha, got {values.shape[2]} channels")
    if values.ndim not in (2, 3):
        raise ValueError(f"texture must have shape (height, width[, channels]), got {values.shape}")
    return values


def _grey(size: int | tuple[int, int], like: NDArray[Any]) -> NDArray[Any]:
    """Return a base of a size, half as bright as white in the dtype of a texture."""
    sides = size if isinstance(size, tuple) else (size, size)
    half = 0.5 if like.dtype.kind == "f" else np.iinfo(like.dtype).max // 2 + 1
    return np.full((*sides, *like.shape[2:]), half, like.dtype)
