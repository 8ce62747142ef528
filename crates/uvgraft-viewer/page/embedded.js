// Reads what `uvgraft view` embedded in the page: a JSON block of names, and blocks of base64.

/// {name, textures: [{name, type}], lookAt}; names may
/// be any text, `lookAt` is a name, a box or null.
export function about() {
  return JSON.parse(document.getElementById("about-data").textContent);
}

export function modelBytes() {
  return decode(take("model-data"));
}

/// The image of `about().textures[index]`.
export function textureBlob(index, type) {
  return new Blob([decode(take(`texture-data-${index}`))], { type });
}

/// Takes the text of a block and removes the block, which would keep its text in memory.
function take(id) {
  const block = document.getElementById(id);
  const text = block.textContent;
  block.remove();
  return text.trim();
}

function decode(text) {
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text);
  const padding = text.endsWith("==") ? 2 : text.endsWith("=") ? 1 : 0;
  const bytes = new Uint8Array((text.length / 4) * 3 - padding);
  // Decode in chunks, to avoid a second copy of the whole text.
  const PIECE = 1 << 20;
  for (let from = 0, to = 0; from < text.length; from += PIECE) {
    const piece = atob(text.slice(from, from + PIECE));
    for (let k = 0; k < piece.length; k += 1, to += 1) bytes[to] = piece.charCodeAt(k);
  }
  return bytes;
}
