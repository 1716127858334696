/** A picture: four bytes a pixel, straight alpha. */
export interface Pixels {
  readonly width: number;
  readonly height: number;
  readonly data: Uint8Array;
}

/** Halvings that do not mix pictures beside each other. */
const HALVINGS = 2;

/** Pixels that filters reach beyond an outline. */
const REACH = 2;

/**
 * Returns a picture and its mipmaps. Colours are averaged by alpha, and clear pixels beside others get their colours, so
 * that filters of straight alpha show no borders.
 */
export function withMipmaps(pixels: Pixels): Pixels[] {
  const all = [pixels];
  for (let i = 0; i < HALVINGS; i += 1) {
    all.push(halved(all[i] as Pixels));
  }
  all.forEach(spreadColours);
  return all;
}

/** Averages squares of four pixels; width and height are even. */
function halved({ width, height, data }: Pixels): Pixels {
  const [half, lines] = [width >> 1, height >> 1];
  const made = new Uint8Array(half * lines * 4);
  for (let y = 0; y < lines; y += 1) {
    for (let x = 0; x < half; x += 1) {
      const from = (2 * y * width + 2 * x) * 4;
      const four = [from, from + 4, from + width * 4, from + width * 4 + 4];
      let alpha = 0;
      const sum = [0, 0, 0];
      for (const at of four) {
        const weight = data[at + 3] as number;
        alpha += weight;
        for (let c = 0; c < 3; c += 1) {
          sum[c] = (sum[c] as number) + weight * (data[at + c] as number);
        }
      }
      if (alpha > 0) {
        made.set([...sum.map((value) => Math.round(value / alpha)), Math.round(alpha / 4)], (y * half + x) * 4);
      }
    }
  }
  return { width: half, height: lines, data: made };
}

/** Gives clear pixels the colours of those beside them. */
function spreadColours({ width, height, data }: Pixels): void {
  const words = new Uint32Array(data.buffer, data.byteOffset, width * height);
  // Little-endian machines alone run browsers.
  const CLEAR = 0x00ffffff;
  let front: number[] = [];
  words.forEach((word, at) => {
    if (word > CLEAR) {
      front.push(at);
    }
  });
  for (let i = 0; i < REACH; i += 1) {
    const next: number[] = [];
    for (const at of front) {
      const x = at % width;
      const beside = [x > 0 ? at - 1 : -1, x + 1 < width ? at + 1 : -1, at - width, at + width];
      for (const other of beside) {
        if (words[other] === 0) {
          words[other] = (words[at] as number) & CLEAR;
          next.push(other);
        }
      }
    }
    front = next;
  }
}
