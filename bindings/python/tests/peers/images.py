"""Compares images with Pillow, OpenCV, tifffile and OpenEXR.

One that agrees is enough: each has its own gaps.
"""

import numpy as np

import uvgraft
from peers import colors
from peers.image_readers import format_of, is_lossy, readers_of
from peers.outcome import (
    NOT_COMPARED,
    REFUSED,
    REFUSED_BY_ALL,
    RIGHT,
    WRONG,
    Outcome,
    PeerError,
    first_line,
)
from peers.picture import over_alpha, picture

# In levels of 8 bits, the largest and the mean: decoders differ in how they interpolate subsampled
# chroma and round their inverse transforms, by up to 11 levels at edges of 500 photographs.
_LOSSY = (16.0, 1.0)
# In steps from one value to the next: the rounding of colours that were premultiplied, and a whole
# step for other depths and for colours that were converted.
_ROUNDED = 0.5 + 1e-6
_CONVERTED = 1.0 + 1e-6
# Relative to the value, for floats: those of EXR have at least 11 bits, premultiplying costs one.
_RELATIVE = 1e-3
# The same of most values where chroma has half the resolution: interpolations of photographs differ
# by 0.1 to 0.7 % in the median, and by more at edges.
_INTERPOLATED = 1e-2


def compare(path, progress=lambda: None):
    """Read an image and compare it with what others read."""
    try:
        ours = picture(uvgraft.read_image(path))
    except (uvgraft.Error, OSError, ValueError) as error:
        ours, reason = None, first_line(error)
    progress()
    data = path.read_bytes()
    name = format_of(data)
    theirs, failures = _read_by_peers(path, name)
    if ours is None:
        return Outcome(REFUSED if theirs else REFUSED_BY_ALL, reason)
    if not theirs:
        return Outcome(WRONG, f"read by uvgraft alone; {'; '.join(failures)}")
    try:
        theirs = _in_srgb(theirs, name, data)
    except PeerError as error:
        return Outcome(NOT_COMPARED, first_line(error))
    lossy = is_lossy(path, name)
    found = [(*_distance(ours, one, name, lossy, data), who) for who, one in theirs]
    excess, difference, words, who = min(found)
    if excess <= 0:
        return Outcome(RIGHT, difference=difference)
    return Outcome(WRONG, f"{words} from {who}, the closest of {len(found)}", difference)


def _read_by_peers(path, name):
    """Return the pictures of all that can read a file, and the reasons of those that cannot."""
    pictures, failures = [], []
    for read in readers_of(name):
        try:
            pictures += [(read.__name__, one) for one in read(path)]
        # Whatever a library raises, it does not read this file.
        except Exception as error:
            failures.append(f"{read.__name__}: {first_line(error)}")
    return pictures, failures


def _in_srgb(theirs, name, data):
    """Convert the colours of a PNG file that states another space."""
    if name != "png":
        return theirs
    return [(who, one._replace(values=colors.srgb_of_png(one.values, data))) for who, one in theirs]


def _distance(ours, theirs, name, lossy, data):
    """Return what a difference exceeds the limits by, the difference itself, and words."""
    if ours.values.shape != theirs.values.shape:
        sizes = [f"{one.values.shape[1]}x{one.values.shape[0]}" for one in (ours, theirs)]
        return np.inf, np.inf, f"{sizes[0]} rather than {sizes[1]}"
    if ours.step == 0:
        return _float_distance(ours.values, theirs.values, lossy)
    difference = 255 * np.abs(ours.values - theirs.values)
    if name == "webp":
        # Whatever colours are where nothing is seen: an animation has none there.
        difference[theirs.values[..., 3] == 0, :3] = 0
    largest, mean = float(difference.max()), float(difference.mean())
    limits = _LOSSY if lossy else _limits(ours, theirs, name, data)
    excess = max(largest - limits[0], mean - limits[1])
    return excess, largest, f"{largest:.3g} levels at most, {mean:.3g} on average"


def _limits(ours, theirs, name, data):
    """Return the largest and the mean difference that is allowed, in levels of 8 bits."""
    converted = ours.step != theirs.step or (name == "png" and colors.of_png(data) is not None)
    # Some readers undo premultiplied alpha by themselves, and round in their own way.
    converted |= name == "tiff" and bool((theirs.values[..., 3] < 1).any())
    steps = _CONVERTED if converted else _ROUNDED
    # Values of fewer bits than 8 are values of 8 bits.
    return 255 * steps * max(ours.step, min(theirs.step, 1 / 255)), np.inf


def _float_distance(ours, theirs, lossy):
    """Compare floats relative to their size, weighted by alpha; others must be equal."""
    ours, theirs = over_alpha(ours), over_alpha(theirs)
    odd = ~np.isfinite(theirs) | ~np.isfinite(ours)
    if not np.array_equal(ours[odd], theirs[odd], equal_nan=True):
        return np.inf, np.inf, "values that are not finite differ"
    difference = np.abs(ours - theirs)[~odd] / np.maximum(np.abs(theirs[~odd]), 1e-2)
    if lossy:
        median = float(np.median(difference))
        return median - _INTERPOLATED, median, f"{median:.3g} relative to the value in the median"
    largest = float(difference.max(initial=0))
    return largest - _RELATIVE, largest, f"{largest:.3g} relative to the value"
