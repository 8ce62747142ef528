"""Compares the silhouettes of models with those of a reader and a rasteriser in NumPy."""

import numpy as np

import uvgraft
from peers import gltf
from peers.outcome import NOT_COMPARED, REFUSED, REFUSED_BY_ALL, RIGHT, WRONG, Outcome, first_line
from peers.raster import covered

# The share of the union on which both must agree, to a pixel. In public suites it is 0.989 or more
# where both read the same, the least for letters a pixel wide; a part that is missing costs more.
_LEAST = 0.98
_SIZE_PX = 256
# From the side and above, so that no axis-aligned face is seen edge-on.
_VIEW = {"azimuth": 25.0, "elevation": 15.0, "fov": 20.0}
# By how much more than the box is framed.
_MARGIN = 1.07


def compare(path, progress=lambda: None):
    """Draw a model and compare the silhouette."""
    try:
        parts = gltf.primitives(path)
        corners = [part.positions[part.faces] for part in parts if len(part.faces)]
        box = _box(corners)
        failure = None
    # Whatever it raises, there is nothing to compare with.
    except Exception as error:
        box, failure = None, first_line(error)
    try:
        ours = _silhouette(path, box)
    except (uvgraft.Error, OSError, ValueError) as error:
        return Outcome(REFUSED_BY_ALL if failure or box is None else REFUSED, first_line(error))
    progress()
    if failure:
        return Outcome(NOT_COMPARED, failure)
    if box is None:
        return Outcome(WRONG, "something is drawn of nothing") if ours.any() else Outcome(RIGHT)
    theirs, unsure = _drawn(parts, box)
    return _overlap(ours & ~unsure, theirs & ~unsure)


def _box(corners):
    """Return two corners of the bounding box, None for nothing."""
    points = (
        np.concatenate([one.reshape(-1, 3) for one in corners]) if corners else np.empty((0, 3))
    )
    points = points[np.isfinite(points).all(1)]
    return np.stack([points.min(0), points.max(0)]) if len(points) else None


def _silhouette(path, box):
    """Return the pixels that uvgraft draws, at least by half."""
    picture = uvgraft.render(
        path,
        size=_SIZE_PX,
        look_at=None if box is None else box.ravel().tolist(),
        background="transparent",
        unlit=True,
        floor=False,
        **_VIEW,
    )
    return picture[..., 3] >= 128


def _drawn(parts, box):
    """Return the pixels that are opaque, and those where only blended or masked materials are."""
    opaque = np.zeros((_SIZE_PX, _SIZE_PX), bool)
    other = opaque.copy()
    for part in parts:
        corners = _projected(part.positions, box)[part.faces]
        if not part.material.get("doubleSided"):
            ab, ac = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
            # Counter-clockwise, with Y down.
            corners = corners[ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0] < 0]
        if part.material.get("alphaMode", "OPAQUE") == "OPAQUE":
            opaque |= covered(corners, _SIZE_PX, _SIZE_PX)
        else:
            # With the pixels at their edges, which are drawn in part.
            other |= covered(corners, _SIZE_PX, _SIZE_PX, margin_px=-1.0)
    return opaque, other & ~opaque


def _projected(points, box):
    """Project points to pixels, with the camera that frames a box as `uvgraft.render` says."""
    azimuth, elevation, fov = np.radians([_VIEW["azimuth"], _VIEW["elevation"], _VIEW["fov"]])
    towards = np.array(
        [
            np.sin(azimuth) * np.cos(elevation),
            np.sin(elevation),
            np.cos(azimuth) * np.cos(elevation),
        ]
    )
    right = np.array([np.cos(azimuth), 0.0, -np.sin(azimuth)])
    axes = np.stack([right, np.cross(towards, right), towards])
    middle, half = box.mean(0), (box[1] - box[0]) / 2
    # The corners of the box in the axes of the camera.
    signs = np.stack(np.meshgrid(*[[-1, 1]] * 3), -1).reshape(-1, 3)
    across, up, near = (signs * half @ axes.T).T
    tangent = np.tan(fov / 2)
    distance = (near + np.maximum(np.abs(across), np.abs(up)) * _MARGIN / tangent).max()
    x, y, depth = ((points - middle) @ axes.T).T
    scale = _SIZE_PX / 2 / tangent / np.maximum(distance - depth, 1e-12)
    return np.stack([_SIZE_PX / 2 + x * scale, _SIZE_PX / 2 - y * scale], 1)


def _overlap(ours, theirs):
    union = (ours | theirs).sum()
    if not union:
        return Outcome(
            NOT_COMPARED, "only blended or masked materials, or nothing, face the camera"
        )
    apart = (ours & ~_grown(theirs)) | (theirs & ~_grown(ours))
    overlap = 1 - float(apart.sum() / union)
    verdict = RIGHT if overlap >= _LEAST else WRONG
    return Outcome(verdict, "" if verdict == RIGHT else f"overlap {overlap:.3f}", 1 - overlap)


def _grown(mask):
    """Return a mask with the eight neighbours of its pixels."""
    padded = np.pad(mask, 1)
    shifted = [padded[1 + y :, 1 + x :] for y in (-1, 0, 1) for x in (-1, 0, 1)]
    height, width = mask.shape
    return np.any([one[:height, :width] for one in shifted], axis=0)
