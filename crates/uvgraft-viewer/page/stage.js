// Camera, studio lights and ground. Draws on changes only, not continuously.

import {
  AmbientLight, Box3, CircleGeometry, Color, DirectionalLight, Group, HemisphereLight, Mesh, PerspectiveCamera,
  Scene, ShadowMaterial, SkeletonHelper, Spherical, Vector3, VSMShadowMap, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

/// Vertical field of view, in degrees.
const FIELD_OF_VIEW = 28;

export class Stage {
  constructor(place) {
    this.place = place;
    // The page draws the background, behind a transparent canvas.
    this.renderer = new WebGLRenderer({ antialias: true, alpha: true });
    this.renderer.setClearAlpha(0);
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = VSMShadowMap;
    // Only when the figure moved: on a phone, blurring the shadow costs more than everything else.
    this.renderer.shadowMap.autoUpdate = false;
    this.canvas = this.renderer.domElement;
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", "The avatar");
    place.prepend(this.canvas);

    this.scene = new Scene();
    this.camera = new PerspectiveCamera(FIELD_OF_VIEW, 1, 0.01, 100);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.enableDamping = true;
    this.controls.addEventListener("change", () => this.draw());
    this.isStale = true;
    this.extras = new Group();
    this.scene.add(this.extras);
    new ResizeObserver(() => this.#fill()).observe(place);
  }

  /// Puts the figure on the stage and lights it.
  show(root) {
    this.root = root;
    this.scene.add(root);
    this.box = new Box3().setFromObject(root, true);
    const size = this.box.getSize(new Vector3());
    this.radius = Math.max(size.length() / 2, 1e-6);
    this.centre = this.box.getCenter(new Vector3());
    this.#light();
    this.skeleton = new SkeletonHelper(root);
    this.skeleton.material.depthTest = false;
    this.skeleton.setColors?.(new Color("#ffb000"), new Color("#ffe3a0"));
    this.skeleton.visible = false;
    this.skeleton.renderOrder = 1;
    this.scene.add(this.skeleton);
  }

  /// Moves the lights and the ground to where the figure is, and the camera too if `withCamera`.
  follow(x, z, withCamera) {
    const step = new Vector3(x, 0, z).sub(this.extras.position);
    if (step.lengthSq() === 0) return;
    this.extras.position.add(step);
    if (!withCamera) return;
    this.camera.position.add(step);
    this.controls.target.add(step);
  }

  // Three-point lighting: a key light with a shadow from the front, to
  // the left of the person, a fill light from the other side, and a
  // rim light from behind that separates the figure from the background.
  #light() {
    const { radius, centre, box } = this;
    const at = (x, y, z) => new Vector3(x, y, z).multiplyScalar(radius * 2.5).add(centre);
    const lamp = (color, intensity, x, y, z) => {
      const light = new DirectionalLight(color, intensity);
      light.position.copy(at(x, y, z));
      light.target.position.copy(centre);
      this.extras.add(light, light.target);
      return light;
    };
    this.extras.add(new HemisphereLight("#eef3ff", "#8d8276", 1.0), new AmbientLight("#ffffff", 0.35));
    const key = lamp("#fff6ec", 1.85, 0.5, 1.05, 0.95);
    lamp("#e6eeff", 0.7, -0.9, 0.25, 0.7);
    lamp("#ffffff", 0.9, -0.3, 0.7, -1);
    key.castShadow = true;
    // Soft, since only the ground receives it.
    key.shadow.mapSize.set(1024, 1024);
    key.shadow.radius = 4;
    key.shadow.blurSamples = 8;
    this.key = key;
    const wide = radius * 2;
    Object.assign(key.shadow.camera, { left: -wide, right: wide, top: wide, bottom: -wide, near: 0, far: radius * 8 });

    // Not beyond the area that the shadow map covers, whose edges would be visible.
    this.ground = new Mesh(new CircleGeometry(wide * 0.95, 48), new ShadowMaterial({ opacity: 0.34 }));
    this.ground.rotation.x = -Math.PI / 2;
    this.ground.position.set(centre.x, box.min.y - radius * 1e-3, centre.z);
    this.ground.receiveShadow = true;
    this.extras.add(this.ground);
  }

  /// Frames a box from the front, with a margin, above what covers the lower edge of the stage.
  ///
  /// - `covered`: height of the covered strip, in pixels.
  frame({ centre, width, height, depth = 0 }, { fromAbove = 0.04, covered = 0 } = {}) {
    const [across, down] = this.#size();
    const free = Math.max(1 - covered / down, 0.3);
    const half = Math.tan((FIELD_OF_VIEW / 2) * (Math.PI / 180));
    // Visible height at the distance of the box.
    const seen = 1.12 * Math.max(height / free, (width * down) / across);
    const target = centre.clone().add(new Vector3(0, (-seen * (1 - free)) / 2, 0));
    // Its front is nearer than its centre and appears larger, but has to be visible too.
    const distance = seen / 2 / half + depth / 2;
    const eye = target.clone().add(new Vector3(0, fromAbove * distance, distance));
    this.setCamera({ eye: eye.toArray(), target: target.toArray(), up: [0, 1, 0], fovY: FIELD_OF_VIEW });
  }

  /// {eye, target, up, fovY}: metres, and degrees for
  /// the vertical field of view; omitted values stay.
  setCamera({ eye, target, up, fovY }) {
    if (up) this.camera.up.fromArray(up);
    if (eye) this.camera.position.fromArray(eye);
    if (target) this.controls.target.fromArray(target);
    if (fovY) this.camera.fov = fovY;
    this.controls.update();
    // Stops motion left over from a drag.
    this.camera.lookAt(this.controls.target);
    this.draw();
  }

  /// Orbits the camera around its target, by angles in radians to the right and down.
  orbit(right, down) {
    const offset = this.camera.position.clone().sub(this.controls.target);
    const at = new Spherical().setFromVector3(offset);
    at.theta += right;
    at.phi += down;
    offset.setFromSpherical(at.makeSafe());
    this.setCamera({ eye: offset.add(this.controls.target).toArray() });
  }

  /// Multiplies the camera's distance from its target by a factor.
  approach(factor) {
    const { target } = this.controls;
    this.setCamera({ eye: this.camera.position.clone().sub(target).multiplyScalar(factor).add(target).toArray() });
  }

  draw() {
    this.isStale = true;
  }

  /// Redraws with shadows, after the figure changed or moved.
  drawFigure() {
    this.renderer.shadowMap.needsUpdate = true;
    this.draw();
  }

  setGround(isOn) {
    this.ground.visible = isOn;
    this.key.castShadow = isOn;
    this.drawFigure();
  }

  /// Draws if anything changed since the last time.
  render() {
    this.controls.update();
    if (!this.isStale) return;
    this.isStale = false;
    this.#clip();
    this.renderer.render(this.scene, this.camera);
  }

  /// An image of any size, as a canvas with a transparent background.
  picture(width, height) {
    this.renderer.setPixelRatio(1);
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.#clip();
    this.renderer.render(this.scene, this.camera);
    const copy = document.createElement("canvas");
    Object.assign(copy, { width, height });
    // The drawing buffer is valid until this task ends.
    copy.getContext("2d").drawImage(this.canvas, 0, 0);
    this.#fill();
    return copy;
  }

  /// Puts the clip planes as close to the figure as possible, for depth precision.
  #clip() {
    const distance = this.camera.position.distanceTo(this.centre ?? new Vector3());
    const radius = this.radius ?? 1;
    this.camera.near = Math.max(distance - radius * 4, radius * 1e-2);
    this.camera.far = distance + radius * 30;
    this.camera.updateProjectionMatrix();
  }

  #size() {
    return [Math.max(this.place.clientWidth, 1), Math.max(this.place.clientHeight, 1)];
  }

  #fill() {
    const [width, height] = this.#size();
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.isStale = true;
    this.render();
  }
}
