"""Textures of heads from photographs."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from uvgraft import _notebook
from uvgraft._types import Image, Relight, Size, StrPath
from uvgraft._uvgraft import Mesh, make_selfie


class Selfie(NamedTuple):
    """The texture and the shape of a head from photographs.

    Attributes
    ----------
    texture : ndarray of uint8, shape (height, width, 3)
        The complete texture in the head's layout, in sRGB.
    known : ndarray of uint8, shape (height, width)
        255 where photographs show a texel, 0 where it was mirrored, filled or painted.
    mesh : Mesh
        The head with the fitted shape and a neutral expression, with its own faces and UV
        coordinates.
    cameras : dict
        ``eye_distance`` in the mesh's unit, and ``cameras``, a list with a dict for each
        photograph: ``rotation`` (rows of a 3 x 3 matrix) and ``translation`` (in the mesh's unit)
        from the head's space to the camera's, whose x points to the right, y down and z forwards;
        ``focal_px`` and ``center_px`` in pixels, where the centre of the first pixel is at 0.5;
        ``size``, width and height in pixels; and ``residual_px``, the median distance of the
        landmarks from those of the fitted head.
    report : str
        Figures of the fit, one a line, as ``uvgraft selfie`` prints them.
    sheet : ndarray of uint8, shape (height, width, 3), or None
        A picture of landmarks, fit, coverage and result, if it was requested.
    """

    texture: NDArray[np.uint8]
    known: NDArray[np.uint8]
    mesh: Mesh
    cameras: dict[str, Any]
    report: str
    sheet: NDArray[np.uint8] | None = None

    def _repr_png_(self) -> bytes:
        return _notebook.texture_png(self.texture if self.sheet is None else self.sheet)


def selfie(
    photos: Image | Sequence[Image],
    head: Mesh | StrPath,
    *,
    size: Size = 2048,
    face_number: int | None = None,
    focal: float | str | None = None,
    head_texture: Image | None = None,
    relight: Relight = "soft",
    frames: int | None = None,
    sheet: bool = False,
    threads: int | None = None,
) -> Selfie:
    """Make the texture of a head from photographs of a face, as ``uvgraft selfie`` does.

    The networks that find faces have to be imported once: see ``uvgraft weights --help``.

    Parameters
    ----------
    photos : image or path, or a sequence of these
        Photographs of one person, at most 64, or a folder of frames. An array has no EXIF data: its
        rows are upright, and `focal` should be given if it is known.
    head : Mesh or path
        A mesh with a head and UV coordinates, a body model file, or ``"demo"`` for the built-in
        figure.
    size : int or (int, int)
        Size of the texture: a side in texels, or ``(height, width)``.
    face_number : int, optional
        The face to use where a photograph shows several, 1 for the largest.
    focal : float or str, optional
        Focal length in pixels, or as on 35 mm film, such as ``"28mm"``. By default from EXIF.
    head_texture : image or path, optional
        Usual texture of the head, such as a mean texture. By default, for ``"demo"``, its own.
    relight : {"off", "soft", "full"}
        How much of the light in the photographs is removed.
    frames : int, optional
        Maximum number of frames used of a folder, 1 to 64. By default 9.
    sheet : bool
        Also draw a contact sheet.
    threads : int, optional
        Number of threads, 0 for one per processor; see `set_threads`.

    Returns
    -------
    Selfie
        Texture, mask, shape and cameras.

    Warns
    -----
    UserWarning
        For frames that are left out, and results that may be implausible.

    Raises
    ------
    uvgraft.Error
        For photographs without a usable face, and if the networks were not imported.
    FileNotFoundError
        If a file does not exist.
    """
    texture, known, mesh, cameras, report, drawn = make_selfie(
        {
            "photos": photos,
            "head": head,
            "size": size,
            "face_number": face_number,
            "focal": focal,
            "head_texture": head_texture,
            "relight": relight,
            "frames": frames,
            "sheet": sheet,
            "threads": threads,
        }
    )
    return Selfie(texture, known, mesh, json.loads(cameras), report, drawn)
