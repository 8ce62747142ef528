// Kernels of transfers. The host puts before them:
//   FILTER (0 nearest, 1 bilinear, 2 Catmull-Rom, 3 Lanczos-3), TAPS, ALPHA (whether the fourth channel is
//   alpha), WHOLE (whether values are filtered as integers), ONE (the level of 1.0), FLOATS (whether levels
//   are stored as they are), and the aliases Scalar (u32 or f32) and Stored (a storage texture).
//
// Positions have 64 bits, the low word first: 32.32 fixed point, in texels. Textures larger than the device
// allows are layers of square tiles, the sides of which are powers of two.

struct Run {
    // Index of the first texel among those of the band.
    first: u32,
    // Column and row in the target, 16 bits each.
    texel: u32,
    footprint: u32,
    unused: u32,
    start_x: vec2<u32>,
    start_y: vec2<u32>,
    step_x: vec2<u32>,
    step_y: vec2<u32>,
}

struct Footprint {
    samples: vec2<u32>,
    first_x: vec2<u32>,
    first_y: vec2<u32>,
    across_x: vec2<u32>,
    across_y: vec2<u32>,
    down_x: vec2<u32>,
    down_y: vec2<u32>,
}

struct Sizes {
    source: vec2<u32>,
    // Logarithms of the sides of tiles, and tiles in a row.
    source_tiles: vec2<u32>,
    target_tiles: vec2<u32>,
    // Invocations that have something to do.
    count: u32,
    // Width of the texture whose texels are copied.
    width: u32,
}

@group(0) @binding(0) var<uniform> sizes: Sizes;
@group(0) @binding(1) var source: texture_2d_array<Scalar>;
@group(0) @binding(2) var base: texture_2d_array<Scalar>;
@group(0) @binding(3) var result: Stored;
// A run for every BLOCK texels, then the texel's run is a few further on.
@group(0) @binding(4) var<storage, read> blocks: array<u32>;
@group(0) @binding(5) var<storage, read> runs: array<Run>;
@group(0) @binding(6) var<storage, read> footprints: array<Footprint>;
// Lanczos weights at equally spaced phases, eight each; floats by their bits.
@group(0) @binding(7) var<storage, read> phases: array<i32>;

const BLOCK = 64u;
const WEIGHT_BITS = 14u;
const ROW_BITS = 6u;
const VALUE_BITS = 20u;
const SUM_BITS = 12u;
const LOST = 1 << (WEIGHT_BITS - 1u);
const NEAR = 8;

fn sum(a: vec2<u32>, b: vec2<u32>) -> vec2<u32> {
    let low = a.x + b.x;
    return vec2(low, a.y + b.y + select(0u, 1u, low < a.x));
}

// A product with a number below 2^16.
fn times(a: vec2<u32>, k: u32) -> vec2<u32> {
    let lower = (a.x & 0xffffu) * k;
    let upper = (a.x >> 16u) * k;
    let low = lower + (upper << 16u);
    return vec2(low, a.y * k + (upper >> 16u) + select(0u, 1u, low < lower));
}

fn near_texture(at: vec2<u32>, count: u32) -> vec2<u32> {
    let texel = bitcast<i32>(at.y);
    let last = i32(count) + NEAR;
    if texel < -NEAR { return vec2(0u, bitcast<u32>(-NEAR)); }
    if texel >= last { return vec2(0u, bitcast<u32>(last)); }
    return at;
}

fn layer(at: vec2<u32>, tiles: vec2<u32>) -> u32 {
    return (at.y >> tiles.x) * tiles.y + (at.x >> tiles.x);
}

fn in_layer(at: vec2<u32>, tiles: vec2<u32>) -> vec2<u32> {
    return at & vec2((1u << tiles.x) - 1u);
}

fn texel(x: i32, y: i32) -> vec4<Scalar> {
    let last = vec2<i32>(sizes.source) - 1;
    let at = vec2<u32>(clamp(vec2(x, y), vec2(0), last));
    return textureLoad(source, in_layer(at, sizes.source_tiles), layer(at, sizes.source_tiles), 0);
}

// The last texel whose centre is not beyond a position, and the distance from there.
struct Split { texel: i32, bits: u32 }

fn split(at: vec2<u32>) -> Split {
    let low = at.x - 0x80000000u;
    return Split(bitcast<i32>(at.y - select(0u, 1u, at.x < 0x80000000u)), low);
}

fn fraction(bits: u32) -> f32 {
    return f32(bits >> 8u) * (1.0 / 16777216.0);
}

fn cubic(t: f32) -> array<f32, 4> {
    return array<f32, 4>(
        ((-0.5 * t + 1.0) * t - 0.5) * t,
        (1.5 * t - 2.5) * t * t + 1.0,
        ((-1.5 * t + 2.0) * t + 0.5) * t,
        (0.5 * t - 0.5) * t * t,
    );
}

fn whole_weights(bits: u32) -> array<i32, 6> {
    var weights = array<i32, 6>();
    if FILTER == 1u {
        let high = i32(bits >> (32u - WEIGHT_BITS));
        weights[0] = (1 << WEIGHT_BITS) - high;
        weights[1] = high;
    } else if FILTER == 2u {
        let exact = cubic(fraction(bits));
        for (var tap = 0u; tap < 4u; tap++) {
            weights[tap] = i32(round(exact[tap] * f32(1 << WEIGHT_BITS)));
        }
    } else {
        let low = (bits >> 22u) * 8u;
        let part = i32((bits >> 7u) & 0x7fffu);
        for (var tap = 0u; tap < TAPS; tap++) {
            let rise = (phases[low + 8u + tap] - phases[low + tap]) * part;
            weights[tap] = phases[low + tap] + ((rise + (1 << 14u)) >> 15u);
        }
    }
    return weights;
}

fn weights(bits: u32) -> array<f32, 6> {
    var weights = array<f32, 6>();
    let t = fraction(bits);
    if FILTER == 1u {
        weights[0] = 1.0 - t;
        weights[1] = t;
    } else if FILTER == 2u {
        let exact = cubic(t);
        for (var tap = 0u; tap < 4u; tap++) { weights[tap] = exact[tap]; }
    } else {
        let phase = t * 1024.0;
        let index = min(u32(phase), 1023u);
        for (var tap = 0u; tap < TAPS; tap++) {
            let low = bitcast<f32>(phases[index * 8u + tap]);
            let high = bitcast<f32>(phases[index * 8u + 8u + tap]);
            weights[tap] = low + (high - low) * (phase - f32(index));
        }
    }
    return weights;
}

fn whole_sample(at_x: vec2<u32>, at_y: vec2<u32>) -> vec4<i32> {
    let x = split(near_texture(at_x, sizes.source.x));
    let y = split(near_texture(at_y, sizes.source.y));
    let before = i32(TAPS) / 2 - 1;
    var across = whole_weights(x.bits);
    var down = whole_weights(y.bits);
    var value = vec4(0);
    for (var b = 0u; b < TAPS; b++) {
        var row = vec4(0);
        for (var a = 0u; a < TAPS; a++) {
            row += vec4<i32>(texel(x.texel + i32(a) - before, y.texel + i32(b) - before)) * across[a];
        }
        value += (row >> vec4(WEIGHT_BITS - ROW_BITS)) * down[b];
    }
    return value;
}

// As levels, premultiplied if there is alpha.
fn levels(x: i32, y: i32) -> vec4<f32> {
    let value = vec4<f32>(texel(x, y));
    if ALPHA { return vec4(value.rgb * (value.a / ONE), value.a); }
    return value;
}

fn sample(at_x: vec2<u32>, at_y: vec2<u32>) -> vec4<f32> {
    let near_x = near_texture(at_x, sizes.source.x);
    let near_y = near_texture(at_y, sizes.source.y);
    if FILTER == 0u { return levels(bitcast<i32>(near_x.y), bitcast<i32>(near_y.y)); }
    let x = split(near_x);
    let y = split(near_y);
    let before = i32(TAPS) / 2 - 1;
    var across = weights(x.bits);
    var down = weights(y.bits);
    var value = vec4(0.0);
    for (var a = 0u; a < TAPS; a++) {
        var column = vec4(0.0);
        for (var b = 0u; b < TAPS; b++) {
            column += levels(x.texel + i32(a) - before, y.texel + i32(b) - before) * down[b];
        }
        value += column * across[a];
    }
    return value;
}

fn from_level(level: vec4<f32>) -> vec4<Scalar> {
    if FLOATS { return vec4<Scalar>(level); }
    return vec4<Scalar>(clamp(level + 0.5, vec4(0.0), vec4(ONE)));
}

fn store(at: vec2<u32>, value: vec4<Scalar>) {
    textureStore(result, in_layer(at, sizes.target_tiles), layer(at, sizes.target_tiles), value);
}

// Composites premultiplied levels over the base.
fn composite(at: vec2<u32>, value: vec4<f32>) {
    if value.a <= 0.0 { return; }
    let tiles = sizes.target_tiles;
    let under = vec4<f32>(textureLoad(base, in_layer(at, tiles), layer(at, tiles), 0));
    let alpha = min(value.a, ONE);
    let scale = alpha / value.a * ONE;
    let below = (ONE - alpha) / ONE * under.a;
    let total = alpha + below;
    store(at, from_level(vec4((value.rgb * scale + under.rgb * below) / total, total)));
}

fn invocation(group: vec3<u32>, groups: vec3<u32>, local: u32) -> u32 {
    return (group.y * groups.x + group.x) * 64u + local;
}

@compute @workgroup_size(64)
fn transfer(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let index = invocation(group, groups, local);
    if index >= sizes.count { return; }
    var number = blocks[index / BLOCK];
    // A last run without texels ends the search.
    while runs[number + 1u].first <= index { number++; }
    let run = runs[number];
    let k = index - run.first;
    let at = vec2((run.texel & 0xffffu) + k, run.texel >> 16u);
    let x = sum(run.start_x, times(run.step_x, k));
    let y = sum(run.start_y, times(run.step_y, k));
    if FILTER == 0u && !ALPHA {
        let column = bitcast<i32>(near_texture(x, sizes.source.x).y);
        let row = bitcast<i32>(near_texture(y, sizes.source.y).y);
        store(at, texel(column, row));
        return;
    }
    let footprint = footprints[run.footprint];
    let count = footprint.samples.x * footprint.samples.y;
    if count == 1u {
        if WHOLE {
            let value = whole_sample(x, y) + ((1 << (VALUE_BITS - 1u)) + LOST);
            store(at, vec4<Scalar>(clamp(value >> vec4(VALUE_BITS), vec4(0), vec4(255))));
        } else if ALPHA {
            composite(at, sample(x, y));
        } else {
            store(at, from_level(sample(x, y)));
        }
        return;
    }
    var whole = vec4(0);
    var total = vec4(0.0);
    for (var b = 0u; b < footprint.samples.y; b++) {
        let row_x = sum(sum(x, footprint.first_x), times(footprint.down_x, b));
        let row_y = sum(sum(y, footprint.first_y), times(footprint.down_y, b));
        for (var a = 0u; a < footprint.samples.x; a++) {
            let sample_x = sum(row_x, times(footprint.across_x, a));
            let sample_y = sum(row_y, times(footprint.across_y, a));
            if WHOLE {
                whole += (whole_sample(sample_x, sample_y) + LOST) >> vec4(VALUE_BITS - SUM_BITS);
            } else {
                total += sample(sample_x, sample_y);
            }
        }
    }
    if WHOLE {
        let mean = vec4<f32>(whole) * (1.0 / f32(count << SUM_BITS));
        store(at, vec4<Scalar>(clamp(round(mean), vec4(0.0), vec4(255.0))));
    } else if ALPHA {
        composite(at, total * (1.0 / f32(count)));
    } else {
        store(at, from_level(total * (1.0 / f32(count))));
    }
}
