/** A camera, in the space of what it looks at: along its -Z, +Y up, as in glTF. */
export interface View {
  /** x, y, z in metres. */
  readonly position: readonly [number, number, number];
  /** The rotation, a unit quaternion x, y, z, w. */
  readonly rotation: readonly [number, number, number, number];
  /** The picture in pixels. */
  readonly width: number;
  readonly height: number;
  /** Vertical field of view in radians. */
  readonly fov: number;
}

/** Floats of a view as the modules take it. */
export const VIEW_FLOATS = 10;

/** Returns views as the modules take them. */
export function packViews(views: readonly View[]): Float32Array {
  const packed = new Float32Array(views.length * VIEW_FLOATS);
  views.forEach((view, i) => {
    packed.set([...view.position, ...view.rotation, view.width, view.height, view.fov], i * VIEW_FLOATS);
  });
  return packed;
}
