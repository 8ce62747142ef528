// The viewer without its controls: one figure on a stage, and everything that can be done with it.

import { Box3, Quaternion, Vector3 } from "three";
import { around } from "./around.js";
import { Expressions } from "./expressions.js";
import * as frames from "./frames.js";
import { Looks } from "./looks.js";
import { Motion } from "./motion.js";
import { backdrop, laid } from "./picture.js";
import { POSES, rotationsOf } from "./poses.js";
import { Rig } from "./rig.js";

export class Viewer extends EventTarget {
  constructor(stage, model) {
    super();
    this.stage = stage;
    this.model = model;
    const { root, vrm, clips } = model;
    this.rig = new Rig(root, vrm);
    this.expressions = new Expressions(root, vrm);
    this.motion = new Motion(root, clips);
    this.looks = new Looks(root);
    stage.show(root);
    root.userData.restTop = stage.box.max.y;
    this.pose = "rest";
    /// Whether the camera follows the figure.
    this.isFollowing = true;
    /// Height in pixels of the strip at the stage's lower edge that controls cover.
    this.covered = 0;
    this.setBackground("studio");
    this.frame("body");
  }

  #changed() {
    this.stage.drawFigure();
    this.dispatchEvent(new Event("change"));
  }

  /// Sets a pose by its name, or rotations by VRM bone name: [x, y, z, w] or quaternions.
  setPose(pose) {
    const isNamed = typeof pose === "string";
    if (isNamed && !Object.hasOwn(POSES, pose)) throw new RangeError(`no pose ${pose}, only ${Object.keys(POSES).join(", ")}`);
    this.motion.choose(null);
    const rotations = isNamed
      ? rotationsOf(POSES[pose], this.rig)
      : Object.fromEntries(Object.entries(pose).map(([name, value]) => [name, new Quaternion(...value).normalize()]));
    this.rig.turn(rotations);
    if (isNamed) this.rig.stand();
    this.pose = isNamed ? pose : null;
    this.#settle();
    this.#changed();
  }

  setClip(which) {
    this.rig.rest();
    this.motion.choose(null);
    const found = this.motion.choose(which);
    this.pose = found ? null : "rest";
    this.#settle();
    this.#changed();
    return found;
  }

  play(isPlaying) {
    this.motion.playing = isPlaying && this.motion.action !== null;
    this.#changed();
  }

  /// Pauses at a time in seconds, in the clip with the given index or name if any.
  setTime(seconds, clip) {
    if (clip !== undefined || !this.motion.action) this.setClip(clip ?? 0);
    this.motion.playing = false;
    this.motion.seek(seconds);
    this.#settle();
    this.#changed();
  }

  setExpression(name, weight) {
    if (!this.expressions.set(name, weight)) throw new RangeError(`no expression ${name}`);
    this.#changed();
  }

  setUnlit(isUnlit) {
    this.looks.setUnlit(isUnlit);
    this.#changed();
  }

  setWireframe(isOn) {
    this.isWireframe = isOn;
    this.looks.setWireframe(isOn);
    this.#changed();
  }

  /// Sets the camera as `Stage.setCamera` does, and stops it from following the figure.
  setCamera(camera) {
    this.isFollowing = false;
    this.stage.setCamera(camera);
  }

  setSkeleton(isOn) {
    this.stage.skeleton.visible = isOn;
    this.#changed();
  }

  setGround(isOn) {
    this.stage.setGround(isOn);
    this.#changed();
  }

  /// Sets one of the backgrounds by name, or a CSS colour.
  setBackground(name) {
    this.background = name;
    this.stage.place.style.setProperty("--backdrop", backdrop(name));
    this.#changed();
  }

  setTexture(part, image) {
    this.looks.setTexture(part, image);
    this.#changed();
  }

  /// Frames the "body" or the "head".
  frame(what) {
    this.isFollowing = true;
    const { root } = this.model;
    const isHead = what === "head";
    this.stage.frame(isHead ? frames.head(root, this.rig) : frames.body(root), {
      fromAbove: isHead ? 0 : 0.04,
      covered: this.covered,
    });
  }

  /// Aims the camera at a bone (by its VRM name), a node, or a box: [x, y, z, x, y, z] in metres.
  lookAt(what) {
    const { root } = this.model;
    const box = Array.isArray(what)
      ? new Box3().setFromPoints([new Vector3(...what.slice(0, 3)), new Vector3(...what.slice(3))])
      : around(root, this.rig, what);
    if (!box) throw new RangeError(`no bone ${what}, only ${[...this.rig.bones.keys()].join(", ")}`);
    this.isFollowing = !Array.isArray(what);
    this.stage.frame(frames.boxed(box), { fromAbove: 0, covered: this.covered });
  }

  /// An image as a canvas, with the background unless `transparent`.
  picture(width, height, { transparent = false } = {}) {
    const canvas = this.stage.picture(width, height);
    return transparent ? canvas : laid(canvas, this.background);
  }

  /// Advances the animation by a time in seconds, and draws.
  advance(seconds) {
    const { vrm } = this.model;
    if (this.motion.advance(seconds)) {
      this.#settle(seconds);
      this.stage.drawFigure();
      this.dispatchEvent(new Event("time"));
    } else if (vrm?.springBoneManager?.joints.size) {
      vrm.springBoneManager.update(seconds);
      this.stage.drawFigure();
    }
    this.stage.render();
  }

  // Updates what depends on the bones and the face: constraints, eyes, swinging hair.
  #settle(seconds = 0) {
    const { vrm } = this.model;
    this.expressions.update();
    const hips = this.rig.bones.get("hips");
    if (hips) {
      const at = hips.node.getWorldPosition(new Vector3()).sub(hips.at);
      this.stage.follow(at.x, at.z, this.isFollowing);
    }
    vrm?.lookAt?.update(seconds);
    vrm?.nodeConstraintManager?.update();
    if (seconds > 0) vrm?.springBoneManager?.update(seconds);
    else vrm?.springBoneManager?.reset();
    for (const material of vrm?.materials ?? []) material.update?.(seconds);
  }
}
