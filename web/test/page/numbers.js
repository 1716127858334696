// Positions of vertices, computed from the arrays of the packages and by three.js.
import { Articula, packViews } from '@articula/core';
import { ArticulaFigure, ArticulaLoader } from '@articula/three';
import * as THREE from 'three';

import { theirs } from './theirs.js';

/** Greatest distance in metres between vertices of a figure, of a crowd's palettes, and of three.js. */
export async function comparePositions(url, clip, secs) {
  const loader = new ArticulaLoader();
  loader.prepare = false;
  const [asset, makeTheirs] = await Promise.all([loader.loadAsync(url), theirs(url)]);
  const expected = positionsOf(makeTheirs(clip, secs));
  const figure = new ArticulaFigure(asset);
  figure.play(clip, secs).update(0);
  const byFigure = positionsOf(figure);
  const byCrowd = await crowdPositions(asset, clip, secs);
  const sphere = figure.mesh.boundingSphere;
  const outside = byFigure.map((point) => sphere.distanceToPoint(point)).reduce((a, b) => Math.max(a, b));
  const tight = new THREE.Sphere().setFromPoints(byFigure).radius / sphere.radius;
  figure.dispose();
  asset.dispose();
  return {
    vertices: [expected.length, byFigure.length, byCrowd.length],
    figure: farthest(expected, byFigure),
    crowd: farthest(expected, byCrowd),
    outside,
    tight,
  };
}

/** Positions of all vertices of all meshes, in their order. */
function positionsOf(object) {
  object.updateMatrixWorld(true);
  const points = [];
  object.traverse((mesh) => {
    if (mesh.isMesh) {
      mesh.skeleton?.update();
      for (let i = 0; i < mesh.geometry.attributes.position.count; i += 1) {
        points.push(mesh.getVertexPosition(i, new THREE.Vector3()).applyMatrix4(mesh.matrixWorld));
      }
    }
  });
  return points;
}

/** The vertices of the second of two characters, from the arrays of the core package alone. */
async function crowdPositions(asset, clip, secs) {
  const articula = await Articula.load();
  const options = { rootMotion: 'as-authored', meshLevels: 1, poseCache: false, clips: [clip] };
  const { crowd, arrays } = articula.crowd(asset.core, 2, options);
  crowd.setFull();
  crowd.place(1, 5, 0, -2, 1);
  crowd.play(1, 0, secs);
  const view = { position: [0, 1, 20], rotation: [0, 0, 0, 1], width: 100, height: 100, fov: 1 };
  crowd.frame(0, packViews([view]));
  const mesh = crowd.mesh(0);
  const [positions, entries, weights] = [mesh.positions(), mesh.entries(), mesh.weights()];
  const { draws, palettes } = arrays;
  const first = draws.indexOf(1) + 1;
  const at = (draws[first] ?? Number.NaN) * 12;
  const points = [];
  for (let v = 0; v < mesh.vertices; v += 1) {
    const point = [0, 0, 0];
    for (let i = 0; i < mesh.influences; i += 1) {
      const weight = weights[v * mesh.influences + i];
      const from = at + entries[v * mesh.influences + i] * 12;
      for (let row = 0; row < 3 && weight !== 0; row += 1) {
        const m = palettes.subarray(from + row * 4, from + row * 4 + 4);
        const moved = m[0] * positions[v * 3] + m[1] * positions[v * 3 + 1] + m[2] * positions[v * 3 + 2] + m[3];
        point[row] += weight * moved;
      }
    }
    points.push(new THREE.Vector3(...point));
  }
  mesh.free();
  crowd.free();
  return points;
}

/** The greatest distance of a point of one list to that of the other at its place. */
function farthest(a, b) {
  return a.reduce((most, point, i) => Math.max(most, b[i] ? point.distanceTo(b[i]) : Number.POSITIVE_INFINITY), 0);
}
