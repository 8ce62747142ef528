// The region that a bone or a node moves, for aiming the camera; the same rule as
// `uvgraft render --look-at`.

import { Box3, Matrix4, Vector3 } from "three";

/// Bones that start a body part; every other bone, such
/// as a finger's, belongs to the part of its parent.
const PARTS = ["hips", "spine", "chest", "upperChest", "neck", "head"];
for (const side of ["left", "right"]) {
  for (const bone of ["Shoulder", "UpperArm", "LowerArm", "Hand", "UpperLeg", "LowerLeg", "Foot"]) PARTS.push(side + bone);
}

/// Bounding box of what a bone (by its VRM name) or a node
/// moves, in the current pose; null if the name is unknown.
export function around(root, rig, name) {
  const bone = rig.bones.get(name)?.node;
  const target = bone ?? root.getObjectByName(name);
  if (!target) return null;
  const starts = new Set(bone ? PARTS.map((part) => rig.bones.get(part)?.node) : []);
  const own = new Set();
  const take = (node) => {
    own.add(node);
    for (const child of node.children) if (!starts.has(child)) take(child);
  };
  take(target);
  root.updateWorldMatrix(true, true);
  const box = new Box3();
  root.traverse((mesh) => {
    if (mesh.isMesh) vertices(mesh, own, (place) => box.expandByPoint(place));
  });
  if (box.isEmpty()) {
    // A joint that moves no vertices: use a box around it of an eighth of the figure's size.
    const whole = new Box3().setFromObject(root, true).getSize(new Vector3()).length();
    box.setFromCenterAndSize(target.getWorldPosition(new Vector3()), new Vector3(1, 1, 1).multiplyScalar(whole / 8));
  }
  return box;
}

/// Calls `call` with the position of each vertex, of each instance, that `own` nodes influence by more
/// than half.
function vertices(mesh, own, call) {
  const instances = mesh.isInstancedMesh ? mesh.count : 1;
  for (let instance = 0; instance < instances; instance += 1) {
    const placed = mesh.matrixWorld.clone();
    if (mesh.isInstancedMesh) {
      const local = new Matrix4();
      mesh.getMatrixAt(instance, local);
      placed.multiply(local);
    }
    ofInstance(mesh, placed, own, call);
  }
}

function ofInstance(mesh, placed, own, call) {
  const { position, skinIndex, skinWeight } = mesh.geometry.attributes;
  const bones = mesh.isSkinnedMesh ? mesh.skeleton.bones.map((bone) => own.has(bone)) : null;
  if (!bones && !own.has(mesh)) return;
  const place = new Vector3();
  for (let vertex = 0; vertex < position.count; vertex += 1) {
    let share = bones ? 0 : 1;
    for (let k = 0; bones && k < 4; k += 1) {
      if (bones[skinIndex.getComponent(vertex, k)]) share += skinWeight.getComponent(vertex, k);
    }
    if (share > 0.5) call(mesh.getVertexPosition(vertex, place).applyMatrix4(placed));
  }
}
