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

/// The same of the head: what is above the joint of the head, or the top of a figure without one.
export function head(root, rig) {
  const whole = body(root);
  const top = whole.centre.y + whole.height / 2;
  const joint = rig.bones.get("head")?.node.getWorldPosition(new Vector3());
  // A hand may be above the head, so the height is the one at rest.
  const rest = rig.bones.get("head")?.at.y;
  const height = rest !== undefined ? Math.max(root.userData.restTop - rest, 1e-3) : whole.height / 7;
  const centre = joint ? joint.clone().add(new Vector3(0, height * 0.42, 0)) : whole.centre.clone().setY(top - height / 2);
  return { centre, width: height * 1.35, height: height * 1.6 };
}
