"""Seeded test images: one smooth, one as detailed as a photograph."""

import cv2
import numpy as np


def image(kind, side, seed):
    """A `[side, side, 3]` array of uint8."""
    random = np.random.default_rng([seed, side, len(kind)])

    def noise(knots, strength):
        values = random.normal(0, strength, (knots, knots, 3)).astype(np.float32)
        return cv2.resize(values, (side, side), interpolation=cv2.INTER_CUBIC)

    # The same picture at every size, except for the grain.
    result = np.full((side, side, 3), 128, np.float32) + noise(4, 20) + noise(9, 20)
    if kind == "detailed":
        # Pores and wrinkles, about equally strong at every scale, and the sensor's grain.
        for knots in (side // 64, side // 16, side // 4):
            result += noise(max(knots, 2), 9)
        result += random.normal(0, 2.5, result.shape).astype(np.float32)
    return np.clip(np.rint(result), 0, 255).astype(np.uint8)
