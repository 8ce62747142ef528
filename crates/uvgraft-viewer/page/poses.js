// Poses that do not depend on the bind pose: they define directions of limbs.

import { Quaternion, Vector3 } from "three";

/// The joint that a limb points to.
const NEXT = { UpperArm: "LowerArm", LowerArm: "Hand", Hand: "MiddleProximal", UpperLeg: "LowerLeg", LowerLeg: "Foot" };

const HANGING = { UpperArm: [0.2, -1, 0.0], LowerArm: [0.1, -1, 0.18], Hand: [0.02, -1, 0.1] };

// Directions are for the left side and mirrored for the right: x is outwards, y up, z forwards.
// `turn` is in degrees about x, y and z; `curl` in degrees for each finger joint.
export const POSES = {
  rest: { title: "Rest" },
  t: { title: "T", both: { UpperArm: [1, 0, 0], LowerArm: [1, 0, 0], Hand: [1, 0, 0] } },
  a: { title: "A", both: { UpperArm: [1, -1, 0], LowerArm: [1, -1, 0], Hand: [1, -1, 0] } },
  stand: { title: "Stand", both: HANGING, curl: 16 },
  wave: {
    title: "Wave",
    left: HANGING,
    right: { UpperArm: [0.9, -0.35, 0.25], LowerArm: [0.3, 1, 0.2], Hand: [0.12, 1, 0.1] },
    turn: { head: [0, 0, 6] },
    curl: { left: 16, right: 4 },
  },
  cheer: {
    title: "Cheer",
    both: { UpperArm: [0.75, 0.75, 0], LowerArm: [0.35, 1, 0.1], Hand: [0.3, 1, 0.1] },
    turn: { head: [-10, 0, 0] },
  },
  stride: {
    title: "Stride",
    left: { UpperArm: [0.2, -1, -0.45], LowerArm: [0.1, -1, 0.1], Hand: [0, -1, 0.1], UpperLeg: [0, -1, 0.45], LowerLeg: [0, -1, 0.1] },
    right: { UpperArm: [0.2, -1, 0.45], LowerArm: [0.05, -0.9, 0.75], Hand: [0, -1, 0.8], UpperLeg: [0, -1, -0.3], LowerLeg: [0, -0.9, -0.75] },
    turn: { chest: [0, -6, 0], head: [0, 6, 0] },
    curl: 28,
  },
  sit: {
    title: "Sit",
    both: { UpperArm: [0.22, -1, 0.12], LowerArm: [-0.05, -0.55, 1], Hand: [-0.1, -0.15, 1], UpperLeg: [0.14, -0.06, 1], LowerLeg: [0, -1, 0.05] },
    curl: 12,
  },
};

/// Rotations of a pose for a rig, as input to `Rig.turn`.
export function rotationsOf(pose, rig) {
  const aims = {};
  for (const [side, mirror] of [["left", 1], ["right", -1]]) {
    for (const [limb, [x, y, z]] of Object.entries({ ...pose.both, ...pose[side] })) {
      aims[side + limb] = {
        to: new Vector3(x * mirror, y, z).normalize(),
        from: rig.direction(side + limb, side + NEXT[limb]),
      };
    }
  }
  // World rotation of each bone's axes, computed parents first.
  const turned = new Map();
  const rotations = {};
  const visit = (name) => {
    if (name === null) return new Quaternion();
    if (turned.has(name)) return turned.get(name);
    const parent = visit(rig.bones.get(name).parent);
    const aim = aims[name];
    const world = parent.clone();
    if (aim?.from) {
      world.premultiply(new Quaternion().setFromUnitVectors(aim.from.applyQuaternion(parent), aim.to));
    }
    const local = localTurn(pose, name);
    if (local) world.multiply(local);
    turned.set(name, world);
    if (aim || local) rotations[name] = parent.clone().invert().multiply(world);
    return world;
  };
  for (const name of rig.bones.keys()) visit(name);
  return rotations;
}

function localTurn(pose, name) {
  const radians = Math.PI / 180;
  const turn = pose.turn?.[name];
  if (turn) {
    const about = (axis, angle) => new Quaternion().setFromAxisAngle(axis, angle * radians);
    return about(new Vector3(1, 0, 0), turn[0])
      .multiply(about(new Vector3(0, 1, 0), turn[1]))
      .multiply(about(new Vector3(0, 0, 1), turn[2]));
  }
  const finger = /^(left|right)(Index|Middle|Ring|Little)/.exec(name);
  const curl = finger && (pose.curl?.[finger[1]] ?? pose.curl);
  if (typeof curl !== "number") return null;
  // Arms are bound at the sides with palms down or inwards, so fingers bend about the forward axis.
  const angle = (finger[1] === "left" ? -curl : curl) * radians;
  return new Quaternion().setFromAxisAngle(new Vector3(0, 0, 1), angle);
}
