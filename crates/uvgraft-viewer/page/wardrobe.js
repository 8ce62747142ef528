// Textures to choose from: the file's own, those embedded in the page, and dropped ones.

import { textureBlob } from "./embedded.js";

export class Wardrobe extends EventTarget {
  constructor(viewer, embedded) {
    super();
    this.viewer = viewer;
    this.parts = viewer.looks.textured.map((part, index) => ({
      part, worn: 0, name: part.material.name || `part ${index + 1}`,
    }));
    this.chosenPart = 0;
    /// [{name, image}]; images are decoded when first used.
    this.textures = [
      { name: "As in the file", image: null },
      ...embedded.map(({ name, type }, index) => ({ name, blob: textureBlob(index, type) })),
    ];
  }

  get canChange() {
    return this.parts.length > 0;
  }

  get worn() {
    return this.parts[this.chosenPart]?.worn ?? 0;
  }

  choosePart(index) {
    this.chosenPart = index;
    this.dispatchEvent(new Event("change"));
  }

  /// Applies a texture to the chosen part; rejects if it is not an image.
  async wear(index) {
    const texture = this.textures[index];
    const chosen = this.parts[this.chosenPart];
    if (!texture || !chosen) throw new RangeError(`no texture ${index}`);
    if (texture.blob && !texture.image) {
      texture.image = await createImageBitmap(texture.blob, { colorSpaceConversion: "none" }).catch(() => {
        throw new Error(`${texture.name}: no picture that this browser can show`);
      });
    }
    this.viewer.setTexture(chosen.part, texture.image);
    chosen.worn = index;
    this.dispatchEvent(new Event("change"));
  }

  /// Adds an image file and applies it.
  async add(file) {
    this.textures.push({ name: file.name, blob: file });
    try {
      await this.wear(this.textures.length - 1);
    } catch (error) {
      this.textures.pop();
      throw error;
    }
  }
}
