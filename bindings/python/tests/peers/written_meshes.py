"""Meshes with layouts of rarer kinds, by hand."""

from peers.case import Case

_SQUARE = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0))
# Beyond the unit square on all sides.
_OUTSIDE = ((-1, -1), (2, -1), (2, 2), (-1, 2))


def cases():
    island = _box(0, 0, 0.4, 0.4)
    around = _ring(0.1, 0.1, 0.9, 0.9)
    return [
        Case(
            "twin_faces.obj",
            _obj([(_SQUARE, _box(0, 0, 0.4, 0.8)), (_SQUARE, _box(0.6, 0, 1, 0.8))]),
        ),
        Case(
            "turned_twins.obj",
            _obj([(_SQUARE, _box(0, 0, 0.4, 0.8)), (_SQUARE[::-1], _box(0.5, 0, 1, 0.9))]),
        ),
        Case("outside_first.obj", _obj([(_SQUARE, _OUTSIDE), (_raised(1), island)])),
        Case("outside_last.obj", _obj([(_raised(1), island), (_SQUARE, _OUTSIDE)])),
        Case(
            "cards_400.obj", _obj([(_raised(n), _box(0.05, 0.05, 0.95, 0.95)) for n in range(400)])
        ),
        Case("nested_islands.obj", _obj([*around, (_raised(5), _box(0.3, 0.3, 0.7, 0.7))])),
        Case(
            "twin_faces.ply",
            _ply([(_SQUARE, _box(0, 0, 0.4, 0.8)), (_SQUARE, _box(0.6, 0, 1, 0.8))]),
        ),
        Case(
            "no_uv.obj",
            lambda path: path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
            "coordinate",
        ),
    ]


def _box(left, bottom, right, top):
    return ((left, bottom), (right, bottom), (right, top), (left, top))


def _raised(height):
    return tuple((x, y, height) for x, y, _ in _SQUARE)


def _ring(left, bottom, right, top, width=0.1):
    """Return four strips around a hole, each on a surface of its own."""
    boxes = (
        _box(left, bottom, right, bottom + width),
        _box(left, top - width, right, top),
        _box(left, bottom + width, left + width, top - width),
        _box(right - width, bottom + width, right, top - width),
    )
    return [(_raised(height), box) for height, box in enumerate(boxes)]


def _obj(quads):
    """Write quads of positions and texture coordinates; equal positions are one vertex."""

    def write(path):
        vertices = list(dict.fromkeys(point for points, _ in quads for point in points))
        lines = [f"v {x} {y} {z}" for x, y, z in vertices]
        lines += [f"vt {u} {v}" for _, uv in quads for u, v in uv]
        for number, (points, _) in enumerate(quads):
            corners = [
                (vertices.index(point) + 1, 4 * number + at + 1) for at, point in enumerate(points)
            ]
            lines.append("f " + " ".join(f"{vertex}/{uv}" for vertex, uv in corners))
        path.write_text("\n".join(lines) + "\n")

    return write


def _ply(quads):
    """Write quads with texture coordinates at the corners of faces."""

    def write(path):
        vertices = list(dict.fromkeys(point for points, _ in quads for point in points))
        lines = ["ply", "format ascii 1.0", f"element vertex {len(vertices)}"]
        lines += [f"property float {axis}" for axis in "xyz"]
        lines += [f"element face {len(quads)}", "property list uchar int vertex_indices"]
        lines += ["property list uchar float texcoord", "end_header"]
        lines += [f"{x} {y} {z}" for x, y, z in vertices]
        for points, uv in quads:
            corners = " ".join(str(vertices.index(point)) for point in points)
            lines.append(f"4 {corners} 8 " + " ".join(f"{u} {v}" for u, v in uv))
        path.write_text("\n".join(lines) + "\n")

    return write
