//! TIFFs of kinds that uvgraft reads and does not write, small enough to be written out.

/// A little-endian TIFF of one strip or tile, with tags of 16-bit numbers.
fn tiff(tags: &[(u16, &[u16])], strip: &[u8]) -> Vec<u8> {
    let mut file = b"II*\0\0\0\0\0".to_vec();
    file.extend(strip);
    let is_tiled = tags.iter().any(|&(tag, _)| tag == 322);
    let [offsets, counts] = if is_tiled { [324, 325] } else { [273, 279] };
    let (start, length) = ([8], [strip.len() as u16]);
    let mut tags = tags.to_vec();
    tags.extend([(offsets, &start[..]), (counts, &length)]);
    let mut directory = (tags.len() as u16).to_le_bytes().to_vec();
    for (tag, numbers) in tags {
        let mut value: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        if value.len() > 4 {
            let at = file.len() as u32;
            file.extend(value);
            value = at.to_le_bytes().to_vec();
        }
        value.resize(4, 0);
        directory.extend([&tag.to_le_bytes()[..], &3u16.to_le_bytes()].concat());
        directory.extend((numbers.len() as u32).to_le_bytes());
        directory.extend(value);
    }
    let at = file.len() as u32;
    file.splice(4..8, at.to_le_bytes());
    file.extend(directory);
    file.extend([0; 4]);
    file
}

/// A palette, blocks of luma and colour differences, a tile, PackBits, and both kinds of LZW.
pub(crate) fn all() -> Vec<Vec<u8>> {
    let grey = |compression: &'static [u16], strip: &[u8]| {
        let tags: [(u16, &[u16]); 6] =
            [(256, &[4]), (257, &[1]), (258, &[8]), (259, compression), (262, &[0]), (266, &[1])];
        tiff(&tags, strip)
    };
    let map: Vec<u16> = (0..12).map(|at| at * 5_000).collect();
    let palette: [(u16, &[u16]); 5] =
        [(256, &[5]), (257, &[2]), (258, &[2]), (262, &[3]), (320, &map)];
    let blocks: [(u16, &[u16]); 6] =
        [(256, &[3]), (257, &[2]), (258, &[8, 8, 8]), (262, &[6]), (277, &[3]), (530, &[2, 2])];
    let tile: [(u16, &[u16]); 9] = [
        (256, &[3]),
        (257, &[2]),
        (258, &[16]),
        (262, &[2]),
        (266, &[2]),
        (277, &[4]),
        (338, &[1]),
        (322, &[4]),
        (323, &[3]),
    ];
    vec![
        tiff(&palette, &[0b0001_1011, 0x40, 0b1110_0100, 0x80]),
        tiff(&blocks, &[10, 20, 30, 40, 128, 128, 76, 9, 76, 9, 85, 255]),
        tiff(&tile, &(0..96).collect::<Vec<u8>>()),
        grey(&[32_773], &[0xfe, 7, 0, 9]),
        // Codes of 9 bits: clear, 7, 7, 258 and the end.
        grey(&[5], &[0x80, 0x01, 0xc0, 0xf0, 0x28, 0x08]),
        // The same from the lowest bit on.
        grey(&[5], &[0x00, 0x0f, 0x1c, 0x10, 0x18, 0x10]),
    ]
}
