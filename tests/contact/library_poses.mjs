/* The same as library_poses.c in WebAssembly, without threads:
 *
 *     node library_poses.mjs LIBRARY RESULT PATCH STRIP CONTACT POSES RESULTS FOLLOW
 *
 * RESULT, PATCH, STRIP: sizes of the structs of the header in bytes. */
import fs from "node:fs";

const MOST_PATCHES = 6, MOST_STRIPS = 2000;
const [library, ...words] = process.argv.slice(2);
const [RESULT, PATCH, STRIP] = words.slice(0, 3).map(Number), [file, poses, results, follow] = words.slice(3);
const { instance } = await WebAssembly.instantiate(fs.readFileSync(library), {});
const c = instance.exports;
c._initialize();
const bytes = () => new Uint8Array(c.memory.buffer); // anew: memory that grows is another buffer
const content = fs.readFileSync(file);
const place = c.malloc(content.length), handle = c.malloc(4), text = c.malloc(400);
bytes().set(content, place);
if (c.wrsim_contact_open_memory(place, content.length, handle, text, 400) !== 0) {
    const message = bytes().subarray(text, text + 400);
    throw new Error(new TextDecoder().decode(message.subarray(0, message.indexOf(0))));
}
c.free(place);
const contact = new DataView(c.memory.buffer).getUint32(handle, true);
c.wrsim_contact_follow(contact, Number(follow));
const pose = c.malloc(96), result = c.malloc(RESULT);
const patches = c.malloc(MOST_PATCHES * PATCH), strips = c.malloc(MOST_STRIPS * STRIP);
const out = [], copy = (from, size) => out.push(Buffer.from(bytes().slice(from, from + size)));
const rows = fs.readFileSync(poses);
for (let i = 0; i < rows.length; i += 104) {
    bytes().set(rows.subarray(i, i + 96), pose);
    const distance = rows.readDoubleLE(i + 96);
    if (c.wrsim_contact_evaluate(contact, pose, pose + 24, pose + 48, pose + 72, distance) < 0) process.exit(1);
    c.wrsim_contact_forces(contact, result);
    copy(result, RESULT);
    const count = c.wrsim_contact_patches(contact, patches, MOST_PATCHES);
    for (let j = 0; j < count; j++) {
        copy(patches + j * PATCH, PATCH);
        copy(strips, c.wrsim_contact_strips(contact, j, strips, MOST_STRIPS) * STRIP);
    }
}
fs.writeFileSync(results, Buffer.concat(out));
