/** A picture behind the character. */
export interface Background {
  readonly bytes: Uint8Array;
  readonly type: string;
  readonly name: string;
}

/** Types of pictures that browsers and viewers of SVG show. */
export const PICTURES = 'image/png,image/jpeg,image/webp';

/** Largest picture that goes into an SVG. */
const MOST_BYTES = 8e6;

export async function readBackground(file: File): Promise<Background> {
  if (!PICTURES.split(',').includes(file.type)) {
    throw new Error(`${file.name}: a background is a PNG, JPEG or WebP picture`);
  }
  if (file.size > MOST_BYTES) {
    throw new Error(`${file.name}: a background has at most ${MOST_BYTES / 1e6} MB; make it smaller`);
  }
  return { bytes: new Uint8Array(await file.arrayBuffer()), type: file.type, name: file.name };
}

/** An SVG with a picture behind all that it draws, which fills it. */
export function withBackground(svg: Uint8Array, background: Background): Uint8Array {
  const text = new TextDecoder().decode(svg);
  const head = /<svg\b[^>]*>/.exec(text);
  if (head === null) {
    throw new Error('the picture is no SVG');
  }
  const [x = 0, y = 0, width = 0, height = 0] = (/viewBox="([^"]*)"/.exec(head[0])?.[1] ?? '').split(/[\s,]+/).map(Number);
  const size = width > 0 ? `x="${x}" y="${y}" width="${width}" height="${height}"` : 'width="100%" height="100%"';
  const image = `<image ${size} preserveAspectRatio="xMidYMid slice" href="data:${background.type};base64,${inBase64(background.bytes)}"/>`;
  const end = head.index + head[0].length;
  return new TextEncoder().encode(text.slice(0, end) + image + text.slice(end));
}

function inBase64(bytes: Uint8Array): string {
  let text = '';
  for (let at = 0; at < bytes.length; at += 0x8000) {
    text += String.fromCharCode(...bytes.subarray(at, at + 0x8000));
  }
  return btoa(text);
}
