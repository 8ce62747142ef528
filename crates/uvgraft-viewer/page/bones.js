// Bone names of humanoids: VRM names mapped to those of the SMPL family and Mixamo.

const FINGERS = { Index: "index", Middle: "middle", Ring: "ring", Little: "pinky" };
const JOINTS = ["Proximal", "Intermediate", "Distal"];
const THUMB = ["Metacarpal", "Proximal", "Distal"];

/// [VRM, SMPL-X, Mixamo]
const NAMES = [
  ["hips", "pelvis", "Hips"],
  ["spine", "spine1", "Spine"],
  ["chest", "spine2", "Spine1"],
  ["upperChest", "spine3", "Spine2"],
  ["neck", "neck", "Neck"],
  ["head", "head", "Head"],
  ["jaw", "jaw", "Jaw"],
  ["leftEye", "left_eye_smplhf", "LeftEye"],
  ["rightEye", "right_eye_smplhf", "RightEye"],
];
for (const [side, Side] of [["left", "Left"], ["right", "Right"]]) {
  NAMES.push(
    [`${side}Shoulder`, `${side}_collar`, `${Side}Shoulder`],
    [`${side}UpperArm`, `${side}_shoulder`, `${Side}Arm`],
    [`${side}LowerArm`, `${side}_elbow`, `${Side}ForeArm`],
    [`${side}Hand`, `${side}_wrist`, `${Side}Hand`],
    [`${side}UpperLeg`, `${side}_hip`, `${Side}UpLeg`],
    [`${side}LowerLeg`, `${side}_knee`, `${Side}Leg`],
    [`${side}Foot`, `${side}_ankle`, `${Side}Foot`],
    [`${side}Toes`, `${side}_foot`, `${Side}ToeBase`],
  );
  for (let k = 0; k < 3; k += 1) {
    const thumb = [`${side}_thumb${k + 1}`, `${Side}HandThumb${k + 1}`];
    NAMES.push([`${side}Thumb${THUMB[k]}`, ...thumb]);
    for (const [finger, smpl] of Object.entries(FINGERS)) {
      const mixamo = `${Side}Hand${finger === "Little" ? "Pinky" : finger}${k + 1}`;
      NAMES.push([`${side}${finger}${JOINTS[k]}`, `${side}_${smpl}${k + 1}`, mixamo]);
    }
  }
}

/// Nodes by VRM bone name. A VRM file defines them itself; otherwise the vocabulary, of the three,
/// that matches most joints of the file is used.
export function findBones(root, vrm) {
  const found = new Map();
  if (vrm) {
    for (const [bone] of NAMES) {
      const node = vrm.humanoid?.getRawBoneNode(bone);
      if (node) found.set(bone, node);
    }
    return found;
  }
  const byName = new Map();
  root.traverse((node) => {
    // Exporters prepend namespaces, whose colon the loader removes.
    const name = node.name.replace(/^mixamorig\d*/, "");
    // Prefer a joint to a mesh of the same name.
    if (!byName.has(name) || node.isBone) byName.set(name, node);
  });
  const count = (k) => NAMES.filter((names) => byName.has(names[k])).length;
  const vocabulary = [0, 1, 2].reduce((best, k) => (count(k) > count(best) ? k : best), 0);
  for (const names of NAMES) {
    const node = byName.get(names[vocabulary]);
    if (node) found.set(names[0], node);
  }
  return found;
}
