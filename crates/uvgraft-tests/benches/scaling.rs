//! How run times scale with texture and mesh size: Markdown tables, medians of several runs. The
//! time per texel or triangle should stay constant, cache effects aside.

#![allow(clippy::print_stdout, reason = "tables are what this is for")]

use std::collections::HashMap;
use std::sync::Arc;
use std::time::Instant;

use uvgraft::blend::Side;
use uvgraft::correspond::{By, FindOptions, find};
use uvgraft::piece::Weights;
use uvgraft::{
    Blend, BlendDomain, BlendOptions, Channels, Depth, Direction, Encoding, Extent, Filter, Graft,
    MapOptions, Mesh, Pair, Piece, SamplingMap, Size, Sizes, Texture,
};
use uvgraft_figure::Figure;
use uvgraft_tests::remeshed::Remeshed;
use uvgraft_tests::synthetic::{self, posed};

/// The median time of `runs` runs of `work`, in milliseconds; `prepare` is not timed.
fn median_ms<T, R>(
    runs: usize,
    mut prepare: impl FnMut() -> T,
    mut work: impl FnMut(T) -> R,
) -> f64 {
    let mut times: Vec<f64> = (0..runs)
        .map(|_| {
            let input = prepare();
            let start = Instant::now();
            let result = work(input);
            let time = start.elapsed().as_secs_f64() * 1e3;
            drop(result);
            time
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[runs / 2]
}

/// Transfers between textures of the same size, for one pair.
fn textures() {
    let pair = synthetic::sheets(20_000);
    println!(
        "\n| texture | covered texels | map | map and padding | bilinear, 8-bit RGB | ns per texel |"
    );
    println!("|---|---|---|---|---|---|");
    for side in [512, 1024, 2048, 4096, 8192] {
        let size = Size::square(side);
        let options = MapOptions::default();
        let runs = if side > 4096 { 5 } else { 11 };
        let map = median_ms(
            runs,
            || (),
            |()| SamplingMap::new(&pair, Direction::Forward, size, &options),
        );
        let builder = Graft::builder(Arc::clone(&pair), Sizes { from: size, to: size })
            .filter(Filter::Bilinear)
            .map_options(options);
        let new = || builder.clone().build().expect("a sound size");
        let prepared = median_ms(runs, || (), |()| new());
        let graft = new();
        let filled = |value| {
            Texture::filled(size, Channels::Rgb, Encoding::Srgb, Depth::U8, &[value; 3])
                .expect("a sound size")
        };
        let (source, base) = (filled(0.3), filled(0.6));
        let applied = median_ms(
            runs,
            || (source.clone(), base.clone()),
            |(source, base)| graft.apply(source, base),
        );
        let covered = graft.map().stats().covered;
        let each = (prepared + applied) * 1e6 / covered as f64;
        println!(
            "| {side}² | {covered} | {map:.2} ms | {prepared:.2} ms | {applied:.2} ms | {each:.2} |"
        );
    }
}

/// Maps of one size, for meshes with more and more triangles.
fn meshes() {
    let size = Size::square(2048);
    println!("\n| triangles | map of {size} | ns per triangle and covered texel |");
    println!("|---|---|---|");
    for triangles in [1_000, 10_000, 100_000, 1_000_000] {
        let pair = synthetic::sheets(triangles);
        let new = || SamplingMap::new(&pair, Direction::Forward, size, &MapOptions::default());
        let time = median_ms(7, || (), |()| new());
        let triangles = pair.target().faces().len();
        let each = time * 1e6 / (triangles + new().stats().covered) as f64;
        println!("| {triangles} | {time:.2} ms | {each:.2} |");
    }
}

/// Membranes over most of a bumpy sheet, for meshes with more and more triangles.
fn membranes() {
    println!("\n| triangles | membrane |");
    println!("|---|---|");
    for side in [71_u32, 223, 707] {
        let across = side + 1;
        let pair = bumpy_sheet(side);
        let margin = side / 12;
        let is_inner = |vertex: &u32| {
            [vertex % across, vertex / across].iter().all(|k| (margin..across - margin).contains(k))
        };
        let inner: Vec<u32> = (0..across * across).filter(is_inner).collect();
        let domain = BlendDomain::new(Arc::clone(&pair), Direction::Forward);
        let region = domain.vertices(Side::Target, &inner).expect("a region");
        let new = || Blend::new(&region, BlendOptions::default().membrane()).expect("a blend");
        let time = median_ms(3, || (), |()| new());
        println!("| {} | {time:.0} ms |", pair.target().faces().len());
    }
}

/// A sheet of squares with bumps, linked to itself.
fn bumpy_sheet(side: u32) -> Arc<Pair> {
    let across = side + 1;
    let mut rng = fastrand::Rng::with_seed(5);
    let positions: Vec<[f32; 3]> = (0..across * across)
        .map(|vertex| {
            let (x, y) = ((vertex % across) as f32, (vertex / across) as f32);
            let height = 8.0 * (x * 0.05).sin() * (y * 0.04).cos();
            [x + 0.4 * rng.f32(), y + 0.4 * rng.f32(), height + 0.3 * rng.f32()]
        })
        .collect();
    let uv = positions.iter().map(|&[x, y, _]| [x, y].map(|k| k / (across + 1) as f32)).collect();
    let squares = (0..side).flat_map(|y| (0..side).map(move |x| y * across + x));
    let mut faces: Vec<[u32; 3]> = squares
        .flat_map(|k| [[k, k + 1, k + across], [k + 1, k + across + 1, k + across]])
        .collect();
    rng.shuffle(&mut faces);
    let mesh = Mesh::from_triangles(positions, uv, &faces, &faces).expect("a sound mesh");
    let same: Vec<i64> = (0..i64::from(across * across)).collect();
    Arc::new(Pair::by_vertex_map(mesh.clone(), mesh, &same).expect("a pair"))
}

/// Heads of other topology and shape, and maps of their pieces beside maps of as many whole triangles.
fn registrations() {
    let size = Size::square(4096);
    println!(
        "\n| triangles | registration | pieces | map of {size} | of whole triangles | ratio |"
    );
    println!("|---|---|---|---|---|---|");
    let head = Figure::new().head;
    let own = Remeshed::new(&head);
    // Wider and flatter by a few percent.
    let other = posed(&head, false, |[x, y, z]| [1.05 * x, y, 0.96 * z]);
    for [from, to] in [
        [own.clone(), own.clone().turned().decimated(&head, 0.6, 1)],
        [own.clone().divided(), own.clone().turned()],
        [own.clone().turned(), own.clone().divided()],
    ] {
        let (source, target) = (from.mesh(&head), to.mesh(&other));
        let counts = [&source, &target].map(|mesh| mesh.faces().len());
        let mut options = FindOptions::default();
        options.by = By::Surface;
        let link = |(source, target)| find(source, target, &options).expect("two heads").pair;
        let registered = median_ms(3, || (source.clone(), target.clone()), link);
        let pair = link((source, target));
        let whole = of_whole_triangles(&pair);
        let pieces = pair.pieces().count();
        let map = |pair| {
            median_ms(
                7,
                || (),
                |()| SamplingMap::new(pair, Direction::Forward, size, &MapOptions::default()),
            )
        };
        let (map, wanted) = (map(&pair), map(&whole));
        println!(
            "| {}, {} | {registered:.0} ms | {pieces} | {map:.1} ms | {wanted:.1} ms | {:.2} |",
            counts[0],
            counts[1],
            map / wanted
        );
    }
}

/// The same links between meshes in which every piece is a triangle.
fn of_whole_triangles(pair: &Pair) -> Pair {
    let [mut source, mut target] = [Vec::new(), Vec::new()];
    for piece in pair.pieces() {
        let unit = |k: usize| std::array::from_fn(|i| f64::from(u8::from(i == k)));
        let [on_target, on_source]: [[Weights; 3]; 2] = match piece.extent {
            Extent::Whole(corners) => {
                [[0, 1, 2].map(unit), corners.map(|corner| unit(usize::from(corner)))]
            }
            Extent::Part { target, source } => [target, source],
        };
        for (mesh, face, corners, uvs) in [
            (pair.target(), piece.target, on_target, &mut target),
            (pair.source(), piece.source, on_source, &mut source),
        ] {
            let points = mesh.uv_faces()[face as usize].map(|point| mesh.uv()[point as usize]);
            uvs.extend(corners.map(|weights| {
                [0, 1].map(|axis| {
                    (0..3).map(|k| f64::from(points[k][axis]) * weights[k]).sum::<f64>() as f32
                })
            }));
        }
    }
    let mesh = |uv: &[[f32; 2]]| {
        // Corners at the same place are one, so that triangles make up islands.
        let mut points = HashMap::new();
        let mut places = Vec::new();
        let mut corner = |at: [f32; 2]| {
            *points.entry(at.map(f32::to_bits)).or_insert_with(|| {
                places.push(at);
                places.len() as u32 - 1
            })
        };
        let faces: Vec<[u32; 3]> =
            uv.as_chunks::<3>().0.iter().map(|&corners| corners.map(&mut corner)).collect();
        let positions = places.iter().map(|&[u, v]| [u, v, 0.0]).collect();
        Mesh::from_triangles(positions, places, &faces, &faces).expect("triangles of sound meshes")
    };
    let count = target.len() as u32 / 3;
    let whole = (0..count).map(|face| Piece::whole(face, face, [0, 1, 2]));
    Pair::from_pieces(mesh(&source), mesh(&target), whole).expect("a link for each triangle")
}

fn main() {
    textures();
    meshes();
    membranes();
    registrations();
}
