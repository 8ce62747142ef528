// Turning a humanoid's bones from the pose it was bound in.
//
// A rotation here is what VRM calls normalized: relative to the parent bone, in axes that are
// aligned with the world at rest, whatever the axes of the file's nodes are.

import { Quaternion, Vector3 } from "three";
import { findBones } from "./bones.js";

export class Rig {
  constructor(root, vrm) {
    this.root = root;
    this.rootHeight = root.position.y;
    root.updateWorldMatrix(true, true);
    this.bones = new Map();
    for (const [name, node] of findBones(root, vrm)) {
      this.bones.set(name, {
        node,
        rest: node.quaternion.clone(),
        parentFromWorld: node.parent.getWorldQuaternion(new Quaternion()).invert(),
        worldFromParent: node.parent.getWorldQuaternion(new Quaternion()),
        at: node.getWorldPosition(new Vector3()),
      });
    }
    for (const bone of this.bones.values()) bone.parent = this.#parentOf(bone.node);
  }

  /// Whether there is enough of a humanoid to pose.
  get canPose() {
    return ["head", "leftUpperArm", "rightUpperArm"].every((name) => this.bones.has(name));
  }

  #parentOf(node) {
    for (let at = node.parent; at; at = at.parent) {
      for (const [name, bone] of this.bones) if (bone.node === at) return name;
    }
    return null;
  }

  /// Puts all bones as they were at rest.
  rest() {
    this.root.position.y = this.rootHeight;
    for (const { node, rest } of this.bones.values()) node.quaternion.copy(rest);
  }

  /// Rests, then turns bones; names that the rig lacks are passed over.
  turn(rotations) {
    this.rest();
    for (const [name, rotation] of Object.entries(rotations)) {
      const bone = this.bones.get(name);
      if (!bone) continue;
      bone.node.quaternion
        .copy(bone.parentFromWorld).multiply(rotation).multiply(bone.worldFromParent).multiply(bone.rest);
    }
  }

  /// Lets the figure down, or lifts it, so that its lower foot is as high as at rest.
  stand() {
    const heights = ["leftFoot", "rightFoot", "leftToes", "rightToes"]
      .map((name) => this.bones.get(name))
      .filter(Boolean)
      .map(({ node, at }) => node.getWorldPosition(new Vector3()).y - at.y);
    if (heights.length) this.root.position.y -= Math.min(...heights);
  }

  /// The direction from a bone to another at rest.
  direction(from, to) {
    const [a, b] = [this.bones.get(from), this.bones.get(to)];
    return a && b ? b.at.clone().sub(a.at).normalize() : null;
  }

  /// Where each bone is now: name → [x, y, z] in the world.
  positions() {
    const found = {};
    for (const [name, { node }] of this.bones) {
      found[name] = node.getWorldPosition(new Vector3()).toArray();
    }
    return found;
  }
}
