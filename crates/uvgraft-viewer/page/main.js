// Loads what is embedded in the page and shows it.

import { about, modelBytes } from "./embedded.js";
import { expose, fill } from "./hook.js";
import { load } from "./model.js";
import { Panel } from "./panel.js";
import { POSES } from "./poses.js";
import { Stage } from "./stage.js";
import { Viewer } from "./viewer.js";
import { Wardrobe } from "./wardrobe.js";

async function start() {
  const { name, textures, lookAt } = about();
  let stage;
  try {
    stage = new Stage(document.getElementById("stage"));
  } catch (error) {
    throw new Error("This browser does not support WebGL 2, which the viewer requires.", { cause: error });
  }
  const viewer = new Viewer(stage, await load(modelBytes()));
  const wardrobe = new Wardrobe(viewer, textures);
  const panel = new Panel({ name, viewer, wardrobe });
  if (viewer.motion.clips.length) {
    viewer.setClip(0);
    viewer.play(!matchMedia("(prefers-reduced-motion: reduce)").matches);
  } else if (viewer.rig.canPose) {
    viewer.setPose("stand");
  }
  viewer.frame("body");
  if (lookAt) viewer.lookAt(lookAt);
  let before = performance.now();
  const tick = (now) => {
    // After a while in the background, continue from where the motion stopped.
    viewer.advance(Math.min((now - before) / 1000, 0.1));
    before = now;
    requestAnimationFrame(tick);
  };
  viewer.advance(0);
  requestAnimationFrame(tick);
  panel.say("");
  return fill({ viewer, wardrobe, poses: viewer.rig.canPose ? Object.keys(POSES) : [], name });
}

const ready = start();
expose(ready);
ready.catch((error) => {
  document.getElementById("message").textContent = `The avatar cannot be shown.\n${error.message}`;
  console.error(error);
});
