//! Checksums that are made right again after a change: otherwise hardly any change would get past
//! them.

use sha2::{Digest, Sha256};

/// A PNG with the checksums of all its chunks corrected, as far as its chunks can be followed.
pub fn png_resealed(bytes: &[u8]) -> Vec<u8> {
    let mut sealed = bytes.to_vec();
    let mut at = 8;
    while let Some(length) = sealed.get(at..at + 4) {
        let length = u32::from_be_bytes([length[0], length[1], length[2], length[3]]) as usize;
        let Some(end) = (at + 8).checked_add(length).filter(|end| end + 4 <= sealed.len()) else {
            break;
        };
        let crc = crc32fast::hash(&sealed[at + 4..end]).to_be_bytes();
        sealed[end..end + 4].copy_from_slice(&crc);
        at = end + 4;
    }
    sealed
}

/// A pair file with its checksum corrected, if the place of the checksum is found.
pub(crate) fn pair_resealed(bytes: &[u8]) -> Vec<u8> {
    const DIGITS: usize = 64;
    /// How the checksum is written in the JSON within the JSON of the header.
    const KEY: &[u8] = b"checksum\\\":\\\"";
    let mut sealed = bytes.to_vec();
    let found = sealed.windows(KEY.len()).position(|window| window == KEY);
    let place = found.map(|at| at + KEY.len()..at + KEY.len() + DIGITS);
    if let Some(place) = place.filter(|place| place.end <= sealed.len()) {
        sealed[place.clone()].fill(b'0');
        let digest = Sha256::digest(&sealed);
        let digits: String = digest.iter().map(|byte| format!("{byte:02x}")).collect();
        sealed[place].copy_from_slice(digits.as_bytes());
    }
    sealed
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_right_stays_and_what_was_changed_is_right_again() {
        for png in crate::seeds::image().iter().filter(|seed| seed.starts_with(b"\x89PNG")) {
            assert!(png_resealed(png) == *png);
            let mut changed = png.clone();
            let last = changed.len() - 1;
            changed[last] ^= 1;
            assert!(png_resealed(&changed) == *png);
        }
        for pair in crate::seeds::pair_file() {
            assert!(pair_resealed(&pair) == pair);
            let mut changed = pair.clone();
            let last = changed.len() - 1;
            changed[last] ^= 1;
            let sealed = pair_resealed(&changed);
            assert!(sealed != changed && sealed != pair);
        }
    }
}
