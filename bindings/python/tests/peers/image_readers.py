"""Independent readers of images: Pillow, OpenCV, tifffile and OpenEXR.

Each returns the pictures that a file may stand for, most often one, or raises.
"""

import contextlib
import os
import warnings

# Read when OpenCV is imported.
os.environ.setdefault("OPENCV_IO_ENABLE_OPENEXR", "1")
os.environ.setdefault("OPENCV_LOG_LEVEL", "SILENT")

import cv2
import numpy as np
import OpenEXR
import PIL.Image
import PIL.ImageOps
import tifffile

from peers import colors
from peers.outcome import PeerError
from peers.picture import Picture, picture, turned

_ORIENTATION = 274


def format_of(data):
    """Detect a format from how a file begins."""
    starts = {
        b"\x89PNG\r\n\x1a\n": "png",
        b"\xff\xd8": "jpeg",
        b"II*\0": "tiff",
        b"MM\0*": "tiff",
        b"II+\0": "tiff",
        b"MM\0+": "tiff",
        b"\x76\x2f\x31\x01": "exr",
    }
    if data[:4] == b"RIFF" and data[8:12] == b"WEBP":
        return "webp"
    return next((name for start, name in starts.items() if data.startswith(start)), "unknown")


def readers_of(name):
    """Return the readers of a format."""
    return {"tiff": (pillow, tiff, opencv), "exr": (exr,)}.get(name, (pillow, opencv))


def is_lossy(path, name):
    """Whether decoders may differ by what they make of waves or of colour differences."""
    if name == "tiff":
        try:
            with tifffile.TiffFile(path) as file:
                page = file.pages.first
                names = [getattr(it, "name", "") for it in (page.compression, page.photometric)]
                return "JPEG" in names[0] or names[1] == "YCBCR"
        # What is wrong with it, readers say.
        except Exception:
            return False
    if name == "exr":
        # Chroma of half the resolution is interpolated in many ways.
        with contextlib.suppress(Exception):
            channels = OpenEXR.File(os.fspath(path), separate_channels=True).channels().values()
            return any(channel.xSampling > 1 for channel in channels)
        return False
    # The chunk of a lossy image, in an animation behind further headers.
    return name == "jpeg" or (name == "webp" and b"VP8 " in path.read_bytes())


def pillow(path):
    """Read with Pillow, which says what colours mean by modes."""
    PIL.Image.MAX_IMAGE_PIXELS = None
    with warnings.catch_warnings(action="ignore"), PIL.Image.open(path) as opened:
        image = PIL.ImageOps.exif_transpose(opened)
    mode = image.mode
    clear = image.info.get("transparency")
    if mode in ("P", "PA"):
        image = image.convert("RGBA" if clear is not None or mode == "PA" else "RGB")
    elif mode in ("1", "YCbCr"):
        image = image.convert("L" if mode == "1" else "RGB")
    elif mode in ("L", "RGB") and clear is not None:
        image = image.convert("LA" if mode == "L" else "RGBA")
    elif mode in ("La", "RGBa"):
        return [picture(np.asarray(image), premultiplied=True)]
    elif mode.startswith("I"):
        array = np.asarray(image)
        if array.dtype.kind == "i":
            array = array.astype(
                np.uint32 if array.min() >= 0 and array.max() > 65535 else np.uint16
            )
        if isinstance(clear, int):
            array = np.stack([array, np.where(array == clear, 0, 65535).astype(array.dtype)], 2)
        return [picture(array)]
    elif mode not in ("L", "LA", "RGB", "RGBA", "F"):
        raise PeerError(f"Pillow has it as {mode}")
    return [picture(np.asarray(image))]


def opencv(path):
    """Read with OpenCV, which leaves orientation to its callers here."""
    array = cv2.imdecode(np.fromfile(path, np.uint8), cv2.IMREAD_UNCHANGED)
    if array is None:
        raise PeerError("OpenCV cannot read it")
    if array.ndim == 3 and array.shape[2] >= 3:
        array = array[..., [2, 1, 0, 3][: array.shape[2]]]
    return [picture(turned(array, _orientation(path)))]


def _orientation(path):
    """Return the EXIF orientation of a file, 1 if it states none that can be read."""
    try:
        with warnings.catch_warnings(action="ignore"), PIL.Image.open(path) as opened:
            return opened.getexif().get(_ORIENTATION, 1)
    except Exception:
        return 1


def tiff(path):
    """Read the first page with tifffile and imagecodecs, and do what its tags say of samples."""
    with tifffile.TiffFile(path) as file:
        page = file.pages.first
        array = page.asarray()
        if page.planarconfig == 2 and page.samplesperpixel > 1:
            array = np.moveaxis(array, 0, -1)
        tag = page.tags.get(_ORIENTATION)
        array = turned(
            array.reshape(page.imagelength, page.imagewidth, -1), tag.value if tag else 1
        )
        return list(_by_photometric(page, array))


def _by_photometric(page, array):
    kind = page.photometric.name
    bits = page.bitspersample
    bits = min(bits) if isinstance(bits, tuple) else bits
    if array.dtype.kind not in "uf" and array.dtype != bool:
        raise PeerError(f"tifffile has it as {array.dtype}")
    if kind == "PALETTE":
        yield picture(np.moveaxis(page.colormap[:, array[..., 0].astype(int)], 0, -1))
        return
    if kind not in ("MINISWHITE", "MINISBLACK", "RGB", "YCBCR"):
        raise PeerError(f"tifffile has it as {kind}")
    if kind == "YCBCR" and getattr(page.compression, "name", "") not in ("JPEG", "OJPEG"):
        array = _rgb_from_ycbcr(array)
    colors_in = 3 if kind in ("RGB", "YCBCR") else 1
    values, step = picture(array[..., :colors_in], bits)
    if kind == "MINISWHITE":
        values[..., :3] = 1 - values[..., :3]
    extras = tuple(page.extrasamples)
    if not extras or extras[0] == 0 or array.shape[2] <= colors_in:
        yield Picture(values, step)
    if extras and array.shape[2] > colors_in:
        alpha = picture(array[..., colors_in], bits).values[..., :1]
        color = values[..., :3]
        if extras[0] == 1:
            color = np.divide(color, alpha, out=color.copy(), where=alpha != 0)
        yield Picture(np.concatenate([color, alpha], 2), step)


def _rgb_from_ycbcr(array):
    """Convert by the coefficients of BT.601, which TIFF has if it states none."""
    y, cb, cr = np.moveaxis(array[..., :3].astype(float), -1, 0)
    red, blue = y + 1.402 * (cr - 128), y + 1.772 * (cb - 128)
    green = (y - 0.299 * red - 0.114 * blue) / 0.587
    return np.clip(np.rint(np.stack([red, green, blue], 2)), 0, 255).astype(np.uint8)


def exr(path):
    """Read the first part with OpenEXR: linear BT.709, in the display window."""
    part = OpenEXR.File(os.fspath(path), separate_channels=True).parts[0]
    header, channels = part.header, part.channels
    if "deep" in str(header.get("type", "")).lower():
        raise PeerError("deep data")
    stated = header.get("chromaticities")
    stated = colors.BT709 if stated is None else np.reshape(stated, (4, 2))
    plane = {name: _plane(channel) for name, channel in channels.items()}
    if {"R", "G", "B"} <= plane.keys():
        color = np.stack([plane[name] for name in "RGB"], 2)
    elif {"Y", "RY", "BY"} <= plane.keys():
        color = colors.rgb_from_luminance_chroma(plane["Y"], plane["RY"], plane["BY"], stated)
    elif "Y" in plane or len(plane) == 1:
        color = np.repeat(plane.get("Y", next(iter(plane.values())))[..., None], 3, 2)
        stated = colors.BT709
    else:
        raise PeerError(f"OpenEXR has the channels {', '.join(plane)}")
    alpha = plane["A"] if "A" in plane and len(plane) > 1 else np.ones(color.shape[:2])
    if np.abs(stated - colors.BT709).max() > 1e-4:
        # XYZ states colours, not parts of its formal white.
        is_xyz = np.abs(stated[:3] - [[1, 0], [0, 1], [0, 0]]).max() < 1e-3
        neutral = header.get("adoptedNeutral", colors.BT709[3] if is_xyz else None)
        color = color @ colors.bt709_from(stated, neutral).T
    color = np.divide(color, alpha[..., None], out=color.copy(), where=alpha[..., None] != 0)
    values = np.concatenate([color, alpha[..., None]], 2)
    return [Picture(_in_display_window(values, header, "A" in plane), 0.0)]


def _plane(channel):
    """Return a channel as `(h, w)` of float64, that of a subsampled one interpolated."""
    values = np.asarray(channel.pixels)
    if values.dtype.kind != "f":
        raise PeerError("whole numbers")
    across, down = channel.xSampling, channel.ySampling
    return _stretched(_stretched(values.astype(float), down).T, across).T


def _stretched(rows, times):
    """Put rows between rows, by linear interpolation; the last one is repeated."""
    if times == 1:
        return rows
    at = np.minimum(np.arange(len(rows) * times) / times, len(rows) - 1)
    below = np.floor(at).astype(int)
    above = np.minimum(below + 1, len(rows) - 1)
    share = (at - below)[:, None]
    return (1 - share) * rows[below] + share * rows[above]


def _in_display_window(values, header, has_alpha):
    """Place the data window in the display window; the rest is black, or clear."""
    (left, top), (right, bottom) = (np.array(corner, int) for corner in header["displayWindow"])
    (x, y), _ = header["dataWindow"]
    shown = np.zeros((bottom - top + 1, right - left + 1, 4))
    shown[..., 3] = 0.0 if has_alpha else 1.0
    x, y = int(x) - left, int(y) - top
    inside = values[max(-y, 0) :, max(-x, 0) :]
    place = shown[max(y, 0) :, max(x, 0) :]
    height, width = (min(pair) for pair in zip(inside.shape[:2], place.shape[:2], strict=True))
    place[:height, :width] = inside[:height, :width]
    return shown
