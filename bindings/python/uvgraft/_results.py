"""What some methods return."""

from typing import Any, NamedTuple

from numpy.typing import NDArray


class Fit(NamedTuple):
    """A fitted texture, and how well it fits.

    Attributes
    ----------
    texture : ndarray
        The texture, laid over the base.
    steps : int
        Steps taken.
    sampled_rms, fitted_rms : float
        Root mean square error of reading the source back from the sampled and from the fitted
        texture; 1.0 is the difference between black and white.
    share_met : float
        Fraction of the source's linked texels that have an equation, from 0 to 1.
    """

    texture: NDArray[Any]
    steps: int
    sampled_rms: float
    fitted_rms: float
    share_met: float


class Tone(NamedTuple):
    """How a blend changes the colours of a texture and of its base.

    Attributes
    ----------
    lightness : (float, float)
        Change in lightness of the texture's cheeks and of the body's skin, in L* of CIELAB.
    clipped : (float, float)
        Fraction of the skin that newly clips in a channel, in the texture and in the base, 0 to 1.
    boundary_delta_e : float or None
        How much both sides still differ along the boundary once their cheeks match, ΔE 2000; None
        where no skin meets skin. This remainder fades out near the boundary.
    left_out : float
        Fraction of the transferred surface that is left out as cloth or background, 0 to 1.
    warnings : list of str
        What is implausible about these figures.
    """

    lightness: tuple[float, float]
    clipped: tuple[float, float]
    boundary_delta_e: float | None
    left_out: float
    warnings: list[str]


class SeamSteps(NamedTuple):
    """Colour differences across edges in ΔE 2000, weighted by the length of edge.

    Attributes
    ----------
    mean, median : float
        Mean and median.
    p95, p99 : float
        95th and 99th percentile by length.
    max : float
        The largest.
    """

    mean: float
    median: float
    p95: float
    p99: float
    max: float


class EdgeGroup(NamedTuple):
    """Edges of one kind.

    Attributes
    ----------
    edges : int
        Number of edges.
    length : float
        Their length on the surface, in the mesh's unit.
    points : int
        Number of points measured along them.
    delta_e : SeamSteps or None
        Differences across them in ΔE 2000; None if no point could be measured.
    """

    edges: int
    length: float
    points: int
    delta_e: SeamSteps | None


class WorstEdge(NamedTuple):
    """An edge with a large difference. Pairs hold its two sides, the region's first.

    Attributes
    ----------
    edge_mean : float
        Mean of the differences along the edge, ΔE 2000.
    delta_e : float
        The largest of them; `along`, `uv`, `sampled_uv` and `colors` are of this point.
    edge_length : float
        Length of the edge on the surface, in the mesh's unit.
    is_uv_seam, is_rim : bool
        Whether the edge is a UV seam, and whether the region ends there.
    ends : ((float, float, float), (float, float, float))
        Ends of the edge on the surface.
    along : float
        Position along the edge: 0 at its first end, 1 at its second.
    uv : ((float, float), (float, float))
        That position in the texture, from 0 to 1 with the origin at the top left, on both sides.
    sampled_uv : ((float, float), (float, float))
        Where the colours were sampled.
    colors : ((float, float, float), (float, float, float))
        The colours: sRGB, 1.0 for full intensity.
    """

    edge_mean: float
    delta_e: float
    edge_length: float
    is_uv_seam: bool
    is_rim: bool
    ends: tuple[tuple[float, float, float], tuple[float, float, float]]
    along: float
    uv: tuple[tuple[float, float], tuple[float, float]]
    sampled_uv: tuple[tuple[float, float], tuple[float, float]]
    colors: tuple[tuple[float, float, float], tuple[float, float, float]]


class SkinMatch(NamedTuple):
    """How well the skin tone of a transferred face matches the body.

    Attributes
    ----------
    cheek_to_chest : float or None
        Difference between the mean colours of cheeks and chest, ΔE 2000; None if one has no colour.
    own : float or None
        The same of the base; None without one.
    chest : {"chest", "neck"} or None
        What the cheeks are compared with: the neck on meshes without a chest.
    hair_shift : float or None
        Median difference of hair and brows from the original face, ΔE 2000; None without a face,
        and for faces without hair.
    clipped : float or None
        Fraction of the transferred skin with a channel that newly clips, 0 to 1; without a face, of
        all transferred texels with one that clips.
    fits : bool
        Whether `cheek_to_chest` is within 4 of `own`, and `clipped` at most 0.01, as far as known.
    """

    cheek_to_chest: float | None
    own: float | None
    chest: str | None
    hair_shift: float | None
    clipped: float | None
    fits: bool


class Seams(NamedTuple):
    """How visible the seams of a texture are.

    A seam is hidden if the differences across it are about those beside it.

    Attributes
    ----------
    uv_seams, uv_seams_inside : EdgeGroup
        Edges where UV islands end, and those of them within the region.
    rim : EdgeGroup
        Edges where the region ends.
    beside_uv_seams, beside_uv_seams_inside, beside_rim : EdgeGroup
        Ordinary edges that share a vertex with these, for comparison.
    ordinary : EdgeGroup
        All ordinary edges.
    worst : list of WorstEdge
        The edges with the largest means, apart from each other, in descending order.
    tone : SkinMatch or None
        The match of skin tones; None if the mesh has no head.
    notes : dict of str to int
        What could not be measured as intended: ``single_edges``, where the surface ends,
        ``collapsed_triangles``; and points: ``no_area``, ``clear`` (transparent) and ``not_finite``
        are skipped, ``shortened`` sampled closer to the edge, ``outside`` outside the texture.
    """

    uv_seams: EdgeGroup
    uv_seams_inside: EdgeGroup
    rim: EdgeGroup
    beside_uv_seams: EdgeGroup
    beside_uv_seams_inside: EdgeGroup
    beside_rim: EdgeGroup
    ordinary: EdgeGroup
    worst: list[WorstEdge]
    tone: SkinMatch | None
    notes: dict[str, int]

    def _repr_html_(self) -> str:
        """Show the figures in a notebook."""
        from uvgraft._notebook import seams_html  # noqa: PLC0415 - needs what this module defines

        return seams_html(self)
