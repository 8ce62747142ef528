"""A curved sheet in two layouts: enough triangles for every texel to tell where it is from."""

import numpy as np

import uvgraft

# The sheet fills the square between these in the layout of the source.
LOW, HIGH = 0.06, 0.94


def sheet_arrays(cells=6):
    """Return positions (n, 3), faces (m, 3) and both layouts (n, 2), from the top left."""
    side = np.linspace(0, 1, cells + 1)
    u, v = np.meshgrid(side, side)
    flat = np.stack([u.ravel(), v.ravel()], 1)
    positions = np.c_[flat, 0.2 * np.sin(3 * flat[:, 0])]
    corner = np.arange(cells * (cells + 1)).reshape(cells, cells + 1)[:, :-1].ravel()
    below = corner + cells + 1
    faces = np.r_[np.c_[corner, corner + 1, below], np.c_[corner + 1, below + 1, below]]
    source = LOW + (HIGH - LOW) * flat
    turned = (flat - 0.5) @ np.array([[0.55, 0.35], [-0.35, 0.55]])
    target = 0.5 + turned + 0.03 * np.sin(7 * flat[:, ::-1])
    return positions, faces, source, target


def sheets(cells=6):
    """Pair the sheet with itself in the other layout."""
    positions, faces, source, target = sheet_arrays(cells)
    meshes = [
        uvgraft.Mesh(positions, faces, uv, uv_origin="top-left", name=name)
        for uv, name in ((source, "flat"), (target, "turned"))
    ]
    return uvgraft.Pair(*meshes, vertex_map=range(len(positions)))
