// What the figure wears: materials as in the file or without light, wires, and other textures.

import { MeshBasicMaterial, SRGBColorSpace, Texture } from "three";

export class Looks {
  constructor(root) {
    /// Materials of the file, each with its twin that no light changes, and what it covers.
    this.parts = [];
    this.meshes = [];
    const parts = new Map();
    root.traverse((mesh) => {
      if (!mesh.isMesh) return;
      const own = [mesh.material].flat();
      this.meshes.push({ mesh, own, isList: Array.isArray(mesh.material) });
      for (const material of own) {
        if (!parts.has(material)) parts.set(material, { material, unlit: unlit(material), triangles: 0, original: material.map });
        const { index, attributes } = mesh.geometry;
        parts.get(material).triangles += (index ?? attributes.position).count / 3 / own.length;
      }
    });
    // Outlines of toon materials and the like have no name of their own to choose them by.
    this.parts = [...parts.values()].sort((a, b) => b.triangles - a.triangles);
    this.byMaterial = parts;
    this.isUnlit = false;
  }

  /// Parts whose texture can be swapped, the largest first.
  get textured() {
    return this.parts.filter(({ material, original }) => original && !material.isOutline);
  }

  setUnlit(isUnlit) {
    this.isUnlit = isUnlit;
    for (const { mesh, own, isList } of this.meshes) {
      const shown = own.map((material) => (isUnlit ? this.byMaterial.get(material).unlit : material));
      mesh.material = isList ? shown : shown[0];
    }
  }

  setWireframe(isWireframe) {
    for (const { material, unlit } of this.parts) {
      material.wireframe = isWireframe;
      unlit.wireframe = isWireframe;
    }
  }

  /// Gives a part another texture, or its own again for `null`.
  setTexture(part, image) {
    const { material, unlit, original } = part;
    const before = material.map;
    const texture = image ? dressed(image, original) : original;
    material.map = texture;
    unlit.map = texture;
    // Toon materials shade with a second picture of the same skin.
    if ("shadeMultiplyTexture" in material) {
      part.shade ??= material.shadeMultiplyTexture;
      material.shadeMultiplyTexture = image ? texture : part.shade;
    }
    if (before !== original) before.dispose();
  }
}

function unlit(material) {
  const { map, color, opacity, transparent, alphaTest, side, vertexColors, depthWrite } = material;
  const isOutline = material.isOutline === true;
  return new MeshBasicMaterial({
    map: map ?? null, opacity, transparent, alphaTest, side, vertexColors, depthWrite,
    ...(color && { color }), toneMapped: false, visible: material.visible && !isOutline,
  });
}

/// A texture of an image that is sampled as another one is.
function dressed(image, like) {
  const texture = new Texture(image);
  texture.flipY = false;
  texture.colorSpace = SRGBColorSpace;
  for (const key of ["wrapS", "wrapT", "magFilter", "minFilter", "anisotropy", "channel", "rotation"]) texture[key] = like[key];
  for (const key of ["offset", "repeat", "center"]) texture[key].copy(like[key]);
  texture.needsUpdate = true;
  return texture;
}
