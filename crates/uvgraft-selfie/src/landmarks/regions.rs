//! Landmarks by what they are on. "Right" and "left" are the person's; the right eye is on the left of a
//! picture.
//!
//! Outlines are closed curves along edges of the canonical mesh. Those of the right and the left side
//! list mirror partners in the same order.

/// Tip of the nose.
pub const NOSE_TIP: usize = 1;

/// Lowest point of the chin.
pub const CHIN: usize = 152;

/// Top of the forehead, in the middle.
pub const FOREHEAD: usize = 10;

/// Outer corner of the right eye.
pub const RIGHT_EYE_OUTER: usize = 33;

/// Outer corner of the left eye.
pub const LEFT_EYE_OUTER: usize = 263;

/// Right corner of the mouth.
pub const RIGHT_MOUTH_CORNER: usize = 61;

/// Left corner of the mouth.
pub const LEFT_MOUTH_CORNER: usize = 291;

/// Where the face ends in front of the right ear.
pub const RIGHT_SIDE: usize = 234;

/// Where the face ends in front of the left ear.
pub const LEFT_SIDE: usize = 454;

/// Edges of the right lids, from the outer corner along the lower lid.
pub const RIGHT_EYE: [usize; 16] =
    [33, 7, 163, 144, 145, 153, 154, 155, 133, 173, 157, 158, 159, 160, 161, 246];

/// Edges of the left lids, from the outer corner along the lower lid.
pub const LEFT_EYE: [usize; 16] =
    [263, 249, 390, 373, 374, 380, 381, 382, 362, 398, 384, 385, 386, 387, 388, 466];

/// Outline of the right eyebrow: the lower edge from the outside inwards, then the upper one back.
pub const RIGHT_BROW: [usize; 10] = [46, 53, 52, 65, 55, 107, 66, 105, 63, 70];

/// Outline of the left eyebrow: the lower edge from the outside inwards, then the upper one back.
pub const LEFT_BROW: [usize; 10] = [276, 283, 282, 295, 285, 336, 296, 334, 293, 300];

/// Outer edge of the lips, from the right corner along the lower lip.
pub const LIPS_OUTER: [usize; 20] =
    [61, 146, 91, 181, 84, 17, 314, 405, 321, 375, 291, 409, 270, 269, 267, 0, 37, 39, 40, 185];

/// Inner edge of the lips, from the right corner along the lower lip.
pub const LIPS_INNER: [usize; 20] =
    [78, 95, 88, 178, 87, 14, 317, 402, 318, 324, 308, 415, 310, 311, 312, 13, 82, 81, 80, 191];

/// Edge of the mesh, from the top of the forehead along the person's left side.
pub const FACE_OVAL: [usize; 36] = [
    10, 338, 297, 332, 284, 251, 389, 356, 454, 323, 361, 288, 397, 365, 379, 378, 400, 377, 152,
    148, 176, 149, 150, 136, 172, 58, 132, 93, 234, 127, 162, 21, 54, 103, 67, 109,
];

/// Ridge of the nose, from between the eyes to the lip.
pub const NOSE_RIDGE: [usize; 9] = [168, 6, 197, 195, 5, 4, 1, 19, 94];

/// Lower edge of the nose, from the right wing to the left one.
pub const NOSE_BASE: [usize; 5] = [98, 97, 2, 326, 327];
