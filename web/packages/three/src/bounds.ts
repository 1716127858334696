import { type BufferGeometry, Box3, Matrix4, Sphere, Vector3 } from 'three';

const matrix = new Matrix4();
const centre = new Vector3();

/**
 * Bounds of a skinned mesh in any pose. A vertex is a mean of points that its entries move, so the spheres around the
 * vertices of each entry, moved by its matrix, hold the mesh.
 */
export class PoseBounds {
  readonly #spheres: readonly (Sphere | undefined)[];

  constructor(geometry: BufferGeometry, bindings: number) {
    this.#spheres = entrySpheres(geometry, bindings);
  }

  /** Sets `to` to a sphere around the pose; `entry` gives the matrix of an entry. */
  enclose(to: Sphere, entry: (index: number, into: Matrix4) => Matrix4): Sphere {
    const box = new Box3();
    this.#spheres.forEach((sphere, i) => {
      if (sphere === undefined) {
        return;
      }
      entry(i, matrix);
      centre.copy(sphere.center).applyMatrix4(matrix);
      const radius = sphere.radius * matrix.getMaxScaleOnAxis();
      box.expandByPoint(centre.addScalar(radius));
      box.expandByPoint(centre.addScalar(-2 * radius));
    });
    return box.getBoundingSphere(to);
  }
}

/** The sphere around the vertices of each entry, wide enough for every morph target at weight 1. */
function entrySpheres(geometry: BufferGeometry, bindings: number): (Sphere | undefined)[] {
  const { position, skinIndex, skinWeight } = geometry.attributes;
  const boxes = new Map<number, Box3>();
  if (position === undefined || skinIndex === undefined || skinWeight === undefined) {
    return [];
  }
  const reach = morphReach(geometry, position.count);
  const point = new Vector3();
  for (let vertex = 0; vertex < position.count; vertex += 1) {
    for (let slot = 0; slot < 4; slot += 1) {
      if (skinWeight.getComponent(vertex, slot) === 0) {
        continue;
      }
      const entry = skinIndex.getComponent(vertex, slot);
      const box = boxes.get(entry) ?? new Box3();
      boxes.set(entry, box);
      point.fromBufferAttribute(position, vertex);
      box.expandByPoint(point.addScalar(reach[vertex] ?? 0));
      box.expandByPoint(point.addScalar(-2 * (reach[vertex] ?? 0)));
    }
  }
  return Array.from({ length: bindings }, (_, i) => boxes.get(i)?.getBoundingSphere(new Sphere()));
}

/** How far all morph targets together can move each vertex. */
function morphReach(geometry: BufferGeometry, vertices: number): Float32Array {
  const reach = new Float32Array(vertices);
  const delta = new Vector3();
  for (const target of geometry.morphAttributes.position ?? []) {
    for (let vertex = 0; vertex < vertices; vertex += 1) {
      reach[vertex] = (reach[vertex] ?? 0) + delta.fromBufferAttribute(target, vertex).length();
    }
  }
  return reach;
}
