/** Colours of drawings on light and on dark ground. */
export const LIGHT = {
  paper: "#ffffff", ink: "#222222", quiet: "#6b6b6b", faint: "#d9d9d9", rail: "#e4e7eb", wheel: "#f4efe4",
  N: "#b00020", Y: "#0072b2", Q: "#00795c",
};
export const DARK = {
  paper: "#16191d", ink: "#e8e8e8", quiet: "#a3a8ae", faint: "#3c4249", rail: "#2c333b", wheel: "#38342b",
  N: "#ff7a85", Y: "#62b5ef", Q: "#4fc7a6",
};
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
