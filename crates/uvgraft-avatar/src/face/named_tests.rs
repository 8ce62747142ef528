use uvgraft_figure::Figure;

use super::*;

/// The figure with ARKit's names for what its morphs do, and no expressions.
fn figure() -> (crate::Avatar, Vec<Morph>) {
    let mut avatar = Figure::new().avatar();
    let mut morphs = std::mem::take(&mut avatar.morphs);
    avatar.expressions.clear();
    for morph in &mut morphs {
        morph.name = match morph.name.as_str() {
            "jaw_open" => "jawOpen",
            "blink_left" => "eyeBlinkLeft",
            "blink_right" => "eyeBlinkRight",
            "lips_round" => "mouthPucker",
            "brows_up" => "browInnerUp",
            other => other,
        }
        .to_owned();
    }
    let mut funnel = morphs.iter().find(|morph| morph.name == "mouthPucker").unwrap().clone();
    funnel.name = "mouthFunnel".to_owned();
    morphs.push(funnel);
    (avatar, morphs)
}

#[test]
fn named_morphs_become_expressions_and_presets() {
    let (mut avatar, morphs) = figure();
    let count = morphs.len();
    let added = add_named(&mut avatar, morphs.clone());
    assert_eq!((added.named, added.taken.len()), (count, 0));
    use Preset::*;
    assert_eq!(added.presets, [Sad, Aa, Ou, Oh, BlinkLeft, BlinkRight, Blink]);
    avatar.check().unwrap();
    let names: Vec<&str> = avatar.expressions.iter().map(|e| e.name.as_str()).collect();
    assert!(["jawOpen", "blink", "aa"].iter().all(|name| names.contains(name)), "{names:?}");
    let blink = avatar.expressions.iter().find(|e| e.preset == Some(Blink)).unwrap();
    assert!(blink.morphs.iter().all(|&(_, weight)| weight == 1.0));
    // As far as it should: 0.38 of the mouth's width.
    let face = Face::find(&avatar.mesh).unwrap();
    let aa = avatar.expressions.iter().find(|e| e.preset == Some(Aa)).unwrap();
    let mut positions = avatar.mesh.positions().to_vec();
    aa.morphs.iter().for_each(|&(morph, weight)| avatar.morphs[morph].add(weight, &mut positions));
    let [rest, shown] = [avatar.mesh.positions(), &positions].map(|at| face.measure(at));
    let opening = (shown.lip_opening - rest.lip_opening) / rest.mouth_width;
    assert!((0.2..0.42).contains(&opening), "{opening}");
    // A second time all names are taken, and no preset is missing.
    let again = add_named(&mut avatar, morphs);
    assert_eq!((again.named, again.taken.len(), again.presets.len()), (0, count, 0));
}

#[test]
fn presets_of_the_avatar_stay() {
    let (mut avatar, morphs) = figure();
    let own = crate::rig::Expression::preset(Preset::Aa, Vec::new());
    avatar.expressions.push(own.clone());
    let added = add_named(&mut avatar, morphs);
    assert!(!added.presets.contains(&Preset::Aa));
    assert_eq!(avatar.expressions[0], own);
}
