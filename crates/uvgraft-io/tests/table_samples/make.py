"""Makes the samples in this folder. Run once with each Python, from this folder:

    python2.7 make.py    # with numpy 1.16, scipy 1.2
    python3.6 make.py    # with numpy 1.19, scipy 1.5
    python3.10 make.py   # with numpy 1.26, scipy 1.11
    python3.11 make.py   # with numpy 2.4, scipy 1.17

All values are invented: a mesh of 4 vertices, and a square of 12x12 texels with two triangles. The tests read the
files and need no Python.
"""

import pickle
import sys

import numpy as np
from scipy import sparse


def matrix():
    """Three vertices on a mesh of four, and multiples of its normals in the second half."""
    weights = np.array([[0, 1, 0, 0], [0.25, 0, 0.75, 0], [0.5, 0.25, 0, 0.25]])
    return np.hstack((weights, np.diag([0.01, -0.02, 0.03, 0])[:3]))


def texture_data():
    """In the form of TF_FLAME's files: texels of a square of which two triangles fill the middle."""
    side = 12
    vt = np.array([[0.1, 0.9], [0.9, 0.9], [0.1, 0.1], [0.9, 0.1]])
    ft = np.array([[0, 2, 1], [1, 2, 3]], dtype=np.uint32)
    f = np.array([[7, 4, 5], [5, 4, 6]])
    x_coords = np.array([i + 0.5 for i in range(side) for _ in range(side)])
    y_coords = np.array([i + 0.5 for _ in range(side) for i in range(side)])
    ids, faces, weights = [], [], []
    corners = np.stack((side * vt[:, 0], side - side * vt[:, 1], np.ones(4)), axis=1)
    for texel, (x, y) in enumerate(zip(x_coords, y_coords)):
        for face, corner in enumerate(ft):
            found = np.linalg.solve(corners[corner].T, [x, y, 1])
            if found.min() >= 0:
                ids.append(texel)
                faces.append(f[face])
                weights.append(found)
                break
    return {
        "x_coords": x_coords,
        "y_coords": y_coords,
        "valid_pixel_ids": np.array(ids),
        "valid_pixel_3d_faces": np.array(faces),
        "valid_pixel_b_coords": np.array(weights),
        "img_size": side,
        "vt": vt,
        "ft": ft,
    }


def dump(name, value, protocol):
    with open(name, "wb") as file:
        pickle.dump(value, file, protocol)


if sys.version_info[0] == 2:
    dump("scipy_1_2_csc.pkl", {"mtx": sparse.csc_matrix(matrix())}, 2)
    dump("scipy_1_2_coo.pkl", {"mtx": sparse.coo_matrix(matrix().astype(np.float32))}, 0)
    np.save("numpy_1_16_texture_data.npy", texture_data())
elif sys.version_info[1] == 6:
    dump("scipy_1_5_csr.pkl", {"mtx": sparse.csr_matrix(matrix())}, 4)
    dump("scipy_1_5_coo.pkl", sparse.coo_matrix(matrix()), 3)
    sparse.save_npz("scipy_1_5_csc.npz", sparse.csc_matrix(matrix()))
elif sys.version_info[1] == 10:
    dump("scipy_1_11_coo.pkl", {"matrix": sparse.coo_array(matrix())}, 4)
    dump("scipy_1_11_csc.pkl", sparse.csc_matrix(matrix()), 5)
else:
    dump("scipy_1_17_coo.pkl", {"mtx": sparse.coo_array(matrix())}, 5)
    dump("scipy_1_17_csr.pkl", {"mtx": sparse.csr_array(matrix())}, 4)
    dump("dense.pkl", {"mtx": np.asfortranarray(matrix()), "valid_vertices": np.arange(3)}, 4)
    sparse.save_npz("scipy_1_17_csr.npz", sparse.csr_array(matrix()))
    sparse.save_npz("scipy_1_17_coo.npz", sparse.coo_matrix(matrix()), compressed=False)
    np.save("numpy_2_texture_data.npy", texture_data())
