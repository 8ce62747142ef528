"""The grids of the reference implementation: made, read, written and sampled.

Song et al., "Fast Texture Transfer for XR Avatars via Barycentric UV Conversion", arXiv 2508.19518.
A grid says for each texel of the target where in the source it comes from (``uv_grid``), and which
triangle it is in (``pix_to_face``).
"""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from uvgraft._uvgraft import Error, Mesh, SamplingMap

Positions = NDArray[np.float32]

# Rows that are sampled at a time, so that memory does not grow with the target.
_BAND = 256


class UvGrid(NamedTuple):
    """Where each texel of a target comes from.

    Attributes
    ----------
    positions : ndarray of float32, shape (height, width, 2)
        x and y in the source, as stored; 0 where nothing is covered.
    faces : ndarray of int64, shape (height, width)
        A triangle, negative where nothing is covered.
    aligned_size : (int, int) or None
        Width and height of the textures for whose centres of texels -1 and 1 stand; by default they
        stand for the edges of a texture of any size.
    """

    positions: Positions
    faces: NDArray[np.int64]
    aligned_size: tuple[int, int] | None = None

    @classmethod
    def load(cls, path: Any) -> UvGrid:
        """Read an NPZ file, of the reference implementation or of ``uvgraft map``.

        Raises
        ------
        ValueError
            If the file does not have these arrays.
        """
        with np.load(path) as file:
            missing = {"uv_grid", "pix_to_face"} - set(file.files)
            if missing:
                raise ValueError(f"{path} must have the array {min(missing)!r}, has {file.files}")
            positions, faces = file["uv_grid"], file["pix_to_face"]
            if faces.ndim != 2 or positions.shape != (1, *faces.shape, 2):
                raise ValueError(
                    f"{path} must hold uv_grid (1, H, W, 2) and pix_to_face (H, W), "
                    f"got {positions.shape} and {faces.shape}"
                )
            is_exact = "convention" in file.files and str(file["convention"]) == "exact"
            size = tuple(int(side) for side in file["source_size"]) if is_exact else None
        aligned = (size[0], size[1]) if size else None
        return cls(positions[0].astype(np.float32, copy=False), faces, aligned)

    def save(self, path: Any) -> None:
        """Write an NPZ file, whole or not at all; ``.npz`` is added to a name without it."""
        path = Path(path)
        if path.suffix != ".npz":
            path = path.with_name(path.name + ".npz")
        # A file that is cut short would be taken for the grid by the next run.
        unfinished = path.with_name(f".{path.name}.{os.getpid()}")
        try:
            with unfinished.open("wb") as file:
                np.savez(file, uv_grid=self.positions[None], pix_to_face=self.faces)
            unfinished.replace(path)
        finally:
            unfinished.unlink(missing_ok=True)

    @classmethod
    def of_map(cls, map: SamplingMap) -> UvGrid:
        """Return the grid of one of our own maps, gutter included."""
        faces = map.faces(gutter=True).astype(np.int64)
        positions = 2 * map.uv() - 1
        positions[faces < 0] = 0
        return cls(positions, faces)

    @classmethod
    def rasterized(
        cls, source: NDArray[Any], target: NDArray[Any], size: tuple[int, int]
    ) -> UvGrid:
        """Return the grid of triangles as the reference implementation makes it.

        A texel belongs to the last triangle that its centre is in or on the edge of.

        Parameters
        ----------
        source, target : ndarray of float, shape (triangles, 3, 2)
            UV coordinates of corresponding triangles, from the top left.
        size : (int, int)
            Width and height of the target.
        """
        width, height = size
        positions = np.zeros((height, width, 2), np.float32)
        faces = np.full((height, width), -1, np.int64)
        corners = target * np.array(size, np.float64)
        limits = np.array(size) - 1
        first = np.clip(np.floor(corners.min(axis=1)), 0, limits).astype(int)
        last = np.clip(np.floor(corners.max(axis=1)), 0, limits).astype(int) + 1
        for face, (triangle, (x0, y0), (x1, y1)) in enumerate(
            zip(corners, first, last, strict=True)
        ):
            weights = _barycentric(triangle, np.arange(x0, x1) + 0.5, np.arange(y0, y1) + 0.5)
            if weights is None:
                continue
            inside = (weights >= 0).all(axis=-1)
            faces[y0:y1, x0:x1][inside] = face
            positions[y0:y1, x0:x1][inside] = 2 * (weights[inside] @ source[face]) - 1
        return cls(positions, faces)

    def sampled(
        self,
        source: NDArray[np.uint8],
        base: NDArray[np.uint8],
        texel_of: Callable[[UvGrid, Positions, tuple[int, int]], Positions],
        stored: Callable[[NDArray[np.float32]], NDArray[np.uint8]],
    ) -> NDArray[np.uint8]:
        """Return a base with bilinear samples of a source where the grid covers it.

        Parameters
        ----------
        source, base : ndarray of uint8, shape (height, width, channels)
            The texture, and what shows elsewhere.
        texel_of : callable
            Turns stored positions into positions in texels of a source of some width and height,
            where 0 is the centre of the first one.
        stored : callable
            Turns values from 0 to 1 into levels.
        """
        if base.shape[:2] != self.faces.shape:
            raise ValueError(f"the grid is for {self.faces.shape}, the base is {base.shape[:2]}")
        # What becomes of the levels of the base, which takes the same way as the samples.
        levels = np.arange(256, dtype=np.float32) / np.float32(255)
        result = stored(levels)[base]
        height, width = source.shape[:2]
        for row in range(0, len(base), _BAND):
            band = slice(row, row + _BAND)
            covered = self.faces[band] >= 0
            at = texel_of(self, self.positions[band][covered], (width, height))
            result[band][covered] = stored(_bilinear(levels, source, at))
        return result


def aligned(grid: UvGrid, stored: Positions, size: tuple[int, int]) -> Positions:
    """Take -1 and 1 for the centres of the first and the last texel, whatever was stored."""
    return (stored + np.float32(1)) * (np.array(size, np.float32) - 1) / np.float32(2)


def exact(grid: UvGrid, stored: Positions, size: tuple[int, int]) -> Positions:
    """Take stored positions for what they are."""
    share = (stored.astype(np.float64) + 1) / 2
    if grid.aligned_size is not None:
        of_file = np.array(grid.aligned_size)
        share = (share * (of_file - 1) + 0.5) / of_file
    return (share * size - 0.5).astype(np.float32)


def linked_faces(
    head: Mesh, body: Mesh, body_of_head: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the faces of a head, and those of a body that have the same corners in the same order.

    Parameters
    ----------
    body_of_head : ndarray of int64, shape (head vertices,)
        The vertex of the body for each of the head, -1 for none.

    Raises
    ------
    Error
        If there are none.
    """
    faces = {corners: face for face, corners in enumerate(map(tuple, body.faces.tolist()))}
    wanted = map(tuple, body_of_head[head.faces].tolist())
    found = [(face, faces[key]) for face, key in enumerate(wanted) if key in faces]
    if not found:
        raise Error("no face of flame_obj is one of smplx_obj under smplx_flame_vertex_ids")
    of_head, of_body = np.array(found, np.int64).T
    return of_head, of_body


def _barycentric(
    triangle: NDArray[Any], x: NDArray[Any], y: NDArray[Any]
) -> NDArray[np.float64] | None:
    """Return the weights of a triangle's corners at each point; None for one without area."""
    origin, along, across = triangle[0], triangle[1] - triangle[0], triangle[2] - triangle[0]
    area = along[0] * across[1] - along[1] * across[0]
    if area == 0:
        return None
    dx, dy = x[None] - origin[0], y[:, None] - origin[1]
    second = (dx * across[1] - dy * across[0]) / area
    third = (dy * along[0] - dx * along[1]) / area
    return np.stack([1 - second - third, second, third], axis=-1)


def _bilinear(
    levels: NDArray[np.float32], source: NDArray[np.uint8], at: Positions
) -> NDArray[np.float32]:
    """Return samples of a texture, whose edge is repeated beyond it."""
    last = np.array(source.shape[1::-1]) - 1
    at = np.clip(at, 0, last.astype(np.float32))
    low = np.floor(at).astype(np.int64)
    (x0, y0), (x1, y1) = low.T, np.minimum(low + 1, last).T
    right, down = (at - low.astype(np.float32)).T[..., None]
    left, up = 1 - right, 1 - down
    # In the order of `grid_sample`: where values are truncated, rounding errors are whole levels.
    result: NDArray[np.float32] = levels[source[y0, x0]] * (left * up)
    result += levels[source[y0, x1]] * (right * up)
    result += levels[source[y1, x0]] * (left * down)
    result += levels[source[y1, x1]] * (right * down)
    return result
