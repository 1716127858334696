// A file of one triangle with a morph target and textures, as text.

/** The file, as glTF with all that it refers to inside. */
export function triangle() {
  const corners = [0, 0, 0, 1, 0, 0, 0, 1, 0];
  const texcoords = [0, 0, 1, 0, 0, 1];
  const opened = [0, -1, 0, 0, 0, 0, 0, 0, 0];
  const floats = new Float32Array([...corners, ...texcoords, ...opened]);
  const uri = `data:application/octet-stream;base64,${Buffer.from(floats.buffer).toString("base64")}`;
  const view = (byteOffset, byteLength) => ({ buffer: 0, byteOffset, byteLength });
  const accessor = (bufferView, type, more) => ({ bufferView, componentType: 5126, count: 3, type, ...more });
  const moved = { KHR_texture_transform: { offset: [0.5, 0], scale: [2, 2] } };
  const json = {
    asset: { version: "2.0" },
    extensionsUsed: ["KHR_texture_transform"],
    scene: 0,
    scenes: [{ nodes: [0] }],
    nodes: [{ mesh: 0, name: "face" }],
    buffers: [{ uri, byteLength: floats.byteLength }],
    bufferViews: [view(0, 36), view(36, 24), view(60, 36)],
    accessors: [
      accessor(0, "VEC3", { min: [0, 0, 0], max: [1, 1, 0] }),
      accessor(1, "VEC2"),
      accessor(2, "VEC3", { min: [0, -1, 0], max: [0, 0, 0] }),
    ],
    meshes: [
      {
        primitives: [{ attributes: { POSITION: 0, TEXCOORD_0: 1 }, targets: [{ POSITION: 2 }], material: 0 }],
        extras: { targetNames: ["jawOpen"] },
      },
    ],
    samplers: [{ wrapS: 33071 }],
    images: [{ uri: "data:image/png;base64,iVBORw0KGgo=", name: "skin" }],
    textures: [{ source: 0, sampler: 0 }, {}],
    materials: [
      {
        pbrMetallicRoughness: {
          baseColorTexture: { index: 0, extensions: moved },
          metallicRoughnessTexture: { index: 0, texCoord: 1 },
        },
        normalTexture: { index: 1, scale: 0.5, extensions: moved },
      },
    ],
  };
  return new TextEncoder().encode(JSON.stringify(json));
}
