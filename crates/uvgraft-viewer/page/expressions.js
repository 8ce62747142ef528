// Expressions: those that a VRM defines, otherwise the morph targets of all meshes by name.

export class Expressions {
  constructor(root, vrm) {
    this.manager = vrm?.expressionManager ?? null;
    /// Name → weight in 0..1.
    this.weights = new Map();
    this.meshes = [];
    root.traverse((node) => {
      if (node.morphTargetDictionary) this.meshes.push(node);
    });
    const names = this.manager?.expressions.length
      ? this.manager.expressions.map((expression) => expression.expressionName)
      : this.meshes.flatMap((mesh) => Object.keys(mesh.morphTargetDictionary));
    if (!this.manager?.expressions.length) this.manager = null;
    for (const name of names) this.weights.set(name, 0);
  }

  /// Sets a weight; false if there is no such expression.
  set(name, weight) {
    if (!this.weights.has(name)) return false;
    const value = Math.min(Math.max(Number(weight) || 0, 0), 1);
    this.weights.set(name, value);
    if (this.manager) {
      this.manager.setValue(name, value);
      this.manager.update();
    }
    for (const mesh of this.manager ? [] : this.meshes) {
      const index = mesh.morphTargetDictionary[name];
      if (index !== undefined) mesh.morphTargetInfluences[index] = value;
    }
    return true;
  }

  /// To be called once a frame, after animation moved the face: expressions
  /// that are set override the animation. While none is set, the VRM's
  /// expressions are not updated, since that would clear the animation.
  update() {
    for (const [name, weight] of this.weights) if (weight > 0) this.set(name, weight);
  }
}
