// A crowd in Babylon.js by @articula/core alone: palettes and transforms are textures, what is drawn are attributes of thin
// instances, and a shader of forty lines poses them. Any other engine with instancing and float textures does the same.
import { Articula, packViews } from '@articula/core';

const { BABYLON } = window;

/** Texels of a row of the data textures; a multiple of the three that a matrix takes. */
const WIDTH = 1536;

const VERTEX = `#version 300 es
precision highp float;
precision highp sampler2D;
in vec3 position;
in vec3 normal;
in vec2 uv;
in vec4 entries;
in vec4 shares;
in vec4 draw;
uniform mat4 viewProjection;
uniform sampler2D palettes;
uniform sampler2D cached;
uniform sampler2D transforms;
out vec3 vNormal;
out vec2 vUV;

struct Rows { vec4 x; vec4 y; vec4 z; };

vec4 texel(sampler2D from, int at) { return texelFetch(from, ivec2(at % ${WIDTH}, at / ${WIDTH}), 0); }

Rows matrix(sampler2D from, int index) {
  return Rows(texel(from, 3 * index), texel(from, 3 * index + 1), texel(from, 3 * index + 2));
}

vec3 carry(Rows m, vec4 p) { return vec3(dot(m.x, p), dot(m.y, p), dot(m.z, p)); }

// A draw is: first matrix of its palette, the character, and whether the palette is a cached one.
Rows entry(float index) {
  int at = int(draw.x) + int(index);
  if (draw.z > 0.5) return matrix(cached, at);
  return matrix(palettes, at);
}

void main() {
  Rows pose = Rows(vec4(0.0), vec4(0.0), vec4(0.0));
  for (int i = 0; i < 4; i += 1) {
    Rows m = entry(entries[i]);
    pose = Rows(pose.x + shares[i] * m.x, pose.y + shares[i] * m.y, pose.z + shares[i] * m.z);
  }
  Rows world = matrix(transforms, int(draw.y));
  gl_Position = viewProjection * vec4(carry(world, vec4(carry(pose, vec4(position, 1.0)), 1.0)), 1.0);
  vNormal = carry(world, vec4(carry(pose, vec4(normal, 0.0)), 0.0));
  vUV = uv;
}`;

const FRAGMENT = `#version 300 es
precision highp float;
in vec3 vNormal;
in vec2 vUV;
uniform vec4 color;
uniform sampler2D picture;
out vec4 fragment;
void main() {
  vec3 n = normalize(vNormal);
  float light = 0.45 + 0.55 * max(dot(n, normalize(vec3(0.4, 0.8, 0.6))), 0.0);
  fragment = vec4(pow(color.rgb, vec3(1.0 / 2.2)) * texture(picture, vUV).rgb * light, 1.0);
}`;

/** Shows a crowd of a file on a canvas; resolves to the engine and a function that shows the next frame. */
export async function showCrowd(canvas, url, count) {
  const articula = await Articula.load();
  const response = await fetch(url);
  if (!response.ok) {
    throw new Error(`${response.status} ${response.statusText}`);
  }
  const asset = articula.open(new Uint8Array(await response.arrayBuffer()), url.split('/').at(-1));
  const clip = Math.max(0, asset.clips.findIndex((name) => /walk/i.test(name)));
  const { crowd, arrays } = articula.crowd(asset, count, { clips: [asset.clips[clip]] });
  const side = Math.ceil(Math.sqrt(count));
  const height = asset.bounds[4] - asset.bounds[1];
  for (let i = 0; i < count; i += 1) {
    crowd.place(i, height * ((i % side) - (side - 1) / 2), 0, -height * Math.floor(i / side), 0);
    crowd.play(i, 0, 0.37 * i);
  }

  const engine = new BABYLON.Engine(canvas, true, { preserveDrawingBuffer: true });
  const scene = new BABYLON.Scene(engine);
  // Characters are right-handed, as glTF.
  scene.useRightHandedSystem = true;
  scene.clearColor = new BABYLON.Color4(0.53, 0.6, 0.67, 1);
  const camera = new BABYLON.FreeCamera('camera', new BABYLON.Vector3(0, 1.2 * height, 3 * height), scene);
  camera.setTarget(new BABYLON.Vector3(0, 0.6 * height, -2 * height));
  camera.minZ = height / 20;

  const rows = { palettes: dataTexture(scene), cached: dataTexture(scene), transforms: dataTexture(scene) };
  const look = JSON.parse(asset.materials());
  const materials = new Map();
  const shown = new Map();

  function materialOf(index) {
    let made = materials.get(index);
    if (made === undefined) {
      made = crowdMaterial(scene, rows, asset, look, index);
      materials.set(index, made);
    }
    return made;
  }

  function meshesOf({ kind, level }) {
    const key = `${kind} ${level}`;
    let made = shown.get(key);
    if (made === undefined) {
      made = levelMeshes(scene, crowd.mesh(level), materialOf, count);
      shown.set(key, made);
    }
    return made;
  }

  function frame(secs) {
    const { x, y, z } = camera.position;
    const turn = BABYLON.Quaternion.FromRotationMatrix(camera.getWorldMatrix());
    const [width, height] = [engine.getRenderWidth(), engine.getRenderHeight()];
    const view = { position: [x, y, z], rotation: [turn.x, turn.y, turn.z, turn.w], width, height, fov: camera.fov };
    crowd.frame(secs, packViews([view]));
    rows.palettes.write(arrays.palettes);
    rows.cached.write(arrays.cached, true);
    rows.transforms.write(arrays.transforms);
    for (const meshes of shown.values()) {
      meshes.forEach((mesh) => mesh.setEnabled(false));
    }
    for (const group of arrays.groups()) {
      const meshes = meshesOf(group);
      const list = group.kind === 'step' ? arrays.stepped : arrays.draws;
      const draws = new Float32Array(4 * group.count);
      for (let i = 0; i < group.count; i += 1) {
        const at = 2 * (group.first + i);
        draws.set([list[at + 1], list[at], group.kind === 'step' ? 1 : 0, 0], 4 * i);
      }
      for (const mesh of meshes) {
        mesh.thinInstanceSetBuffer('draw', draws, 4, false);
        mesh.thinInstanceCount = group.count;
        mesh.setEnabled(true);
      }
    }
    scene.render();
  }

  frame(0);
  engine.runRenderLoop(() => frame(Math.min(0.1, engine.getDeltaTime() / 1000)));
  return { engine, scene, crowd, frame };
}

/** A texture of floats that holds rows of matrices, and grows. */
function dataTexture(scene) {
  let texture = make(1);
  let isSent = false;
  function make(height) {
    const data = new Float32Array(4 * WIDTH * height);
    const { TEXTURETYPE_FLOAT, TEXTURE_NEAREST_SAMPLINGMODE, TEXTUREFORMAT_RGBA } = BABYLON.Constants;
    const made = new BABYLON.RawTexture(
      data, WIDTH, height, TEXTUREFORMAT_RGBA, scene, false, false, TEXTURE_NEAREST_SAMPLINGMODE, TEXTURETYPE_FLOAT,
    );
    made.data = data;
    made.rows = height;
    return made;
  }
  return {
    get texture() {
      return texture;
    },
    write(floats, isOnce = false) {
      if (floats.length === 0 || (isOnce && isSent)) {
        return;
      }
      isSent = true;
      const height = Math.ceil(floats.length / (4 * WIDTH));
      if (height > texture.rows) {
        texture.dispose();
        texture = make(height);
      }
      texture.data.set(floats);
      texture.update(texture.data);
    },
  };
}

function crowdMaterial(scene, rows, asset, { materials, textures }, index) {
  const material = new BABYLON.ShaderMaterial(
    `material ${index}`,
    scene,
    { vertexSource: VERTEX, fragmentSource: FRAGMENT },
    {
      attributes: ['position', 'normal', 'uv', 'entries', 'shares', 'draw'],
      uniforms: ['viewProjection', 'color'],
      samplers: ['palettes', 'cached', 'transforms', 'picture'],
      shaderLanguage: BABYLON.ShaderLanguage.GLSL,
    },
  );
  const { baseColorFactor = [1, 1, 1, 1], baseColorTexture } = materials[index]?.pbrMetallicRoughness ?? {};
  const image = textures[baseColorTexture?.index]?.image;
  const picture =
    image === undefined
      ? BABYLON.RawTexture.CreateRGBATexture(new Uint8Array([255, 255, 255, 255]), 1, 1, scene)
      : BABYLON.Texture.LoadFromDataString(`picture ${image}`, asset.image(image), scene, false, false, false);
  material.backFaceCulling = materials[index]?.doubleSided !== true;
  material.sideOrientation = BABYLON.Material.CounterClockWiseSideOrientation;
  material.setColor4('color', new BABYLON.Color4(...baseColorFactor));
  material.onBindObservable.add(() => {
    const effect = material.getEffect();
    for (const name of ['palettes', 'cached', 'transforms']) {
      effect.setTexture(name, rows[name].texture);
    }
  });
  material.setTexture('picture', picture);
  return material;
}

/** A mesh for each part of a level. */
function levelMeshes(scene, geometry, materialOf, most) {
  const first = (all, size) => {
    const { influences, vertices } = geometry;
    return Float32Array.from({ length: size * vertices }, (_, i) => all[Math.floor(i / size) * influences + (i % size)]);
  };
  const buffers = [
    ['position', geometry.positions(), 3],
    ['normal', geometry.normals(), 3],
    ['uv', geometry.texcoords(), 2],
    ['entries', first(geometry.entries(), 4), 4],
    ['shares', first(geometry.weights(), 4), 4],
  ];
  const triangles = geometry.triangles();
  const parts = geometry.parts();
  const made = Array.from({ length: parts.length / 3 }, (_, part) => {
    const [material, start, count] = parts.subarray(3 * part, 3 * part + 3);
    const mesh = new BABYLON.Mesh(`part ${part}`, scene);
    for (const [kind, data, size] of buffers) {
      mesh.setVerticesBuffer(new BABYLON.VertexBuffer(scene.getEngine(), data, kind, false, false, size));
    }
    mesh.setIndices(triangles.subarray(3 * start, 3 * (start + count)));
    mesh.material = materialOf(material);
    // Babylon.js counts instances by their matrices, which the shader does not read.
    mesh.thinInstanceSetBuffer('matrix', new Float32Array(16 * most), 16, true);
    // The crowd culls its characters itself.
    mesh.alwaysSelectAsActiveMesh = true;
    return mesh;
  });
  geometry.free();
  return made;
}
