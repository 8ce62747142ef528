// Loads a GLB or VRM, and lists facts about it.

import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
import { VRMLoaderPlugin, VRMUtils } from "@pixiv/three-vrm";

/// {root, clips, vrm, json}; `vrm` is null for an ordinary GLB.
export async function load(bytes) {
  const loader = new GLTFLoader();
  loader.register((parser) => new VRMLoaderPlugin(parser));
  const gltf = await loader.parseAsync(bytes.buffer, "");
  const vrm = gltf.userData.vrm ?? null;
  // VRM 0 faces -Z, everything else +Z.
  if (vrm) VRMUtils.rotateVRM0(vrm);
  const root = vrm?.scene ?? gltf.scene;
  root.traverse((node) => {
    if (!node.isMesh) return;
    node.castShadow = true;
    // Bounds of a skinned mesh are those of the rest pose.
    node.frustumCulled = false;
  });
  return { root, clips: gltf.animations, vrm, json: gltf.parser.json };
}

/// Rows for the section about the file: [label, value].
export function facts({ root, clips, vrm, json }) {
  let triangles = 0;
  const joints = new Set();
  root.traverse((node) => {
    if (node.isMesh) {
      const { index, attributes } = node.geometry;
      triangles += ((index ?? attributes.position).count / 3) * (node.isInstancedMesh ? node.count : 1);
    }
    for (const bone of node.skeleton?.bones ?? []) joints.add(bone);
  });
  const meta = vrm?.meta;
  const list = (values) => (values ?? []).filter(Boolean).join(", ");
  return [
    ["Title", meta?.name ?? meta?.title],
    ["Author", meta && (list(meta.authors) || meta.author)],
    ["Licence", meta && (meta.licenseUrl ?? meta.licenseName)],
    ["Format", vrm ? `VRM ${meta?.metaVersion === "0" ? "0" : "1.0"}` : "GLB"],
    ["Triangles", Math.round(triangles).toLocaleString("en")],
    ["Joints", joints.size || null],
    ["Motions", clips.length || null],
    ["Made by", json.asset?.generator],
  ].filter(([, value]) => value);
}
