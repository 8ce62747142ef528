// `window.uvgraft`: scripting interface of the page, for tests and the console.
//
// - `ready`: a promise of `info()`, fulfilled once
//   the figure is drawn, or rejected if it cannot be.
// - `info()`: {name, isVrm, clips: [{name, duration}], poses, expressions, parts, textures}.
// - `bones()`: current positions of the humanoid's bones,
//   {"leftHand": [x, y, z], …}, by VRM name; metres.
// - `setPose("wave")`, or `setPose({leftUpperArm: [x, y, z, w], …})`: rotations relative to the
//   parent bone, in axes that are aligned with the world at rest. Stops a motion.
// - `setExpression("happy", 0.7)`; `setTime(1.5)` or
//   `setTime(1.5, "walk")`: pauses at a time in seconds.
// - `setCamera({eye: [x, y, z], target: [x, y, z], up: [0, 1, 0], fovY: 28})`: metres and degrees;
//   omitted values stay. The camera stops following the figure.
// - `lookAt("leftHand")`: a bone by its VRM name, or
//   any node; or `lookAt([x, y, z, x, y, z])`: a box.
// - `setUnlit(true)`, `setBackground("#ffffff")`, `setGround(false)`, `setTexture(1)`: a texture by
//   its index in `info().textures`, of which 0 is the file's own.
// - `screenshot(width, height, {transparent: true})`: a data URL of a PNG.
//
// Everything except `ready` becomes available when `ready` is fulfilled, throws a RangeError for
// unknown names, and takes effect immediately.

export function expose(ready) {
  window.uvgraft = { ready };
}

export function fill({ viewer, wardrobe, poses, name }) {
  const info = () => ({
    name,
    isVrm: viewer.model.vrm !== null,
    clips: viewer.motion.clips.map((clip) => ({ name: clip.name, duration: clip.duration })),
    poses,
    expressions: [...viewer.expressions.weights.keys()],
    parts: wardrobe.parts.map((part) => part.name),
    textures: wardrobe.textures.map((texture) => texture.name),
  });
  Object.assign(window.uvgraft, {
    info,
    bones: () => {
      viewer.model.root.updateWorldMatrix(true, true);
      return viewer.rig.positions();
    },
    setPose: (pose) => viewer.setPose(pose),
    setExpression: (expression, weight) => viewer.setExpression(expression, weight),
    setTime: (seconds, clip) => viewer.setTime(seconds, clip),
    setCamera: (camera) => viewer.setCamera(camera),
    lookAt: (what) => viewer.lookAt(what),
    setUnlit: (isUnlit) => viewer.setUnlit(isUnlit),
    setBackground: (background) => viewer.setBackground(background),
    setGround: (isOn) => viewer.setGround(isOn),
    setTexture: (index) => wardrobe.wear(index),
    screenshot: (width, height, options) => viewer.picture(width, height, options).toDataURL("image/png"),
  });
  return info();
}
