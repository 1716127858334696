// A character made for the tests: it has what the files of the repository lack.
import * as THREE from 'three';
import { GLTFExporter } from 'three/addons/exporters/GLTFExporter.js';

/** Returns the bytes of a GLB: a waving post of four materials, with morph targets and vertex colours. */
export async function madeCharacter() {
  const root = new THREE.Bone();
  root.name = 'root';
  const tip = new THREE.Bone();
  tip.name = 'tip';
  tip.position.y = 0.5;
  root.add(tip);
  const scene = new THREE.Group();
  scene.add(root);
  scene.updateMatrixWorld(true);
  const skeleton = new THREE.Skeleton([root, tip]);
  const looks = materials();
  looks.forEach((material, i) => {
    const mesh = new THREE.SkinnedMesh(post(i), material);
    mesh.name = material.name;
    mesh.bind(skeleton, new THREE.Matrix4());
    mesh.updateMorphTargets();
    scene.add(mesh);
  });
  const half = Math.SQRT1_2;
  const tracks = [
    new THREE.QuaternionKeyframeTrack('tip.quaternion', [0, 1, 2], [0, 0, 0, 1, 0, 0, half, half, 0, 0, 0, 1]),
    ...looks.map(
      ({ name }) => new THREE.NumberKeyframeTrack(`${name}.morphTargetInfluences`, [0, 1, 2], [0, 0, 1, 0.5, 0, 1]),
    ),
  ];
  const options = { binary: true, animations: [new THREE.AnimationClip('wave', 2, tracks)] };
  return new Uint8Array(await new GLTFExporter().parseAsync(scene, options));
}

/** A box around a part of the bones. */
function post(i) {
  const geometry = new THREE.BoxGeometry(0.22, 1, 0.22, 2, 6, 2).translate(0.26 * (i - 1.5), 0.5, 0);
  const { position } = geometry.attributes;
  const indices = [];
  const weights = [];
  const colors = [];
  const [wide, twisted] = [[], []];
  for (let v = 0; v < position.count; v += 1) {
    const y = position.getY(v);
    const share = Math.min(Math.max(y * 2 - 0.5, 0), 1);
    indices.push(0, 1, 0, 0);
    weights.push(1 - share, share, 0, 0);
    colors.push(1, 1 - 0.5 * y, 1 - y);
    wide.push(0, 0, position.getZ(v) * y * 2);
    twisted.push(0, 0.3 * position.getZ(v), 0.2 * y);
  }
  geometry.setAttribute('skinIndex', new THREE.Uint16BufferAttribute(indices, 4));
  geometry.setAttribute('skinWeight', new THREE.Float32BufferAttribute(weights, 4));
  geometry.setAttribute('color', new THREE.Float32BufferAttribute(colors, 3));
  geometry.morphAttributes.position = [wide, twisted].map((deltas) => new THREE.Float32BufferAttribute(deltas, 3));
  geometry.morphTargetsRelative = true;
  return geometry;
}

/** Every kind of picture, alpha mode and side. */
function materials() {
  const bumps = picture(32, (x, y) => [128 + 80 * Math.sin(x), 128 + 80 * Math.cos(y), 220, 255]);
  const checks = picture(8, (x, y) => ((x + y) % 2 === 0 ? [255, 80, 40, 255] : [40, 120, 255, 255]));
  checks.colorSpace = THREE.SRGBColorSpace;
  checks.wrapS = THREE.RepeatWrapping;
  checks.wrapT = THREE.MirroredRepeatWrapping;
  checks.magFilter = THREE.NearestFilter;
  checks.repeat.set(0.7, 1.2);
  checks.offset.set(0.1, 0.2);
  const holes = picture(8, (x, y) => [230, 220, 60, (x >> 1) % 2 === (y >> 1) % 2 ? 255 : 0]);
  holes.colorSpace = THREE.SRGBColorSpace;
  holes.magFilter = THREE.NearestFilter;
  const rough = picture(16, (x, y) => [255 - 8 * x, 16 * y, 15 * x, 255]);
  const glow = picture(16, (x) => (x % 4 === 0 ? [0, 255, 120, 255] : [0, 0, 0, 255]));
  glow.colorSpace = THREE.SRGBColorSpace;
  const common = { vertexColors: true };
  return [
    new THREE.MeshStandardMaterial({
      ...common,
      name: 'lit',
      map: checks,
      metalness: 0,
      roughness: 0.7,
    }),
    new THREE.MeshStandardMaterial({
      ...common,
      name: 'masked',
      map: holes,
      alphaTest: 0.5,
      side: THREE.DoubleSide,
      metalness: 0,
    }),
    new THREE.MeshStandardMaterial({
      ...common,
      name: 'bumpy',
      normalMap: bumps,
      normalScale: new THREE.Vector2(0.8, 0.8),
      roughnessMap: rough,
      metalnessMap: rough,
      aoMap: rough,
      aoMapIntensity: 0.6,
      emissiveMap: glow,
      emissive: new THREE.Color(0.8, 0.9, 1),
    }),
    new THREE.MeshBasicMaterial({ ...common, name: 'glass', color: 0x66ccff, transparent: true, opacity: 0.4 }),
  ];
}

function picture(size, pixel) {
  const canvas = document.createElement('canvas');
  canvas.width = canvas.height = size;
  const context = canvas.getContext('2d');
  const data = context.createImageData(size, size);
  for (let i = 0; i < size * size; i += 1) {
    data.data.set(pixel(i % size, Math.floor(i / size)), i * 4);
  }
  context.putImageData(data, 0, 0);
  const texture = new THREE.CanvasTexture(canvas);
  texture.flipY = false;
  return texture;
}
