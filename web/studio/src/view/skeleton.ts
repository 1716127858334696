import {
  Color,
  CylinderGeometry,
  DynamicDrawUsage,
  InstancedMesh,
  Matrix4,
  MeshBasicMaterial,
  Object3D,
  Quaternion,
  SphereGeometry,
  Vector3,
} from 'three';

/** States of a joint, as the module numbers them. */
export const PASSIVE = 0;
export const ACTIVE = 1;
export const IN_TRANSITION = 2;

/** Colours of passive, active and changing joints at first, told apart by lightness too; those of the legend in the style sheet. */
export const STATE_COLORS: readonly Color[] = [new Color('#d6393d'), new Color('#1fae57'), new Color('#f2a60d')];

const MATRIX_FLOATS = 12;
const UP = new Vector3(0, 1, 0);
const from = new Vector3();
const to = new Vector3();
const along = new Vector3();
const turn = new Quaternion();
const size = new Vector3();
const matrix = new Matrix4();

/** The joints and bones of a figure over its body, coloured by the state of each joint. */
export class SkeletonOverlay extends Object3D {
  readonly #joints: InstancedMesh;
  readonly #bones: InstancedMesh;
  readonly #parents: readonly number[];
  /** Colours of passive, active and changing joints. */
  colors = STATE_COLORS;
  /** Radius of a joint in metres. */
  radius: number;

  constructor(parents: readonly number[], height: number) {
    super();
    this.#parents = parents;
    this.radius = height * 0.008;
    const material = (): MeshBasicMaterial => new MeshBasicMaterial({ depthTest: false, transparent: true, toneMapped: false });
    this.#joints = new InstancedMesh(new SphereGeometry(1, 10, 8), material(), parents.length);
    this.#bones = new InstancedMesh(new CylinderGeometry(0.35, 0.6, 1, 6), material(), parents.length);
    this.#bones.renderOrder = 10;
    this.#joints.renderOrder = 11;
    for (const mesh of [this.#joints, this.#bones]) {
      mesh.instanceMatrix.setUsage(DynamicDrawUsage);
      mesh.frustumCulled = false;
      this.add(mesh);
    }
  }

  /** Takes over matrices of three rows of four numbers, and the state of each joint. */
  update(rows: Float32Array, states: Uint8Array): void {
    this.#parents.forEach((parent, joint) => {
      const state = states[joint] ?? ACTIVE;
      place(rows, joint, to);
      // Passive joints are smaller, so that states differ without colours too.
      const radius = this.radius * (state === PASSIVE ? 0.75 : 1);
      this.#joints.setMatrixAt(joint, matrix.compose(to, turn.identity(), size.setScalar(radius)));
      this.#joints.setColorAt(joint, this.colors[state] as Color);
      if (parent < 0) {
        this.#bones.setMatrixAt(joint, matrix.makeScale(0, 0, 0));
      } else {
        place(rows, parent, from);
        along.subVectors(to, from);
        const length = along.length();
        turn.setFromUnitVectors(UP, along.divideScalar(Math.max(length, 1e-6)));
        size.set(radius, length, radius);
        this.#bones.setMatrixAt(joint, matrix.compose(from.add(to).multiplyScalar(0.5), turn, size));
      }
      this.#bones.setColorAt(joint, this.colors[states[parent] ?? state] as Color);
    });
    for (const mesh of [this.#joints, this.#bones]) {
      mesh.instanceMatrix.needsUpdate = true;
      if (mesh.instanceColor !== null) {
        mesh.instanceColor.needsUpdate = true;
      }
    }
  }

  override dispose(): void {
    for (const mesh of [this.#joints, this.#bones]) {
      mesh.geometry.dispose();
      (mesh.material as MeshBasicMaterial).dispose();
      mesh.dispose();
    }
    this.removeFromParent();
  }
}

function place(rows: Float32Array, joint: number, into: Vector3): void {
  const at = joint * MATRIX_FLOATS;
  into.set(rows[at + 3] ?? 0, rows[at + 7] ?? 0, rows[at + 11] ?? 0);
}
