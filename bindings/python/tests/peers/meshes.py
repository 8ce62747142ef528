"""Pairs meshes with themselves: a texture must come back as it was, wherever it is covered."""

import warnings

import numpy as np

import uvgraft
from peers.mesh_readers import layout
from peers.outcome import NOT_COMPARED, REFUSED, REFUSED_BY_ALL, RIGHT, WRONG, Outcome, first_line
from peers.raster import covered

_SIZE_PX = 256
# Of texels from the edges of triangles: 32-bit coordinates are exact to 0.00002 texels here.
_MARGIN_PX = 0.01
# In levels: positions are rounded, and noise is as steep as a texture can be.
_LARGEST = 2
# What uvgraft warns of when parts have images of their own: it links the layout of one.
_LEFT_OUT = "with layouts of their own"
# How far a triangle may leave the unit square, by rounding, and still be in it.
_OUTSIDE = 1e-6


def compare(path, progress=lambda: None):
    """Read a mesh, carry a texture onto itself, and compare layout and texels."""
    try:
        with warnings.catch_warnings(record=True, action="always") as warned:
            mesh = uvgraft.Mesh.load(path)
            carried, sampled, texture = _carried(mesh)
        reason = None
    except (uvgraft.Error, OSError, ValueError) as error:
        reason = first_line(error)
    progress()
    try:
        theirs = layout(path)
    # Whatever it raises, there is nothing to compare with.
    except Exception as error:
        verdict = NOT_COMPARED if reason is None else REFUSED_BY_ALL
        return Outcome(verdict, reason or first_line(error))
    if reason is not None:
        return Outcome(REFUSED if len(theirs.uv) else REFUSED_BY_ALL, reason)
    is_partial = any(_LEFT_OUT in str(warning.message) for warning in warned)
    wrong = _wrong_counts(mesh, theirs) or _wrong_coverage(sampled, theirs.uv, is_partial)
    if wrong:
        return Outcome(WRONG, wrong)
    mask = sampled.mask() > 0
    difference = np.abs(carried[mask].astype(int) - texture[mask])
    largest = int(difference.max(initial=0))
    if largest <= _LARGEST:
        return Outcome(RIGHT, difference=largest)
    count = int((difference.max(1) > _LARGEST).sum())
    return Outcome(WRONG, f"{count} of {mask.sum()} texels are not their own", largest)


def _carried(mesh):
    """Return the texture after the transfer, the sampling map, and the texture."""
    random = np.random.default_rng(1)
    texture = random.integers(0, 256, (_SIZE_PX, _SIZE_PX, 3), np.uint8)
    graft = uvgraft.Graft(uvgraft.Pair(mesh, mesh), size=_SIZE_PX, gutter=0)
    return graft.apply(texture)[..., :3], graft.map(), texture


def _wrong_counts(mesh, theirs):
    if theirs.vertices is not None and len(mesh.positions) != theirs.vertices:
        return f"{len(mesh.positions)} vertices rather than {theirs.vertices}"
    if len(mesh.faces) != len(theirs.uv):
        return f"{len(mesh.faces)} triangles rather than {len(theirs.uv)}"
    return None


def _wrong_coverage(sampled, uv, is_partial):
    """Compare with the texels of triangles in the unit square; others may be covered or not."""
    mask = sampled.mask() > 0
    inside = ((uv >= -_OUTSIDE) & (uv <= 1 + _OUTSIDE)).all((1, 2))
    corners = uv * _SIZE_PX
    missing = covered(corners[inside], *mask.shape, margin_px=_MARGIN_PX) & ~mask
    # Others are moved into the unit square as a whole, or cut where tiles meet.
    outside, low = corners[~inside], np.floor(uv[~inside].min(1, keepdims=True))
    steps = (np.zeros(2), -low, -low - [1, 0], -low - [0, 1], -low - [1, 1])
    around = [corners[inside], *(outside + _SIZE_PX * step for step in steps)]
    extra = mask & ~covered(np.concatenate(around), *mask.shape, margin_px=-_MARGIN_PX)
    # Where islands overlap, one owns the texels of others at its edge, which are its gutter.
    allowed = mask.size if is_partial else sampled.stats["gutter"]
    if missing.sum() > allowed or extra.any():
        return f"{missing.sum()} texels are not covered, {extra.sum()} more than there are"
    return None
