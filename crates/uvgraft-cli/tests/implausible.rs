//! What is likely to be a mistake is told: parts with textures of their own, layouts that are flipped,
//! pairs that link next to nothing, and pictures that were made for another layout.

#![expect(clippy::unwrap_used, reason = "a test that cannot set up its files has failed")]

use std::fmt::Write as _;

use serde_json::{Value, json};
use uvgraft::{Channels, Encoding, Size, Texels, Texture};
use uvgraft_figure::{Figure, paint_body, paint_head};
use uvgraft_tests::strip::Strip;

use crate::bench::Bench;

/// Vertices along each side of a sheet.
const SIDE: u32 = 5;

/// A part of an avatar: a sheet whose layout fills the unit square.
struct Part {
    name: &'static str,
    /// The URI of the image of its base colour.
    image: Option<&'static str>,
}

const fn part(name: &'static str, image: Option<&'static str>) -> Part {
    Part { name, image }
}

fn floats(values: impl IntoIterator<Item = f32>) -> Vec<u8> {
    values.into_iter().flat_map(f32::to_le_bytes).collect()
}

fn grid() -> impl Iterator<Item = [f32; 2]> {
    (0..SIDE * SIDE)
        .map(|vertex| [vertex % SIDE, vertex / SIDE].map(|at| at as f32 / (SIDE - 1) as f32))
}

fn triangles() -> impl Iterator<Item = [u32; 3]> {
    (0..(SIDE - 1) * (SIDE - 1)).flat_map(|quad| {
        let at = quad / (SIDE - 1) * SIDE + quad % (SIDE - 1);
        [[at, at + 1, at + SIDE + 1], [at, at + SIDE + 1, at + SIDE]]
    })
}

/// An avatar of sheets one behind the other, each with a node, a mesh and a material, and with the whole
/// square as its layout.
fn avatar(parts: &[Part]) -> Strip {
    avatar_with(parts, |_, uv| uv.map(|at| 0.02 + 0.96 * at))
}

/// The same with other layouts.
///
/// - `layout`: from the number of a part and its own UV coordinates.
fn avatar_with(parts: &[Part], layout: impl Fn(usize, [f32; 2]) -> [f32; 2]) -> Strip {
    let mut file = Strip { json: Strip::new().json, binary: Vec::new() };
    for list in ["accessors", "bufferViews"] {
        file.json[list] = json!([]);
    }
    for list in ["skins", "animations", "samplers"] {
        file.json.as_object_mut().unwrap().remove(list);
    }
    let (mut meshes, mut nodes, mut materials) = (Vec::new(), Vec::new(), Vec::new());
    let mut images: Vec<&str> = Vec::new();
    let vertices = (SIDE * SIDE) as usize;
    for (depth, Part { name, image }) in parts.iter().enumerate() {
        let positions = floats(grid().flat_map(|[x, y]| [x, 1.0 - y, -(depth as f32)]));
        let positions = file.add(&positions, 5126, vertices, "VEC3");
        let uv = floats(grid().flat_map(|uv| layout(depth, uv)));
        let uv = file.add(&uv, 5126, vertices, "VEC2");
        let indices: Vec<u8> =
            triangles().flatten().flat_map(|index| (index as u16).to_le_bytes()).collect();
        let indices = file.add(&indices, 5123, indices.len() / 2, "SCALAR");
        let mut material = json!({ "name": format!("{name} material") });
        if let Some(image) = *image {
            let index = images.iter().position(|known| *known == image).unwrap_or_else(|| {
                images.push(image);
                images.len() - 1
            });
            material["pbrMetallicRoughness"] = json!({ "baseColorTexture": { "index": index } });
        }
        materials.push(material);
        meshes.push(json!({ "primitives": [{
            "attributes": { "POSITION": positions, "TEXCOORD_0": uv },
            "indices": indices, "material": depth
        }]}));
        nodes.push(json!({ "name": name, "mesh": depth }));
    }
    file.json["scenes"] = json!([{ "nodes": (0..parts.len()).collect::<Vec<_>>() }]);
    file.json["textures"] = (0..images.len()).map(|source| json!({ "source": source })).collect();
    file.json["images"] = images.iter().map(|uri| json!({ "uri": uri })).collect();
    for (list, values) in [("meshes", meshes), ("nodes", nodes), ("materials", materials)] {
        file.json[list] = values.into();
    }
    file
}

/// A bench with a sheet as `sheet.obj`, and vertex maps from it to each of four sheets of an avatar.
fn bench() -> Bench {
    let bench = Bench::new();
    bench.write("sheet.obj", sheet(|uv| uv));
    for part in 0..4 {
        let ids: Vec<String> =
            (0..SIDE * SIDE).map(|vertex| (part * SIDE * SIDE + vertex).to_string()).collect();
        bench.write(&format!("to_{part}.txt"), ids.join("\n"));
    }
    bench.draw("picture.png", (64, 64), |x, y| [4 * x as u8, 4 * y as u8, 99]);
    bench
}

/// The sheet as OBJ, whose V is counted upwards, with other UV coordinates.
fn sheet(uv: impl Fn([f32; 2]) -> [f32; 2]) -> String {
    let mut text = String::new();
    for [x, y] in grid() {
        let [u, v] = uv([x, y]);
        let _ = writeln!(text, "v {x} {} 0\nvt {u} {}", 1.0 - y, 1.0 - v);
    }
    for corners in triangles() {
        let [a, b, c] = corners.map(|index| index + 1);
        let _ = writeln!(text, "f {a}/{a} {b}/{b} {c}/{c}");
    }
    text
}

/// A pair whose links are in the second part, and the picture through it.
fn transferred(bench: &Bench, avatar: &str) -> (String, Texture) {
    let run = bench.run(&format!("pair sheet.obj {avatar} --vertex-map to_1.txt -o new.uvpair"));
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    bench.succeed("transfer new.uvpair picture.png --onto #000000 --size 64 -o out.png");
    (run.stderr, bench.texture("out.png"))
}

/// The image of the layout of the face alone.
fn expected(bench: &Bench) -> Texture {
    bench.write("alone.glb", avatar(&[part("Face", Some("face.png"))]).glb());
    bench.succeed("pair sheet.obj alone.glb --vertex-map to_0.txt -o alone.uvpair");
    bench.succeed("transfer alone.uvpair picture.png --onto #000000 --size 64 -o alone.png");
    bench.texture("alone.png")
}

#[test]
fn parts_with_other_images_are_left_out() {
    let bench = bench();
    let expected = expected(&bench);
    let [hair, face, body] = [
        part("Hair", Some("hair.png")),
        part("Face", Some("face.png")),
        part("Body", Some("body.png")),
    ];
    let bald = [part("Hair", None), part("Face", Some("face.png")), part("Glasses", None)];
    let plain =
        [part("Hair", Some("hair.png")), part("Face", None), part("Glasses", Some("hair.png"))];
    for (name, parts, wanted) in [
        (
            "three",
            &[hair, face, body][..],
            "three.glb: linked is the layout of Face (image \"face.png\"); left out, with layouts of \
             their own: Body (image \"body.png\"), Hair (image \"hair.png\"); three.glb#Body selects one",
        ),
        ("bald", &bald, "left out, with layouts of their own: Glasses (no image), Hair (no image)"),
        ("plain", &plain, "linked is the layout of Face (no image)"),
    ] {
        bench.write(&format!("{name}.glb"), avatar(parts).glb());
        let (said, texture) = transferred(&bench, &format!("{name}.glb"));
        assert!(said.contains(wanted) && said.contains("note: "), "{name}: {said}");
        assert!(texture == expected, "{name}");
    }
    // Primitives of one mesh, as VRM files have them: the name of the node says nothing, that of the
    // material does.
    let mut one = avatar(&[part("a", Some("a.png")), part("b", Some("b.png"))]);
    let primitives = [0, 1].map(|mesh| one.json["meshes"][mesh]["primitives"][0].clone());
    one.json["meshes"] = json!([{ "primitives": primitives }]);
    one.json["nodes"] = json!([{ "name": "Face", "mesh": 0 }]);
    bench.write("one.glb", one.with("/scenes/0/nodes", json!([0])).glb());
    let (said, texture) = transferred(&bench, "one.glb");
    assert!(said.contains("one.glb#a material selects one"), "{said}");
    assert!(texture == expected);
    // The source's parts too.
    let own = SIDE * SIDE..2 * SIDE * SIDE;
    let ids = (0..3 * SIDE * SIDE).map(|vertex| match own.contains(&vertex) {
        true => (vertex - own.start).to_string(),
        false => "-1".to_owned(),
    });
    bench.write("from_1.txt", ids.collect::<Vec<_>>().join("\n"));
    let run = bench.run("pair three.glb sheet.obj --vertex-map from_1.txt -o new.uvpair");
    assert!(run.code == Some(0) && run.stderr.contains("three.glb: linked is"), "{}", run.stderr);
}

#[test]
fn parts_that_share_an_image_stay_together() {
    let bench = bench();
    let shared = [part("Left", Some("skin.png")), part("Right", Some("skin.png"))];
    let halves = |part: usize, [u, v]: [f32; 2]| [0.5 * part as f32 + 0.48 * u, v];
    bench.write("shared.glb", avatar_with(&shared, halves).glb());
    // Two images of the same bytes, as exporters write them that embed an image for each material.
    let apart = [part("Left", Some("a.png")), part("Right", Some("b.png"))];
    let mut twice = avatar_with(&apart, halves);
    for image in 0..2 {
        let start = twice.binary.len();
        twice.binary.extend(uvgraft_tests::strip::texture());
        let view =
            json!({ "buffer": 0, "byteOffset": start, "byteLength": twice.binary.len() - start });
        let views = twice.json["bufferViews"].as_array_mut().unwrap();
        views.push(view);
        let index = views.len() - 1;
        twice.json["images"][image] = json!({ "bufferView": index, "mimeType": "image/png" });
    }
    twice.json["buffers"][0]["byteLength"] = twice.binary.len().into();
    bench.write("twice.glb", twice.glb());
    for file in ["shared.glb", "twice.glb"] {
        let text = bench
            .succeed(&format!("pair sheet.obj {file} --vertex-map to_1.txt -o new.uvpair --json"));
        let report: Value = serde_json::from_str(&text).unwrap();
        assert_eq!(report["target"]["faces"], 64, "{file}");
    }
}

#[test]
fn where_images_are_unknown_overlaps_tell() {
    let bench = bench();
    let expected = expected(&bench);
    // Two materials over each other, and then two side by side.
    let over = format!("usemtl hair\n{}", sheet(|[u, v]| [0.02 + 0.96 * u, 0.02 + 0.96 * v]));
    let second = |text: &str| {
        text.lines()
            .map(|line| match line.strip_prefix("f ") {
                None => format!("{line}\n"),
                Some(corners) => {
                    let moved = corners.split(['/', ' ']).step_by(2);
                    let moved = moved.map(|index| index.parse::<u32>().unwrap() + SIDE * SIDE);
                    let moved: Vec<String> =
                        moved.map(|index| format!("{index}/{index}")).collect();
                    format!("f {}\n", moved.join(" "))
                }
            })
            .collect::<String>()
    };
    let face = over.replace("usemtl hair", "usemtl face");
    bench.write("over.obj", over.clone() + &second(&face));
    let (said, texture) = transferred(&bench, "over.obj");
    assert!(said.contains("note: over.obj: linked is the layout of face; left out"), "{said}");
    assert!(texture == expected);
    let beside = format!("usemtl hair\n{}", sheet(|[u, v]| [0.45 * u, v]));
    let face = format!("usemtl face\n{}", sheet(|[u, v]| [0.5 + 0.45 * u, v]));
    bench.write("beside.obj", beside + &second(&face));
    let run = bench.run("pair sheet.obj beside.obj --vertex-map to_1.txt -o new.uvpair --json");
    assert_eq!((run.code, &*run.stderr), (Some(0), ""));
    assert_eq!(serde_json::from_str::<Value>(&run.stdout).unwrap()["target"]["faces"], 64);
    // Without any names nothing is left out, but what is not linked takes no texel.
    let nameless = |text: String| text.replace("usemtl hair\n", "").replace("usemtl face\n", "");
    bench.write("nameless.obj", nameless(bench_text(&bench, "over.obj")));
    let (said, texture) = transferred(&bench, "nameless.obj");
    assert_eq!(said, "");
    assert!(texture == expected);
}

fn bench_text(bench: &Bench, name: &str) -> String {
    String::from_utf8(bench.bytes(name)).unwrap()
}

#[test]
fn the_base_colour_has_a_uv_set_of_its_own() {
    let bench = bench();
    let expected = expected(&bench);
    let vertices = (SIDE * SIDE) as usize;
    let with_second = |info: Value| {
        let mut file = avatar(&[part("Face", Some("face.png"))]);
        let first = file.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"].clone();
        let light = file.add(&floats(vec![0.5; 2 * vertices]), 5126, vertices, "VEC2");
        let attributes = &mut file.json["meshes"][0]["primitives"][0]["attributes"];
        (attributes["TEXCOORD_0"], attributes["TEXCOORD_1"]) = (light.into(), first);
        file.with("/materials/0/pbrMetallicRoughness/baseColorTexture", info)
    };
    for (name, info) in [
        ("own.glb", json!({ "index": 0, "texCoord": 1 })),
        (
            "moved.glb",
            json!({ "index": 0, "extensions": { "KHR_texture_transform": { "texCoord": 1 } } }),
        ),
    ] {
        bench.write(name, with_second(info).glb());
        bench.succeed(&format!("pair sheet.obj {name} --vertex-map to_0.txt -o new.uvpair"));
        bench.succeed("transfer new.uvpair picture.png --onto #000000 --size 64 -o out.png");
        assert!(bench.texture("out.png") == expected, "{name}");
        // A set that is asked for counts; here nothing is left of its triangles.
        let run =
            bench.run(&format!("pair sheet.obj {name}#0 --vertex-map to_0.txt -o none.uvpair"));
        assert!(run.code == Some(2) && run.stderr.contains("none owns a texel"), "{}", run.stderr);
    }
}

#[test]
fn links_in_other_layouts_are_lost_with_a_warning() {
    let bench = bench();
    // The vertex map reaches into two sheets with images of their own.
    bench.write(
        "two.glb",
        avatar(&[part("Face", Some("face.png")), part("Ears", Some("ears.png"))]).glb(),
    );
    let ids: Vec<String> = (0..SIDE * SIDE)
        .map(|vertex| (if vertex / SIDE < 3 { vertex + SIDE * SIDE } else { vertex }).to_string())
        .collect();
    bench.write("torn.txt", ids.join("\n"));
    let run = bench.run("pair sheet.obj two.glb --vertex-map torn.txt -o new.uvpair");
    let wanted = "warning: two.glb: linked is the layout of Ears (image \"ears.png\"); left out, with \
                  layouts of their own: Face (image \"face.png\"), among them 33 % of the linked area";
    assert!(run.code == Some(0) && run.stderr.contains(wanted), "{}", run.stderr);
}

#[test]
fn flipped_layouts_are_reported_and_flipped_back() {
    let figure = Figure::new();
    let bench = Bench::of_figure(&figure, 128);
    uvgraft_io::obj::save(&figure.head, bench.path("head.obj")).unwrap();
    uvgraft_io::obj::save(&figure.body, bench.path("body.obj")).unwrap();
    uvgraft_io::vertex_map::save_npy(&figure.vertex_map, bench.path("head_ids.npy")).unwrap();
    bench.succeed("pair head.obj body.obj --vertex-map head_ids.npy -o right.uvpair");
    bench.succeed("transfer right.uvpair face.png --onto base.png -o right.png");
    let right = bench.texture("right.png");
    let derive = |name: &str, from: &str, change: &dyn Fn([f32; 2]) -> [f32; 2]| {
        let text = bench_text(&bench, from);
        let lines = text.lines().map(|line| {
            let Some(uv) = line.strip_prefix("vt ") else { return line.to_owned() };
            let uv: Vec<f32> = uv.split(' ').map(|value| value.parse().unwrap()).collect();
            let [u, v] = change([uv[0], uv[1]]);
            format!("vt {u} {v}")
        });
        bench.write(name, lines.collect::<Vec<_>>().join("\n"));
    };
    derive("head_v.obj", "head.obj", &|[u, v]| [u, 1.0 - v]);
    derive("head_u.obj", "head.obj", &|[u, v]| [1.0 - u, v]);
    derive("body_v.obj", "body.obj", &|[u, v]| [u, 1.0 - v]);
    derive("body_u.obj", "body.obj", &|[u, v]| [1.0 - u, v]);
    derive("head_turned.obj", "head.obj", &|[u, v]| [v, u]);
    for (meshes, reported, options) in [
        ("head_v.obj body.obj", "the V axis of head_v.obj seems to be flipped", "--flip-v source"),
        ("head_u.obj body.obj", "the U axis of head_u.obj seems to be flipped", "--flip-u source"),
        ("head.obj body_v.obj", "the V axis of body_v.obj seems to be flipped", "--flip-v target"),
        ("head.obj body_u.obj", "the U axis of body_u.obj seems to be flipped", "--flip-u target"),
    ] {
        let pair = format!("pair {meshes} --vertex-map head_ids.npy -o new.uvpair");
        let run = bench.run(&pair);
        let wanted = format!("100 % of the linked area is mirrored: {reported}");
        assert!(run.code == Some(0) && run.stderr.contains(&wanted), "{meshes}: {}", run.stderr);
        assert!(run.stderr.contains(options), "{}", run.stderr);
        let run = bench.run(&format!("{pair} {options}"));
        assert_eq!((run.code, &*run.stderr), (Some(0), ""), "{meshes}");
        bench.succeed("transfer new.uvpair face.png --onto base.png -o out.png");
        let [out, right] = [&bench.texture("out.png"), &right].map(mean);
        assert!((out - right).abs() < 1e-3, "{meshes}: {out} {right}");
    }
    // Transposed, the axis cannot be told.
    let run = bench.run("pair head_turned.obj body.obj --vertex-map head_ids.npy -o new.uvpair");
    assert!(run.stderr.contains("V or U of head_turned.obj seems to be flipped"), "{}", run.stderr);
    // Both flipped are right for each other, but wrong for textures; nothing in a pair tells.
    let both =
        "pair head_v.obj body_v.obj --vertex-map head_ids.npy -o new.uvpair --flip-v source,target";
    assert_eq!(bench.run(both).stderr, "");
    bench.succeed("transfer new.uvpair face.png --onto base.png -o out.png");
    assert!((mean(&bench.texture("out.png")) - mean(&right)).abs() < 1e-3);
    // Negated, and in another column: outside the unit square.
    derive("head_negated.obj", "head.obj", &|[u, v]| [u, -v]);
    derive("head_beside.obj", "head.obj", &|[u, v]| [u + 1.0, v]);
    derive("head_below.obj", "head.obj", &|[u, v]| [u, v - 1.0]);
    for (head, options) in [
        ("head_negated.obj", "--outside repeat --flip-v source"),
        ("head_beside.obj", "--outside repeat"),
        ("head_below.obj", "--outside repeat"),
    ] {
        let pair = format!("pair {head} body.obj --vertex-map head_ids.npy -o new.uvpair");
        let run = bench.run(&pair);
        let wanted = "outside the unit square; --outside repeat moves them into it";
        assert!(run.code == Some(2) && run.stderr.contains(wanted), "{head}: {}", run.stderr);
        let run = bench.run(&format!("{pair} {options}"));
        assert!(run.code == Some(0) && !run.stderr.contains("warning"), "{head}: {}", run.stderr);
        bench.succeed("transfer new.uvpair face.png --onto base.png -o out.png");
        let [out, right] = [&bench.texture("out.png"), &right].map(mean);
        assert!((out - right).abs() < 1e-3, "{head}: {out} {right}");
    }
    // In texels, and in per cent: moving them would tear them apart.
    for factor in [512.0, 100.0] {
        derive("head_scaled.obj", "head.obj", &|at| at.map(|value| factor * value));
        let run =
            bench.run("pair head_scaled.obj body.obj --vertex-map head_ids.npy -o new.uvpair");
        let wanted = "warning: head_scaled.obj: most triangles cross borders of UV tiles";
        assert!(run.code == Some(2) && run.stderr.contains(wanted), "{factor}: {}", run.stderr);
    }
}

/// The brightness of a texture, weighted by place, so that what is moved or mirrored differs.
fn mean(texture: &Texture) -> f64 {
    let size = texture.size();
    let places = (0..size.height).flat_map(|y| (0..size.width).map(move |x| (x, y)));
    let weighted = places.map(|(x, y)| {
        let weight =
            f64::from(x) / f64::from(size.width) + 2.0 * f64::from(y) / f64::from(size.height);
        weight * f64::from(texture.get(x, y, 0))
    });
    weighted.sum::<f64>() / size.texels() as f64
}

#[test]
fn hardly_any_links_are_warned_of() {
    let bench = bench();
    let last = SIDE * SIDE;
    // Only the corners of one triangle of 32, of a sheet that is one of many.
    let ids: Vec<String> =
        (0..last)
            .map(|vertex| {
                if [0, 1, SIDE + 1].contains(&vertex) {
                    vertex.to_string()
                } else {
                    "-1".to_owned()
                }
            })
            .collect();
    bench.write("few.txt", ids.join("\n"));
    let mut large = sheet(|uv| uv);
    let _ = write!(large, "v -9 0 0\nv 9 0 0\nv 9 9 0\nvt 0.9 0.1\n");
    let [a, b, c] = [1, 2, 3].map(|k| last + k);
    let _ = writeln!(large, "f {a}/{a} {b}/{a} {c}/{a}");
    bench.write("large.obj", large);
    bench.write("few.txt", [ids.join("\n"), "-1\n-1\n-1\n".to_owned()].join("\n"));
    let run = bench.run("pair large.obj large.obj --vertex-map few.txt -o new.uvpair");
    let wanted =
        "warning: only 0.04 % of the area of large.obj and 0.04 % of that of large.obj are linked";
    assert!(run.code == Some(0) && run.stderr.contains(wanted), "{}", run.stderr);
}

/// Pictures in the layouts of the figure's head and body, right ones and wrong ones, in all places that
/// take one.
#[test]
fn pictures_for_other_layouts_are_reported() {
    let figure = Figure::new();
    let bench = Bench::of_figure(&figure, 512);
    bench.save("body.png", paint_body(&figure, Size::square(512)));
    bench.save("light.png", brighter(&paint_head(&figure, Size::square(512))));
    bench.succeed("transfer demo.uvpair face.png --onto body.png -o carried.png");
    bench.succeed("transfer demo.uvpair --reverse body.png --size 512 -o back.png");
    bench.succeed("transfer demo.uvpair --reverse carried.png --onto face.png -o back_on_face.png");
    bench.paint("grey.png", (512, 512), Channels::Rgb, &[150, 140, 130]);
    bench.paint_noise("noise.png", (512, 512), Channels::Rgb, uvgraft::Depth::U8);
    let made_for = |layout: &'static [&'static str], other: &'static [&'static str]| {
        (layout.iter().map(|name| (*name, true))).chain(other.iter().map(|name| (*name, false)))
    };
    let heads: &[&str] = &["face.png", "light.png", "back.png", "back_on_face.png", "grey.png"];
    let bodies: &[&str] = &["body.png", "base.png", "carried.png"];
    let (mut right, mut wrong, mut found) = (0, 0, 0);
    let mut check = |command: &str, is_right: bool| {
        let run = bench.run(command);
        assert_eq!(run.code, Some(0), "{command}: {}", run.stderr);
        let is_reported = run.stderr.contains("does not look like a texture for the layout of");
        assert!(!(is_right && is_reported), "{command}: {}", run.stderr);
        right += usize::from(is_right);
        wrong += usize::from(!is_right);
        found += usize::from(is_reported);
    };
    for (picture, is_right) in made_for(heads, bodies) {
        check(&format!("transfer demo.uvpair {picture} --size 512 -o out.png"), is_right);
        check(&format!("seams demo.uvpair {picture} --reverse"), is_right);
    }
    for (picture, is_right) in made_for(bodies, &heads[..4]) {
        check(&format!("transfer demo.uvpair --reverse {picture} --size 512 -o out.png"), is_right);
        check(&format!("seams demo.uvpair {picture}"), is_right);
    }
    for (picture, is_right) in
        made_for(&["body.png", "base.png", "carried.png", "grey.png"], &heads[..4])
    {
        check(&format!("transfer demo.uvpair face.png --onto {picture} -o out.png"), is_right);
    }
    // Data and noise have no layout to tell.
    check("transfer demo.uvpair noise.png --data --size 512 -o out.png", true);
    check("transfer demo.uvpair face.png --onto #808080 --size 512 -o out.png", true);
    assert!(right >= 20 && wrong >= 18, "{right} right, {wrong} wrong");
    assert!(5 * found >= 4 * wrong, "{found} of {wrong}");
}

#[test]
fn pictures_that_show_no_colours_are_reported() {
    let bench = Bench::of_figure(&Figure::new(), 128);
    let transfer = |name: &str| {
        let run = bench.run(&format!("transfer demo.uvpair {name} --onto base.png -o out.png"));
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        run.stderr
    };
    bench.paint("clear.png", (128, 128), Channels::Rgba, &[200, 150, 120, 0]);
    assert!(transfer("clear.png").contains("clear.png: transparent on all islands"));
    bench.draw("normals.png", (128, 128), |x, y| [118 + (x % 20) as u8, 118 + (y % 20) as u8, 254]);
    assert!(transfer("normals.png").contains("normals.png: looks like a normal map"));
    // As data, and colours of the same kind.
    bench.succeed("transfer demo.uvpair --map normal=normals.png --size 128 -o out");
    bench.paint("half.png", (128, 128), Channels::Rgba, &[200, 150, 120, 1]);
    bench.paint("blue.png", (128, 128), Channels::Rgb, &[70, 100, 235]);
    bench.paint("lilac.png", (128, 128), Channels::Rgb, &[160, 150, 230]);
    for name in ["half.png", "blue.png", "lilac.png"] {
        assert_eq!(transfer(name), "", "{name}");
    }
}

fn brighter(texture: &Texture) -> Texture {
    let size = texture.size();
    let places = (0..size.height).flat_map(|y| (0..size.width).map(move |x| (x, y)));
    let values = places.flat_map(|(x, y)| {
        [0, 1, 2].map(|channel| (255.0 * texture.get(x, y, channel).powf(0.7)).round() as u8)
    });
    Texture::new(size, Channels::Rgb, Encoding::Srgb, Texels::U8(values.collect())).unwrap()
}
