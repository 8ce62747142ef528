//! Sampling maps in the formats of other tools, and transfers through them.

#![expect(clippy::unwrap_used, reason = "a test that cannot set up its files has failed")]

use crate::bench::{self, Bench};
use crate::exports::{SOURCE, TARGET, bilinear, figure, map, positions};
use uvgraft::{Channels, Depth, Size, Texels, Texture};
use uvgraft_io::arrays;

/// The levels of an 8-bit texture, and its number of channels.
fn levels(texture: &Texture) -> (&[u8], usize) {
    let Texels::U8(levels) = texture.texels() else { panic!("8 bits") };
    (levels, texture.channels().count())
}

/// The greatest difference between the colours of two results, where both have any.
fn greatest_difference(bench: &Bench, a: &str, b: &str) -> u8 {
    let [a, b] = [a, b].map(|name| bench.texture(name));
    assert_eq!((a.size(), a.channels()), (b.size(), b.channels()));
    let (a, b) = (levels(&a).0, levels(&b).0);
    a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max().unwrap()
}

#[test]
fn the_matrix_is_the_transfer() {
    let bench = figure();
    let source = bench.texture("face.png");
    let source = levels(&source).0;
    // Minified and magnified, with and without rows below 16 texels, in both directions.
    for (options, side) in [
        ("--size 33x50 --filter lanczos3", [33, 50]),
        ("--size 200 --filter bilinear --gutter 3", [200, 200]),
        ("--size 90x40 --filter catmull-rom", [90, 40]),
        ("--size 70x60 --filter nearest", [70, 60]),
        ("--size 64x80 --filter lanczos3 --prefer left", [64, 80]),
    ] {
        bench.succeed(&format!("map demo.uvpair {options} --source-size 72x64 -o h.csr.npz"));
        bench.succeed(&format!("transfer demo.uvpair face.png {options} -o out.png"));
        let out = bench.texture("out.png");
        let (out, count) = levels(&out);
        assert_eq!(count, 4);
        let matrix = arrays::read(bench.path("h.csr.npz")).unwrap();
        assert_eq!(matrix.text("format"), Some("csr"));
        let integers = |name: &str| matrix.require(name).unwrap().integers().unwrap();
        let rows = side[0] * side[1];
        assert_eq!(integers("shape"), [rows, SOURCE.texels() as i64]);
        let (ends, columns) = (integers("indptr"), integers("indices"));
        let data = matrix.require("data").unwrap().f32s().into_owned();
        assert_eq!((ends.len() as i64, ends[0]), (rows + 1, 0));
        assert_eq!(ends.last(), Some(&(data.len() as i64)));
        let mut reached = 0;
        for (texel, range) in out.chunks_exact(4).zip(ends.windows(2)) {
            let range = range[0] as usize..range[1] as usize;
            assert_eq!(range.is_empty(), texel[3] == 0, "{options}");
            if range.is_empty() {
                continue;
            }
            reached += 1;
            for channel in 0..3 {
                let terms = range.clone().map(|k| {
                    f64::from(data[k]) * f64::from(source[columns[k] as usize * 3 + channel])
                });
                let value = terms.sum::<f64>().clamp(0.0, 255.0);
                let found = f64::from(texel[channel]);
                assert!((value - found).abs() <= 1.0, "{options}: {value} {found}");
            }
        }
        assert!(reached > 100, "{options}: {reached}");
    }
}

#[test]
fn every_format_is_read_back_as_one_sample() {
    let bench = figure();
    let size = "--size 480x520";
    bench.succeed(&format!("map demo.uvpair {size} -o grid.npy"));
    bench.succeed(&format!("map demo.uvpair {size} -o reference.npz"));
    let exact = "--convention exact --source-size 72x64";
    bench.succeed(&format!("map demo.uvpair {size} {exact} -o exact.npz"));
    bench.succeed(&format!("map demo.uvpair {size} --format exr -o st.exr"));
    bench.succeed(&format!("transfer demo.uvpair face.png {size} --filter bilinear -o pair.png"));
    for map in ["grid.npy", "reference.npz", "exact.npz", "st.exr"] {
        let run = format!("transfer padded.png --with-map {map} --filter bilinear -o {map}.png");
        bench.succeed(&run);
    }
    for map in ["reference.npz", "exact.npz", "st.exr"] {
        let difference = greatest_difference(&bench, "grid.npy.png", &format!("{map}.png"));
        assert!(difference <= 1, "{map}: {difference}");
    }
    let [padded, ours, pair] = ["padded.png", "grid.npy.png", "pair.png"].map(|name| {
        let texture = bench.texture(name);
        assert!(texture.depth() == Depth::U8);
        texture
    });
    let (ours, pair) = (levels(&ours).0, levels(&pair).0);
    let mut compared = 0;
    for (k, position) in positions(&map(&bench)).into_iter().enumerate() {
        let (ours, pair) = (&ours[4 * k..][..4], &pair[4 * k..][..4]);
        assert_eq!((ours[3], pair[3]), if position.is_some() { (255, 255) } else { (0, 0) });
        let Some((uv, true)) = position else { continue };
        compared += 1;
        for channel in 0..3 {
            let wanted = bilinear(&padded, uv, channel);
            for found in [ours[channel], pair[channel]] {
                assert!((wanted - f64::from(found)).abs() <= 1.0, "{k}: {wanted} {found}");
            }
        }
    }
    assert!(compared * 20 > TARGET.texels(), "{compared} texels are not minified");
}

#[test]
fn what_transfers_do_through_a_map() {
    let bench = Bench::new();
    bench.succeed("map my.uvpair --size 40x30 --gutter 0 -o grid.npy");
    // The input layout holds the sheet at twice the size, from 0.1 to 0.9.
    bench.paint("red.png", (64, 64), Channels::Rgb, &[200, 10, 30]);
    bench.paint("base.png", (80, 60), Channels::Rgb, &[0, 90, 0]);
    bench
        .succeed("transfer red.png --with-map grid.npy --onto base.png --mask mask.png -o out.jpg");
    let out = bench.texture("out.jpg");
    assert_eq!(out.size(), Size::new(40, 30));
    bench.succeed("transfer red.png --with-map grid.npy --onto base.png -o out.png");
    let out = bench.texture("out.png");
    assert_eq!(bench::texel_u8(&out, 10, 10), [200, 10, 30]);
    assert_eq!(bench::texel_u8(&out, 30, 20), [0, 90, 0]);
    assert_eq!(bench::texel_u8(&bench.texture("mask.png"), 10, 10), [255]);
    // 16 bits, data, several textures, and maps of a material.
    let deep = Texture::filled(
        Size::square(16),
        Channels::Grey,
        uvgraft::Encoding::Srgb,
        Depth::U16,
        &[0.3],
    );
    bench.save("deep.png", deep.unwrap());
    bench.succeed("transfer deep.png --with-map grid.npy --data -o deep_out.png");
    let out = bench.texture("deep_out.png");
    assert_eq!(out.depth(), Depth::U16);
    assert!((out.get(10, 10, 0) - 0.3).abs() < 1e-4);
    bench.make_folder("many");
    bench.succeed("transfer red.png deep.png --with-map grid.npy --size 40x30 -o many");
    assert!(bench.exists("many/red.png") && bench.exists("many/deep.png"));
    let maps = "--map albedo=red.png --map roughness=deep.png";
    bench.succeed(&format!("transfer --with-map grid.npy {maps} -o material/"));
    assert!(bench.exists("material/albedo.png") && bench.exists("material/roughness.png"));
    // A changed map makes outputs out of date.
    let again = "transfer red.png --with-map grid.npy --skip-existing -o again.png";
    bench.succeed(again);
    assert_eq!(bench.succeed(again), "1 of 1 up to date\n");
    bench.succeed("map my.uvpair --size 40x30 --gutter 1 -o grid.npy");
    assert_eq!(bench.succeed(again), "0 of 1 up to date\n");
}

#[test]
fn what_exports_refuse() {
    let bench = Bench::new();
    let csr = "map my.uvpair --size 8 -o h.csr.npz";
    for (args, wanted) in [
        (csr.to_owned(), &["--source-size is required"][..]),
        (format!("{csr} --source-size 0"), &["must be N or WxH"]),
        (format!("{csr} --source-size 8 --convention exact"), &["--convention", "npz only"]),
        ("map my.uvpair --size 8 --convention exact -o a.npz".to_owned(), &["--source-size is"]),
        ("map my.uvpair --size 8 --source-size 8 -o a.npz".to_owned(), &["--source-size is for"]),
        ("map my.uvpair --size 8 --source-size 8 -o a.exr".to_owned(), &["--source-size is for"]),
        ("map my.uvpair --size 8 --filter nearest -o a.npy".to_owned(), &["csr only"]),
        ("map my.uvpair --size 8 -o a.csr".to_owned(), &["extension must be"]),
        ("map my.uvpair --size 8 --format png -o a.npy".to_owned(), &["png"]),
        ("map my.uvpair --size 8 --format csr --source-size 8 -o none/a".to_owned(), &["none"]),
    ] {
        bench.refuse(&args, wanted);
    }
}

#[test]
fn what_a_map_rules_out() {
    let bench = Bench::new();
    bench.paint("red.png", (8, 8), Channels::Rgb, &[200, 10, 30]);
    bench.write("list.txt", "1 2 3\n");
    bench.succeed("map my.uvpair --size 8 -o grid.npy");
    let transfer = "transfer red.png --with-map grid.npy -o out.png";
    for (options, wanted) in [
        ("--blend membrane", &["--with-map cannot be used with --blend", "a map has none"][..]),
        ("--feather 5mm", &["surface of a mesh"]),
        ("--region list.txt", &["--region", "a map has none"]),
        ("--grow 2rings", &["--grow"]),
        ("--preview seen.png", &["--preview"]),
        ("--fit", &["--fit", "way back"]),
        ("--reverse", &["--reverse", "map --reverse"]),
        ("--overlap average", &["--overlap average"]),
        ("--size 9", &["--size must be that of the map, 8×8, got 9×9"]),
        ("--gutter 3", &["--gutter"]),
        ("--prefer left", &["--prefer"]),
    ] {
        bench.refuse(&format!("{transfer} {options}"), wanted);
    }
    for (args, wanted) in [
        ("transfer my.uvpair red.png --with-map grid.npy -o out.png", &["leave out my.uvpair"][..]),
        ("transfer --with-map grid.npy -o out.png", &["no textures"]),
        ("transfer red.png --with-map grid.npy --map albedo=red.png -o m/", &["red.png"]),
        ("transfer --with-map grid.npy --map normal=red.png -o m/", &["tangent frames"]),
        ("transfer red.png --with-map red.png -o out.png", &["red.png: must be an NPY array"]),
        ("transfer red.png --with-map none.npy -o out.png", &["none.npy: "]),
        ("transfer red.png --with-map grid.npy -o grid.npy", &["grid.npy"]),
        ("transfer my.uvpair -o out.png", &["TEXTURE"]),
    ] {
        bench.refuse(args, wanted);
    }
}

/// An NPY array with a header and values as given.
fn npy(shape: &str, values: &[f32]) -> Vec<u8> {
    let header = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}, }}\n");
    let mut bytes = b"\x93NUMPY\x01\0".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.bytes());
    bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    bytes
}

#[test]
fn hostile_maps() {
    let bench = Bench::new();
    bench.paint("red.png", (8, 8), Channels::Rgb, &[200, 10, 30]);
    bench.succeed("map my.uvpair --size 8 -o good.npy");
    bench.succeed("map my.uvpair --size 8 -o good.npz");
    bench.succeed("map my.uvpair --size 8 -o good.exr");
    bench.succeed("map my.uvpair --size 8 --source-size 8 -o good.csr.npz");
    for name in ["good.npy", "good.npz", "good.exr"] {
        bench.derive(&format!("short_{name}"), name, |bytes| bytes.truncate(bytes.len() - 40));
    }
    bench.write("empty.npy", b"");
    bench.write("flat.npy", npy("(4, 4)", &[0.0; 16]));
    bench.write("three.npy", npy("(2, 2, 3)", &[0.0; 12]));
    bench.write("none.npy", npy("(0, 2, 2)", &[]));
    bench.write("huge.npy", npy("(32769, 1, 2)", &[0.0; 65538]));
    bench.write("claims.npy", npy("(30000, 30000, 2)", &[0.0; 8]));
    bench.write("overflow.npy", npy("(9223372036854775807, 9223372036854775807, 2)", &[0.0; 8]));
    bench.write("nan.npy", npy("(2, 2, 2)", &[f32::NAN; 8]));
    bench.write("inf.npy", npy("(1, 2, 2)", &[0.5, 0.5, 0.5, f32::INFINITY]));
    bench.write("far.npy", npy("(1, 2, 2)", &[0.5, 0.5, -1e30, 0.5]));
    for (name, wanted) in [
        ("short_good.npy", "bytes"),
        ("short_good.npz", "archive"),
        ("short_good.exr", "short_good.exr: "),
        ("good.csr.npz", "sparse matrix"),
        ("empty.npy", "the file is empty"),
        ("flat.npy", "(height, width, 2)"),
        ("three.npy", "(height, width, 2)"),
        ("none.npy", "(height, width, 2)"),
        ("huge.npy", "sides up to 32768, got [32769, 1, 2]"),
        ("claims.npy", "bytes"),
        ("overflow.npy", "bytes"),
        ("nan.npy", "at least one texel"),
        ("inf.npy", "the position of texel (1, 0) must be NaN or lie between"),
        ("far.npy", "the position of texel (1, 0)"),
    ] {
        bench.refuse(&format!("transfer red.png --with-map {name} -o out.png"), &[name, wanted]);
    }
    // One texel is a map too, and positions somewhat outside read the edge.
    bench.write("one.npy", npy("(1, 1, 2)", &[7.5, -3.0]));
    bench.succeed("transfer red.png --with-map one.npy -o out.png");
    assert_eq!(bench::texel_u8(&bench.texture("out.png"), 0, 0), [200, 10, 30, 255]);
}
