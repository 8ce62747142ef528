"""The functions of FastFLAME2SMPLX, the reference implementation of Song et al.

"Fast Texture Transfer for XR Avatars via Barycentric UV Conversion", arXiv 2508.19518. A script
that uses it runs after a change of one import::

    from uvgraft.compat import fastflame2smplx as ftx  # was: from src.core import ftx

    body = ftx.flame_smplx_texture_combine(
        "face.png", "body.png", uv_grid_load_path="flame_smplx_uv_grid.npz"
    )
    cv2.imwrite("body_with_face.png", body)

Arguments, results and grid files are those of that code; neither OpenCV nor PyTorch is needed.
Nothing is printed. ``convention`` is ours:

``"reference"``
    The same pixels, up to rounding: positions of centres are sampled as if -1 and 1 were the
    centres of the outer texels, which is off by up to half a texel; values are truncated; the
    source is resized to ``src_size``.
``"exact"``
    uvgraft's own transfer where the meshes are given, with Lanczos filter, averaging where the
    source is minified, gutter and rounding; with a grid alone, bilinear samples at the right
    places. The source is read at its own size, so ``src_size`` is not used.
"""

from __future__ import annotations

import os
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from uvgraft._uvgraft import Graft, Mesh, Pair, read_image
from uvgraft.compat._uv_grid import UvGrid, aligned, exact, linked_faces

__all__ = ["flame_smplx_texture_combine", "smplx_flame_texture_combine"]

StrPath = str | os.PathLike[str]
Convention = Literal["reference", "exact"]


def flame_smplx_texture_combine(  # noqa: PLR0917 (the reference implementation's arguments)
    flame_texture_path: StrPath,
    smplx_texture_path: StrPath,
    flame_obj: StrPath | None = None,
    smplx_obj: StrPath | None = None,
    smplx_flame_vertex_ids: StrPath | None = None,
    smplx_face_indexes: StrPath | None = None,
    uv_grid_load_path: StrPath | None = None,
    uv_grid_save_path: StrPath | None = None,
    src_size: tuple[int, int] = (2048, 2048),
    tgt_size: tuple[int, int] = (4096, 4096),
    *,
    convention: Convention = "reference",
) -> NDArray[np.uint8]:
    """Put the texture of a FLAME head on that of a SMPL-X body.

    Parameters
    ----------
    flame_texture_path, smplx_texture_path : path
        Images of 8 or 16 bits. Grey ones become BGR; alpha is ignored.
    flame_obj, smplx_obj : path, optional
        The meshes, with UV coordinates. Needed without a grid.
    smplx_flame_vertex_ids : path, optional
        NPY file of integers, one for each FLAME vertex: the SMPL-X vertex that it is, or -1. Needed
        without a grid.
    smplx_face_indexes : path, optional
        NPY file of the SMPL-X *vertices* that are transferred, by default all.
    uv_grid_load_path : path, optional
        NPZ file of a grid. If it exists, the meshes are not read; with ``convention="exact"`` it is
        used only without the meshes.
    uv_grid_save_path : path, optional
        Where to write the grid if it was made.
    src_size, tgt_size : (int, int)
        *Width and height* that the source and the target are resized to.
    convention : {"reference", "exact"}
        Whose pixels; see the module.

    Returns
    -------
    ndarray of uint8, shape (height, width, 3)
        The body's texture in the channel order of OpenCV: blue, green, red.

    Raises
    ------
    ValueError
        If neither a grid nor all meshes are given, or sizes or files do not fit.
    OSError
        If a file cannot be read or written.
    Error
        If a file has the wrong content, or no triangles correspond.
    """
    templates = _templates(flame_obj, smplx_obj, smplx_flame_vertex_ids, smplx_face_indexes)
    return _combined(
        (flame_texture_path, smplx_texture_path),
        (src_size, tgt_size),
        templates,
        reverse=False,
        load=uv_grid_load_path,
        save=uv_grid_save_path,
        convention=convention,
    )


def smplx_flame_texture_combine(  # noqa: PLR0917 (the reference implementation's arguments)
    smplx_texture_path: StrPath,
    flame_texture_path: StrPath,
    smplx_obj: StrPath | None = None,
    flame_obj: StrPath | None = None,
    smplx_flame_vertex_ids: StrPath | None = None,
    smplx_face_indexes: StrPath | None = None,
    uv_grid_load_path: StrPath | None = None,
    uv_grid_save_path: StrPath | None = None,
    src_size: tuple[int, int] = (4096, 4096),
    tgt_size: tuple[int, int] = (2048, 2048),
    *,
    convention: Convention = "reference",
) -> NDArray[np.uint8]:
    """Take the texture of a FLAME head from that of a SMPL-X body.

    As `flame_smplx_texture_combine`, the other way round: the body is the source, and the head's
    texture shows where nothing is transferred.
    """
    templates = _templates(flame_obj, smplx_obj, smplx_flame_vertex_ids, smplx_face_indexes)
    return _combined(
        (smplx_texture_path, flame_texture_path),
        (src_size, tgt_size),
        templates,
        reverse=True,
        load=uv_grid_load_path,
        save=uv_grid_save_path,
        convention=convention,
    )


class _Templates(NamedTuple):
    """The files that say which triangles correspond."""

    flame: StrPath
    smplx: StrPath
    vertex_ids: StrPath
    region: StrPath | None

    def load(self) -> tuple[Mesh, Mesh, NDArray[np.int64]]:
        """Read the head, the body, and the body's vertex of each of the head's, -1 for none."""
        head, body = Mesh.load(self.flame), Mesh.load(self.smplx)
        ids = np.load(self.vertex_ids)
        if ids.dtype.kind not in "iu" or ids.shape != (len(head.positions),):
            raise ValueError(
                f"smplx_flame_vertex_ids must be {len(head.positions)} integers, one for each "
                f"vertex of flame_obj, got {ids.dtype} of shape {ids.shape}"
            )
        if self.region is not None:
            ids = np.where(np.isin(ids, np.load(self.region)), ids, -1)
        return head, body, ids.astype(np.int64)


def _templates(
    flame: StrPath | None, smplx: StrPath | None, ids: StrPath | None, region: StrPath | None
) -> _Templates | None:
    if flame is None or smplx is None or ids is None:
        return None
    return _Templates(flame, smplx, ids, region)


def _combined(
    images: tuple[StrPath, StrPath],
    sizes: tuple[tuple[int, int], tuple[int, int]],
    templates: _Templates | None,
    *,
    reverse: bool,
    load: StrPath | None,
    save: StrPath | None,
    convention: Convention,
) -> NDArray[np.uint8]:
    if convention not in ("reference", "exact"):
        raise ValueError(f'convention must be "reference" or "exact", got {convention!r}')
    # As in the original, no path and an empty one are the same.
    is_loaded = bool(load) and os.path.exists(load or "")
    if templates is None and not is_loaded:
        raise ValueError(
            "without a grid, flame_obj, smplx_obj and smplx_flame_vertex_ids are required"
            + (f"; {os.fspath(load)} does not exist" if load else "")
        )
    source, base = map(_read, images)
    base = _resized(base, sizes[1])
    if convention == "exact":
        if templates is None:
            return UvGrid.load(load).sampled(source, base, exact, _rounded)
        return _exact_from_meshes(source, base, templates, reverse, save)
    source = _resized(source, sizes[0])
    if is_loaded:
        grid = UvGrid.load(load)
    else:
        assert templates is not None
        grid = _reference_grid(templates, reverse, sizes[1])
        if save:
            grid.save(save)
    return grid.sampled(source, base, aligned, _truncated)


def _exact_from_meshes(
    source: NDArray[np.uint8],
    base: NDArray[np.uint8],
    templates: _Templates,
    reverse: bool,
    save: StrPath | None,
) -> NDArray[np.uint8]:
    head, body, ids = templates.load()
    graft = Graft(Pair(head, body, vertex_map=ids), reverse=reverse)
    if save:
        height, width = base.shape[:2]
        UvGrid.of_map(graft.map(size=(height, width))).save(save)
    return graft.apply(source, base)


def _reference_grid(templates: _Templates, reverse: bool, size: tuple[int, int]) -> UvGrid:
    head, body, ids = templates.load()
    head_faces, body_faces = linked_faces(head, body, ids)
    head_uv = head.uv[head.uv_faces.astype(np.int64)]
    body_uv = body.uv[body.uv_faces.astype(np.int64)]
    if not reverse:
        return UvGrid.rasterized(head_uv[head_faces], body_uv[body_faces], size)
    # Of faces of the head that share one of the body, the last one counts, in the place of the
    # first.
    head_of_body = dict(zip(body_faces.tolist(), head_faces.tolist(), strict=True))
    source, target = list(head_of_body), list(head_of_body.values())
    return UvGrid.rasterized(body_uv[source], head_uv[target], size)


def _truncated(values: NDArray[np.float32]) -> NDArray[np.uint8]:
    return (values * np.float32(255)).astype(np.uint8)


def _rounded(values: NDArray[np.float32]) -> NDArray[np.uint8]:
    result: NDArray[np.uint8] = np.rint(values * np.float32(255)).astype(np.uint8)
    return result


def _read(path: StrPath) -> NDArray[np.uint8]:
    """Read an image as OpenCV does by default: 8 bits, blue, green, red."""
    image = read_image(path)
    if image.dtype == np.uint16:
        # OpenCV drops the lower bits.
        image = (image >> 8).astype(np.uint8)
    if image.dtype != np.uint8:
        raise ValueError(f"{os.fspath(path)} must have 8 or 16 bits, got {image.dtype}")
    colors = image[..., :1].repeat(3, axis=-1) if image.shape[2] < 3 else image[..., 2::-1]
    return np.ascontiguousarray(colors)


def _resized(image: NDArray[np.uint8], size: tuple[int, int]) -> NDArray[np.uint8]:
    """Resize an image as ``cv2.resize`` does: bilinear, in whole numbers, and aliasing."""
    if image.shape[1::-1] == tuple(size):
        return image
    low, high, near, far = _taps(image.shape[1], size[0])
    rows = image[:, low] * near[:, None] + image[:, high] * far[:, None]
    rows >>= 4
    low, high, near, far = _taps(image.shape[0], size[1])
    sums = (rows[low] * near[:, None, None]) >> 16
    sums += (rows[high] * far[:, None, None]) >> 16
    result: NDArray[np.uint8] = ((sums + 2) >> 2).astype(np.uint8)
    return result


def _taps(found: int, wanted: int) -> tuple[NDArray[Any], ...]:
    """Return the two texels that each of the wanted ones is between, and their shares of 2048."""
    at = ((np.arange(wanted) + 0.5) * (found / wanted) - 0.5).astype(np.float32)
    low = np.floor(at).astype(np.int64)
    share = np.where((low < 0) | (low >= found - 1), np.float32(0), at - low.astype(np.float32))
    low = np.clip(low, 0, found - 1)
    near, far = (np.rint(part * np.float32(2048)).astype(np.int32) for part in (1 - share, share))
    return low, np.minimum(low + 1, found - 1), near, far
