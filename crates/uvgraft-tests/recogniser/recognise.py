"""How far avatars are from the face in a photograph, and from other faces, to a face recogniser.

    scripts/recognise.sh PHOTO --avatar VIEW... [--others PICTURE...] [--check]

Each picture may show several faces, such as a strip of views; they are numbered from the left. VIEWs are
in order of their angle, the one from the front first. Distances below 0.6 customarily mean the same
person. With --check, the exit status is 1 unless the front is at most 0.5 from the photograph, every view
at most 0.6, and every other face at least 0.1 farther from each view than the photograph is.

The recogniser is dlib's (D. King, "High quality face recognition with deep metric learning", 2017).
"""

import argparse
import importlib.util
import pathlib
import sys

import dlib
import numpy as np
from PIL import Image

FRONT, EACH, MARGIN = 0.5, 0.6, 0.1


def models():
    # The package itself cannot be imported without an old setuptools.
    package = importlib.util.find_spec("face_recognition_models")
    return pathlib.Path(package.submodule_search_locations[0]) / "models"


class Recogniser:
    def __init__(self):
        folder = models()
        self.detector = dlib.get_frontal_face_detector()
        self.slow_detector = dlib.cnn_face_detection_model_v1(str(folder / "mmod_human_face_detector.dat"))
        self.points = dlib.shape_predictor(str(folder / "shape_predictor_68_face_landmarks.dat"))
        self.network = dlib.face_recognition_model_v1(
            str(folder / "dlib_face_recognition_resnet_model_v1.dat")
        )

    def faces(self, path):
        """Names and descriptors of the faces in a picture, from the left."""
        picture = np.asarray(Image.open(path).convert("RGB"))
        # Enlarged pictures have more that looks like a face.
        boxes = list(self.detector(picture, 0)) or list(self.detector(picture, 1))
        if not boxes:
            boxes = [found.rect for found in self.slow_detector(picture, 0)]
        # What is much smaller is something in the background that looks like a face.
        largest = max((box.width() for box in boxes), default=0)
        boxes = sorted((box for box in boxes if 2 * box.width() > largest), key=lambda box: box.left())
        name = pathlib.Path(path).stem
        names = [name] if len(boxes) == 1 else [f"{name} {number}" for number in range(1, len(boxes) + 1)]
        # Means of ten slightly moved crops.
        descriptors = [
            np.array(self.network.compute_face_descriptor(picture, self.points(picture, box), 10))
            for box in boxes
        ]
        if not boxes:
            print(f"{path}: no face was found", file=sys.stderr)
        return list(zip(names, descriptors))


def main():
    parser = argparse.ArgumentParser(description="compares avatars with a photograph and other faces")
    parser.add_argument("photo")
    parser.add_argument("--avatar", nargs="+", required=True, metavar="VIEW")
    parser.add_argument("--others", nargs="*", default=[], metavar="PICTURE")
    parser.add_argument("--check", action="store_true", help="exit with 1 if limits are exceeded")
    given = parser.parse_args()

    recogniser = Recogniser()
    own = recogniser.faces(given.photo)
    if len(own) != 1:
        sys.exit(f"{given.photo} must show one face, got {len(own)}")
    views = [face for path in given.avatar for face in recogniser.faces(path)]
    others = [face for path in given.others for face in recogniser.faces(path)]
    if not views:
        sys.exit("no face was found in any view")

    columns = own + others
    width = max(len(name) for name, _ in columns + views) + 2
    print("".ljust(width) + "".join(name.rjust(max(len(name), 6) + 2) for name, _ in columns))
    sound = len(views) >= len(given.avatar)
    for number, (name, view) in enumerate(views):
        distances = [np.linalg.norm(view - face) for _, face in columns]
        cells = zip(columns, distances)
        print(name.ljust(width) + "".join(f"{far:.3f}".rjust(max(len(of), 6) + 2) for (of, _), far in cells))
        sound &= distances[0] <= (EACH if number else FRONT)
        sound &= all(far >= distances[0] + MARGIN for far in distances[1:])
    distances = [np.linalg.norm(own[0][1] - face) for _, face in others]
    if others:
        print(f"the photograph is {min(distances):.3f} or more from all others")
    if given.check:
        print("within the limits" if sound else "NOT within the limits")
        sys.exit(0 if sound else 1)


main()
