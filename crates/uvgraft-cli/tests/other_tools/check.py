"""Applies exported maps with SciPy, grid_sample and OpenCV, and compares with uvgraft's results.

check.py FOLDER

The folder holds the files that tests/other_tools.rs makes. Differences are in levels of 8 bits. Prints
what was compared; fails on the first comparison that does not hold.
"""

import sys
from pathlib import Path

import cv2
import numpy as np
import OpenEXR
import scipy.sparse

try:
    import torch
except ImportError:
    torch = None

folder = Path(sys.argv[1])


def image(name):
    found = cv2.imread(str(folder / name), cv2.IMREAD_UNCHANGED)
    assert found is not None, name
    # RGB with or without alpha instead of BGR.
    return found[..., [2, 1, 0, 3][: found.shape[2]]]


def compare(what, found, wanted, most):
    difference = np.abs(found.astype(np.float64) - wanted)
    excess = (difference - most).max()
    print(f"{what}: greatest difference {difference.max():.3f} of {difference.size} values")
    assert difference.size > 10_000, what
    assert excess <= 0, f"{what}: {excess} beyond what is allowed"


def grid_sample(texture, grid, align_corners):
    """PyTorch's `grid_sample`, bilinear, with zeros outside: `[H, W, C]` and `[h, w, 2]`, in 64 bits.
    With `align_corners`, -1 and 1 are the centres of the first and the last texel, else the edges."""
    if torch is not None:
        image = torch.from_numpy(texture.astype(np.float32)).permute(2, 0, 1)[None]
        positions = torch.from_numpy(grid.astype(np.float32))[None]
        sampled = torch.nn.functional.grid_sample(
            image, positions, mode="bilinear", align_corners=align_corners
        )
        return sampled[0].permute(1, 2, 0).numpy()
    size = np.array(texture.shape[1::-1])
    grid = grid.astype(np.float64)
    at = (grid + 1) / 2 * (size - 1) if align_corners else ((grid + 1) * size - 1) / 2
    first = np.floor(at).astype(int)
    total = 0.0
    for dx, dy in np.ndindex(2, 2):
        texel = first + [dx, dy]
        weight = np.prod(1 - np.abs(at - texel), axis=-1)
        weight = np.where(((texel >= 0) & (texel < size)).all(-1), weight, 0)
        x, y = np.moveaxis(np.clip(texel, 0, size - 1), -1, 0)
        total = total + weight[..., None] * texture[y, x]
    return total


def reference(npz, source, base):
    """The part of the reference implementation (arXiv 2508.19518) that applies a map: it loads both
    arrays, samples with aligned corners and keeps the base where no face is."""
    loaded = np.load(folder / npz)
    uv_grid, pix_to_face = loaded["uv_grid"], loaded["pix_to_face"]
    assert uv_grid.dtype == np.float32 and pix_to_face.dtype == np.int64
    assert uv_grid.shape == (1, *base.shape[:2], 2) and pix_to_face.shape == base.shape[:2]
    sampled = grid_sample(source, uv_grid[0], align_corners=True)
    mask = (pix_to_face.astype(np.float32) >= 0).astype(np.float32)[..., None]
    return sampled * mask + base * (1 - mask)


# The transfer as a matrix.
source, transfer = image("face.png"), image("transfer.png")
matrix = scipy.sparse.load_npz(folder / "h.csr.npz")
assert matrix.format == "csr" and matrix.dtype == np.float32 and matrix.indices.dtype == np.int32
assert matrix.has_canonical_format
colors = matrix @ source.reshape(-1, 3).astype(np.float32)
colors = np.clip(colors, 0, 255).reshape(*transfer.shape[:2], 3)
reached = np.diff(matrix.indptr).reshape(transfer.shape[:2]) > 0
assert (reached == (transfer[..., 3] > 0)).all()
compare("scipy, matrix against transfer", colors[reached], transfer[reached][:, :3], 1.0)

# Positions, against our own bilinear filter on the padded source.
padded, ours = image("padded.png"), image("one_sample.png")
single = np.load(folder / "single.npz")["single"].astype(bool)
wanted = ours[single][:, :3].astype(np.float64)
# The result is rounded to levels.
most = 1.0
grid = np.load(folder / "grid.npy")
covered = ~np.isnan(grid[..., 0])
assert (covered == (ours[..., 3] > 0)).all() and not (single & ~covered).any()
size = np.array(padded.shape[1::-1])
# At the edge of a texture we repeat its texels, where grid_sample takes zeros.
inside = (np.nan_to_num(grid) * size >= 0.5).all(-1) & (np.nan_to_num(grid) * size <= size - 0.5).all(-1)
inside = inside[single]
sampled = grid_sample(padded, np.nan_to_num(2 * grid - 1, nan=-2), align_corners=False)
compare("grid_sample, grid.npy", sampled[single][inside], wanted[inside], most)

base = np.zeros((*grid.shape[:2], 3), np.uint8)
exact = reference("exact.npz", padded, base)
compare("reference implementation, exact convention", exact[single][inside], wanted[inside], most)
assert (exact[~covered] == 0).all()
off = reference("reference.npz", padded, base)
# Its own convention is half a texel off at the edges of the texture, and exact at its centre.
shift = 0.5 * np.abs(2 * grid[single] - 1)
print(f"reference implementation, own convention: off by {shift.mean():.2f} texels on average")
assert np.abs(off[single] - wanted).mean() > 2 * np.abs(exact[single] - wanted).mean()


def spread(x, y):
    """The difference between the greatest and the least texel around positions."""
    near = [np.rint(axis).astype(np.float32) for axis in (x, y)]
    edges = {"borderMode": cv2.BORDER_REPLICATE}
    high, low = (
        cv2.remap(operation(padded, np.ones((3, 3), np.uint8)), *near, cv2.INTER_NEAREST, **edges)
        for operation in (cv2.dilate, cv2.erode)
    )
    return high.astype(np.float64) - low


def remapped(what, x, y):
    x, y = x.astype(np.float32), y.astype(np.float32)
    found = cv2.remap(padded, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    # OpenCV 4 rounds positions to 1/32 texel: by up to 1/64 on each axis, along which a value changes by
    # no more than the spread per texel.
    allowed = most + 2 / 64 * spread(x, y)
    compare(f"cv2.remap, {what}", found[single], wanted, allowed[single])


remapped("grid.npy", *(np.nan_to_num(grid[..., k] * size[k] - 0.5, nan=-100) for k in (0, 1)))

# The ST map, as a compositor applies it: rows from the bottom, and texels opaque where alpha is 1.
with OpenEXR.File(str(folder / "st.exr"), separate_channels=True) as file:
    channels = {name: channel.pixels for name, channel in file.channels().items()}
assert sorted(channels) == ["A", "B", "G", "R"]
assert all(channel.dtype == np.float32 for channel in channels.values())
assert (channels["A"] == covered).all() and (channels["B"] == covered).all()
assert (channels["R"][~covered] == 0).all() and (channels["G"][~covered] == 0).all()
remapped("st.exr", channels["R"] * size[0] - 0.5, (1 - channels["G"]) * size[1] - 0.5)
upward = np.stack([channels["R"], channels["G"]], -1)[::-1]
sampled = grid_sample(padded[::-1], 2 * upward - 1, align_corners=False)[::-1]
compare("grid_sample, st.exr from the bottom", sampled[single][inside], wanted[inside], most)
