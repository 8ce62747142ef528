"""Which files are compared as what, and which independent readers that takes."""

import importlib
import importlib.util

KINDS = ("images", "meshes", "models")
_IMAGES = {".png", ".apng", ".jpg", ".jpeg", ".webp", ".tif", ".tiff", ".exr"}
_MODELS = {".glb", ".gltf", ".vrm"}
_MESHES = {".obj", ".ply", *_MODELS}
# The import names of the packages that images are compared with.
PACKAGES = ("PIL", "cv2", "tifffile", "imagecodecs", "OpenEXR")


def of(path):
    """Return the kinds that a file is compared as, by its extension."""
    extensions = zip(KINDS, (_IMAGES, _MESHES, _MODELS), strict=True)
    return [kind for kind, known in extensions if path.suffix.lower() in known]


def missing():
    """Return the packages that are not installed."""
    return [name for name in PACKAGES if importlib.util.find_spec(name) is None]


def compare(kind, path, progress=lambda: None):
    """Compare a file with its peers.

    `progress` is called once uvgraft is done, so that a crash afterwards is not blamed on it.
    """
    return importlib.import_module(f"peers.{kind}").compare(path, progress)
