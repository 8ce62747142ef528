//! Measures what becomes of photographs of a face:
//! `cargo run -p uvgraft-tests --example selfie_report -- FOLDER [--cases NAMES]`
//!
//! Photographs the built-in figure, reconstructs it, and prints how the result compares with the
//! truth. In FOLDER each case gets a sheet (photographs, texture, what is known, errors, the result
//! from 0°, 20° and 35°) and a folder with the pictures. `--cases` selects by substrings of the
//! names, separated by semicolons.
//!
//! With `--head HEAD.obj` and photographs, the truth of which is unknown, only the pictures are
//! written, and landmarks are found again:
//! `... -- FOLDER --head flame.obj --photos "a.png;b.png"`
//! The folder `others` then has other faces, for `scripts/recognise.sh`.
//!
//! The columns:
//! - `n`: photographs;
//! - `pose`: the largest error of a camera's rotation in degrees, in all and by axes of the picture;
//! - `turn`: by how much the found shape is turned against the true one, in degrees; a camera that is
//!   turned as much the other way sees the same;
//! - `px`: median distance of landmarks from those of the fit, in pixels;
//! - `PSNR`, `skin`: of what is known, with and without eyeballs, after one gain per channel, in
//!   decibels, and both again with the true cameras and shape;
//! - `known`: share of the face seen at less than 60° that is known, in per cent;
//! - `hair`, `cloth`, `glass`, `hidd.`: shares of what is known that are on hair, cloth and glasses, or
//!   that no photograph sees, in per cent;
//! - `beside`: share of what is known that was sampled beside the face in a single photograph;
//! - `again`: median distance of landmarks that are found again on the result, in millimetres;
//! - `s`: seconds for fit and texture.

#![expect(clippy::print_stdout, clippy::print_stderr, reason = "the table is the output")]

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use uvgraft::{Averaging, Channels, Depth, Encoding, Filter, Size, Texels, Texture};
use uvgraft_image::{self as image, Image, WriteOptions};
use uvgraft_io::obj;
use uvgraft_selfie::landmarks::FaceNetworks;
use uvgraft_selfie::{Head, PhotoLandmarks, Relight, TextureOptions};
use uvgraft_tests::looks::{FaceLook, SkinTone};
use uvgraft_tests::photographed::{
    Light, Photograph, Reconstruction, Shot, Subject, error_map, landmark_error_mm, landmarks,
    networks, prepared, views,
};

/// Size of textures: that of the photographs' faces, or detail would be judged that they lack.
const TEXTURE: Size = Size::square(512);

/// Cells of a sheet.
const CELL: Size = Size::square(480);

struct Arguments {
    folder: PathBuf,
    cases: Vec<String>,
    head: Option<PathBuf>,
    photos: Vec<PathBuf>,
}

struct Case {
    name: &'static str,
    subject: &'static str,
    shots: Vec<Shot>,
    relight: Relight,
    is_focal_known: bool,
}

fn main() -> ExitCode {
    let Some(arguments) = Arguments::parse() else {
        eprintln!(
            "usage: selfie_report FOLDER [--cases NAMES] [--head HEAD.obj --photos A.png;B.png]"
        );
        return ExitCode::from(2);
    };
    let Some(networks) = networks() else { return ExitCode::FAILURE };
    match &arguments.head {
        Some(head) => real(&arguments, head, &networks),
        None => synthetic(&arguments, &networks),
    }
    ExitCode::SUCCESS
}

impl Arguments {
    fn parse() -> Option<Self> {
        let mut given = std::env::args().skip(1);
        let folder = given.next()?.into();
        let mut found = Self { folder, cases: vec![], head: None, photos: vec![] };
        while let Some(argument) = given.next() {
            let value = given.next()?;
            match argument.as_str() {
                "--cases" => found.cases = value.split(';').map(str::to_owned).collect(),
                "--head" => found.head = Some(value.into()),
                "--photos" => found.photos = value.split(';').map(PathBuf::from).collect(),
                _ => return None,
            }
        }
        Some(found)
    }

    fn wants(&self, name: &str) -> bool {
        self.cases.is_empty() || self.cases.iter().any(|part| name.contains(part.as_str()))
    }
}

fn cases() -> Vec<Case> {
    let front = Shot::PORTRAIT;
    let new = |name, subject, shots| Case {
        name,
        subject,
        shots,
        relight: Relight::Off,
        is_focal_known: true,
    };
    let near = Shot { focal: 0.9, distance: 0.42, ..front };
    let window = Shot { light: Light::WINDOW, ..front };
    let lamp = Shot { light: Light::LAMP, ..front };
    vec![
        new("front", "figure", vec![front]),
        Case { is_focal_known: false, ..new("focal unknown", "figure", vec![near]) },
        Case { relight: Relight::Soft, ..new("soft", "figure", vec![front]) },
        new("turned", "figure", vec![front.turned(20.0, 0.0, 0.0)]),
        new("raised", "figure", vec![front.turned(-8.0, 12.0, 5.0)]),
        new("rolled", "figure", vec![front.turned(10.0, -6.0, 25.0)]),
        new(
            "far",
            "figure",
            vec![Shot { focal: 2.4, distance: 1.1, ..front }.turned(5.0, 3.0, 0.0)],
        ),
        new("off centre", "figure", vec![Shot { offset: [0.14, -0.12], distance: 0.7, ..front }]),
        Case { relight: Relight::Full, ..new("window", "figure", vec![window]) },
        Case { relight: Relight::Full, ..new("lamp", "figure", vec![lamp]) },
        new("nine", "figure", front.nine().to_vec()),
        Case { relight: Relight::Full, ..new("nine, window", "figure", window.nine().to_vec()) },
        new("painted", "bare", vec![front]),
        new("dark skin", "dark", vec![front]),
        new("fringe", "fringe", vec![front.turned(-6.0, 4.0, 0.0)]),
        new("glasses", "glasses", vec![front.turned(8.0, 0.0, 3.0)]),
        new("collar", "collar", vec![front.turned(4.0, 6.0, 0.0)]),
        new("fringe, nine", "fringe", front.nine().to_vec()),
        new("glasses, nine", "glasses", front.nine().to_vec()),
        new("collar, nine", "collar", front.nine().to_vec()),
    ]
}

fn synthetic(arguments: &Arguments, networks: &FaceNetworks) {
    let plain = FaceLook::new("bare", SkinTone::LIGHT);
    let dark = FaceLook::new("dark", SkinTone::DARK);
    let mut subjects = vec![Subject::figure(TEXTURE)];
    subjects.extend([plain, dark].map(|look| Subject::painted(&look, TEXTURE)));
    subjects.extend(Subject::dressed(TEXTURE));
    let head = match prepared(subjects[0].head.clone(), Some(&subjects[0].texture), networks) {
        Ok(head) => head,
        Err(error) => return eprintln!("the figure: {error}"),
    };
    let certain = head.landmarks().iter().filter(|landmark| landmark.certainty > 0.5);
    println!("{} of {} landmarks are certain", certain.count(), head.landmarks().len());
    println!("{HEADING}");
    for case in cases().iter().filter(|case| arguments.wants(case.name)) {
        let subject = subjects.iter().find(|subject| subject.name == case.subject);
        let subject = subject.expect("a case of a subject");
        run(case, subject, &head, networks, &arguments.folder);
    }
}

fn run(case: &Case, subject: &Subject, head: &Head, networks: &FaceNetworks, folder: &Path) {
    let file = case.name.replace([' ', ','], "-");
    let out = folder.join(&file);
    let (photographs, found) = photographed(case, subject, networks, &out);
    if photographs.is_empty() {
        return;
    }
    let pictures: Vec<Texture> =
        photographs.iter().map(|photograph| photograph.picture.clone()).collect();
    let mut options = TextureOptions::default();
    (options.size, options.relight) = (TEXTURE, case.relight);
    let start = Instant::now();
    let made = Reconstruction::new(head, &pictures, &found, &options);
    let seconds = start.elapsed().as_secs_f64();
    let ideal = Reconstruction::of_true_fit(head, &photographs, &found, &options);
    let (cells, again) = seen_again(&made, head, networks, &out);
    println!("{}", row(case, (head, subject), &photographs, [&made, &ideal], &again, seconds));

    let errors = [&made, &ideal].map(|made| error_map(subject, made.found()));
    write(&made.result.texture, &out.join("texture.png"));
    write(&made.result.known, &out.join("known.png"));
    write(&errors[0], &out.join("errors.png"));
    write(&ideal.result.texture, &out.join("texture-of-true-fit.png"));
    let first = marked(&pictures[0], &found[0]);
    let upper = [&first, &subject.texture, &made.result.texture, &made.result.known, &errors[0]];
    let mut lower: Vec<&Texture> = cells.iter().collect();
    lower.extend([&ideal.result.texture, &errors[1]]);
    write(&sheet(&[upper.to_vec(), lower]), &folder.join(format!("{file}.png")));
}

/// Photographs of a case, without those that are refused.
fn photographed(
    case: &Case,
    subject: &Subject,
    networks: &FaceNetworks,
    out: &Path,
) -> (Vec<Photograph>, Vec<PhotoLandmarks>) {
    let (mut photographs, mut found) = (Vec::new(), Vec::new());
    for (index, shot) in case.shots.iter().enumerate() {
        let photograph = shot.take(subject);
        write(&photograph.picture, &out.join(format!("photo-{index}.png")));
        let focal = case.is_focal_known.then_some(photograph.camera.focal_px);
        match landmarks(networks, &photograph.picture, focal) {
            Ok(landmarks) => {
                found.push(landmarks);
                photographs.push(photograph);
            }
            Err(error) => println!("{:<14} photograph {index}: {error}", case.name),
        }
    }
    (photographs, found)
}

const HEADING: &str = "case            n  pose (pitch   yaw  roll)  turn    px |  PSNR  skin (true fit) known |  hair cloth \
                       glass  hidd. beside | again 0°/20°/35° |    s";

/// A row below [`HEADING`].
fn row(
    case: &Case,
    (head, subject): (&Head, &Subject),
    photographs: &[Photograph],
    [made, ideal]: [&Reconstruction; 2],
    again: &str,
    seconds: f64,
) -> String {
    let judged = made.judged(subject, photographs);
    let ideal = ideal.judged(subject, photographs);
    let poses = made.pose_errors(photographs);
    let pose = poses.into_iter().max_by(|a, b| a.length().total_cmp(&b.length()));
    let pose = pose.unwrap_or_default();
    let residual = made.fit.photos.iter().map(|photo| photo.residual_px).fold(0.0, f64::max);
    let turn = made.shape_turn_degrees(head);
    let beside = match photographs {
        [only] => format!("{:.2}", 100.0 * made.sampled_beside(subject, only, 0)),
        _ => "-".to_owned(),
    };
    let shares = [judged.hair, judged.cloth, judged.glasses, judged.hidden];
    let shares = shares.map(|share| format!("{:>6.2}", 100.0 * share)).concat();
    format!(
        "{:<14} {:>2} {:>5.2} ({:>5.1} {:>5.1} {:>5.1}) {turn:>5.1} {residual:>5.2} | {:>5.1} {:>5.1} ({:>4.1} {:>4.1}) \
         {:>6.1} |{shares}  {beside:>6} | {again:>15} | {seconds:>5.1}",
        case.name,
        photographs.len(),
        pose.length(),
        pose.x,
        pose.y,
        pose.z,
        judged.psnr_db,
        judged.skin_psnr_db,
        ideal.psnr_db,
        ideal.skin_psnr_db,
        100.0 * judged.coverage,
    )
}

/// Pictures of the result from three sides, and the errors of the landmarks in them.
fn seen_again(
    made: &Reconstruction,
    head: &Head,
    networks: &FaceNetworks,
    out: &Path,
) -> (Vec<Texture>, String) {
    let subject = made.subject(head, "result");
    let mut errors = Vec::new();
    let mut pictures = Vec::new();
    for shot in views() {
        let photograph = shot.take(&subject);
        write(&photograph.picture, &out.join(format!("view-{:02}.png", shot.angles[0])));
        let error = match landmarks(networks, &photograph.picture, None) {
            Ok(found) => {
                let visible = made.visible_landmarks(head, &photograph);
                let images = visible.iter().map(|&(_, index)| {
                    let [x, y, _] = found.points[index];
                    [x, y]
                });
                let points = visible.iter().map(|&(point, _)| point);
                format!("{:.2}", landmark_error_mm(&photograph, points, images))
            }
            Err(_) => "none".to_owned(),
        };
        errors.push(error);
        pictures.push(photograph.picture);
    }
    (pictures, errors.join(" "))
}

fn real(arguments: &Arguments, head: &Path, networks: &FaceNetworks) {
    let mesh = obj::read(head).expect("a mesh");
    let head = prepared(mesh, None, networks).expect("a head");
    let pictures: Vec<Texture> = arguments
        .photos
        .iter()
        .map(|path| image::read(path).expect("a photograph").texture)
        .collect();
    let found: Vec<PhotoLandmarks> = pictures
        .iter()
        .map(|picture| landmarks(networks, picture, None).expect("a face"))
        .collect();
    let start = Instant::now();
    let made = Reconstruction::new(&head, &pictures, &found, &TextureOptions::default());
    let seconds = start.elapsed().as_secs_f64();
    let (cells, again) = seen_again(&made, &head, networks, &arguments.folder);
    println!("landmarks found again: {again} mm; {seconds:.1} s");
    write(&made.result.texture, &arguments.folder.join("texture.png"));
    write(&made.result.known, &arguments.folder.join("known.png"));
    let [front, ..] = views();
    for other in Subject::others() {
        let name = other.name.replace([' ', ',', '.'], "-");
        write(&front.take(&other).picture, &arguments.folder.join(format!("others/{name}.png")));
    }
    let first = marked(&pictures[0], &found[0]);
    let upper = vec![&first, &made.result.texture, &made.result.known];
    write(&sheet(&[upper, cells.iter().collect()]), &arguments.folder.join("sheet.png"));
}

/// A picture with its landmarks as dots.
fn marked(picture: &Texture, landmarks: &PhotoLandmarks) -> Texture {
    let picture = picture.clone().converted(Channels::Rgb, Depth::U8);
    let size = picture.size();
    let Texels::U8(mut values) = picture.into_texels() else { unreachable!("converted") };
    for [x, y, _] in &landmarks.points {
        if (0.0..size.width.into()).contains(x) && (0.0..size.height.into()).contains(y) {
            let at = (*y as usize * size.width as usize + *x as usize) * 3;
            values[at..at + 3].copy_from_slice(&[0, 255, 0]);
        }
    }
    Texture::new(size, Channels::Rgb, Encoding::Srgb, Texels::U8(values)).expect("as before")
}

/// Pictures in rows, each fitted into a cell.
fn sheet(rows: &[Vec<&Texture>]) -> Texture {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(1) as u32;
    let size = Size::new(columns * CELL.width, rows.len() as u32 * CELL.height);
    let mut values = vec![0; size.texels() * 3];
    for (row, cells) in (0..).zip(rows) {
        for (column, cell) in (0..).zip(cells) {
            let cell = fitted(cell);
            for y in 0..cell.size().height {
                for x in 0..cell.size().width {
                    let (left, top) = (column * CELL.width + x, row * CELL.height + y);
                    let at = (top * size.width + left) as usize * 3;
                    for k in 0..3 {
                        values[at + k] = (255.0 * cell.get(x, y, k) + 0.5) as u8;
                    }
                }
            }
        }
    }
    Texture::new(size, Channels::Rgb, Encoding::Srgb, Texels::U8(values)).expect("some cells")
}

fn fitted(picture: &Texture) -> Texture {
    let size = picture.size();
    let scale = f64::from(CELL.width) / f64::from(size.width.max(size.height));
    let side = |length: u32| ((f64::from(length) * scale) as u32).max(1);
    let small = Size::new(side(size.width), side(size.height));
    let picture = picture.clone().encoded_as(Encoding::Srgb).converted(Channels::Rgb, Depth::U8);
    picture.resized(small, Filter::Lanczos3, Averaging::Encoded).expect("memory for a picture")
}

fn write(texture: &Texture, path: &Path) {
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).expect("a folder to write to");
    }
    let image = Image::from(texture.clone());
    // 8-bit PNG files lose nothing.
    let _ = image::write(&image, path, &WriteOptions::default()).expect("a file to write");
}
