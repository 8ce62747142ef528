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
