// What the camera looks at: the whole figure as it stands now, or its head.

import { Box3, Vector3 } from "three";

/// {centre, width, height, depth} of a box.
export function boxed(box) {
  const size = box.getSize(new Vector3());
  return { centre: box.getCenter(new Vector3()), width: size.x, height: size.y, depth: size.z };
}

/// The same of the whole figure.
export function body(root) {
  root.updateWorldMatrix(true, true);
  const box = new Box3().setFromObject(root, true);
  const size = box.getSize(new Vector3());
  // Seen from any side, it is at most this wide.
  return { ...boxed(box), width: Math.max(size.x, size.z) };
}

/// No body is as small as that, in metres, and no head as tall.
const BUST = 0.6;

/// The same of the head: what is above its joint, or the neck's, or the top of a body without either.
export function head(root, rig) {
  const whole = body(root);
  // FLAME's head turns about its neck.
  const bone = rig.bones.get("head") ?? rig.bones.get("neck");
  if (bone) {
    // A hand may be above the head, so the height is the one at rest.
    const height = Math.max(root.userData.restTop - bone.at.y, 1e-3);
    const centre = bone.node.getWorldPosition(new Vector3()).add(new Vector3(0, height * 0.42, 0));
    return { centre, width: height * 1.35, height: height * 1.6 };
  }
  if (whole.height < BUST) return whole;
  const height = whole.height / 7;
  const top = whole.centre.y + whole.height / 2;
  const centre = whole.centre.clone().setY(top - height / 2);
  return { centre, width: height * 1.35, height: height * 1.6 };
}
