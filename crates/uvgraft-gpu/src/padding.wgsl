// Copies texels of a texture to others of the same texture, in two steps, since a kernel cannot read what it
// writes. The host puts before this the aliases Scalar and Stored.

struct Copies {
    // Logarithm of the side of tiles, and tiles in a row.
    tiles: vec2<u32>,
    width: u32,
    count: u32,
}

@group(0) @binding(0) var<uniform> copies: Copies;
@group(0) @binding(1) var source: texture_2d_array<Scalar>;
@group(0) @binding(2) var padded: Stored;
// Indices of the texels to read and to write.
@group(0) @binding(3) var<storage, read> pairs: array<vec2<u32>>;
@group(0) @binding(4) var<storage, read_write> values: array<vec4<u32>>;

fn invocation(group: vec3<u32>, groups: vec3<u32>, local: u32) -> u32 {
    return (group.y * groups.x + group.x) * 64u + local;
}

fn position(texel: u32) -> vec2<u32> {
    return vec2(texel % copies.width, texel / copies.width);
}

fn layer(at: vec2<u32>) -> u32 {
    return (at.y >> copies.tiles.x) * copies.tiles.y + (at.x >> copies.tiles.x);
}

fn in_layer(at: vec2<u32>) -> vec2<u32> {
    return at & vec2((1u << copies.tiles.x) - 1u);
}

@compute @workgroup_size(64)
fn gather(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let index = invocation(group, groups, local);
    if index >= copies.count { return; }
    let at = position(pairs[index].x);
    values[index] = bitcast<vec4<u32>>(textureLoad(source, in_layer(at), layer(at), 0));
}

@compute @workgroup_size(64)
fn scatter(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let index = invocation(group, groups, local);
    if index >= copies.count { return; }
    let at = position(pairs[index].y);
    textureStore(padded, in_layer(at), layer(at), bitcast<vec4<Scalar>>(values[index]));
}
