// Draws the texture under the pointer: ridges as they are wide, on the scale of the pad.

// Millimetres of a CSS pixel: 96 are an inch.
export const MM_PER_PX = 25.4 / 96;

const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

export function draw(canvas, texture, mmPerPx, pointer) {
  const ratio = devicePixelRatio;
  const width = Math.max(1, Math.round(canvas.clientWidth * ratio));
  const height = Math.max(1, Math.round(canvas.clientHeight * ratio));
  if (canvas.width !== width) canvas.width = width;
  if (canvas.height !== height) canvas.height = height;
  const context = canvas.getContext("2d");
  context.clearRect(0, 0, width, height);
  if (texture !== null) {
    context.fillStyle = colour("--band");
    const period = (texture.period_mm / mmPerPx) * ratio;
    // Finer than a pixel they cannot be seen.
    if (period > 2) for (let x = 0; x < width; x += period) context.fillRect(x, 0, period / 2, height);
    else context.fillRect(0, 0, width, height);
  }
  if (pointer === null) return;
  context.strokeStyle = colour("--accent");
  context.lineWidth = 2 * ratio;
  context.beginPath();
  context.arc(pointer.x * ratio, pointer.y * ratio, 14 * ratio, 0, 2 * Math.PI);
  context.stroke();
}
