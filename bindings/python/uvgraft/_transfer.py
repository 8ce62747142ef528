"""Transfers in one call."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal, overload

from numpy.typing import ArrayLike, NDArray

from uvgraft._region import Region
from uvgraft._types import (
    Image,
    Images,
    MeshLike,
    NormalY,
    Overlap,
    Side,
    Size,
    StrPath,
    TransferMethod,
)
from uvgraft._uvgraft import Graft, Pair, is_pair_file

if TYPE_CHECKING:
    from typing_extensions import Unpack


class GraftOptions(TransferMethod, total=False):
    """Options of `Graft`."""

    size: Size | None
    reverse: bool
    overlap: Overlap
    linear_light: bool
    encoding: Literal["srgb", "linear"]
    content: Literal["color", "data", "normals"]
    normal_y: NormalY
    normal_y_out: NormalY | None
    region: Region | None
    feather: float | None
    skin: Image | None
    labels: Image | None


class PairingOptions(GraftOptions, total=False):
    """Options of `Graft`, and those of `Pair` that say how two meshes correspond."""

    vertex_map: ArrayLike | StrPath | None
    table: StrPath | None
    by: Literal["auto", "vertex-map", "table", "faces", "topology", "surface"]
    align: Literal["similarity", "rigid", "none"]
    landmarks: ArrayLike | None
    reach: float | None
    visibility: float | None
    outside: Literal["unlinked", "clamp", "repeat"]
    flip_u: Side | Sequence[Side] | None
    flip_v: Side | Sequence[Side] | None


_OF_GRAFTS = GraftOptions.__annotations__.keys()
_OF_PAIRS = PairingOptions.__annotations__.keys() - _OF_GRAFTS


@overload
def transfer(
    source: Pair | StrPath,
    texture: Images,
    base: Images | None = None,
    *,
    onto: Images | None = None,
    out: Any = None,
    threads: int | None = None,
    **options: Unpack[GraftOptions],
) -> Any: ...
@overload
def transfer(
    source: MeshLike,
    target: MeshLike,
    texture: Images,
    base: Images | None = None,
    *,
    onto: Images | None = None,
    out: Any = None,
    threads: int | None = None,
    **options: Unpack[PairingOptions],
) -> Any: ...
# With a pair, arguments by position are one place to the left of their names.
def transfer(  # type: ignore[misc]
    source: Any,
    target: Any = None,
    texture: Any = None,
    base: Any = None,
    *,
    onto: Any = None,
    out: Any = None,
    threads: int | None = None,
    **options: Any,
) -> NDArray[Any] | list[NDArray[Any]]:
    """Transfer a texture, or several, from one mesh to another in a single call.

    It is short for ``Graft(Pair(source, target), ...).apply(texture, base)``, and takes the options
    of both. The pair and the graft are made in each call: to transfer many textures give them as a
    list, or keep the `Graft`.

    Parameters
    ----------
    source : Mesh, path, mesh of trimesh, or Pair
        The mesh that textures come from. With a pair, or the path of a pair file, there is no
        `target`: ``transfer(pair, texture, base)``.
    target : Mesh, path or mesh of trimesh
        The mesh that textures go to.
    texture, base, out
        As in `Graft.apply`: one, or several as a list or as an array of shape
        (n, height, width, channels).
    onto
        What the command calls `base`; give one of them.
    threads : int, optional
        Number of threads, 0 for one per processor; see `set_threads`.
    **options
        See below.

    Other Parameters
    ----------------
    vertex_map, table, by, align, landmarks, reach, visibility, outside, flip_u, flip_v
        How two meshes correspond: see `Pair`.
    size, reverse, filter, gutter, prefer, overlap, linear_light, encoding, content, normal_y, \
normal_y_out, region, blend, feather, tone, match_skin, keep_all, skin, labels
        How textures are transferred: see `Graft`. `size` is required unless the base is an image.

    Returns
    -------
    ndarray or list of ndarray
        As `Graft.apply` returns it.

    Raises
    ------
    TypeError
        For options that do not exist, and for options of two meshes with a pair.
    ValueError, OSError, uvgraft.Error
        As `Pair` and `Graft`.

    Examples
    --------
    >>> body = transfer("head.obj", "body.obj", "face.png", "body.png", blend="membrane")
    """
    for name in options:
        if name not in _OF_GRAFTS and name not in _OF_PAIRS:
            raise TypeError(f"transfer() got an unexpected keyword argument {name!r}")
    of_pair = {name: options.pop(name) for name in _OF_PAIRS & options.keys()}
    if _is_pair(source):
        if target is not None:
            if texture is not None and base is not None:
                raise TypeError("transfer() takes a pair, a texture and a base; source is a pair")
            texture, base = target, texture if base is None else base
        if of_pair:
            name = min(of_pair)
            raise TypeError(f"{name} is for two meshes, which a pair has linked already")
        pair = source if isinstance(source, Pair) else Pair.load(source)
    else:
        if target is None:
            raise TypeError("target is missing: transfer() takes two meshes, or a pair")
        _check_texture(texture)
        pair = Pair(source, target, threads=threads, **of_pair)
    _check_texture(texture)
    if onto is not None and base is not None:
        raise TypeError("transfer() takes either base or onto, got both")
    graft = Graft(pair, threads=threads, **options)
    result: NDArray[Any] | list[NDArray[Any]]
    result = graft.apply(texture, onto if base is None else base, out=out)
    return result


def _is_pair(source: Any) -> bool:
    if isinstance(source, str | os.PathLike):
        return is_pair_file(source)
    return isinstance(source, Pair)


def _check_texture(texture: Any) -> None:
    if texture is None:
        raise TypeError(
            "texture is missing: transfer() takes two meshes or a pair, a texture and a base"
        )
