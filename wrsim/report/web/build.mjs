// Bundles the scripts of the pages: node build.mjs [folder], by default the one that is committed beside this one.
import { build } from "esbuild";
import { readFile, writeFile } from "node:fs/promises";
import { join } from "node:path";
import { fileURLToPath } from "node:url";

const here = fileURLToPath(new URL(".", import.meta.url));
const out = process.argv[2] ?? join(here, "..", "bundle");
await build({
  absWorkingDir: here,
  entryPoints: Object.fromEntries(["report", "view", "print", "live_contact", "live_vehicle", "live_worker"].map((name) => [name, `src/${name}.js`])),
  outdir: out,
  bundle: true,
  minify: true,
  format: "iife",
  target: "es2020",
  charset: "utf8",
  legalComments: "none",
  banner: { js: "/* made by wrsim/report/web/build.mjs; licences: licences.txt beside this file */" },
});
const licences = [];
for (const [name, text] of [["uPlot", "uplot"], ["three.js", "three"]]) {
  licences.push(`${name}\n\n${await readFile(join(here, "node_modules", text, "LICENSE"), "utf8")}`);
}
await writeFile(join(out, "licences.txt"), licences.join("\n\n"));
