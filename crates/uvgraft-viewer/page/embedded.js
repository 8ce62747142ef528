// What `uvgraft view` put into the page: a JSON block of names, and blocks of base64.

/// {name, textures: [{name, type}], lookAt}; names are text of any kind, `lookAt` is a name, a box or null.
export function about() {
  return JSON.parse(document.getElementById("about-data").textContent);
}

export function modelBytes() {
  return decode(take("model-data"));
}

/// The picture number `index` of `about().textures`.
export function textureBlob(index, type) {
  return new Blob([decode(take(`texture-data-${index}`))], { type });
}

/// The text of a block. The block goes, because the text would stay in memory with it.
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
  // In pieces, so that there is no second text of the whole.
  const PIECE = 1 << 20;
  for (let from = 0, to = 0; from < text.length; from += PIECE) {
    const piece = atob(text.slice(from, from + PIECE));
    for (let k = 0; k < piece.length; k += 1, to += 1) bytes[to] = piece.charCodeAt(k);
  }
  return bytes;
}
