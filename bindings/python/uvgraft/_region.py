"""Regions of the surface that a pair links."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

Side = Literal["source", "target"]


class Region:
    """A part of the linked surface.

    A region belongs to no pair: it is a recipe, which `Graft` follows on the surface of its own
    pair. Regions combine with ``|`` (union), ``&`` (intersection) and ``-`` (difference).

    Examples
    --------
    >>> face = Region.vertices([0, 1, 2]) - Region.vertices([2])
    >>> face.grown(0.005)
    <uvgraft.Region: length>
    """

    __slots__ = ("_recipe",)

    def __init__(self) -> None:
        """Make the region of everything that is linked."""
        self._recipe: tuple[Any, ...] = ("linked",)

    @classmethod
    def _of(cls, *recipe: Any) -> Region:
        region = cls()
        region._recipe = recipe
        return region

    @classmethod
    def vertices(cls, ids: ArrayLike, *, side: Side = "source") -> Region:
        """Triangles all of whose vertices are listed.

        Parameters
        ----------
        ids : array_like of int, shape (n,)
            Indices of vertices.
        side : {"source", "target"}
            The mesh that they are vertices of.
        """
        values = np.asarray(ids)
        if values.size and values.dtype.kind not in "iu":
            raise TypeError(f"ids must be vertex indices, got dtype {values.dtype}")
        return cls._of("vertices", side, values.astype(np.int64).reshape(-1))

    @classmethod
    def mask(cls, image: Any, *, side: Side = "source") -> Region:
        """Where an image in a layout is white.

        Parameters
        ----------
        image : ndarray, PIL image or path
            White is inside; a boolean array will do.
        side : {"source", "target"}
            The mesh in whose layout it is painted.
        """
        return cls._of("mask", side, image)

    def grown(self, length: float | None = None, *, rings: int | None = None) -> Region:
        """Grow the region along the surface, or shrink it if negative.

        Parameters
        ----------
        length : float, optional
            A distance in the target mesh's unit, less than the size of the region or of what is
            around it.
        rings : int, optional
            A number of rings of triangles, in place of a length.
        """
        if (length is None) == (rings is None):
            raise TypeError("grown() takes either a length or rings")
        if rings is not None:
            return self._of("rings", self._recipe, int(rings))
        return self._of("length", self._recipe, float(length or 0.0))

    def __or__(self, other: Region) -> Region:
        """Unite two regions."""
        return self._with("union", other)

    def __and__(self, other: Region) -> Region:
        """Intersect two regions."""
        return self._with("intersection", other)

    def __sub__(self, other: Region) -> Region:
        """Take another region away."""
        return self._with("difference", other)

    def _with(self, how: str, other: Region) -> Region:
        if not isinstance(other, Region):
            return NotImplemented
        return self._of(how, self._recipe, other._recipe)

    def __repr__(self) -> str:
        """Name the last step of the recipe."""
        return f"<uvgraft.Region: {self._recipe[0]}>"
