// Playback of a file's clips.

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

  /// Selects a clip by index or name, or none, which restores the state before any clip.
  choose(which) {
    this.mixer.stopAllAction();
    const clip = this.clips[which] ?? this.clips.find(({ name }) => name === which) ?? null;
    this.action = clip && this.mixer.clipAction(clip);
    this.action?.play();
    if (!clip) this.playing = false;
    this.mixer.update(0);
    return clip !== null;
  }

  /// Sets the time in seconds, clamped to the clip.
  seek(seconds) {
    if (!this.action) return;
    this.action.time = Math.min(Math.max(seconds, 0), this.duration);
    this.mixer.update(0);
  }

  /// Advances by a time in seconds, looping at the end. Returns whether a clip is playing.
  advance(seconds) {
    if (!this.playing || !this.action) return false;
    this.mixer.update(seconds * this.speed);
    return true;
  }
}
