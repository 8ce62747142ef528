"""Colour that files state themselves, by the published formulas, as linear BT.709 or sRGB.

- PNG, third edition: cICP comes before iCCP, that before sRGB, that before gAMA and cHRM.
- Primaries as matrices: SMPTE RP 177-1993. White points are adapted by Bradford's matrix
  (ICC.1:2022, annex E).
- PQ: SMPTE ST 2084, with the diffuse white of ITU-R BT.2408.
"""

import struct

import numpy as np

from peers.outcome import PeerError

# x, y of red, green, blue and white.
BT709 = np.array([[0.64, 0.33], [0.30, 0.60], [0.15, 0.06], [0.3127, 0.3290]])
_BRADFORD = np.array(
    [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]]
)
# What sRGB is written as by programs, 45455, and its neighbours.
_SRGB_GAMMAS = (0.45, 0.459)
# Of ITU-T H.273: colour primaries, and the transfer characteristics that are compared.
_CICP_PRIMARIES = {
    1: BT709,
    9: np.array([[0.708, 0.292], [0.170, 0.797], [0.131, 0.046], [0.3127, 0.3290]]),
    12: np.array([[0.680, 0.320], [0.265, 0.690], [0.150, 0.060], [0.3127, 0.3290]]),
}
_LINEAR, _SRGB, _PQ = 8, 13, 16
# Diffuse white in HDR, of 10,000 cd/m2 in all: BT.2408.
_PQ_WHITE = 203 / 10_000
# Coordinates in PNG have five decimals, and programs round sRGB's in different ways.
_PRIMARIES_SLACK = 0.002


def xyz_from(chromaticities):
    """Return the matrix from linear RGB to XYZ, for a white of luminance 1."""
    xy = np.asarray(chromaticities, float)
    xyz = np.c_[xy, 1 - xy.sum(1)].T
    primaries, white = xyz[:, :3], xyz[:, 3] / xy[3, 1]
    return primaries * np.linalg.solve(primaries, white)


def bt709_from(chromaticities, neutral=None):
    """Return the matrix to linear BT.709, with the white point adapted.

    - `neutral`: `(2,)`, the chromaticity that becomes white instead of that of the primaries.
    """
    source, target = xyz_from(chromaticities), xyz_from(BT709)
    x, y = np.asarray(chromaticities, float)[3] if neutral is None else neutral
    whites = [np.array([x / y, 1, (1 - x - y) / y]), target.sum(1)]
    cones = [_BRADFORD @ white for white in whites]
    adapted = np.linalg.inv(_BRADFORD) @ np.diag(cones[1] / cones[0]) @ _BRADFORD
    return np.linalg.inv(target) @ adapted @ source


def srgb_from_linear(values):
    """Encode linear light by the curve of IEC 61966-2-1."""
    values = np.clip(values, 0, 1)
    return np.where(values <= 0.0031308, 12.92 * values, 1.055 * values ** (1 / 2.4) - 0.055)


def linear_from_srgb(values):
    """Decode by the curve of IEC 61966-2-1."""
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


def png_chunks(data):
    """Return the first chunk of each kind in a PNG file."""
    chunks, at = {}, 8
    while at + 8 <= len(data):
        (length,) = struct.unpack(">I", data[at : at + 4])
        chunks.setdefault(data[at + 4 : at + 8], data[at + 8 : at + 8 + length])
        at += 12 + length
    return chunks


def of_png(data):
    """Return decoding to linear light and matrix to BT.709 of a PNG file, None if it is sRGB."""
    chunks = png_chunks(data)
    if b"cICP" in chunks:
        return _of_code_points(chunks[b"cICP"])
    if b"iCCP" in chunks or b"sRGB" in chunks or b"gAMA" not in chunks:
        return None
    gamma = struct.unpack(">I", chunks[b"gAMA"][:4])[0] / 1e5
    if gamma == 0:
        return None
    is_srgb = _SRGB_GAMMAS[0] <= gamma <= _SRGB_GAMMAS[1]
    matrix = np.eye(3)
    if b"cHRM" in chunks:
        white, *primaries = np.array(struct.unpack(">8I", chunks[b"cHRM"][:32])).reshape(4, 2) / 1e5
        stated = np.array([*primaries, white])
        if np.abs(stated - BT709).max() > _PRIMARIES_SLACK and stated[:, 1].min() > 0:
            matrix = bt709_from(stated)
    if is_srgb and (matrix == np.eye(3)).all():
        return None
    return linear_from_srgb if is_srgb else lambda values: values ** (1 / gamma), matrix


def _of_code_points(chunk):
    primaries, transfer, _, is_full = chunk[:4]
    curves = {_LINEAR: lambda values: values, _SRGB: linear_from_srgb, _PQ: linear_from_pq}
    if primaries not in _CICP_PRIMARIES or transfer not in curves or not is_full:
        raise PeerError(f"cICP {list(chunk)} is not compared")
    if (primaries, transfer) == (1, _SRGB):
        return None
    return curves[transfer], bt709_from(_CICP_PRIMARIES[primaries])


def linear_from_pq(values):
    """Decode by SMPTE ST 2084, with diffuse white as 1."""
    root = values ** (32 / 2523)
    light = np.maximum(root - 107 / 128, 0) / (2413 / 128 - 2392 / 128 * root)
    return light ** (8192 / 1305) / _PQ_WHITE


def srgb_of_png(values, data):
    """Convert the encoded colours of a PNG file, `(h, w, 4)` from 0 to 1, to sRGB."""
    space = of_png(data)
    if space is None:
        return values
    decode, matrix = space
    color = srgb_from_linear(decode(values[..., :3]) @ matrix.T)
    return np.concatenate([color, values[..., 3:]], 2)


def rgb_from_luminance_chroma(y, ry, by, chromaticities):
    """Undo the luminance and chroma of OpenEXR: RY = (R - Y) / Y, BY = (B - Y) / Y."""
    weights = xyz_from(chromaticities)[1]
    red, blue = (ry + 1) * y, (by + 1) * y
    green = (y - red * weights[0] - blue * weights[2]) / weights[1]
    return np.stack([red, green, blue], 2)
