//! Mouths of the figure and, with real data, of SMPL-X and FLAME: whatever the faces do, nothing
//! comes out of them or shows through them.

use glam::Vec3;
use uvgraft_avatar::Avatar;
use uvgraft_avatar::rig::Morph;
use uvgraft_gltf::preset::{Preset, QUEST};
use uvgraft_tests::mouths::{Face, Subject};

/// Jaw rotations: closed, in speech, and wide.
const JAWS: [f32; 4] = [0.0, 0.06, 0.15, 0.3];

#[test]
fn nothing_comes_out_of_a_face() {
    let mut wrong = Vec::new();
    for subject in Subject::all().into_iter().chain(Subject::expressive()) {
        let names: Vec<String> =
            subject.after.morphs.iter().map(|morph: &Morph| morph.name.clone()).collect();
        let single: Vec<[(&str, f32); 1]> =
            names.iter().map(|name| [(name.as_str(), 1.0)]).collect();
        let mut faces: Vec<Face<'_>> = JAWS.iter().map(|&jaw| Face(&[], jaw)).collect();
        faces.extend(single.iter().map(|weights| Face(weights, 0.0)));
        faces.extend(single.iter().map(|weights| Face(weights, 0.15)));
        for face in faces {
            let outside = subject.outside(face);
            if !outside.is_empty() {
                wrong.push(format!("{}, {face:?}: {:?}", subject.name, outside));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn nothing_shows_through_a_face() {
    for subject in Subject::all() {
        let smile: &[(&str, f32)] = match subject.name {
            "figure" => &[("smile", 1.0)],
            _ => &[("smile left", 1.0), ("smile right", 1.0)],
        };
        let round: &[(&str, f32)] = match subject.name {
            "figure" => &[("lips_round", 1.0), ("jaw_open", 0.3)],
            _ => &[("pucker", 1.0), ("jaw_open", 0.3)],
        };
        let faces = [
            Face(&[], 0.0),
            Face(&[("jaw_open", 0.25)], 0.0),
            Face(&[("jaw_open", 1.0)], 0.1),
            Face(smile, 0.1),
            Face(round, 0.0),
        ];
        let after = Subject::seen_through(&subject.after, &faces);
        assert_eq!(after, 0, "{}", subject.name);
        if subject.name != "figure" {
            // Check that the test detects holes.
            let before = Subject::seen_through(&subject.before, &faces[1..2]);
            assert!(before > 20, "{}: {before}", subject.name);
        }
    }
}

#[test]
fn nothing_shows_through_expressions() {
    for subject in Subject::expressive() {
        let names: Vec<String> =
            subject.after.morphs.iter().map(|morph| morph.name.clone()).collect();
        let weights: Vec<[(&str, f32); 1]> =
            names.iter().map(|name| [(name.as_str(), 1.0)]).collect();
        // Jaw closed, and rotated as in speech.
        let faces: Vec<Face<'_>> =
            weights.iter().flat_map(|face| [Face(face, 0.0), Face(face, 0.12)]).collect();
        assert_eq!(faces.len(), 32, "{}", subject.name);
        assert_eq!(Subject::seen_through(&subject.after, &faces), 0, "{}", subject.name);
    }
}

#[test]
fn presets_keep_mouths() {
    for subject in Subject::all() {
        let own = subject.before.mesh.positions().len();
        let preset = Preset { triangles: 6_000, ..QUEST };
        let places: Vec<[f32; 3]> = subject.after.mesh.positions()[own..].to_vec();
        let Ok(fitted) = preset.fit(subject.after.clone()) else { continue };
        let kept =
            fitted.avatar.mesh.positions().iter().filter(|place| places.contains(place)).count();
        assert!(kept > 60, "{}: {kept} of {} vertices", subject.name, places.len());
        let simple = Subject { after: fitted.avatar, ..subject };
        let faces = [Face(&[], 0.0), Face(&[("jaw_open", 0.5)], 0.0)];
        let pixels = Subject::seen_through(&simple.after, &faces);
        assert!(pixels <= 4, "{}: {pixels}", simple.name);
    }
}

/// Area of a face that turns over in a morph, in square metres: slivers that end up facing the
/// wrong way, since nothing rotates that far.
fn turned_over(avatar: &Avatar, morph: &Morph) -> f32 {
    let rest = avatar.mesh.positions();
    let mut moved = rest.to_vec();
    for &(vertex, offset) in &morph.offsets {
        let position = &mut moved[vertex as usize];
        *position = (Vec3::from(*position) + Vec3::from(offset)).to_array();
    }
    let normal = |positions: &[[f32; 3]], face: &[u32; 3]| {
        let [a, b, c] = face.map(|vertex| Vec3::from(positions[vertex as usize]));
        (b - a).cross(c - a) / 2.0
    };
    let over = |face: &[u32; 3]| {
        let (before, after) = (normal(rest, face), normal(&moved, face));
        if before.dot(after) < 0.0 { after.length() } else { 0.0 }
    };
    avatar.mesh.faces().iter().map(over).sum()
}

#[test]
fn presets_turn_nothing_over() {
    for subject in Subject::expressive() {
        let all = subject.after;
        for triangles in [18_000, 14_000, 10_000, 7_000] {
            let preset = Preset { triangles, ..QUEST };
            let Ok(fitted) = preset.fit(all.clone()) else { continue };
            for (full, morph) in all.morphs.iter().zip(&fitted.avatar.morphs) {
                let areas = [turned_over(&all, full), turned_over(&fitted.avatar, morph)];
                let [full, fewer] = areas.map(|area| 1e6 * area);
                let case =
                    format!("{} {triangles} {}: {full}, {fewer} mm²", subject.name, morph.name);
                // Lids roll over their own edges when they close.
                let is_blink = morph.name.starts_with("blink");
                assert!(fewer < full + if is_blink { 0.2 * full } else { 1.0 }, "{case}");
            }
        }
    }
}
