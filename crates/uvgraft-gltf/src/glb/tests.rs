//! Files are read back with the crate `gltf`, animated by their contents, and compared with the
//! avatar.

use std::collections::HashMap;

use glam::{Mat4, Quat, Vec3};
use gltf::accessor::{DataType, Dimensions};
use gltf::animation::util::ReadOutputs;
use uvgraft::{Channels, Depth, Encoding, Mesh, Size, Texture};
use uvgraft_avatar::rig::{ExpressionPreset, HumanBone, Joint, Pose, Skeleton};

use super::testing::{RINGS, SIDES, tube};
use super::*;

pub(super) fn picture(format: EmbeddedFormat) -> EmbeddedImage {
    let color = [0.8, 0.6, 0.5];
    let texture =
        Texture::filled(Size::square(8), Channels::Rgb, Encoding::Srgb, Depth::U8, &color);
    EmbeddedImage::encode(texture.unwrap(), format, 90).unwrap()
}

pub(super) fn looks() -> AvatarMaterial {
    AvatarMaterial::new(picture(EmbeddedFormat::Png))
}

/// A file as loaded by a player.
pub(super) struct Player {
    pub(super) document: gltf::Document,
    blob: Vec<u8>,
}

impl Player {
    pub(super) fn new(bytes: &[u8]) -> Self {
        let gltf::Gltf { document, blob } = gltf::Gltf::from_slice(bytes).unwrap();
        Self { document, blob: blob.unwrap() }
    }

    pub(super) fn buffer(&self, _: gltf::Buffer<'_>) -> Option<&[u8]> {
        Some(&self.blob)
    }

    fn primitive(&self) -> gltf::Primitive<'_> {
        self.document.meshes().next().unwrap().primitives().next().unwrap()
    }

    /// Positions with morphs applied.
    fn positions(&self, weights: &[f32]) -> Vec<Vec3> {
        let primitive = self.primitive();
        let reader = primitive.reader(|buffer| self.buffer(buffer));
        let mut positions: Vec<Vec3> = reader.read_positions().unwrap().map(Vec3::from).collect();
        for ((offsets, normals, _), &weight) in reader.read_morph_targets().zip(weights) {
            assert_eq!(normals.unwrap().count(), positions.len());
            for (position, offset) in positions.iter_mut().zip(offsets.unwrap()) {
                *position += weight * Vec3::from(offset);
            }
        }
        positions
    }

    /// The world matrices of joints, in a frame of the first clip or at rest.
    fn joints(&self, frame: Option<usize>) -> Vec<Mat4> {
        let mut locals: Vec<(Vec3, Quat)> = self
            .document
            .nodes()
            .map(|node| {
                let (translation, rotation, _) = node.transform().decomposed();
                (translation.into(), Quat::from_array(rotation))
            })
            .collect();
        let animation = frame.map(|frame| (frame, self.document.animations().next().unwrap()));
        if let Some((frame, animation)) = animation {
            for channel in animation.channels() {
                let reader = channel.reader(|buffer| self.buffer(buffer));
                let node = channel.target().node().index();
                let held = reader.read_inputs().unwrap().count() == 2;
                let frame = if held { 0 } else { frame };
                match reader.read_outputs().unwrap() {
                    ReadOutputs::Translations(mut all) => {
                        locals[node].0 = all.nth(frame).unwrap().into();
                    }
                    ReadOutputs::Rotations(all) => {
                        locals[node].1 = Quat::from_array(all.into_f32().nth(frame).unwrap());
                    }
                    _ => panic!("a channel that should not be there"),
                }
            }
        }
        let mut world = vec![Mat4::IDENTITY; locals.len()];
        // Joints come in order, parents first.
        for node in self.document.nodes() {
            let (translation, rotation) = locals[node.index()];
            let local = Mat4::from_rotation_translation(rotation, translation);
            world[node.index()] *= local;
            for child in node.children() {
                world[child.index()] = world[node.index()];
            }
        }
        world
    }

    fn posed(&self, frame: Option<usize>, weights: &[f32]) -> Vec<Vec3> {
        let skin = self.document.skins().next().unwrap();
        let reader = skin.reader(|buffer| self.buffer(buffer));
        let inverse = reader.read_inverse_bind_matrices().unwrap();
        let world = self.joints(frame);
        let matrices: Vec<Mat4> = skin
            .joints()
            .zip(inverse)
            .map(|(joint, inverse)| world[joint.index()] * Mat4::from_cols_array_2d(&inverse))
            .collect();
        let primitive = self.primitive();
        let reader = primitive.reader(|buffer| self.buffer(buffer));
        let joints = reader.read_joints(0).unwrap().into_u16();
        let influences = joints.zip(reader.read_weights(0).unwrap().into_f32());
        let place = |(position, (joints, weights)): (Vec3, ([u16; 4], [f32; 4]))| {
            let sum: f32 = weights.iter().sum();
            assert_eq!(sum, 1.0, "{weights:?}");
            joints.iter().zip(weights).fold(Vec3::ZERO, |sum, (&joint, weight)| {
                sum + weight * matrices[usize::from(joint)].transform_point3(position)
            })
        };
        self.positions(weights).into_iter().zip(influences).map(place).collect()
    }
}

/// For each vertex of a file, the mesh vertex at its position.
fn origins(player: &Player, mesh: &Mesh) -> Vec<usize> {
    let places: HashMap<[u32; 3], usize> =
        (0..).zip(mesh.positions()).map(|(v, position)| (position.map(f32::to_bits), v)).collect();
    assert_eq!(places.len(), mesh.positions().len(), "a mesh without vertices on one place");
    let place = |position: Vec3| places[&position.to_array().map(f32::to_bits)];
    player.positions(&[]).into_iter().map(place).collect()
}

#[test]
fn a_file_moves_like_the_avatar() {
    let avatar = tube();
    let exported = write(&avatar, &looks(), &Export::default()).unwrap();
    let player = Player::new(&exported.bytes);
    let origins = origins(&player, &avatar.mesh);
    // The seam duplicates one vertex of each ring.
    assert_eq!(origins.len(), RINGS * (SIDES + 1));
    let pruned = Avatar { skin: avatar.skin.pruned(4).0, ..avatar.clone() };
    for (weights, frame) in
        [([0.0, 0.0], None), ([0.0, 0.0], Some(0)), ([1.0, 0.4], Some(2)), ([0.5, 1.0], Some(4))]
    {
        let pose =
            frame.map_or_else(|| Pose::rest(6), |frame| avatar.clips[0].poses[frame].clone());
        let wanted = pruned.posed(&pose, &weights).unwrap();
        for (found, &vertex) in player.posed(frame, &weights).into_iter().zip(&origins) {
            let wanted = Vec3::from(wanted[vertex]);
            // A hundredth of a millimetre; floats of this size are accurate to a ten-thousandth.
            assert!(found.distance(wanted) < 1e-5, "{frame:?} {vertex}: {found} {wanted}");
        }
    }
}

#[test]
fn pruning_error_is_reported() {
    let avatar = tube();
    let report = write(&avatar, &looks(), &Export::default()).unwrap().report;
    assert_eq!(report.pruning.vertices, RINGS * SIDES);
    let pruned = avatar.skin.pruned(4).0;
    let mut most = 0.0_f32;
    for pose in &avatar.clips[0].poses {
        let whole = avatar.posed(pose, &[]).unwrap();
        let motions = avatar.skeleton.motions(pose).unwrap();
        for (a, b) in whole.iter().zip(pruned.pose(avatar.mesh.positions(), &motions)) {
            most = most.max(Vec3::from(*a).distance(b.into()));
        }
    }
    assert!((report.pruning_most - most).abs() < 1e-6 && most > 1e-3);
    assert!(report.pruning_mean > 0.0 && report.pruning_mean < most);
}

#[test]
fn accessors_are_as_readers_expect_them() {
    let exported = write(&tube(), &looks(), &Export::default()).unwrap();
    let player = Player::new(&exported.bytes);
    let primitive = player.primitive();
    let found = |semantic| {
        let accessor = primitive.get(&semantic).unwrap();
        (accessor.data_type(), accessor.dimensions(), accessor.normalized())
    };
    assert_eq!(found(gltf::Semantic::Positions), (DataType::F32, Dimensions::Vec3, false));
    assert_eq!(found(gltf::Semantic::Joints(0)), (DataType::U8, Dimensions::Vec4, false));
    assert_eq!(found(gltf::Semantic::Weights(0)), (DataType::F32, Dimensions::Vec4, false));
    assert!(primitive.get(&gltf::Semantic::Tangents).is_none());
    let indices = primitive.indices().unwrap();
    assert_eq!((indices.data_type(), indices.count()), (DataType::U16, 6 * 16 * 3));
    // The bounding box of the tube: its eight sides touch 5 cm in every direction.
    let bounds = primitive.bounding_box();
    assert!((bounds.min[0] + 0.05).abs() < 1e-7 && (bounds.max[2] - 0.05).abs() < 1e-7);
    assert_eq!((bounds.min[1], bounds.max[1]), (0.0, 0.6));
    // The first morph moves few vertices, the second all.
    let targets: Vec<_> = primitive.morph_targets().collect();
    assert!(targets[0].positions().unwrap().sparse().is_some());
    assert!(targets[1].positions().unwrap().sparse().is_none());
    let extras = player.document.meshes().next().unwrap().extras().clone().unwrap();
    assert_eq!(extras.get(), r#"{"targetNames":["bump","thick"]}"#);
    assert!(player.blob.len().is_multiple_of(4));
}

#[test]
fn joints_that_rest_have_no_channel() {
    let exported = write(&tube(), &looks(), &Export::default()).unwrap();
    let player = Player::new(&exported.bytes);
    let animation = player.document.animations().next().unwrap();
    let channels: Vec<_> = animation
        .channels()
        .map(|channel| {
            let reader = channel.reader(|buffer| player.buffer(buffer));
            (channel.target().node().index(), reader.read_inputs().unwrap().count())
        })
        .collect();
    // The root's translation, and joints 1, 3 and 5; joint 2 is constant, 0 and 4 rest.
    assert_eq!(channels, [(0, 5), (1, 5), (2, 2), (3, 5), (5, 5)]);

    let mut still = tube();
    still.clips[0].poses = vec![Pose::rest(6); 5];
    let exported = write(&still, &looks(), &Export::default()).unwrap();
    let player = Player::new(&exported.bytes);
    let animation = player.document.animations().next().unwrap();
    assert_eq!(animation.channels().count(), 1);
    // The length is preserved.
    let channel = animation.channels().next().unwrap();
    let times = channel.reader(|buffer| player.buffer(buffer)).read_inputs().unwrap();
    assert_eq!(times.collect::<Vec<_>>(), [0.0, 1.0]);
}

#[test]
fn a_normal_map_brings_tangents() {
    let looks = AvatarMaterial { normal: Some(picture(EmbeddedFormat::Png)), ..looks() };
    let exported = write(&tube(), &looks, &Export::default()).unwrap();
    let player = Player::new(&exported.bytes);
    let primitive = player.primitive();
    let reader = primitive.reader(|buffer| player.buffer(buffer));
    let positions = player.positions(&[]);
    for ((position, normal), [x, y, z, w]) in
        positions.iter().zip(reader.read_normals().unwrap()).zip(reader.read_tangents().unwrap())
    {
        // `u` increases counter-clockwise seen from above, along the tube's circle.
        let out = Vec3::new(position.x, 0.0, position.z).normalize();
        assert!(Vec3::from(normal).abs_diff_eq(out, 1e-5), "{normal:?} {out}");
        assert!(Vec3::new(x, y, z).dot(Vec3::Y.cross(out)) > 0.99);
        assert_eq!(w, 1.0);
    }
    assert_eq!(player.document.textures().count(), 2);
}

pub(super) fn json(bytes: &[u8]) -> Value {
    serde_json::from_slice(&gltf::Glb::from_slice(bytes).unwrap().json).unwrap()
}

#[test]
fn webp_is_a_required_extension() {
    let webp = picture(EmbeddedFormat::WebP);
    let alone = write(&tube(), &AvatarMaterial::new(webp), &Export::default()).unwrap();
    let found = json(&alone.bytes);
    assert_eq!(found["extensionsRequired"][0], "EXT_texture_webp");
    assert_eq!(found["textures"][0]["source"], Value::Null);
    assert_eq!(found["textures"][0]["extensions"]["EXT_texture_webp"]["source"], 0);
}

#[test]
fn the_same_avatar_makes_the_same_bytes() {
    let write = || write(&tube(), &looks(), &Export::default()).unwrap().bytes;
    assert_eq!(write(), write());
}

/// The tube with the required human bones, the left arm hanging down.
pub(super) fn human() -> Avatar {
    use HumanBone as B;
    let mut avatar = tube();
    let parents: [(HumanBone, usize, [f32; 3]); 17] = [
        (B::Hips, 0, [0.0, 0.9, 0.0]),
        (B::Spine, 0, [0.0, 1.0, 0.0]),
        (B::Head, 1, [0.0, 1.5, 0.0]),
        (B::LeftUpperLeg, 0, [0.1, 0.9, 0.0]),
        (B::LeftLowerLeg, 3, [0.1, 0.5, 0.0]),
        (B::LeftFoot, 4, [0.1, 0.1, 0.0]),
        (B::RightUpperLeg, 0, [-0.1, 0.9, 0.0]),
        (B::RightLowerLeg, 6, [-0.1, 0.5, 0.0]),
        (B::RightFoot, 7, [-0.1, 0.1, 0.0]),
        (B::LeftUpperArm, 1, [0.2, 1.4, 0.0]),
        (B::LeftLowerArm, 9, [0.2, 1.1, 0.0]),
        (B::LeftHand, 10, [0.2, 0.8, 0.0]),
        (B::RightUpperArm, 1, [-0.2, 1.4, 0.0]),
        (B::RightLowerArm, 12, [-0.5, 1.4, 0.0]),
        (B::RightHand, 13, [-0.8, 1.4, 0.0]),
        (B::LeftEye, 2, [0.03, 1.6, 0.08]),
        (B::RightEye, 2, [-0.03, 1.6, 0.08]),
    ];
    let joints = parents.iter().enumerate().map(|(index, &(bone, parent, position))| Joint {
        name: format!("bone {index}"),
        parent: (index > 0).then_some(parent),
        position,
        human: Some(bone),
    });
    avatar.skeleton = Skeleton::new(joints.collect()).unwrap();
    avatar.clips.clear();
    avatar
}

pub(super) fn meta() -> VrmMeta {
    VrmMeta::new("Tube", vec!["Someone".to_owned()], Permissions::ONLY_AUTHOR)
}

#[test]
fn a_vrm_maps_its_bones_and_is_in_t_pose() {
    let avatar = human();
    let export = Export { vrm: Some(meta()), ..Export::default() };
    let exported = write(&avatar, &looks(), &export).unwrap();
    assert!(exported.report.posed_as_t);
    let found = json(&exported.bytes);
    assert_eq!(found["extensionsUsed"], serde_json::json!(["VRMC_vrm"]));
    let vrm = &found["extensions"]["VRMC_vrm"];
    assert_eq!(vrm["specVersion"], "1.0");
    assert_eq!(vrm["meta"]["authors"][0], "Someone");
    assert_eq!(vrm["meta"]["avatarPermission"], "onlyAuthor");
    assert_eq!(vrm["meta"]["licenseUrl"], "https://vrm.dev/licenses/1.0/");
    assert_eq!(vrm["humanoid"]["humanBones"]["leftHand"]["node"], 11);
    let bind = &vrm["expressions"]["preset"]["happy"]["morphTargetBinds"][0];
    assert_eq!(*bind, serde_json::json!({ "node": 17, "index": 0, "weight": 1.0 }));
    assert_eq!(vrm["expressions"]["custom"]["huge"]["morphTargetBinds"][0]["weight"], 0.5);
    assert_eq!(vrm["lookAt"]["type"], "bone");
    assert!((vrm["lookAt"]["offsetFromHeadBone"][1].as_f64().unwrap() - 0.1).abs() < 1e-6);
    assert_eq!(vrm["firstPerson"]["meshAnnotations"][0]["node"], 17);
    // The arm, 60 cm long, points to the left.
    let hand = Player::new(&exported.bytes).joints(None)[11].transform_point3(Vec3::ZERO);
    assert!(hand.abs_diff_eq(Vec3::new(0.8, 1.4, 0.0), 1e-6), "{hand}");
}

#[test]
fn invalid_vrm_input_is_rejected() {
    let refused = |avatar: &Avatar, meta: VrmMeta| {
        let export = Export { vrm: Some(meta), ..Export::default() };
        write(avatar, &looks(), &export).unwrap_err().to_string()
    };
    assert!(refused(&tube(), meta()).contains("must have the bones `hips`, `spine`, `head`"));
    assert!(
        refused(&human(), VrmMeta { authors: vec![], ..meta() }).contains("must have an author")
    );
    assert!(
        refused(&human(), VrmMeta { name: " ".to_owned(), ..meta() }).contains("must have a name")
    );
    let mut wrong = human();
    wrong.expressions[0].morphs[0].1 = 1.5;
    assert!(refused(&wrong, meta()).contains("1.5"));
    let mut wrong = human();
    wrong.expressions[1].preset = Some(ExpressionPreset::Happy);
    assert!(refused(&wrong, meta()).contains("`happy`"));
}

#[test]
fn duplicate_names_are_rejected() {
    let mut wrong = tube();
    wrong.morphs[1].name = "bump".to_owned();
    let error = write(&wrong, &looks(), &Export::default()).unwrap_err();
    assert_eq!(error.to_string(), "duplicate name `bump` of morphs");
    let looks = AvatarMaterial { roughness_factor: f32::NAN, ..looks() };
    assert!(matches!(
        write(&tube(), &looks, &Export::default()),
        Err(GlbError::Factor { what: "roughness", .. })
    ));
}

#[test]
fn given_normals_are_kept() {
    let mut normals = vec![[0.0, 2.0, 0.0]; RINGS * SIDES];
    normals[0] = [f32::NAN; 3];
    let export = Export { normals: Some(normals.clone()), ..Export::default() };
    let exported = write(&tube(), &looks(), &export).unwrap();
    let player = Player::new(&exported.bytes);
    let primitive = player.primitive();
    let reader = primitive.reader(|buffer| player.buffer(buffer));
    let found: Vec<_> = reader.read_normals().unwrap().collect();
    // Zero normals are replaced: the first vertex is in front.
    assert!(Vec3::from(found[0]).abs_diff_eq(Vec3::Z, 1e-6));
    assert!(found[1..].iter().filter(|&&normal| normal == [0.0, 1.0, 0.0]).count() > 50);

    normals.pop();
    let export = Export { normals: Some(normals), ..Export::default() };
    let error = write(&tube(), &looks(), &export).unwrap_err();
    assert_eq!(error.to_string(), "must have 56 normals, got 55");
}

#[test]
fn mesh_nodes_have_unique_names() {
    let export = Export { name: "joint 3".to_owned(), ..Export::default() };
    let exported = write(&tube(), &looks(), &export).unwrap();
    let player = Player::new(&exported.bytes);
    let names: Vec<_> =
        player.document.nodes().skip(5).map(|n| n.name().unwrap().to_owned()).collect();
    assert_eq!(names, ["joint 5", "joint 3 mesh"]);
}
