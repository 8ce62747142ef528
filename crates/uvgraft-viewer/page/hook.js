// `window.uvgraft`: the page by script, for tests and for consoles.
//
// - `ready`: a promise of `info()`, once the figure is drawn; rejected if it could not be.
// - `info()`: {name, isVrm, clips: [{name, duration}], poses, expressions, parts, textures}.
// - `bones()`: where the humanoid's bones are now, {"leftHand": [x, y, z], …}, by VRM's names; metres.
// - `setPose("wave")`, or `setPose({leftUpperArm: [x, y, z, w], …})`: rotations relative to the parent
//   bone in axes that are aligned with the world at rest. Ends a motion.
// - `setExpression("happy", 0.7)`; `setTime(1.5)` or `setTime(1.5, "walk")`: seconds, paused there.
// - `setCamera({eye: [x, y, z], target: [x, y, z], up: [0, 1, 0], fovY: 28})`: metres,
//   degrees; what is left out stays. The camera follows the figure no more then.
// - `lookAt("leftHand")`, by VRM's name of a bone or any node's, or `lookAt([x, y, z, x, y, z])`: a box.
// - `setUnlit(true)`, `setBackground("#ffffff")`, `setGround(false)`, `setTexture(1)`: a texture by its
//   number in `info().textures`, of which 0 is the file's own.
// - `screenshot(width, height, {transparent: true})`: a data URL of a PNG.
//
// All but `ready` are there when it is fulfilled, throw a RangeError for names that there are none of,
// and take effect at once.

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
