// A VRM of three-vrm that stands in a crowd: near the camera three-vrm shows it, with its expressions, its look-at and its
// spring bones, and poses come from the library at the level of articulation that the distance needs; farther away it
// is one of the crowd.
import { ArticulaCrowd } from '@articula/three';
import { Matrix4, PropertyBinding, Vector3 } from 'three';

const parentFromModel = new Matrix4();
const modelFromJoint = new Matrix4();
const place = new Vector3();

export class CrowdedVrm {
  /** The first character of the crowd is the VRM, whose `scene` is placed like any object. */
  constructor(vrm, asset, crowd, nearMetres = 8) {
    this.vrm = vrm;
    this.crowd = crowd;
    this.nearMetres = nearMetres;
    this.isNear = true;
    const { figure, arrays } = asset.articula.figure(asset.core);
    this.figure = figure;
    this.arrays = arrays;
    // GLTFLoader leaves out signs of names that paths of tracks use.
    const nodeOf = (joint) => vrm.scene.getObjectByName(PropertyBinding.sanitizeNodeName(joint));
    this.nodes = asset.joints.map(nodeOf);
    this.parents = asset.core.parents;
    this.clips = asset.clips;
  }

  /** Plays a clip near and far. */
  play(clip, secs = 0) {
    this.figure.play(this.clips.indexOf(clip), secs);
    this.crowd.play(0, clip, secs);
    return this;
  }

  /** Before the `update` of the crowd: poses the VRM, or gives its place to the crowd. */
  update(secs, camera, size) {
    const { vrm, crowd } = this;
    this.isNear = camera.position.distanceTo(vrm.scene.getWorldPosition(place)) < this.nearMetres;
    vrm.scene.visible = this.isNear;
    const { x, y, z } = vrm.scene.position;
    // A character far below the ground is culled.
    crowd.place(0, x, this.isNear ? -1e5 : y, z, vrm.scene.rotation.y);
    this.figure.frame(secs, this.#view(camera, size));
    if (this.isNear) {
      this.#pose();
      vrm.update(secs);
    }
  }

  dispose() {
    this.figure.free();
  }

  /** The camera in the space of the VRM. */
  #view(camera, { width, height }) {
    const view = parentFromModel.copy(this.vrm.scene.matrixWorld).invert().multiply(camera.matrixWorld);
    const [position, rotation, scale] = [new Vector3(), camera.quaternion.clone(), new Vector3()];
    view.decompose(position, rotation, scale);
    return Float32Array.of(...position, ...rotation, width, height, (camera.fov * Math.PI) / 180);
  }

  #pose() {
    const { joints } = this.arrays;
    this.nodes.forEach((node, joint) => {
      if (node === undefined) {
        return;
      }
      rows(modelFromJoint, joints, joint);
      const parent = this.parents[joint];
      if (parent >= 0) {
        modelFromJoint.premultiply(rows(parentFromModel, joints, parent).invert());
      }
      modelFromJoint.decompose(node.position, node.quaternion, node.scale);
    });
  }
}

/** Makes a crowd whose first character is a VRM of three-vrm. */
export function crowdAround(vrm, asset, count, options) {
  const crowd = new ArticulaCrowd(asset, count, options);
  return { crowd, hero: new CrowdedVrm(vrm, asset, crowd) };
}

function rows(matrix, all, index) {
  const m = all.subarray(12 * index, 12 * (index + 1));
  return matrix.set(...m, 0, 0, 0, 1);
}
