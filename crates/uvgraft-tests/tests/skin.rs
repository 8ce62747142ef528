//! How well skin is told from what else a body's texture shows, on the synthetic figure, whose parts
//! name their material.

#![expect(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use uvgraft::blend::skin::SkinModel;
use uvgraft::raster::ScanTriangle;
use uvgraft::{Direction, Pair, Size, Texels, Texture, Transfer, TransferOptions};
use uvgraft_avatar::{Figure, paint_body, paint_head};

const SIDE: u32 = 1024;

struct Scene {
    /// Per texel the number of its part in `parts`.
    part: Vec<Option<usize>>,
    parts: Vec<(String, String)>,
    plain: Vec<[f32; 3]>,
    faced: Vec<[f32; 3]>,
}

fn colors(texture: &Texture) -> Vec<[f32; 3]> {
    let Texels::U8(values) = texture.texels() else { panic!("8 bits") };
    values.as_chunks::<3>().0.iter().map(|t| t.map(|v| f32::from(v) / 255.0)).collect()
}

impl Scene {
    fn new() -> Self {
        let figure = Figure::new();
        let size = Size::square(SIDE);
        let mesh = &figure.body;
        let mut part = vec![None; size.texels()];
        let mut parts = Vec::new();
        for (number, named) in mesh.parts().iter().enumerate() {
            parts.push((named.group.clone(), named.material.clone()));
            for polygon in named.polygons.clone() {
                for face in mesh.polygon(polygon as usize) {
                    let corners =
                        mesh.uv_triangle(face).map(|uv| uv.map(|v| f64::from(v) * f64::from(SIDE)));
                    let Some(scan) = ScanTriangle::new(corners, size) else { continue };
                    for row in scan.rows() {
                        for x in scan.span(row) {
                            part[(row * SIDE + x) as usize] = Some(number);
                        }
                    }
                }
            }
        }
        let body = paint_body(&figure, size);
        let head = paint_head(&figure, size);
        let map: Vec<i64> = figure.vertex_map.iter().map(|&v| v.into()).collect();
        let pair = Pair::by_vertex_map(figure.head.clone(), figure.body.clone(), &map).unwrap();
        let transfer =
            Transfer::new(&pair, Direction::Forward, size, size, &TransferOptions::default());
        let faced = transfer.apply(head, body.clone()).unwrap();
        Self { part, parts, plain: colors(&body), faced: colors(&faced) }
    }
}

#[test]
fn explore() {
    let scene = Scene::new();
    let group = |t: usize| scene.part[t].map(|p| scene.parts[p].0.as_str()).unwrap_or("");
    let material = |t: usize| scene.part[t].map(|p| scene.parts[p].1.as_str()).unwrap_or("");
    let isskin =
        |t: usize| material(t) == "skin" && group(t) != "face" && !group(t).starts_with("ear");
    let recolors: [(&str, [f32; 3], f32); 8] = [
        ("own", [1.0; 3], 0.0),
        ("dark", [0.50, 0.42, 0.36], 0.0),
        ("darker", [0.25, 0.20, 0.17], 0.0),
        ("pale", [0.75, 0.8, 0.85], 0.22),
        ("blue", [0.35, 0.6, 1.3], 0.0),
        ("green", [0.4, 1.0, 0.5], 0.0),
        ("grey", [0.0; 3], -1.0),
        ("scaled", [0.6; 3], 0.0),
    ];
    for (name, gain, add) in recolors {
        for (which, texels) in [("plain", &scene.plain), ("faced", &scene.faced)] {
            let texels: Vec<[f32; 3]> = texels
                .iter()
                .enumerate()
                .map(|(t, c)| {
                    if add < 0.0 {
                        let y = (c[0] + c[1] + c[2]) / 3.0;
                        return [y; 3];
                    }
                    let skinny = isskin(t) || (which == "faced" && material(t) == "skin");
                    if !skinny {
                        return *c;
                    }
                    std::array::from_fn(|k| {
                        ((c[k] * gain[k] + add) * 255.0).round().clamp(0.0, 255.0) / 255.0
                    })
                })
                .collect();
            let of = |g: &str, step: usize| -> Vec<[f32; 3]> {
                (0..texels.len())
                    .filter(|&t| group(t) == g)
                    .step_by(step)
                    .map(|t| texels[t])
                    .collect()
            };
            let chest = of("chest", 13);
            let mut seeds = chest.clone();
            let n = chest.len();
            seeds.extend(of("shirt", 101).iter().take(n * 3 / 10));
            seeds.extend(of("hair", 11).iter().take(n / 5));
            let others: Vec<[f32; 3]> = (0..texels.len())
                .filter(|&t| scene.part[t].is_some())
                .step_by(37)
                .map(|t| texels[t])
                .collect();
            for (sname, s) in [("clean", &chest), ("dirty", &seeds)] {
                let model = match SkinModel::new(s, &others) {
                    Ok(m) => m,
                    Err(e) => {
                        println!("{name} {which} {sname}: {e}");
                        continue;
                    }
                };
                println!(
                    "{name} {which} {sname} seeds {} others {} color {:?} {model:?}",
                    s.len(),
                    others.len(),
                    model.color().map(|v| (v * 255.0).round())
                );
                let mut groups: Vec<String> = scene.parts.iter().map(|p| p.0.clone()).collect();
                groups.sort();
                groups.dedup();
                for g in groups {
                    if g.contains("right") {
                        continue;
                    }
                    let mut w: Vec<f32> = (0..texels.len())
                        .filter(|&t| group(t) == g)
                        .map(|t| model.weight(texels[t]))
                        .collect();
                    if w.is_empty() {
                        continue;
                    }
                    w.sort_by(f32::total_cmp);
                    let q = |s: f32| w[((w.len() - 1) as f32 * s) as usize];
                    let mean = w.iter().map(|&v| f64::from(v)).sum::<f64>() / w.len() as f64;
                    println!(
                        "   {g:16} {:7} mean {mean:.4} p1 {:.3} p5 {:.3} p50 {:.3} p95 {:.3}",
                        w.len(),
                        q(0.01),
                        q(0.05),
                        q(0.5),
                        q(0.95)
                    );
                }
            }
        }
    }
}

#[test]
fn real_face() {
    use uvgraft::{Channels, Depth, Encoding};
    let Some(folder) = uvgraft_tests::real::folder() else { return };
    for (file, boxes) in [
        ("flame_face_texture.png", [[0.3, 0.78, 0.7, 0.97], [0.0, 0.0, 0.0, 0.0]]),
        ("flame_mean_texture.jpg", [[0.3, 0.78, 0.7, 0.97], [0.0, 0.0, 0.0, 0.0]]),
    ] {
        let t = uvgraft_io::image::read(&folder.join(file))
            .unwrap()
            .texture
            .converted(Channels::Rgb, Depth::U8);
        let size = t.size();
        let c = colors(&t);
        let (w, h) = (size.width as f32, size.height as f32);
        let mut seeds = Vec::new();
        for [l, t, r, b] in boxes {
            for y in (t * h) as u32..(b * h) as u32 {
                for x in (l * w) as u32..(r * w) as u32 {
                    if (x + y) % 3 == 0 {
                        seeds.push(c[(y * size.width + x) as usize]);
                    }
                }
            }
        }
        let others: Vec<[f32; 3]> = c.iter().step_by(7).copied().collect();
        let model = SkinModel::new(&seeds, &others).unwrap();
        println!("{file} {size} {} {model:?}", seeds.len());
        let out: Vec<u8> = c
            .iter()
            .flat_map(|&c| {
                let w = model.weight(c);
                // keep skin, green elsewhere
                [c[0] * w, c[1] * w + (1.0 - w), c[2] * w].map(|v| (v * 255.0) as u8)
            })
            .collect();
        let out = Texture::new(size, Channels::Rgb, Encoding::Srgb, Texels::U8(out)).unwrap();
        uvgraft_io::image::write(
            &out.into(),
            &std::path::Path::new("/tmp").join(format!("skin_{file}.png")),
            &Default::default(),
        )
        .unwrap();
    }
}
