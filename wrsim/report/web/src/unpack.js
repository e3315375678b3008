// Numbers that stand in the page as compressed text (view_data.packed, view_data.steps_of).
const KINDS = { u1: Uint8Array, f4: Float32Array, f8: Float64Array, i2: Int16Array };

async function values(packed) {
  const bytes = Uint8Array.from(atob(packed.data), (c) => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new KINDS[packed.kind](await new Response(stream).arrayBuffer());
}

/** An array with its shape. */
export async function unpack(packed) {
  return { shape: packed.shape, data: await values(packed) };
}

/** Whole units whose differences along the first dimension were kept. */
export async function unpackSteps(packed) {
  const steps = await values(packed);
  const row = packed.shape.slice(1).reduce((a, b) => a * b, 1);
  const data = new Float32Array(steps.length);
  const last = new Int16Array(row);
  for (let i = 0; i < steps.length; i++) {
    const k = i % row;
    last[k] += steps[i]; // wraps as it was written
    data[i] = last[k] * packed.unit;
  }
  return { shape: packed.shape, data };
}

/** Every packed array in a tree in the place of its text. */
export async function unpackAll(tree) {
  if (Array.isArray(tree)) return Promise.all(tree.map(unpackAll));
  if (tree === null || typeof tree !== "object") return tree;
  if (typeof tree.data === "string" && tree.kind) {
    const { data, kind, shape, unit, ...rest } = tree;
    const found = kind === "i2" ? await unpackSteps(tree) : await unpack(tree);
    return { ...rest, ...(kind === "i2" ? {} : { unit }), ...found };
  }
  const entries = Object.entries(tree).map(async ([key, value]) => [key, await unpackAll(value)]);
  return Object.fromEntries(await Promise.all(entries));
}
