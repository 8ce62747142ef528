"""Pictures of any reader in one form, and how far two are apart."""

from typing import NamedTuple

import numpy as np

_OPAQUE = 1.0


class Picture(NamedTuple):
    """An upright picture.

    `values` is `(h, w, 4)` of float64, RGBA with 1.0 for white, alpha not premultiplied. `step` is
    that from one value to the next, 0 for floats.
    """

    values: np.ndarray
    step: float


def picture(array, bits=None, premultiplied=False):
    """Make a picture of an array: grey, grey and alpha, RGB or RGBA, of whole numbers or floats."""
    array = np.asarray(array)
    array = array[..., None] if array.ndim == 2 else array
    step = 0.0
    if array.dtype == bool:
        step = 1.0
    elif array.dtype.kind == "u":
        step = 1 / (2 ** (bits or 8 * array.dtype.itemsize) - 1)
    values = array.astype(np.float64) * (step or 1.0)
    count = values.shape[2]
    color = values[..., :3] if count > 2 else np.repeat(values[..., :1], 3, 2)
    alpha = values[..., -1:] if count in (2, 4) else np.full_like(values[..., :1], _OPAQUE)
    if premultiplied:
        color = np.divide(color, alpha, out=color.copy(), where=alpha != 0)
    return Picture(np.concatenate([color, alpha], 2), step)


def turned(array, orientation):
    """Turn an array upright, by the EXIF orientation of its file."""
    if orientation in (5, 6, 7, 8):
        array = array.swapaxes(0, 1)
    if orientation in (2, 3, 6, 7):
        array = array[:, ::-1]
    if orientation in (3, 4, 7, 8):
        array = array[::-1]
    return array


def over_alpha(values):
    """Multiply colours by alpha where it is not 0: those of low alpha are uncertain."""
    alpha = values[..., 3:]
    return np.concatenate([values[..., :3] * np.where(alpha == 0, 1, alpha), alpha], 2)
