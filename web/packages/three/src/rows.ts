import { MATRIX_FLOATS } from '@articula/core';
import type { Matrix4 } from 'three';

/** Sets `to` to matrix `index` of `rows`, matrices of three rows of four numbers. */
export function matrixOfRows(to: Matrix4, rows: ArrayLike<number>, index: number): Matrix4 {
  const at = index * MATRIX_FLOATS;
  const n = (i: number): number => rows[at + i] ?? 0;
  return to.set(n(0), n(1), n(2), n(3), n(4), n(5), n(6), n(7), n(8), n(9), n(10), n(11), 0, 0, 0, 1);
}

/** Copies `count` matrices of three rows into columns of 4 x 4 matrices. */
export function columnsOfRows(to: Float32Array, rows: Float32Array, count: number): void {
  for (let i = 0; i < count; i += 1) {
    const from = i * MATRIX_FLOATS;
    const at = i * 16;
    for (let column = 0; column < 4; column += 1) {
      to[at + column * 4] = rows[from + column] as number;
      to[at + column * 4 + 1] = rows[from + 4 + column] as number;
      to[at + column * 4 + 2] = rows[from + 8 + column] as number;
    }
    to[at + 15] = 1;
  }
}
