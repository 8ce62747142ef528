//! Blocks of 8×8 values: colours, the discrete cosine transform, quantisation.
//!
//! # Source
//! ITU-T T.81, annexes A and K; ITU-T T.871 for colours; Arai, Agui and Nakajima, "A fast DCT-SQ
//! scheme for images" (1988), with which the scale of each coefficient is part of its quantisation.

pub(super) const SIDE: usize = 8;

/// Values of a block, row by row.
pub(super) type Block = [[f32; SIDE]; SIDE];

/// The place of each coefficient in the order of storage: row and column, packed as in a block.
pub(super) const ZIGZAG: [u8; 64] = zigzag();

/// Annex K's tables, row by row.
const LUMA: [u8; 64] = [
    16, 11, 10, 16, 24, 40, 51, 61, 12, 12, 14, 19, 26, 58, 60, 55, 14, 13, 16, 24, 40, 57, 69, 56,
    14, 17, 22, 29, 51, 87, 80, 62, 18, 22, 37, 56, 68, 109, 103, 77, 24, 35, 55, 64, 81, 104, 113,
    92, 49, 64, 78, 87, 103, 121, 120, 101, 72, 92, 95, 98, 112, 100, 103, 99,
];
const CHROMA: [u8; 64] = [
    17, 18, 24, 47, 99, 99, 99, 99, 18, 21, 26, 66, 99, 99, 99, 99, 24, 26, 56, 99, 99, 99, 99, 99,
    47, 66, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99,
    99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99,
];

/// How coefficients are rounded.
#[derive(Debug, Clone)]
pub(super) struct Quantisation {
    /// The divisors, in a block's order.
    pub(super) table: [u8; 64],
    /// The inverse of each, with the scale of the transform, for transposed blocks.
    factors: Block,
}

/// Walks the diagonals, up and down in turn.
const fn zigzag() -> [u8; 64] {
    let mut order = [0; 64];
    let (mut index, mut diagonal) = (0, 0);
    while diagonal < 15 {
        let mut step = 0;
        while step <= diagonal {
            let (row, column) =
                if diagonal % 2 == 0 { (diagonal - step, step) } else { (step, diagonal - step) };
            if row < 8 && column < 8 {
                order[index] = row * 8 + column;
                index += 1;
            }
            step += 1;
        }
        diagonal += 1;
    }
    order
}

impl Quantisation {
    /// The customary scale of annex K's tables, which are for 50.
    pub(super) fn new(quality: u8, is_chroma: bool) -> Self {
        let quality = u32::from(quality.clamp(1, 100));
        let scale = if quality < 50 { 5000 / quality } else { 200 - 2 * quality };
        let table = if is_chroma { CHROMA } else { LUMA };
        let table = table.map(|value| ((u32::from(value) * scale + 50) / 100).clamp(1, 255) as u8);
        // cos(kπ/16)·√2, with 1 for k = 0.
        let of = |k: usize| {
            if k == 0 { 1.0 } else { (k as f64 * std::f64::consts::PI / 16.0).cos() * 2f64.sqrt() }
        };
        let factor = |column: usize, row: usize| {
            let divisor = f64::from(table[row * SIDE + column]) * of(row) * of(column) * 8.0;
            (1.0 / divisor) as f32
        };
        let factors = std::array::from_fn(|column| std::array::from_fn(|row| factor(column, row)));
        Self { table, factors }
    }

    /// The quantised coefficients of a block, in the order of storage.
    pub(super) fn coefficients(&self, block: &Block) -> [i16; 64] {
        let transformed = transform(&transposed(&transform(block)));
        // Adding rounds to whole numbers, in the lowest bits of the sum.
        const ROUND: f32 = 12_582_912.0;
        let mut rounded = [[0; SIDE]; SIDE];
        for ((rounded, values), factors) in rounded.iter_mut().zip(&transformed).zip(&self.factors)
        {
            for ((rounded, value), factor) in rounded.iter_mut().zip(values).zip(factors) {
                let bits = (value * factor + ROUND).to_bits();
                *rounded = bits.wrapping_sub(ROUND.to_bits()) as i16;
            }
        }
        // The block is transposed.
        let rounded = rounded.as_flattened();
        std::array::from_fn(|k| rounded[usize::from(ZIGZAG[k] % 8 * 8 + ZIGZAG[k] / 8) % 64])
    }
}

/// The transform of each column, unscaled.
fn transform(block: &Block) -> Block {
    type Lanes = [f32; SIDE];
    let add = |a: Lanes, b: Lanes| -> Lanes { std::array::from_fn(|k| a[k] + b[k]) };
    let sub = |a: Lanes, b: Lanes| -> Lanes { std::array::from_fn(|k| a[k] - b[k]) };
    let mul = |a: Lanes, by: f32| -> Lanes { a.map(|value| value * by) };
    let [d0, d1, d2, d3, d4, d5, d6, d7] = *block;
    let [s0, s1, s2, s3] = [add(d0, d7), add(d1, d6), add(d2, d5), add(d3, d4)];
    let [t0, t1, t2, t3] = [sub(d0, d7), sub(d1, d6), sub(d2, d5), sub(d3, d4)];

    let [even, middle] = [add(s0, s3), add(s1, s2)];
    let [outer, inner] = [sub(s0, s3), sub(s1, s2)];
    let turned = mul(add(inner, outer), std::f32::consts::FRAC_1_SQRT_2);

    let [low, mid, high] = [add(t3, t2), add(t2, t1), add(t1, t0)];
    // sin(π/8), √2·sin(π/8) and √2·cos(π/8).
    let shared = mul(sub(low, high), 0.382_683_43);
    let [low, high] = [add(mul(low, 0.541_196_1), shared), add(mul(high, 1.306_563), shared)];
    let mid = mul(mid, std::f32::consts::FRAC_1_SQRT_2);
    let [plus, minus] = [add(t0, mid), sub(t0, mid)];
    [
        add(even, middle),
        add(plus, high),
        add(outer, turned),
        sub(minus, low),
        sub(even, middle),
        add(minus, low),
        sub(outer, turned),
        sub(plus, high),
    ]
}

fn transposed(block: &Block) -> Block {
    std::array::from_fn(|row| std::array::from_fn(|column| block[column][row]))
}

/// The levels of eight grey texels around 0.
pub(super) fn grey(texels: &[u8; SIDE]) -> [f32; SIDE] {
    texels.map(|value| f32::from(value) - 128.0)
}

/// Luma and the two colour differences of eight RGB texels, around 0.
pub(super) fn luma_and_chroma(texels: &[u8; 3 * SIDE]) -> [[f32; SIDE]; 3] {
    let [r, g, b]: [[f32; SIDE]; 3] = std::array::from_fn(|channel| {
        let values: [i32; SIDE] = std::array::from_fn(|k| texels[3 * k + channel].into());
        values.map(|value| value as f32)
    });
    let sum = |of: [f32; 3], offset: f32| -> [f32; SIDE] {
        std::array::from_fn(|k| of[0] * r[k] + of[1] * g[k] + of[2] * b[k] - offset)
    };
    [
        sum([0.299, 0.587, 0.114], 128.0),
        sum([-0.168_735_9, -0.331_264_1, 0.5], 0.0),
        sum([0.5, -0.418_687_6, -0.081_312_41], 0.0),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Annex A.3.3's definition.
    fn by_definition(block: &Block, u: usize, v: usize) -> f64 {
        use std::f64::consts::{FRAC_1_SQRT_2, PI};
        let wave = |x: usize, u: usize| ((2 * x + 1) as f64 * u as f64 * PI / 16.0).cos();
        let of = |u: usize| if u == 0 { FRAC_1_SQRT_2 } else { 1.0 };
        let mut sum = 0.0;
        for (y, row) in block.iter().enumerate() {
            for (x, &value) in row.iter().enumerate() {
                sum += f64::from(value) * wave(x, u) * wave(y, v);
            }
        }
        sum * of(u) * of(v) / 4.0
    }

    #[test]
    fn coefficients_are_those_of_the_definition() {
        let mut random = fastrand::Rng::with_seed(5);
        for quality in [1, 30, 75, 95, 100] {
            for is_chroma in [false, true] {
                let quantisation = Quantisation::new(quality, is_chroma);
                for round in 0..20 {
                    let mut value = || match round {
                        0 => 127.0,
                        1 => f32::from(random.bool()) * 255.0 - 128.0,
                        _ => f32::from(random.u8(..)) - 128.0,
                    };
                    let block = std::array::from_fn(|_| std::array::from_fn(|_| value()));
                    let found = quantisation.coefficients(&block);
                    for (found, place) in found.into_iter().zip(ZIGZAG.map(usize::from)) {
                        let wanted = by_definition(&block, place % 8, place / 8)
                            / f64::from(quantisation.table[place]);
                        let off = (f64::from(found) - wanted).abs();
                        assert!(off < 0.501, "{found} {wanted} at {place}");
                    }
                }
            }
        }
    }

    #[test]
    fn coefficients_are_stored_along_diagonals() {
        assert_eq!(ZIGZAG[..12], [0, 1, 8, 16, 9, 2, 3, 10, 17, 24, 32, 25]);
        assert_eq!(ZIGZAG[61..], [55, 62, 63]);
        let mut all = ZIGZAG;
        all.sort_unstable();
        assert!((0..64).eq(all));
    }

    #[test]
    fn colors_by_hand() {
        let texels = [[255, 255, 255], [255, 0, 0], [0, 0, 255], [10, 10, 10]].as_flattened();
        let texels = [texels, &[0; 12]].concat();
        let [luma, blue, red] = luma_and_chroma(texels[..].try_into().unwrap());
        let near = |found: &[f32], wanted: [f32; 4]| {
            assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-3), "{found:?}");
        };
        near(&luma[..4], [127.0, 255.0 * 0.299 - 128.0, 255.0 * 0.114 - 128.0, -118.0]);
        near(&blue[..4], [0.0, -43.0277, 127.5, 0.0]);
        near(&red[..4], [0.0, 127.5, -20.7347, 0.0]);
    }
}
