//! The sampling map as an array, through the program.

#![expect(clippy::unwrap_used, reason = "a test that cannot set up its files has failed")]

use crate::bench::Bench;
use uvgraft::{Direction, MapOptions, SamplingMap, Size};
use uvgraft_io::pair_file;

/// An NPY file of `[height, width, 2]` floats, its header checked byte by byte.
fn grid(bench: &Bench, name: &str, size: Size) -> Vec<[f32; 2]> {
    let bytes = bench.bytes(name);
    let Size { width, height } = size;
    let dictionary =
        format!("{{'descr': '<f4', 'fortran_order': False, 'shape': ({height}, {width}, 2), }}");
    assert_eq!(bytes[..8], *b"\x93NUMPY\x01\0");
    let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let (header, values) = bytes[10..].split_at(length);
    assert!((10 + length).is_multiple_of(64), "{length}");
    let blanks = " ".repeat(length - dictionary.len() - 1);
    assert_eq!(std::str::from_utf8(header).unwrap(), format!("{dictionary}{blanks}\n"));
    assert_eq!(values.len(), size.texels() * 8);
    let (texels, []) = values.as_chunks::<8>() else { panic!("whole texels") };
    let float = |[a, b, c, d]: [u8; 4]| f32::from_le_bytes([a, b, c, d]);
    texels.iter().map(|&[a, b, c, d, e, f, g, h]| [[a, b, c, d], [e, f, g, h]].map(float)).collect()
}

#[test]
fn positions_follow_from_the_layouts() {
    let bench = Bench::new();
    // At this size the sheet ends on texel borders: from 0.1 to 0.5 across 40 and down 30 texels.
    let size = Size::new(40, 30);
    bench.succeed("map my.uvpair --size 40x30 --gutter 0 -o grid.npy");
    for (index, found) in grid(&bench, "grid.npy", size).into_iter().enumerate() {
        let (x, y) = (index % 40, index / 40);
        if (4..20).contains(&x) && (3..15).contains(&y) {
            let target = [(x as f64 + 0.5) / 40.0, (y as f64 + 0.5) / 30.0];
            for (found, target) in found.into_iter().zip(target) {
                // Half the size it has in the source.
                let wanted = 0.1 + 2.0 * (target - 0.1);
                assert!((f64::from(found) - wanted).abs() < 1e-6, "{x} {y}: {found} {wanted}");
            }
        } else {
            assert!(found.iter().all(|value| value.is_nan()), "{x} {y}: {found:?}");
        }
    }
}

#[test]
fn the_array_holds_what_the_map_says_in_both_directions() {
    let bench = Bench::new();
    let pair = pair_file::read(bench.path("my.uvpair")).unwrap().pair;
    let size = Size::new(33, 57);
    for (direction, options, gutter_px) in [
        (Direction::Forward, "", MapOptions::default().gutter_px),
        (Direction::Forward, "--gutter 3", 3),
        (Direction::Reverse, "--reverse --gutter 2", 2),
    ] {
        bench.succeed(&format!("map my.uvpair --size 33x57 {options} -o grid.npy"));
        let map = SamplingMap::new(&pair, direction, size, &MapOptions::with_gutter(gutter_px));
        let mut wanted = vec![[f32::NAN; 2]; size.texels()];
        for y in 0..size.height {
            for run in map.row(y) {
                let affine = &map.patches()[run.patch as usize].src_uv_from_tgt_px;
                for x in run.x..run.x + run.len {
                    let uv = affine.at([f64::from(x) + 0.5, f64::from(y) + 0.5]);
                    wanted[(y * size.width + x) as usize] = uv.map(|value| value as f32);
                }
            }
        }
        let transferred = map.stats().linked + map.stats().gutter;
        let found = grid(&bench, "grid.npy", size);
        assert_eq!(found.iter().filter(|uv| !uv[0].is_nan()).count(), transferred, "{options}");
        let bits = |grid: Vec<[f32; 2]>| grid.into_iter().map(|uv| uv.map(f32::to_bits));
        assert!(bits(found).eq(bits(wanted)), "{options}");
    }
}

#[test]
fn what_is_refused() {
    let bench = Bench::new();
    bench.derive("pair.npy", "my.uvpair", |_| ());
    bench.write("prose.uvpair", "This is not a pair.\n");
    bench.make_folder("folder.npy");
    for (args, wanted) in [
        ("map my.uvpair --size 8 -o grid.png", &["cannot write grid.png", "must be .npy"][..]),
        ("map my.uvpair --size 8 -o grid", &["cannot write grid: extension must be .npy"]),
        ("map my.uvpair --size 8 -o folder.npy", &["folder.npy", "is a folder"]),
        (
            "map my.uvpair --size 8 -o none/grid.npy",
            &["cannot write", "folder none does not exist"],
        ),
        ("map pair.npy --size 8 -o pair.npy", &["pair.npy is also an input"]),
        ("map none.uvpair --size 8 -o grid.npy", &["none.uvpair: ", "No such file"]),
        ("map prose.uvpair --size 8 -o grid.npy", &["prose.uvpair: ", "pair file"]),
        ("map my.uvpair -o grid.npy", &["--size"]),
        ("map my.uvpair --size 8", &["--output"]),
        ("map my.uvpair --size 0 -o grid.npy", &["must be N or WxH"]),
        ("map my.uvpair --size 8 --gutter 300 -o grid.npy", &["300", "from 0 to 256"]),
    ] {
        bench.refuse(args, wanted);
    }
}
