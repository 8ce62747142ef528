//! Faces on bodies, judged as people would: the person stays recognisable, and the body's clothes
//! unchanged.

use std::sync::Arc;

use uvgraft::{Labels, Tone};
use uvgraft_tests::looks::measure::{self, Bench, Figures};
use uvgraft_tests::looks::subjects::{BODY, Outcome, Subject, subjects, transfer};

/// Number of bodies that each face is tried on.
const BODIES_A_FACE: usize = 3;

/// A shirt in the skin's own hue, without a visible edge all around, follows the body's tone.
const LIKE_SKIN: &str = "brown shirt";
/// Its teeth are recognisable by lightness alone.
const WITHOUT_COLOR: &str = "grey capture";
/// Shirts that extend over the region's boundary at the nape: a neck without a collar is cut off
/// there.
const OVER_RIM: [&str; 3] = ["long sleeves", "beige shirt", "pink shirt"];

/// The measurements out of bounds, in words, except for known ones, which docs/src/looks.md lists.
fn faults(figures: &Figures, face: &str, body: &str) -> Vec<String> {
    let mut faults = Vec::new();
    let mut check = |name: &str, value: Option<f64>, most: f64| {
        if let Some(value) = value.filter(|&value| value > most) {
            faults.push(format!("{name} {value:.2}, at most {most:.2}"));
        }
    };
    let both = figures.cheek_to_chest.zip(figures.own_cheek_to_chest);
    if body != LIKE_SKIN {
        check("cheek to chest off by", both.map(|(found, own)| (found - own).abs()), 2.0);
        check("cloth", figures.cloth.as_ref().map(|shift| shift.p95), 0.5);
    }
    check("hair", figures.hair.as_ref().map(|shift| shift.median), 3.0);
    check("brows", figures.brow.as_ref().map(|shift| shift.median), 3.0);
    check("eyes", figures.eye.as_ref().map(|shift| shift.median), 2.0);
    if face != WITHOUT_COLOR {
        // Most of a mouth's few texels are at its edge.
        check("teeth", figures.mouth.as_ref().map(|shift| shift.median), 5.5);
    }
    check("clipped", figures.clipped_high, 0.01);
    if !OVER_RIM.contains(&body) {
        let rim_bound = figures.own_rim.map_or(1.5, |own| (own + 0.5).max(1.5));
        check("rim", figures.rim, rim_bound);
    }
    faults
}

#[test]
fn faces_look_like_themselves_on_every_body() {
    if uvgraft_tests::real::folder().is_none() {
        return;
    }
    let (pairs, frame, faces, bodies) = subjects();
    let benches: Vec<Bench> =
        pairs.iter().map(|pair| Bench::new(Arc::clone(pair), &frame, BODY)).collect();
    let mut missed = Vec::new();
    for (index, face) in faces.iter().enumerate() {
        let bench = &benches[face.pair];
        let transferred = face.truth.as_ref().map(|truth| bench.transfer(truth));
        for k in 0..BODIES_A_FACE.min(bodies.len()) {
            let body: &Subject =
                &bodies[(index + k * bodies.len().div_ceil(BODIES_A_FACE)) % bodies.len()];
            for tone in [Tone::Base, Tone::Source] {
                let pair = &pairs[face.pair];
                let Outcome { figures, .. } =
                    transfer(pair, bench, face, transferred.as_ref(), body, tone);
                for fault in faults(&figures, &face.name, &body.name) {
                    missed.push(format!("{} on {}, {tone:?}: {fault}", face.name, body.name));
                }
            }
        }
    }
    missed.iter().for_each(|line| eprintln!("{line}"));
    assert!(missed.is_empty(), "{} figures are out of bounds", missed.len());
}

#[test]
fn labels_agree_with_what_was_painted() {
    if uvgraft_tests::real::folder().is_none() {
        return;
    }
    let (pairs, _, faces, _) = subjects();
    for face in &faces {
        let Some(truth) = &face.truth else { continue };
        let found =
            Labels::new(pairs[face.pair].source(), &face.texture).expect("a head's texture");
        let agreement = measure::agreement(&measure::labels_like(truth, &found), truth);
        eprintln!("{}: {agreement:?}", face.name);
        if truth.count(uvgraft_tests::looks::Label::Cloth) > 0 {
            assert!(agreement.cloth_iou >= Some(0.85), "{}: {agreement:?}", face.name);
        } else {
            assert!(agreement.lost_skin <= 0.005, "{}: {agreement:?}", face.name);
        }
    }
}
