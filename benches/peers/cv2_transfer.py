"""A transfer as a user of OpenCV would write it: lays a texture over a base through precomputed maps.

cv2_transfer.py SOURCE BASE MAP_X.npy MAP_Y.npy MASK.npy THREADS OUT
"""

import sys

import cv2
import numpy as np

source, base, map_x, map_y, mask, threads, out = sys.argv[1:]
cv2.setNumThreads(int(threads))
result = cv2.imread(base)
carried = cv2.remap(cv2.imread(source), np.load(map_x), np.load(map_y), cv2.INTER_LINEAR)
cv2.copyTo(carried, np.load(mask), result)
if not cv2.imwrite(out, result):
    sys.exit(f"cannot write {out}")
