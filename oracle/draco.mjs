// Bytes that Draco needs for meshes: `node draco.mjs FILE`.
//
// FILE: four bytes with the length of a JSON head, the head, then arrays, everything
// little-endian; offsets count from the end of the head. The head is
// {meshes: [{name, vertices, triangles, indices, steps?, attributes: [{kind, size, type, offset, bits?, origin?, range?}]}]}
// where `indices` is the offset of 32-bit indices, `kind` one of POSITION, NORMAL, TEX_COORD, COLOR,
// GENERIC, and `type` one of f32, u16, u8. Floats are quantised to `bits`, over `origin` and `range`
// where these are given; integers are kept as they are.
//
// Edgebreaker at encoding and decoding speed 0, which is Draco's best compression. Prints
// [{name, vertices, triangles, bytes, steps, connectivity}]: `vertices` and `triangles` as Draco's
// own decoder gives them back. Only if the head asks for it: `steps`, the bytes with the first
// attribute alone, the first two, and so on, and `connectivity`, those of positions with one bit a coordinate.

import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";

const draco3d = createRequire(import.meta.url)("draco3dgltf");

const ARRAYS = {
  f32: { array: Float32Array, add: "AddFloatAttribute" },
  u16: { array: Uint16Array, add: "AddUInt16Attribute" },
  u8: { array: Uint8Array, add: "AddUInt8Attribute" },
};

/** The head of a file, and a view of its arrays. */
function open(file) {
  const length = file.readUInt32LE(0);
  const head = JSON.parse(file.subarray(4, 4 + length).toString("utf8"));
  const body = file.subarray(4 + length);
  // A copy begins at a multiple of every element's size.
  const array = (kind, offset, count) => {
    const bytes = body.subarray(offset, offset + count * kind.BYTES_PER_ELEMENT);
    if (bytes.length !== count * kind.BYTES_PER_ELEMENT) {
      throw new RangeError(`${count} values at ${offset} are not in the file`);
    }
    return new kind(Uint8Array.from(bytes).buffer);
  };
  return { head, array };
}

function quantise(draco, coder, { kind, size, type, bits, origin, range }) {
  if (type !== "f32") {
    return;
  }
  if (origin) {
    coder.SetAttributeExplicitQuantization(draco[kind], bits, size, origin, range);
  } else {
    coder.SetAttributeQuantization(draco[kind], bits);
  }
}

/** A mesh with some attributes, coded. */
function encode(draco, array, mesh, attributes) {
  const coder = new draco.Encoder();
  const builder = new draco.MeshBuilder();
  const target = new draco.Mesh();
  builder.AddFacesToMesh(target, mesh.triangles, array(Uint32Array, mesh.indices, 3 * mesh.triangles));
  for (const attribute of attributes) {
    const { array: kind, add } = ARRAYS[attribute.type];
    const values = array(kind, attribute.offset, attribute.size * mesh.vertices);
    builder[add](target, draco[attribute.kind], mesh.vertices, attribute.size, values);
    quantise(draco, coder, attribute);
  }
  coder.SetSpeedOptions(0, 0);
  coder.SetEncodingMethod(draco.MESH_EDGEBREAKER_ENCODING);
  const out = new draco.DracoInt8Array();
  const length = coder.EncodeMeshToDracoBuffer(target, out);
  const coded = Int8Array.from({ length }, (_, i) => out.GetValue(i));
  for (const object of [out, target, builder, coder]) {
    draco.destroy(object);
  }
  if (length === 0) {
    throw new Error(`Draco does not encode ${mesh.name}`);
  }
  return coded;
}

/** Vertices and triangles of a coded mesh. */
function counts(draco, coded) {
  const decoder = new draco.Decoder();
  const mesh = new draco.Mesh();
  const status = decoder.DecodeArrayToMesh(coded, coded.length, mesh);
  const found = { vertices: mesh.num_points(), triangles: mesh.num_faces(), ok: status.ok() };
  draco.destroy(mesh);
  draco.destroy(decoder);
  if (!found.ok) {
    throw new Error("Draco does not decode its own bytes");
  }
  return { vertices: found.vertices, triangles: found.triangles };
}

const [path] = process.argv.slice(2);
if (!path) {
  console.error("usage: node draco.mjs FILE");
  process.exit(2);
}
const [encoder, decoder] = await Promise.all([draco3d.createEncoderModule(), draco3d.createDecoderModule()]);
const { head, array } = open(await readFile(path));
const measured = head.meshes.map((mesh) => {
  const { name, attributes } = mesh;
  const size = (some) => encode(encoder, array, mesh, some).length;
  const whole = encode(encoder, array, mesh, attributes);
  const bytes = whole.length;
  const found = { name, ...counts(decoder, whole), bytes };
  if (!mesh.steps) {
    return found;
  }
  const fewer = attributes.slice(1).map((_, last) => size(attributes.slice(0, last + 1)));
  return { ...found, steps: [...fewer, bytes], connectivity: size([{ ...attributes[0], bits: 1 }]) };
});
console.log(JSON.stringify(measured));
