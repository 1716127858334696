import { ArticulaStream } from '@articula/three';
import type { Box3, Camera, Object3D } from 'three';

import { inBytes } from '../ui/dom.js';
import { SERVER } from './server.js';

type Options = NonNullable<ConstructorParameters<typeof ArticulaStream>[2]>;

/** The same character once more in a session of its own, at another rate, to the right of the first. */
export class StreamBeside {
  stream: ArticulaStream | undefined;

  begin(scene: Object3D, character: string, options: Options): void {
    this.end();
    this.stream = new ArticulaStream(SERVER, character, options);
    scene.add(this.stream);
  }

  /** Moves it beside a figure of this size. */
  stand(box: Box3): void {
    this.stream?.position.setX(0.6 * (box.max.y - box.min.y));
  }

  play(clip: string): void {
    this.stream?.play(clip);
  }

  update(dtSecs: number, camera: Camera | undefined): void {
    this.stream?.update(dtSecs, camera);
  }

  /** What it has, in words; undefined without one. */
  get said(): string | undefined {
    const report = this.stream?.report;
    return report && `level ${report.level} of ${report.levels}, ${inBytes(report.bytes)}`;
  }

  end(): void {
    this.stream?.dispose();
    this.stream = undefined;
  }
}
