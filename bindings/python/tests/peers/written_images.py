"""Images of rarer kinds, by Pillow, tifffile, OpenEXR and by hand."""

import io
import os
import struct
import zlib

import numpy as np
import OpenEXR
import tifffile
from PIL import Image

from peers.case import Case

# Odd, so that neither tiles nor subsampled chroma fit.
HEIGHT, WIDTH = 37, 45
_P3 = np.array([[0.680, 0.320], [0.265, 0.690], [0.150, 0.060], [0.3127, 0.3290]])


def gradient(height=HEIGHT, width=WIDTH, channels=3):
    """Return a smooth picture of uint8, which lossy formats keep well."""
    y, x = np.mgrid[0:height, 0:width]
    waves = [128 + 100 * np.sin(x / (7 + n) + n) * np.cos(y / (9 - n)) for n in range(channels)]
    return np.rint(np.stack(waves, 2)).astype(np.uint8)


def cases():
    return [*_tiffs(), *_exrs(), *_pngs(), *_jpegs()]


def _tiffs():
    def black(image):
        return image.convert("1")

    rgb, grey = gradient(), gradient()[..., 0]
    by_plane = np.moveaxis(rgb, -1, 0)
    tiled = {"photometric": "rgb", "planarconfig": "separate", "tile": (16, 32)}
    jpeg = {"photometric": "ycbcr", "compression": "jpeg", "subsampling": (2, 2)}
    depth_32 = grey.astype(np.uint32) << 24
    bits = np.packbits(grey > 128, axis=1)
    as_lzw = _old_lzw(grey.tobytes())
    return [
        Case("palette.tif", _pillow(lambda image: image.quantize(32))),
        Case("tiled_planar.tif", _tifffile(by_plane, **tiled)),
        Case("tiled_planar_lzw.tif", _tifffile(by_plane, compression="lzw", **tiled)),
        Case("ycbcr_jpeg.tif", _tifffile(rgb, **jpeg)),
        Case("fill_order_2.tif", _tiff(_reversed(bits.tobytes()), 1, fill_order=2)),
        Case("old_lzw.tif", _tiff(as_lzw, 8, compression=5)),
        Case("fax_3.tif", _pillow(black, compression="group3"), "fax"),
        Case("fax_4.tif", _pillow(black, compression="group4"), "fax"),
        Case("32_bit.tif", _tifffile(depth_32, photometric="minisblack"), "32"),
        Case("float_64.tif", _tifffile(grey / 255, photometric="minisblack")),
    ]


def _tifffile(array, **options):
    return lambda path: tifffile.imwrite(path, array, **options)


def _pillow(change, **options):
    """Write what Pillow makes of the gradient."""

    def write(path):
        change(Image.fromarray(gradient())).save(path, **options)

    return write


def _tiff(strip, bits, compression=1, fill_order=1):
    """Write a greyscale TIFF of one strip by hand."""
    tags = {256: WIDTH, 257: HEIGHT, 258: bits, 259: compression, 262: 1, 266: fill_order}
    tags |= {273: 8, 277: 1, 278: HEIGHT, 279: len(strip)}
    start = 8 + len(strip) + len(strip) % 2
    entries = b"".join(struct.pack("<HHII", tag, 4, 1, value) for tag, value in tags.items())
    directory = struct.pack("<H", len(tags)) + entries + bytes(4)
    data = b"II*\0" + struct.pack("<I", start) + strip.ljust(start - 8, b"\0") + directory
    return lambda path: path.write_bytes(data)


def _reversed(data):
    """Reverse the bits of each byte."""
    return bytes(int(f"{byte:08b}"[::-1], 2) for byte in data)


def _old_lzw(data):
    """Encode as the first libtiff did, lowest bit first, in literals and tables of 9 bits alone."""
    codes = []
    for start in range(0, len(data), 250):
        codes += [256, *data[start : start + 250]]
    bits = "".join(f"{code:09b}"[::-1] for code in [*codes, 257])
    bits = bits.ljust(-(-len(bits) // 8) * 8, "0")
    return bytes(int(bits[at : at + 8][::-1], 2) for at in range(0, len(bits), 8))


def _exrs():
    rgb = (gradient() / 255.0).astype(np.float32)
    alpha = np.linspace(0, 1, WIDTH, dtype=np.float32)[None].repeat(HEIGHT, 0)
    alpha[:, :9] = 0
    # Light without coverage, as of flames: the colour under alpha 0 is not 0.
    premultiplied = np.concatenate([rgb * np.maximum(alpha, 0.2)[..., None], alpha[..., None]], 2)
    weights = np.array([0.2126, 0.7152, 0.0722])
    y = (rgb @ weights).astype(np.float32)
    chroma = {"RY": (rgb[..., 0] - y) / y, "Y": y, "BY": (rgb[..., 2] - y) / y}
    return [
        Case("chromaticities.exr", _exr({"RGB": rgb}, chromaticities=tuple(_P3.ravel()))),
        Case("light_without_alpha.exr", _exr({"RGBA": premultiplied})),
        Case("luminance_chroma.exr", _exr(chroma)),
        Case("integers.exr", _exr({"Y": (y * 1000).astype(np.uint32)}), "integer"),
    ]


def _exr(channels, **header):
    """Write arrays by the names of channels."""

    def write(path):
        made = {}
        for name, array in channels.items():
            made[name] = OpenEXR.Channel(np.ascontiguousarray(array))
        header_of = {
            "type": OpenEXR.scanlineimage,
            "compression": OpenEXR.ZIP_COMPRESSION,
            **header,
        }
        OpenEXR.File(header_of, made).write(os.fspath(path))

    return write


def _pngs():
    p3 = np.roll(_P3, 1, 0).ravel()
    linear, dark = [(b"gAMA", struct.pack(">I", gamma)) for gamma in (100_000, 55_556)]
    primaries = (b"cHRM", struct.pack(">8I", *np.rint(p3 * 1e5).astype(int)))
    usual = (b"gAMA", struct.pack(">I", 45_455))
    xmp = b'<x:xmpmeta xmlns:x="adobe:ns:meta/">'
    xmp += b'<rdf:RDF xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#">'
    xmp += b'<rdf:Description xmlns:tiff="http://ns.adobe.com/tiff/1.0/" tiff:Orientation="6"/>'
    xmp += b"</rdf:RDF></x:xmpmeta>"
    text = (b"iTXt", b"XML:com.adobe.xmp\0\0\0\0\0" + xmp)
    return [
        Case("gamma_linear.png", _png(linear)),
        Case("gamma_18.png", _png(dark)),
        Case("gamma_usual.png", _png(usual)),
        Case("primaries_p3.png", _png(usual, primaries)),
        Case("srgb_over_gamma.png", _png(linear, (b"sRGB", b"\0"))),
        Case("cicp_p3.png", _png((b"cICP", bytes([12, 13, 0, 1])))),
        Case("cicp_linear.png", _png((b"cICP", bytes([1, 8, 0, 1])))),
        Case("cicp_pq.png", _png((b"cICP", bytes([9, 16, 0, 1])))),
        Case("cicp_unknown.png", _png((b"cICP", bytes([200, 13, 0, 1]))), "cICP"),
        Case("xmp_orientation.png", _png(text)),
    ]


def _png(*chunks, bits=8):
    """Write an RGB image with further chunks by hand."""
    rows = b"".join(b"\0" + row.tobytes() for row in gradient())
    header = struct.pack(">IIBBBBB", WIDTH, HEIGHT, bits, 2, 0, 0, 0)
    parts = [(b"IHDR", header), *chunks, (b"IDAT", zlib.compress(rows)), (b"IEND", b"")]
    data = b"\x89PNG\r\n\x1a\n"
    for kind, content in parts:
        checksum = struct.pack(">I", zlib.crc32(kind + content))
        data += struct.pack(">I", len(content)) + kind + content + checksum
    return lambda path: path.write_bytes(data)


def _jpegs():
    narrow = [
        Case(f"width_{width}_{name}.jpg", _jpeg(gradient(9, width), subsampling))
        for width in range(1, 6)
        for subsampling, name in enumerate(("444", "422", "420"))
    ]
    short_adobe = _segment(0xEE, b"Adobe\0")
    bad_exif = _segment(0xE1, b"Exif\0\0MM\0*\xff\xff\xff\xff junk")
    return [
        *narrow,
        Case("stray_bytes.jpg", _jpeg(inserted=b"\x00\x11\x22")),
        Case("short_app14.jpg", _jpeg(inserted=short_adobe)),
        Case("bad_exif.jpg", _jpeg(inserted=bad_exif)),
        Case("cut_short.jpg", _jpeg(share=0.6), "truncated"),
    ]


def _jpeg(array=None, subsampling=2, inserted=b"", share=1.0):
    """Write with Pillow, with bytes behind the segment of JFIF, or a share of the file alone."""
    array = gradient() if array is None else array

    def write(path):
        out = io.BytesIO()
        Image.fromarray(array).save(out, "jpeg", quality=90, subsampling=subsampling)
        data = out.getvalue()
        # The start of the image and that segment have 20 bytes.
        data = data[:20] + inserted + data[20:]
        path.write_bytes(data[: round(len(data) * share)])

    return write


def _segment(marker, content):
    return bytes([0xFF, marker]) + struct.pack(">H", len(content) + 2) + content
