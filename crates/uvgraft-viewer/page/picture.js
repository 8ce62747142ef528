// Backgrounds, and images composited onto them.

/// Gradient colours from the centre outwards; a single colour for a plain background.
const BACKGROUNDS = {
  studio: ["#8b9098", "#5d636c", "#3d4249"],
  white: ["#ffffff"],
  grey: ["#808080"],
  black: ["#000000"],
};

/// The background as CSS.
export function backdrop(name) {
  const colors = BACKGROUNDS[name] ?? [name];
  return colors.length === 1 ? colors[0] : `radial-gradient(circle farthest-corner at 50% 45%, ${colors.join(", ")})`;
}

/// Composites a transparent canvas onto a background.
export function laid(canvas, name) {
  const { width, height } = canvas;
  const context = canvas.getContext("2d");
  const colors = BACKGROUNDS[name] ?? [name];
  const [x, y] = [width / 2, height * 0.45];
  const gradient = context.createRadialGradient(x, y, 0, x, y, Math.hypot(width / 2, height * 0.55));
  colors.forEach((color, k) => gradient.addColorStop(colors.length === 1 ? 0 : k / (colors.length - 1), color));
  context.globalCompositeOperation = "destination-over";
  context.fillStyle = gradient;
  context.fillRect(0, 0, width, height);
  return canvas;
}

/// Offers a canvas as a download.
export async function save(canvas, name) {
  const blob = await new Promise((resolve) => canvas.toBlob(resolve, "image/png"));
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  // Not immediately: the download starts after this task.
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}
