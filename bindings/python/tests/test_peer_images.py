"""Images of rarer kinds, compared with what Pillow, OpenCV, tifffile and OpenEXR make of them."""

import os

import pytest
from peers import kinds

if kinds.missing() and not os.environ.get("CI"):
    pytest.skip(f"not installed: {', '.join(kinds.missing())}", allow_module_level=True)

from peers import written_images
from peers.case import check, parameters


@pytest.mark.parametrize("case", parameters(written_images.cases()))
def test_images(case, tmp_path):
    check("images", case, tmp_path)
