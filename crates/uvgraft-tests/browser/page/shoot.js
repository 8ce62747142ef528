// See ../shoot.mjs. Shares no code with the viewer, so that both cannot have the same bug.

import * as THREE from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
import { VRMLoaderPlugin } from "@pixiv/three-vrm";

let gltf, vrm, mixer, renderer, atRest;
const scene = new THREE.Scene();

async function load() {
  const loader = new GLTFLoader();
  loader.register((parser) => new VRMLoaderPlugin(parser));
  gltf = await loader.loadAsync("/avatar");
  vrm = gltf.userData.vrm ?? null;
  scene.add(gltf.scene);
  mixer = new THREE.AnimationMixer(gltf.scene);
  renderer = new THREE.WebGLRenderer({ antialias: true, alpha: true, preserveDrawingBuffer: true });
  const sun = new THREE.DirectionalLight("#ffffff", 2.2);
  sun.position.set(1, 2, 3);
  scene.add(sun, new THREE.HemisphereLight("#ffffff", "#999999", 1.4));

  atRest = new Map();
  const morphTargets = {};
  const materials = new Set();
  gltf.scene.traverse((node) => {
    atRest.set(node, { quaternion: node.quaternion.clone(), position: node.position.clone(), influences: node.morphTargetInfluences?.slice() });
    if (node.isMesh) {
      node.frustumCulled = false;
      for (const material of [node.material].flat()) materials.add(material.name);
      node.userData.lit = node.material;
      node.userData.unlit = [node.material].flat().map(unlit);
      if (!Array.isArray(node.material)) [node.userData.unlit] = node.userData.unlit;
    }
    if (node.morphTargetDictionary) morphTargets[node.name] = Object.keys(node.morphTargetDictionary);
  });
  return {
    isVrm: vrm !== null,
    meta: vrm?.meta ?? null,
    humanoid: Object.keys(vrm?.humanoid.humanBones ?? {}),
    expressions: (vrm?.expressionManager?.expressions ?? []).map((each) => each.expressionName),
    animations: gltf.animations.map(({ name, duration }) => ({ name, duration })),
    morphTargets,
    materials: [...materials],
  };
}

function unlit({ map, color, side, transparent, alphaTest, opacity, vertexColors }) {
  return new THREE.MeshBasicMaterial({ map: map ?? null, color, side, transparent, alphaTest, opacity, vertexColors });
}

function shoot(wanted) {
  const { width, height, camera, background, clip, time = 0, pose = {}, expressions = {} } = wanted;
  mixer.stopAllAction();
  for (const [node, { quaternion, position, influences }] of atRest) {
    node.quaternion.copy(quaternion);
    node.position.copy(position);
    influences?.forEach((value, k) => (node.morphTargetInfluences[k] = value));
    if (node.isMesh) node.material = wanted.unlit ? node.userData.unlit : node.userData.lit;
  }
  vrm?.humanoid.resetNormalizedPose();
  vrm?.expressionManager?.resetValues();

  const isPlaying = clip !== undefined && clip !== null;
  if (isPlaying) {
    const found = gltf.animations[clip] ?? gltf.animations.find(({ name }) => name === clip);
    if (!found) throw new Error(`no clip ${clip}`);
    const action = mixer.clipAction(found);
    action.play();
    action.time = time;
    mixer.update(0);
  }
  for (const [name, rotation] of Object.entries(pose)) {
    const node = vrm ? vrm.humanoid.getNormalizedBoneNode(name) : gltf.scene.getObjectByName(name);
    if (!node) throw new Error(`no bone ${name}`);
    node.quaternion.fromArray(rotation);
  }
  if (vrm) {
    // A clip animates the file's own nodes, which normalized bones at rest would reset.
    vrm.humanoid.autoUpdateHumanBones = !isPlaying;
    for (const [name, weight] of Object.entries(expressions)) {
      if (!vrm.expressionManager?.getExpression(name)) throw new Error(`no expression ${name}`);
      vrm.expressionManager.setValue(name, weight);
    }
    // With no expression set, an update would clear the morph targets that a clip animates.
    if (Object.keys(expressions).length) vrm.update(0);
    else vrm.humanoid.update();
  } else {
    for (const [name, weight] of Object.entries(expressions)) {
      let isFound = false;
      gltf.scene.traverse((node) => {
        const index = node.morphTargetDictionary?.[name];
        if (index === undefined) return;
        node.morphTargetInfluences[index] = weight;
        isFound = true;
      });
      if (!isFound) throw new Error(`no morph target ${name}`);
    }
  }
  gltf.scene.updateMatrixWorld(true);

  const { eye, target, up = [0, 1, 0], fovY } = camera;
  const view = new THREE.PerspectiveCamera(fovY, width / height, 0.02, 50);
  view.position.fromArray(eye);
  view.up.fromArray(up);
  view.lookAt(...target);
  renderer.setPixelRatio(1);
  renderer.setSize(width, height);
  renderer.setClearColor(background ?? "#000000", background ? 1 : 0);
  renderer.render(scene, view);

  const place = (node) => node.getWorldPosition(new THREE.Vector3()).toArray();
  const bones = {};
  for (const [name, { node }] of Object.entries(vrm?.humanoid.humanBones ?? {})) bones[name] = place(node);
  const joints = {};
  gltf.scene.traverse((node) => {
    for (const joint of node.skeleton?.bones ?? []) joints[joint.name] = place(joint);
  });
  return { bones, joints, picture: renderer.domElement.toDataURL("image/png") };
}

window.avatar = { load, shoot };
