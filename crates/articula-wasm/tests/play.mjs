// The module that plays, compared with the library on this machine and fed with what is wrong.
import { test } from "node:test";
import assert from "node:assert/strict";
import { Fnv, load, prepared, step, view } from "./load.mjs";
import { triangle } from "./triangle.mjs";

const { Asset, Figure, Crowd, memory } = await load("play");
const bytes = prepared();
const STEP_SECS = 1 / 60;
const FRAMES = 12;
const MATRIX_BYTES = 48;
const DRAW_BYTES = 8;

const at = (offset, count, size) => new Uint8Array(memory.buffer, offset, count * size);

/** Opens the prepared asset for a call, and frees it. */
function withAsset(use) {
  const asset = Asset.open(bytes, "knight.glb");
  try {
    return use(asset);
  } finally {
    asset.free();
  }
}

/** A call that must throw an ArticulaError with a code. */
function refuses(call, code, said) {
  assert.throws(call, (error) => {
    assert.ok(error instanceof Error, String(error));
    assert.equal(error.name, "ArticulaError", error.stack);
    assert.equal(error.code, code, error.message);
    if (said !== undefined) assert.match(error.message, said);
    return true;
  });
}

test("a prepared asset is read as it is", () => {
  withAsset((asset) => {
    assert.ok(asset.isPrepared);
    assert.ok(asset.warnings.every((told) => !told.includes("prepared")), asset.warnings.join("; "));
    assert.equal(asset.clips.length, 1);
    assert.equal(asset.joints.length, asset.parents.length);
    asset.parents.forEach((parent, joint) => assert.ok(parent < joint));
    const [x, y, z, right, top, front] = asset.bounds;
    assert.ok(x < right && y < top && z < front);
  });
});

test("a figure shows what it shows natively", () => {
  withAsset((asset) => {
    const figure = new Figure(asset);
    const geometry = asset.mesh();
    const sum = new Fnv();
    for (let frame = 0; frame < FRAMES; frame += 1) {
      assert.ok(figure.frame(STEP_SECS, view([0, 0, 4], -1)) > 0);
      sum.add(at(figure.paletteAt(), geometry.bindings, MATRIX_BYTES));
    }
    assert.equal(sum.text(), step("palettes of the figure"));
    geometry.free();
    figure.free();
  });
});

test("a crowd shows what it shows natively", () => {
  withAsset((asset) => {
    const crowd = new Crowd(asset, 60);
    assert.deepEqual(crowd.warnings, []);
    for (let i = 0; i < crowd.count; i += 1) {
      crowd.place(i, 2 * (i % 6), 0, 2 * Math.floor(i / 6), 0);
      crowd.play(i, 0, Math.fround(Math.fround(0.037) * i));
    }
    const sum = new Fnv();
    for (let frame = 0; frame < FRAMES; frame += 1) {
      const visible = crowd.frame(STEP_SECS, view([6, 1.7, -6], 1));
      assert.equal(visible, crowd.draws + crowd.records + crowd.stepped);
      sum.add(at(crowd.palettesAt(), crowd.paletteMatrices, MATRIX_BYTES));
      sum.add(at(crowd.drawsAt(), crowd.draws, DRAW_BYTES));
      sum.add(at(crowd.steppedAt(), crowd.stepped, DRAW_BYTES));
    }
    assert.equal(sum.text(), step("palettes of the crowd"));
    crowd.free();
  });
});

test("groups, records and transforms say where everybody is", () => {
  withAsset((asset) => {
    const crowd = new Crowd(asset, 3);
    crowd.usePoseCache("gpu");
    crowd.setTolerance(2);
    crowd.setTransform(1, 10, 2, 3, 0, 0, 0, 1);
    crowd.setScale(1, 2);
    crowd.place(2, 0, 0, 900, 0);
    crowd.frame(STEP_SECS, view([0, 1, -30], 1));
    const groups = new Uint32Array(memory.buffer, crowd.groupsAt(), 6 * crowd.groups);
    let drawn = 0;
    for (let group = 0; group < crowd.groups; group += 1) {
      const [kind, level, first, count] = groups.subarray(6 * group);
      assert.ok(kind <= 1 && level < crowd.levels);
      assert.ok(first + count <= (kind === 0 ? crowd.draws : crowd.records));
      drawn += count;
    }
    assert.equal(drawn, 3);
    assert.ok(crowd.records > 0 && crowd.cachedMatrices > 0);
    const records = new Uint32Array(memory.buffer, crowd.recordsAt(), 4 * crowd.records);
    assert.ok(records[1] < crowd.cachedMatrices && records[3] < 3);
    const moved = new Float32Array(memory.buffer, crowd.transformsAt(), 36).slice(12, 24);
    assert.deepEqual([...moved], [2, 0, 0, 10, 0, 2, 0, 2, 0, 0, 2, 3]);
    const [character, metres] = crowd.pick(10, 4, -50, 0, 0, 1);
    assert.equal(character, 1);
    assert.ok(metres > 40 && metres < 53, String(metres));
    assert.equal(crowd.pick(0, 500, 0, 0, 1, 0), undefined);
    crowd.free();
  });
});

test("a budget coarsens a crowd that takes too long", () => {
  withAsset((asset) => {
    const crowd = new Crowd(asset, 40);
    crowd.setBudget(0.001);
    for (let frame = 0; frame < 30; frame += 1) {
      // Far enough away that no character is near.
      crowd.frame(STEP_SECS, view([0, 1, -30], 1));
      crowd.observe(10);
    }
    assert.ok(crowd.tolerancePx > 1, String(crowd.tolerancePx));
    crowd.setFull();
    assert.equal(crowd.tolerancePx, 0);
    crowd.free();
  });
});

test("joints, layers and levels of a figure", () => {
  withAsset((asset) => {
    const figure = new Figure(asset, "in-place");
    const joints = () => [...new Float32Array(memory.buffer, figure.jointsAt(), 12 * asset.joints.length)];
    const close = view([0, 1, 3], -1);
    const last = asset.joints.length - 1;
    figure.frame(0, close);
    const before = joints();
    figure.poseJoint(last, Math.SQRT1_2, 0, 0, Math.SQRT1_2);
    figure.frame(0, close);
    const turned = joints();
    assert.deepEqual(turned.slice(0, 12 * last), before.slice(0, 12 * last));
    assert.notDeepEqual(turned.slice(12 * last), before.slice(12 * last));
    figure.clearPosed();
    figure.frame(0, close);
    assert.deepEqual(joints(), before);
    const layer = figure.addLayer(0, 1, new Uint32Array(), true);
    figure.setLayerWeight(layer, 0);
    assert.equal(figure.setExpression("no such face", 1), false);
    figure.setTolerance(50);
    figure.setLoa(6);
    for (let frame = 0; frame < 60; frame += 1) figure.frame(STEP_SECS, view([0, 1, 300], -1));
    assert.ok(figure.frame(STEP_SECS, view([0, 1, 300], -1)) < asset.joints.length / 2);
    assert.deepEqual([...figure.rootDelta], [0, 0, 0, 0]);
    figure.free();
  });
});

test("joints are chosen, held by a clock of the caller, and measured", () => {
  withAsset((asset) => {
    const low = [...asset.jointsOfExpression("loa(Low)")];
    assert.deepEqual([...asset.jointsOfProfile('{"complexity": "low"}')], low);
    assert.ok(low.every((joint) => asset.jointLevels[joint] <= 1) && low.length < asset.joints.length);
    assert.equal(asset.jointRegions.length, asset.joints.length);
    assert.ok(asset.clipJoints(0).length > 10 && asset.clipBytes[0] > 1000);
    refuses(() => asset.jointsOfExpression("loa("), "argument", /column/);
    refuses(() => asset.jointsOfExpression("joint(tail)"), "argument", /tail/);
    refuses(() => asset.jointsOfProfile('{"depht": 2}'), "argument", /depht/);
    refuses(() => asset.clipJoints(7), "argument", /clip 7/);
    const figure = new Figure(asset, "in-place");
    const close = view([0, 1, 3], -1);
    refuses(() => figure.setTransition(0, "bouncy", "hold"), "argument", /bouncy/);
    refuses(() => figure.articulate(new Uint32Array([5000])), "argument", /joint 5000/);
    refuses(() => figure.errorPx(new Float32Array()), "argument", /one/);
    figure.setTransition(0.1, "linear", "hold");
    figure.frameAt(0, 0, close);
    assert.deepEqual([...figure.errorPx(close)], [0, 0]);
    figure.articulate(new Uint32Array(low));
    figure.frameAt(0.05, 0.05, close);
    figure.frameAt(0.1, 0.1, close);
    assert.ok(figure.jointStates.some((state) => state === 2), "no joint is in transition");
    figure.frameAt(0.2, 0.2, close);
    assert.deepEqual([...figure.jointStates.keys()].filter((joint) => figure.jointStates[joint] === 1), low);
    assert.equal(figure.work[0], low.length);
    const [most, worst] = figure.errorPx(close);
    assert.ok(most > 0 && worst >= most, `${most}, ${worst}`);
    figure.setThreshold(1, 1, 16, 1, true);
    for (let frame = 0; frame < 30; frame += 1) figure.frameAt(1 + frame / 60, 0.2, close);
    assert.ok(figure.work[0] < low.length, "a threshold of 1 holds no joint");
    figure.free();
  });
});

test("a mesh has all that a renderer needs", () => {
  withAsset((asset) => {
    const geometry = asset.mesh();
    const { vertices, influences, bindings } = geometry;
    assert.equal(geometry.positions().length, 3 * vertices);
    assert.equal(geometry.normals().length, 3 * vertices);
    assert.equal(geometry.texcoords().length, 2 * vertices);
    assert.equal(influences % 4, 0);
    assert.ok(geometry.entries().every((entry) => entry < bindings));
    const weights = geometry.weights();
    for (let vertex = 0; vertex < vertices; vertex += 1) {
      const all = weights.subarray(vertex * influences, (vertex + 1) * influences);
      assert.ok(Math.abs(all.reduce((sum, weight) => sum + weight, 0) - 1) < 1e-5);
    }
    assert.ok(geometry.triangles().every((vertex) => vertex < vertices));
    const parts = geometry.parts();
    const { materials, textures, images } = JSON.parse(asset.materials());
    assert.ok(parts.length > 0 && parts.length % 3 === 0);
    assert.ok(parts[0] < materials.length);
    assert.ok(Array.isArray(textures) && Array.isArray(images));
    geometry.free();
  });
});

test("materials name what the mesh has coordinates for", () => {
  const asset = Asset.open(triangle(), "triangle.gltf");
  const { materials, textures, images } = JSON.parse(asset.materials());
  assert.deepEqual(textures, [{ image: 0, sampler: { wrapS: 33071 } }, { sampler: {} }]);
  assert.deepEqual(images, [{ name: "skin", mimeType: "image/png" }]);
  const [{ pbrMetallicRoughness: surface, normalTexture: bumps }] = materials;
  assert.equal(surface.baseColorTexture.index, 0);
  assert.equal(surface.metallicRoughnessTexture, undefined);
  assert.equal(bumps.scale, 0.5);
  assert.ok(!JSON.stringify(materials).includes("KHR_texture_transform"));
  const geometry = asset.mesh();
  assert.deepEqual([...geometry.texcoords()], [0.5, 0, 2.5, 0, 0.5, 2]);
  assert.equal(geometry.colors(), undefined);
  assert.deepEqual([...asset.image(0)], [0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a]);
  geometry.free();
  asset.free();
});

test("variants tell what they show in place of materials", () => {
  const file = JSON.parse(new TextDecoder().decode(triangle()));
  const VARIANTS = "KHR_materials_variants";
  const [primitive] = file.meshes[0].primitives;
  const shows = (material, variants) => ({ [VARIANTS]: { mappings: [{ material, variants }] } });
  // 1 has no picture, 2 the coordinates of 0, 3 those of no vertex.
  const [own] = file.materials;
  file.materials.push({}, structuredClone(own), { pbrMetallicRoughness: { baseColorTexture: { index: 0 } } });
  file.extensionsUsed.push(VARIANTS);
  file.extensions = { [VARIANTS]: { variants: ["usual", "red", "torn", "moved"].map((name) => ({ name })) } };
  const [first, second] = [structuredClone(primitive), structuredClone(primitive)];
  first.extensions = { [VARIANTS]: { mappings: [{ material: 1, variants: [1] }, { material: 2, variants: [2] }, { material: 3, variants: [3] }] } };
  second.extensions = shows(1, [1]);
  delete primitive.material;
  primitive.extensions = shows(1, [1, 2]);
  file.meshes[0].primitives.push(first, second);
  const asset = Asset.open(new TextEncoder().encode(JSON.stringify(file)), "triangle.gltf");
  const { variants } = JSON.parse(asset.materials());
  assert.deepEqual(variants, [
    { name: "usual", materials: [], mixed: [] },
    { name: "red", materials: [[-1, 1], [0, 1]], mixed: [] },
    { name: "torn", materials: [[-1, 1], [0, 2]], mixed: [0] },
    { name: "moved", materials: [], mixed: [0] },
  ]);
  asset.free();
});

test("impostors of another file are refused, and roles have an importance", () => {
  withAsset((asset) => {
    const table = { format: "articula-impostor", version: 1, clips: [] };
    const made = (change) => () => new Crowd(asset, 3, JSON.stringify({ impostors: { ...table, ...change } }));
    refuses(made({ version: 7 }), "argument", /articula-impostor 7/);
    refuses(made({}), "unsupported", /none of the clips/);
  });
  const roles = JSON.parse(Crowd.usualRoles());
  assert.ok(roles.main > roles.secondary && roles.secondary > roles.audience);
});

test("a face moves by morph targets and by their names", () => {
  const asset = Asset.open(triangle(), "triangle.gltf");
  assert.deepEqual(asset.morphNames, ["jawOpen"]);
  assert.deepEqual(asset.expressions, ["jawOpen"]);
  const geometry = asset.mesh();
  assert.deepEqual([...geometry.morphPositions(0)], [0, -1, 0, 0, 0, 0, 0, 0, 0]);
  refuses(() => geometry.morphPositions(1), "argument", /morph target 1/);
  const figure = new Figure(asset);
  const weight = () => {
    figure.frame(STEP_SECS, new Float32Array());
    return new Float32Array(memory.buffer, figure.morphsAt(), 1)[0];
  };
  assert.equal(weight(), 0);
  assert.ok(figure.setExpression("jawOpen", 0.5));
  assert.equal(weight(), 0.5);
  figure.setMorph(0, 0.25);
  assert.equal(weight(), 0.75);
  figure.clearMorphs();
  assert.equal(weight(), 0);
  [figure, geometry, asset].forEach((object) => object.free());
});

test("a crowd of a file without mesh levels has its mesh alone", () => {
  const asset = Asset.open(triangle(), "triangle.gltf");
  refuses(() => new Crowd(asset, 3, '{"meshLevels": 3}'), "argument", /no mesh levels/);
  const crowd = new Crowd(asset, 3, '{"meshLevels": 1}');
  assert.equal(crowd.count, 3);
  crowd.free();
  asset.free();
});

test("what does not exist is refused", () => {
  withAsset((asset) => {
    refuses(() => asset.image(1000), "argument", /picture 1000/);
    refuses(() => new Figure(asset, "sideways"), "argument", /sideways/);
    refuses(() => new Crowd(asset, 3, '{"clip": []}'), "argument", /clip/);
    refuses(() => new Crowd(asset, 3, '{"clips": ["flight"]}'), "argument", /flight/);
    refuses(() => new Crowd(asset, 4_000_000_000), "too-large", /memory/);
    const figure = new Figure(asset);
    refuses(() => figure.play(1, 0), "argument", /clip 1/);
    refuses(() => figure.fadeTo(-1, 0), "argument");
    refuses(() => figure.addLayer(0, 1, new Uint32Array([5000]), false), "argument", /joint 5000/);
    refuses(() => figure.setLayerWeight(0, 1), "argument", /layer 0/);
    refuses(() => figure.poseJoint(5000, 0, 0, 0, 1), "argument");
    refuses(() => figure.setMorph(5000, 1), "argument");
    refuses(() => figure.frame(STEP_SECS, new Float32Array(9)), "argument", /9 numbers/);
    const crowd = new Crowd(asset, 2);
    refuses(() => crowd.place(2, 0, 0, 0, 0), "argument", /character 2/);
    refuses(() => crowd.play(0, 7, 0), "argument", /clip 7/);
    refuses(() => crowd.mesh(99), "argument", /level 99/);
    refuses(() => crowd.level(-1), "argument");
    refuses(() => crowd.usePoseCache("disk"), "argument", /disk/);
    // Numbers that are none do not end the module.
    crowd.place(0, NaN, Infinity, 0, NaN);
    crowd.play(1, 0, NaN);
    crowd.setScale(1, NaN);
    figure.play(0, NaN);
    crowd.frame(NaN, new Float32Array(10).fill(NaN));
    crowd.frame(-1, view([0, 0, 0], 1));
    figure.frame(Infinity, new Float32Array(10));
    crowd.free();
    figure.free();
  });
});

test("a hostile file is refused, and the module goes on", () => {
  const named = (file, name) => () => Asset.open(file, name);
  refuses(named(new Uint8Array(), "none.glb"), "invalid", /^none\.glb: /);
  refuses(named(new Uint8Array([1, 2, 3]), "none.glb"), "invalid");
  refuses(named(bytes.subarray(0, bytes.length / 2), "half.glb"), "invalid");
  refuses(named(new TextEncoder().encode("no format"), "a.txt"), "unsupported");
  const text = '{"asset": {"version": "2.0"}, "buffers": [{"uri": "far.bin", "byteLength": 4}]}';
  refuses(named(new TextEncoder().encode(text), "a.gltf"), "missing", /far\.bin/);
  const greedy = new TextDecoder().decode(triangle()).replaceAll('"count":3', '"count":40000000');
  const sparse = greedy.replaceAll(/"bufferView":\d,/g, "");
  refuses(named(new TextEncoder().encode(sparse), "greedy.gltf"), "too-large");
  // Every bit of the head and of the start of the JSON.
  for (let bit = 0; bit < 8 * 28; bit += 1) {
    const flipped = bytes.slice();
    flipped[bit >> 3] ^= 1 << (bit & 7);
    try {
      Asset.open(flipped, "flipped.glb").free();
    } catch (error) {
      assert.equal(error.name, "ArticulaError", error.stack);
      assert.equal(error.file, "flipped.glb");
    }
  }
  withAsset((asset) => assert.ok(asset.isPrepared));
});

test("memory is given back", () => {
  let settled = 0;
  for (let round = 0; round < 50; round += 1) {
    withAsset((asset) => {
      const [figure, crowd] = [new Figure(asset), new Crowd(asset, 20)];
      figure.frame(STEP_SECS, view([0, 1, 3], -1));
      crowd.frame(STEP_SECS, view([0, 1, -6], 1));
      figure.free();
      crowd.free();
    });
    if (round === 4) settled = memory.buffer.byteLength;
  }
  assert.equal(memory.buffer.byteLength, settled);
});
