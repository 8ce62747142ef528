// Appearance of the figure: materials as in the file or unlit, wireframe, and other textures.

import { MeshBasicMaterial, SRGBColorSpace, Texture } from "three";

export class Looks {
  constructor(root) {
    /// Materials of the file, each with an unlit copy and the number of triangles that it covers.
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
    // Largest first. Outlines of toon materials and the
    // like are not offered for choice: they have no name.
    this.parts = [...parts.values()].sort((a, b) => b.triangles - a.triangles);
    this.byMaterial = parts;
    this.isUnlit = false;
  }

  /// Parts whose texture can be replaced, the largest first.
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

  /// Gives a part another texture, or its original one for `null`.
  setTexture(part, image) {
    const { material, unlit, original } = part;
    const before = material.map;
    const texture = image ? dressed(image, original) : original;
    material.map = texture;
    unlit.map = texture;
    // Toon materials have a second texture of the same surface for shade.
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

/// A texture of an image with the sampling parameters of another one.
function dressed(image, like) {
  const texture = new Texture(image);
  texture.flipY = false;
  texture.colorSpace = SRGBColorSpace;
  for (const key of ["wrapS", "wrapT", "magFilter", "minFilter", "anisotropy", "channel", "rotation"]) texture[key] = like[key];
  for (const key of ["offset", "repeat", "center"]) texture[key].copy(like[key]);
  texture.needsUpdate = true;
  return texture;
}
