// The shaders of crowds skin the golden buffers in WebGPU, and every point lies where the pose of the plain
// path has it: draws of each form, blend records, and stepped draws, which the shader of draws shows.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { after, before, test } from "node:test";
import { fileURLToPath } from "node:url";
import { findChromium, launchWithGpu, openPage, ORIGIN } from "./chromium.mjs";
import { meshOf } from "./crowd_buffers.mjs";
import { entryOf, expectedOf, FRAMES, open } from "./crowd_golden.mjs";

const shaders = join(dirname(fileURLToPath(import.meta.url)), "../crates/articula/src/crowd/wgsl");
const isNeeded = process.env.ARTICULA_REQUIRE_TOOLS === "1";

/** A renderer's own part: world position and model normal of each vertex, of each instance of a group. */
const ENTRY_POINT = `
struct Group {
    first: u32,
    count: u32,
    vertices: u32,
    first_word: u32,
}

@group(0) @binding(0) var<uniform> group: Group;
@group(0) @binding(1) var<storage, read> words: array<u32>;
@group(0) @binding(2) var<storage, read_write> out: array<vec4<f32>>;

fn floats(word: u32) -> vec3<f32> {
    return vec3<f32>(bitcast<f32>(words[word]), bitcast<f32>(words[word + 1u]), bitcast<f32>(words[word + 2u]));
}

@compute @workgroup_size(64)
fn skin_points(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= group.count * group.vertices {
        return;
    }
    let instance = group.first + id.x / group.vertices;
    let at = group.first_word + id.x % group.vertices * 14u;
    let pairs = vec2<u32>(words[at + 8u], words[at + 9u]);
    let entries = vec4<u32>(pairs.x & 0xffffu, pairs.x >> 16u, pairs.y & 0xffffu, pairs.y >> 16u);
    let weights = vec4<f32>(floats(at + 10u), bitcast<f32>(words[at + 13u]));
    let skin = articula_skin(instance, entries, weights);
    let world = articula_world(articula_character(instance));
    out[2u * id.x] = vec4<f32>(articula_point(world, articula_point(skin, floats(at))), 1.0);
    out[2u * id.x + 1u] = vec4<f32>(articula_normal(skin, floats(at + 3u)), 0.0);
}
`;

/** Runs in the page: the numbers that the shader writes for each group. */
async function compute({ code, palettes, list, transforms, vertices, groups }) {
  const adapter = await navigator.gpu?.requestAdapter();
  if (!adapter) return null;
  const device = await adapter.requestDevice();
  const module = device.createShaderModule({ code });
  const { messages } = await module.getCompilationInfo();
  if (messages.length > 0) throw new Error(messages.map(({ lineNum, message }) => `${lineNum}: ${message}`).join("; "));
  const pipeline = device.createComputePipeline({ layout: "auto", compute: { module, entryPoint: "skin_points" } });
  const upload = (bytes, usage) => {
    const buffer = device.createBuffer({ size: bytes.length, usage: usage | GPUBufferUsage.COPY_DST });
    device.queue.writeBuffer(buffer, 0, Uint8Array.from(bytes));
    return buffer;
  };
  const bind = (index, buffers) => {
    const entries = buffers.map((buffer, binding) => ({ binding, resource: { buffer } }));
    return device.createBindGroup({ layout: pipeline.getBindGroupLayout(index), entries });
  };
  const storage = (bytes) => upload(bytes, GPUBufferUsage.STORAGE);
  const crowd = bind(1, [palettes, list, transforms].map(storage));
  const all = storage(vertices);
  const results = [];
  for (const { first, count, vertices: each, firstWord } of groups) {
    const size = count * each * 32;
    const words = new Uint8Array(Uint32Array.of(first, count, each, firstWord).buffer);
    const out = device.createBuffer({ size, usage: GPUBufferUsage.STORAGE | GPUBufferUsage.COPY_SRC });
    const read = device.createBuffer({ size, usage: GPUBufferUsage.MAP_READ | GPUBufferUsage.COPY_DST });
    const encoder = device.createCommandEncoder();
    const pass = encoder.beginComputePass();
    pass.setPipeline(pipeline);
    pass.setBindGroup(0, bind(0, [upload([...words], GPUBufferUsage.UNIFORM), all, out]));
    pass.setBindGroup(1, crowd);
    pass.dispatchWorkgroups(Math.ceil((count * each) / 64));
    pass.end();
    encoder.copyBufferToBuffer(out, 0, read, 0, size);
    device.queue.submit([encoder.finish()]);
    await read.mapAsync(GPUMapMode.READ);
    results.push(Array.from(new Float32Array(read.getMappedRange())));
  }
  return results;
}

/** The shader of the library, joined as it joins its parts, and the entry point. */
function source(form, list) {
  const parts = ["rows", ...(form.startsWith("half") ? ["halves"] : []), form.replace("-", "_"), list];
  return parts.map((name) => readFileSync(join(shaders, `${name}.wgsl`), "utf8")).join("") + ENTRY_POINT;
}

/** A point by a matrix of twelve numbers, row by row. */
const moved = (m, [x, y, z]) => [0, 4, 8].map((r) => m[r] * x + m[r + 1] * y + m[r + 2] * z + m[r + 3]);

/** A unit normal on a surface that a matrix has moved: the sum of cross products of the images of the axes. */
function turned(m, [x, y, z]) {
  const [a, b, c] = [0, 1, 2].map((column) => [m[column], m[4 + column], m[8 + column]]);
  const cross = (p, q) => [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
  const [bc, ca, ab] = [cross(b, c), cross(c, a), cross(a, b)];
  const n = [0, 1, 2].map((i) => x * bc[i] + y * ca[i] + z * ab[i]);
  return n.map((value) => value / Math.hypot(...n));
}

/** World position and model normal of every vertex of a character, by the expected matrices of its joints. */
function wantedOf(all, expected, wanted) {
  const byEntry = [];
  wanted.matrices.forEach((matrices, skin) =>
    matrices.forEach((matrix, j) => {
      const { joints, inverse_bind } = expected.skins[skin];
      byEntry[entryOf(all.manifest.entries, joints[j], inverse_bind[j])] = matrix;
    }),
  );
  return meshOf(all, wanted.level).vertices.map(({ position, normal, influences }) => {
    const used = influences.filter(({ weight }) => weight > 0);
    const sum = (_, i) => used.reduce((total, { entry, weight }) => total + weight * byEntry[entry][i], 0);
    const blended = Array.from({ length: 12 }, sum);
    return { place: moved(wanted.world, moved(blended, position)), normal: turned(blended, normal) };
  });
}

let browser;
let isSkipped = false;
before(async () => {
  const program = findChromium();
  if (program) browser = await launchWithGpu(program);
});
after(() => browser?.close());

/** The numbers of the groups of draws, records or stepped draws; or null without WebGPU. */
async function skinned(all, name) {
  if (!browser) return null;
  const { manifest, files } = all;
  const page = await openPage(browser, null, () => ({ contentType: "text/html", body: "<!doctype html>" }));
  await page.goto(`${ORIGIN}/`);
  const groups = manifest[name].groups.map(({ level, first, count }) => {
    const { vertices, vertices_at, vertex_bytes } = manifest.levels[level];
    assert.equal(vertex_bytes, 56);
    return { first, count, vertices, firstWord: vertices_at / 4 };
  });
  const job = {
    code: source(manifest.form, name === "records" ? "records" : "draws"),
    palettes: [...files[name === "draws" ? "palettes" : "cached"]],
    list: [...files[name]],
    transforms: [...files.transforms],
    vertices: [...files.vertices],
    groups,
  };
  const results = await page.evaluate(compute, job);
  await page.context().close();
  return results;
}

for (const frame of FRAMES) {
  const cached = frame.endsWith("stepped") ? ["stepped"] : ["records"];
  for (const name of frame.endsWith("rigid") ? ["draws"] : ["draws", ...cached]) {
    test(`${frame}: ${name} are skinned as by the plain path`, async (context) => {
      const all = open(frame);
      const expected = expectedOf(frame);
      const results = await skinned(all, name);
      if (!results) {
        assert.ok(!isNeeded, "no WebGPU in Chromium");
        if (!isSkipped) console.log("skipped: no WebGPU in Chromium");
        isSkipped = true;
        return context.skip("no WebGPU in Chromium");
      }
      const tolerance = frame.startsWith("half") ? 6e-3 : 1e-5;
      const list = new DataView(all.files[name].buffer, all.files[name].byteOffset);
      const [size, at] = name === "records" ? [16, 12] : [8, 0];
      let seen = 0;
      all.manifest[name].groups.forEach(({ level, first, count }, g) => {
        const { vertices } = all.manifest.levels[level];
        for (let i = 0; i < count; i += 1) {
          const character = list.getUint32((first + i) * size + at, true);
          const wanted = expected.characters.find((c) => c.character === character);
          // Floats of a world position 400 m away are exact to 3e-5.
          const far = Math.hypot(...[3, 7, 11].map((cell) => wanted.world[cell])) * 2e-7;
          wantedOf(all, expected, wanted).forEach(({ place, normal }, v) => {
            const found = results[g].slice(8 * (i * vertices + v), 8 * (i * vertices + v + 1));
            const off = Math.hypot(...place.map((value, axis) => value - found[axis]));
            assert.ok(off < tolerance + far, `character ${character}, vertex ${v}: ${off} m`);
            const tilt = Math.hypot(...normal.map((value, axis) => value - found[4 + axis]));
            assert.ok(tilt < tolerance, `character ${character}, normal ${v}: ${tilt}`);
            seen += 1;
          });
        }
      });
      assert.ok(seen > 24, `${seen} points`);
    });
  }
}

test("normals point outwards of a matrix that mirrors", async (context) => {
  const all = open("matrix");
  const plain = await skinned(all, "draws");
  if (!plain) return context.skip("no WebGPU in Chromium");
  // The first row of every matrix with the other sign: the character in a mirror.
  const palettes = Float32Array.from(new Float32Array(Uint8Array.from(all.files.palettes).buffer), (value, i) =>
    i % 12 < 4 ? -value : value,
  );
  const files = { ...all.files, palettes: new Uint8Array(palettes.buffer) };
  const mirrored = await skinned({ ...all, files }, "draws");
  assert.ok(plain.flat().length > 0);
  plain.forEach((numbers, g) =>
    numbers.forEach((value, i) => {
      // Four numbers of a place and four of a normal; only x of a normal changes.
      if (i % 8 < 4) return;
      const wanted = i % 8 === 4 ? -value : value;
      assert.ok(Math.abs(mirrored[g][i] - wanted) < 1e-5, `${i}: ${mirrored[g][i]} is not ${wanted}`);
    }),
  );
});
