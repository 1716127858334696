import { inBytes } from '../ui/dom.js';
import type { Readout } from '../ui/status.js';
import type { PortraitReport } from './portrait.js';

/** The report of `articula flatten --json`, as far as it is shown. */
export interface ClipReport {
  readonly profile: string;
  readonly bytes: { readonly raw: number; readonly gzip: number; readonly brotli: number };
  readonly triangles_of_character: number;
  readonly triangles_drawn: number;
  readonly frames: number;
  readonly fps: number;
  readonly error: { readonly position_rmse_px: number; readonly image_rmse_levels: number; readonly ssim: number; readonly pixels_off_percent: number };
}

type Report = ClipReport | PortraitReport;

/** Tells bytes and errors of a picture, or of a portrait, beside the bytes of the character. */
export function tell(readout: Readout, report: Report, ofCharacter: number): void {
  const { bytes } = report;
  readout.set('File', inBytes(bytes.raw));
  readout.set('gzip', inBytes(bytes.gzip));
  readout.set('Brotli', inBytes(bytes.brotli));
  readout.set('Character in 3D', inBytes(ofCharacter));
  const isHead = (given: Report): given is PortraitReport => given.profile === 'portrait';
  const head = isHead(report) ? report : undefined;
  const clip = isHead(report) ? undefined : report;
  const shown = clip && `${clip.triangles_drawn.toLocaleString('en')} of ${clip.triangles_of_character.toLocaleString('en')}`;
  readout.set('Triangles', shown ?? head?.triangles.toLocaleString('en'));
  readout.set('Frames', clip ? `${clip.frames} at ${clip.fps.toFixed(1)} Hz` : head?.frames.toString());
  readout.set('Pictures of the head', head?.views.toString());
  readout.set('Expressions', head?.expressions.toString());
  readout.set('Error of corners', clip && `${clip.error.position_rmse_px.toFixed(2)} px`);
  readout.set('Error of pixels', clip && `${clip.error.image_rmse_levels.toFixed(2)} of 255`);
  readout.set('Similarity (SSIM)', clip?.error.ssim.toFixed(3));
  readout.set('Pixels off', clip && `${clip.error.pixels_off_percent.toFixed(2)} %`);
  for (const { yaw_deg: yaw, image_rmse_levels: levels } of head?.error ?? []) {
    readout.set(named(yaw), `${levels.toFixed(1)} of 255`);
  }
  if (head === undefined) {
    [0, 10, 20, 30, 40].forEach((yaw) => readout.set(named(yaw), undefined));
  }
}

function named(yaw: number): string {
  return yaw === 0 ? 'Error from the front' : `Error at ${yaw}°`;
}
