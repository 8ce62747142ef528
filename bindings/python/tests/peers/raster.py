"""Which pixels triangles cover, without depth."""

import numpy as np

# Pixels that are tested at a time: a megabyte for each array, which stays in the cache.
_AT_A_TIME = 1 << 17


def covered(corners, height, width, margin_px=0.0):
    """Return the pixels whose centres are inside any triangle: bool, `(height, width)`.

    `corners` is `(m, 3, 2)`, x and y from the top left in pixels. Centres must be further inside
    than `margin_px`; if that is negative, they may be outside by as much.
    """
    mask = np.zeros((height, width), bool)
    corners = corners[np.isfinite(corners).all((1, 2))]
    # Nothing beyond this can be seen, and pixel numbers stay small.
    corners = np.clip(corners, -1e6, 1e6)
    low = np.floor(corners.min(1) - max(-margin_px, 0) - 0.5).astype(int)
    high = np.ceil(corners.max(1) + max(-margin_px, 0) - 0.5).astype(int)
    low, high = np.maximum(low, 0), np.minimum(high, [width - 1, height - 1])
    sides = (high - low + 1).max(1)
    visible = (high >= low).all(1)
    side = 1
    while visible.any():
        now = visible & (sides <= side)
        for chunk in np.array_split(np.flatnonzero(now), now.sum() * side * side // _AT_A_TIME + 1):
            _cover(mask, corners[chunk], low[chunk], side, margin_px)
        visible &= ~now
        side *= 2
    return mask


def _cover(mask, corners, low, side, margin_px):
    """Test squares of pixels, one for each triangle, that start at `low`."""
    if not len(corners):
        return
    steps = np.arange(side)
    x = low[:, 0, None, None] + steps[None, None, :]
    y = low[:, 1, None, None] + steps[None, :, None]
    edges = np.roll(corners, -1, 1) - corners
    area = edges[:, 0, 0] * edges[:, 1, 1] - edges[:, 0, 1] * edges[:, 1, 0]
    inside = np.broadcast_to((area != 0)[:, None, None], (len(corners), side, side)).copy()
    # Along each edge with the inside on the right, of length 1.
    edges *= (np.sign(area)[:, None] / np.maximum(np.linalg.norm(edges, axis=2), 1e-30))[..., None]
    for corner in range(3):
        start = corners[:, corner, :, None, None]
        along = edges[:, corner, :, None, None]
        from_edge = along[:, 0] * (y + 0.5 - start[:, 1]) - along[:, 1] * (x + 0.5 - start[:, 0])
        inside &= from_edge >= margin_px
    inside &= (x < mask.shape[1]) & (y < mask.shape[0])
    triangle, rows, columns = np.nonzero(inside)
    mask[low[triangle, 1] + rows, low[triangle, 0] + columns] = True
