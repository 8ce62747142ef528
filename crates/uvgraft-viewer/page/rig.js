// Rotates a humanoid's bones from the bind pose.
//
// Rotations are what VRM calls normalized: relative to the parent bone, in axes that are aligned
// with the world at rest, whatever the axes of the file's nodes.

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

  /// Whether it has the bones that poses need.
  get canPose() {
    return ["head", "leftUpperArm", "rightUpperArm"].every((name) => this.bones.has(name));
  }

  #parentOf(node) {
    for (let at = node.parent; at; at = at.parent) {
      for (const [name, bone] of this.bones) if (bone.node === at) return name;
    }
    return null;
  }

  /// Restores the rest pose.
  rest() {
    this.root.position.y = this.rootHeight;
    for (const { node, rest } of this.bones.values()) node.quaternion.copy(rest);
  }

  /// Sets rotations relative to the rest pose; names that the rig lacks are ignored.
  turn(rotations) {
    this.rest();
    for (const [name, rotation] of Object.entries(rotations)) {
      const bone = this.bones.get(name);
      if (!bone) continue;
      bone.node.quaternion
        .copy(bone.parentFromWorld).multiply(rotation).multiply(bone.worldFromParent).multiply(bone.rest);
    }
  }

  /// Lowers or lifts the figure so that its lower foot is at its height in the rest pose.
  stand() {
    const heights = ["leftFoot", "rightFoot", "leftToes", "rightToes"]
      .map((name) => this.bones.get(name))
      .filter(Boolean)
      .map(({ node, at }) => node.getWorldPosition(new Vector3()).y - at.y);
    if (heights.length) this.root.position.y -= Math.min(...heights);
  }

  /// The direction from one bone to another in the rest pose.
  direction(from, to) {
    const [a, b] = [this.bones.get(from), this.bones.get(to)];
    return a && b ? b.at.clone().sub(a.at).normalize() : null;
  }

  /// Current positions of all bones: name → [x, y, z] in the world.
  positions() {
    const found = {};
    for (const [name, { node }] of this.bones) {
      found[name] = node.getWorldPosition(new Vector3()).toArray();
    }
    return found;
  }
}
