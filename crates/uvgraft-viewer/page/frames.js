// Boxes to frame with the camera: the whole figure in its current pose, or its head.

import { Box3, Vector3 } from "three";

/// {centre, width, height, depth} of a box.
export function boxed(box) {
  const size = box.getSize(new Vector3());
  return { centre: box.getCenter(new Vector3()), width: size.x, height: size.y, depth: size.z };
}

/// Box of the whole figure.
export function body(root) {
  root.updateWorldMatrix(true, true);
  const box = new Box3().setFromObject(root, true);
  const size = box.getSize(new Vector3());
  // Upper limit of the width seen from any side.
  return { ...boxed(box), width: Math.max(size.x, size.z) };
}

/// Height in metres that separates busts from bodies: no body is that short, and no head that tall.
const BUST = 0.6;

/// Box of the head: what is above the joint of the head
/// or the neck, or the top of a body that has neither.
export function head(root, rig) {
  const whole = body(root);
  // FLAME's head rotates about its neck.
  const bone = rig.bones.get("head") ?? rig.bones.get("neck");
  if (bone) {
    // Use the height at rest: in the current pose a hand may be above the head.
    const height = Math.max(root.userData.restTop - bone.at.y, 1e-3);
    const centre = bone.node.getWorldPosition(new Vector3()).add(new Vector3(0, height * 0.42, 0));
    return { centre, width: height * 1.35, height: height * 1.6 };
  }
  if (whole.height < BUST) return whole;
  const height = whole.height / 7;
  const from = whole.centre.y + whole.height / 2 - height;
  // What is up there: of several bodies side by side, all heads.
  const box = new Box3();
  const place = new Vector3();
  root.traverse((mesh) => {
    const count = mesh.isMesh ? mesh.geometry.attributes.position.count : 0;
    for (let vertex = 0; vertex < count; vertex += 1) {
      mesh.getVertexPosition(vertex, place).applyMatrix4(mesh.matrixWorld);
      if (place.y >= from) box.expandByPoint(place);
    }
  });
  const size = box.getSize(new Vector3());
  return { centre: box.getCenter(new Vector3()), width: Math.max(size.x, size.z) * 1.2, height: height * 1.6 };
}
