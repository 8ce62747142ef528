//! Numbers of TIFF.
//!
//! # Source
//! TIFF 6.0; its Technical Note 2 for JPEG; Adobe Photoshop TIFF Technical Notes for the predictor of floats.

pub(super) const IMAGE_WIDTH: u16 = 256;
pub(super) const IMAGE_LENGTH: u16 = 257;
pub(super) const BITS_PER_SAMPLE: u16 = 258;
pub(super) const COMPRESSION: u16 = 259;
pub(super) const PHOTOMETRIC_INTERPRETATION: u16 = 262;
pub(super) const FILL_ORDER: u16 = 266;
pub(super) const STRIP_OFFSETS: u16 = 273;
pub(super) const ORIENTATION: u16 = 274;
pub(super) const SAMPLES_PER_PIXEL: u16 = 277;
pub(super) const ROWS_PER_STRIP: u16 = 278;
pub(super) const STRIP_BYTE_COUNTS: u16 = 279;
pub(super) const X_RESOLUTION: u16 = 282;
pub(super) const Y_RESOLUTION: u16 = 283;
pub(super) const PLANAR_CONFIGURATION: u16 = 284;
pub(super) const RESOLUTION_UNIT: u16 = 296;
pub(super) const PREDICTOR: u16 = 317;
pub(super) const COLOR_MAP: u16 = 320;
pub(super) const TILE_WIDTH: u16 = 322;
pub(super) const TILE_LENGTH: u16 = 323;
pub(super) const TILE_OFFSETS: u16 = 324;
pub(super) const TILE_BYTE_COUNTS: u16 = 325;
pub(super) const EXTRA_SAMPLES: u16 = 338;
pub(super) const SAMPLE_FORMAT: u16 = 339;
pub(super) const JPEG_TABLES: u16 = 347;
pub(super) const YCBCR_COEFFICIENTS: u16 = 529;
pub(super) const YCBCR_SUBSAMPLING: u16 = 530;
pub(super) const REFERENCE_BLACK_WHITE: u16 = 532;
pub(super) const ICC_PROFILE: u16 = 34_675;

/// Values of [`COMPRESSION`].
pub(super) mod compression {
    pub(in super::super) const NONE: u16 = 1;
    pub(in super::super) const LZW: u16 = 5;
    pub(in super::super) const JPEG: u16 = 7;
    pub(in super::super) const DEFLATE: u16 = 8;
    pub(in super::super) const PACK_BITS: u16 = 32_773;
    /// The number of Deflate before it had one.
    pub(in super::super) const OLD_DEFLATE: u16 = 32_946;
}

/// Values of [`PHOTOMETRIC_INTERPRETATION`].
pub(super) mod photometric {
    pub(in super::super) const WHITE_IS_ZERO: u16 = 0;
    pub(in super::super) const BLACK_IS_ZERO: u16 = 1;
    pub(in super::super) const RGB: u16 = 2;
    pub(in super::super) const PALETTE: u16 = 3;
    pub(in super::super) const YCBCR: u16 = 6;
}

/// Values of [`EXTRA_SAMPLES`].
pub(super) mod extra {
    pub(in super::super) const PREMULTIPLIED_ALPHA: u16 = 1;
    pub(in super::super) const ALPHA: u16 = 2;
}

/// Values of [`PREDICTOR`].
pub(super) mod predictor {
    pub(in super::super) const NONE: u16 = 1;
    pub(in super::super) const HORIZONTAL: u16 = 2;
    pub(in super::super) const FLOAT: u16 = 3;
}

/// Values of [`SAMPLE_FORMAT`].
pub(super) mod sample_format {
    pub(in super::super) const UNSIGNED: u16 = 1;
    pub(in super::super) const SIGNED: u16 = 2;
    pub(in super::super) const FLOAT: u16 = 3;
    /// Undefined; to be read as if nothing were said.
    pub(in super::super) const VOID: u16 = 4;
}

/// Types of values.
pub(super) mod kind {
    pub(in super::super) const BYTE: u16 = 1;
    pub(in super::super) const SHORT: u16 = 3;
    pub(in super::super) const LONG: u16 = 4;
    pub(in super::super) const RATIONAL: u16 = 5;
    pub(in super::super) const UNDEFINED: u16 = 7;
    pub(in super::super) const IFD: u16 = 13;
    pub(in super::super) const LONG8: u16 = 16;
    pub(in super::super) const IFD8: u16 = 18;
}
