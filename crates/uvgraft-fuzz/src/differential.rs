//! Fast paths against references, on inputs that the bytes decide.

use std::io::Cursor;
use std::sync::Arc;

use uvgraft::{
    Channels, Depth, Direction, Encoding, Filter, Graft, Mesh, Pair, Size, Sizes, Texels, Texture,
};
use uvgraft_image::{BandEncoder, Format, Image, TextureSpec, WriteOptions, decode};
use uvgraft_tests::independent;

/// Numbers from bytes; zeros at their end.
struct Numbers<'a>(&'a [u8]);

impl Numbers<'_> {
    fn byte(&mut self) -> u8 {
        let Some((&first, rest)) = self.0.split_first() else { return 0 };
        self.0 = rest;
        first
    }

    fn below(&mut self, limit: u32) -> u32 {
        u32::from(u16::from_le_bytes([self.byte(), self.byte()])) % limit
    }

    /// A coordinate in or near the unit square, on a grid, so that corners coincide often.
    fn coordinate(&mut self) -> f32 {
        (f32::from(self.byte()) - 20.0) / 215.0
    }
}

/// Transfers between random meshes agree with an independent implementation, and bands with the
/// whole.
pub(crate) fn resampling(bytes: &[u8]) {
    let mut numbers = Numbers(bytes);
    let faces: Vec<[u32; 3]> = {
        let (vertices, faces) = (3 + numbers.below(9), 1 + numbers.below(8));
        (0..faces).map(|_| [0; 3].map(|_: u32| numbers.below(vertices))).collect()
    };
    let vertices = 12;
    let positions = (0..vertices).map(|k| [k as f32, (k * k % 7) as f32, (k % 3) as f32]).collect();
    let positions: Vec<[f32; 3]> = positions;
    let mut layout = || -> Vec<[f32; 2]> {
        (0..vertices).map(|_| [numbers.coordinate(), numbers.coordinate()]).collect()
    };
    let layouts = [layout(), layout()];
    let [source, target] =
        layouts.map(|uv| Mesh::from_triangles(positions.clone(), uv, &faces, &faces));
    let (Ok(source), Ok(target)) = (source, target) else { return };
    let ids: Vec<i64> = (0..vertices).collect();
    let Ok(pair) = Pair::by_vertex_map(source, target, &ids) else { return };
    let pair = Arc::new(pair);
    let mut side = || 1 + numbers.below(70);
    let sizes = Sizes { from: Size::new(side(), side()), to: Size::new(side(), side()) };
    let direction = if numbers.byte() % 2 == 0 { Direction::Forward } else { Direction::Reverse };
    let values = (0..sizes.from.texels() * 3).map(|_| numbers.byte()).collect();
    let texture = Texture::new(sizes.from, Channels::Rgb, Encoding::Srgb, Texels::U8(values));
    let base = Texture::filled(sizes.to, Channels::Rgb, Encoding::Srgb, Depth::U8, &[0.5; 3]);
    let (Ok(texture), Ok(base)) = (texture, base) else { return };
    for filter in [Filter::Nearest, Filter::Bilinear, Filter::CatmullRom, Filter::Lanczos3] {
        let builder = Graft::builder(Arc::clone(&pair), sizes).direction(direction);
        let graft = builder.filter(filter).gutter_px(0).build().expect("sizes are sound");
        let overlay = graft.overlay(&texture, base.format()).expect("formats are sound");
        let whole = overlay.lay(0, base.clone()).expect("the base is whole");
        let height = 1 + u32::from(numbers.byte() % 7);
        for first in (0..sizes.to.height).step_by(height as usize) {
            let end = sizes.to.height.min(first + height);
            let band = overlay.lay(first, base.rows(first..end)).expect("within the base");
            assert!(band == whole.rows(first..end), "{filter:?}: rows from {first}");
        }
        if filter == Filter::Bilinear {
            compare(&pair, direction, &texture, &whole);
        }
    }
}

/// Compares texels that one triangle covers, with all that they read inside of the source.
fn compare(pair: &Pair, direction: Direction, source: &Texture, result: &Texture) {
    let Texels::U8(values) = result.texels() else { unreachable!("8 bits stay 8 bits") };
    let found = independent::transfer(pair, direction, source, result.size());
    let mut is_disputed = disputed(pair.to(direction), result.size());
    // Islands may overlap themselves too.
    let width = result.size().width as usize;
    for (texel, _) in found.iter().enumerate().filter(|(_, found)| found.covering > 1) {
        let (x, y) = (texel % width, texel / width);
        for row in y.saturating_sub(2)..(y + 3).min(found.len() / width) {
            let columns = x.saturating_sub(2)..(x + 3).min(width);
            is_disputed[row * width..][columns].fill(true);
        }
    }
    for (texel, found) in found.iter().enumerate() {
        if !(found.linked && found.inside_source && found.covering == 1) || is_disputed[texel] {
            continue;
        }
        for channel in 0..3 {
            let (value, wanted) = (f64::from(values[3 * texel + channel]), found.value[channel]);
            assert!((value - wanted).abs() <= 1.0, "texel {texel}: {value}, wanted {wanted}");
        }
    }
}

/// Which texels are within two texels of triangles that do not share an edge: where islands overlap, if
/// only between texels' centres, their owner keeps a fringe around its triangles.
fn disputed(mesh: &Mesh, size: Size) -> Vec<bool> {
    let scale = [f64::from(size.width), f64::from(size.height)];
    let triangles: Vec<[[f64; 2]; 3]> = (0..mesh.faces().len())
        .map(|face| {
            mesh.uv_triangle(face).map(|uv| [0, 1].map(|axis| f64::from(uv[axis]) * scale[axis]))
        })
        .collect();
    let share_an_edge = |a: usize, b: usize| {
        let [a, b] = [a, b].map(|face| mesh.faces()[face]);
        a.iter().filter(|vertex| b.contains(vertex)).count() >= 2
    };
    (0..size.texels())
        .map(|texel| {
            let centre = [texel % size.width as usize, texel / size.width as usize];
            let centre = centre.map(|at| at as f64 + 0.5);
            let near: Vec<usize> = (0..triangles.len())
                .filter(|&face| distance(centre, triangles[face]) <= 2.0)
                .collect();
            near.iter().any(|&a| near.iter().any(|&b| a < b && !share_an_edge(a, b)))
        })
        .collect()
}

/// The distance of a point from a triangle, which may be a line or a point.
fn distance(point: [f64; 2], corners: [[f64; 2]; 3]) -> f64 {
    let minus = |a: [f64; 2], b: [f64; 2]| [a[0] - b[0], a[1] - b[1]];
    let cross = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
    let edges = [0, 1, 2].map(|k| (corners[k], minus(corners[(k + 1) % 3], corners[k])));
    let sides = edges.map(|(from, along)| cross(along, minus(point, from)));
    if sides.iter().all(|&side| side > 0.0) || sides.iter().all(|&side| side < 0.0) {
        return 0.0;
    }
    let to_edges = edges.map(|(from, along)| {
        let [across, squared] =
            [minus(point, from), along].map(|v| v[0] * along[0] + v[1] * along[1]);
        let share = if squared > 0.0 { (across / squared).clamp(0.0, 1.0) } else { 0.0 };
        let nearest = [from[0] + share * along[0], from[1] + share * along[1]];
        minus(point, nearest)[0].hypot(minus(point, nearest)[1])
    });
    to_edges.into_iter().fold(f64::INFINITY, f64::min)
}

/// A PNG in bands of any height decodes to what was encoded.
pub(crate) fn png_round_trip(bytes: &[u8]) {
    let mut numbers = Numbers(bytes);
    let size = Size::new(1 + numbers.below(90), 1 + numbers.below(60));
    let channels = [Channels::Grey, Channels::GreyAlpha, Channels::Rgb, Channels::Rgba];
    let channels = channels[numbers.below(4) as usize];
    let (band, kind) = (1 + numbers.below(size.height), numbers.byte());
    let options = WriteOptions::default().compress(kind & 2 != 0);
    let count = size.texels() * channels.count();
    let texels = if kind & 1 == 0 {
        Texels::U8((0..count).map(|_| numbers.byte()).collect())
    } else {
        Texels::U16((0..count).map(|_| u16::from_le_bytes([numbers.byte(); 2])).collect())
    };
    let Ok(texture) = Texture::new(size, channels, Encoding::Srgb, texels) else { return };
    let image = Image { texture, icc: (kind & 4 != 0).then(|| vec![kind; 9]) };
    let spec = TextureSpec::from(&image.texture);
    let out = Cursor::new(Vec::new());
    let encoder = BandEncoder::new(out, Format::PNG, spec, image.icc.as_deref(), &options);
    let mut encoder = encoder.expect("PNG holds such textures");
    for first in (0..size.height).step_by(band as usize) {
        let rows = image.texture.rows(first..size.height.min(first + band));
        encoder.push(&rows).expect("the rows are those of the image");
    }
    let (_, file) = encoder.finish().expect("all rows were pushed");
    assert!(decode(file.get_ref()).expect("a PNG of our own") == image);
}
