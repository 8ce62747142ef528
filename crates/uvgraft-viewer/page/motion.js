// Playing the clips of a file.

import { AnimationMixer } from "three";

export class Motion {
  constructor(root, clips) {
    this.mixer = new AnimationMixer(root);
    this.clips = clips;
    this.action = null;
    this.playing = false;
    this.speed = 1;
  }

  get duration() {
    return this.action?.getClip().duration ?? 0;
  }

  get time() {
    return this.action?.time ?? 0;
  }

  /// Takes a clip by its number or name, or none: then everything is as it was before.
  choose(which) {
    this.mixer.stopAllAction();
    const clip = this.clips[which] ?? this.clips.find(({ name }) => name === which) ?? null;
    this.action = clip && this.mixer.clipAction(clip);
    this.action?.play();
    if (!clip) this.playing = false;
    this.mixer.update(0);
    return clip !== null;
  }

  /// Puts the clip to a time in seconds; times beyond its end are its end.
  seek(seconds) {
    if (!this.action) return;
    this.action.time = Math.min(Math.max(seconds, 0), this.duration);
    this.mixer.update(0);
  }

  /// Goes on by a time in seconds, around at the end. Whether anything moved.
  advance(seconds) {
    if (!this.playing || !this.action) return false;
    this.mixer.update(seconds * this.speed);
    return true;
  }
}
