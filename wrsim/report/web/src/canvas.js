/** Paint a canvas in CSS pixels, as sharp as the screen; paint(g, width, height). Nothing where it is not shown. */
export function painted(canvas, paint) {
  const scale = devicePixelRatio || 1;
  const width = canvas.clientWidth, height = canvas.clientHeight;
  if (!width || !height) return;
  canvas.width = width * scale;
  canvas.height = height * scale;
  const g = canvas.getContext("2d");
  g.scale(scale, scale);
  paint(g, width, height);
}
