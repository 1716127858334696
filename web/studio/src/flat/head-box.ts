import type { ArticulaAsset } from '@articula/three';
import { Box3, Vector3 } from 'three';

/** Share of the height of a figure that its head is, where no joint tells. */
const HEAD = 0.14;
/** Heights of the head that are shown below its lowest joint, the neck. */
const BELOW = 0.35;
/** Numbers of a matrix of three rows. */
const ROWS = 12;

/** About where the head is, by the joints of the face; `rows` are the matrices of all joints. */
export function headBox(asset: ArticulaAsset, rows: Float32Array): Box3 {
  const { bounds, core } = asset;
  const of = [...core.jointRegions].flatMap((region, joint) => (region === 'face' ? [joint] : []));
  const at = (joint: number, axis: number): number => rows[joint * ROWS + 4 * axis + 3] ?? 0;
  const top = bounds.max.y;
  const low = Math.min(...of.map((joint) => at(joint, 1)), top - HEAD * (top - bounds.min.y));
  const height = top - low;
  const middle = (axis: number): number => of.reduce((sum, joint) => sum + at(joint, axis), 0) / Math.max(of.length, 1);
  const [x, z] = of.length > 0 ? [middle(0), middle(2)] : [0, 0];
  const half = height / 2;
  return new Box3(new Vector3(x - half, low - BELOW * height, z - half), new Vector3(x + half, top, z + half));
}
