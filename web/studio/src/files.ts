/** What a file is to the studio, by its name. */
export type FileKind = 'played' | 'prepared' | 'motion' | 'face' | 'voice' | 'json' | 'item' | 'unknown';

const EXTENSIONS: Readonly<Record<Exclude<FileKind, 'unknown'>, readonly string[]>> = {
  // Characters that play without a worker, and those that are made first.
  played: ['glb', 'vrm'],
  prepared: ['gltf', 'fbx', 'x3d', 'asf'],
  motion: ['bvh', 'amc', 'bap', 'abp', 'bva', 'vrma'],
  face: ['fap', 'afp', 'fba', 'csv'],
  voice: ['wav'],
  json: ['json'],
  item: ['zip'],
};

/** All that may be opened, as a picker of files wants it. */
export const ACCEPTED = Object.values(EXTENSIONS)
  .flat()
  .map((extension) => `.${extension}`)
  .join(',');

export function kindOf(name: string): FileKind {
  const extension = /\.([a-z0-9]+)$/i.exec(name)?.[1]?.toLowerCase() ?? '';
  const found = Object.entries(EXTENSIONS).find(([, all]) => all.includes(extension));
  return (found?.[0] as FileKind | undefined) ?? 'unknown';
}

/** What is said about a file that is nothing to the studio. */
export function refused(name: string): Error {
  const sound = /\.(mp3|ogg|opus|m4a|flac|aac)$/i.test(name);
  const more = sound
    ? `A voice is a WAV file: ffmpeg -i ${name} voice.wav.`
    : 'It opens GLB, VRM, glTF, FBX and X3D as characters, BVH, AMC, BAP, ABP, BVA and VRMA as motions, FAP, AFP, FBA and CSV as motions of a face, WAV as a voice, JSON as a level or camera path, and ZIP as a digital item.';
  return new Error(`${name}: the studio knows no such file. ${more}`);
}

/** Name of a file without its extensions. */
export function baseOf(name: string): string {
  return name.replace(/(\.[a-z0-9]+)+$/i, '');
}

/** Whether a ZIP file names a manifest, as a digital item does; the server reads the rest. */
export function isItem(bytes: Uint8Array): boolean {
  return new TextDecoder('latin1').decode(bytes).includes('manifest.json');
}
