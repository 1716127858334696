/**
 * The table of impostors, pictures that show a character far away: `docs/formats/impostor.md`. Lengths are metres,
 * times seconds, in the space of the character.
 */
export interface ImpostorTable {
  readonly format: 'articula-impostor';
  readonly version: 1;
  /** Name of the picture with all pictures, beside the table. */
  readonly picture: string;
  readonly cell: {
    /** Width and height of a picture. */
    readonly size_px: readonly [number, number];
    readonly metres_per_px: number;
    /** The lower left corner, from the centre of the pose. */
    readonly corner_m: readonly [number, number];
    /** Pictures in a row. */
    readonly columns: number;
  };
  /** Rows of directions, from the lowest. */
  readonly rows: readonly {
    readonly from_deg: number;
    readonly pitch_deg: number;
    readonly lean: number;
    readonly yaws: number;
  }[];
  readonly to_deg: number;
  readonly clips: readonly {
    readonly name: string;
    readonly duration_secs: number;
    readonly error_m: number;
    readonly first_pose: number;
    readonly from_secs: readonly number[];
    readonly pose_secs: readonly number[];
    /** Three numbers a pose. */
    readonly centres_m: readonly number[];
  }[];
}
