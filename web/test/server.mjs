// Serves the packages, three.js and the characters of the repository on this machine alone.
import { createReadStream } from 'node:fs';
import { stat } from 'node:fs/promises';
import { createServer } from 'node:http';
import { extname, join, normalize, sep } from 'node:path';
import { fileURLToPath } from 'node:url';

const WEB = fileURLToPath(new URL('..', import.meta.url));
const ASSETS = fileURLToPath(new URL('../../assets', import.meta.url));
/** The full set of characters, if it is here. */
export const DATA = process.env.ARTICULA_DATA ?? fileURLToPath(new URL('../../../shared/data', import.meta.url));
const TYPES = {
  '.css': 'text/css',
  '.html': 'text/html',
  '.js': 'text/javascript',
  '.json': 'application/json',
  '.mjs': 'text/javascript',
  '.svg': 'image/svg+xml',
  '.wasm': 'application/wasm',
};

/** The file of a path: characters of the repository and of the full set, else what belongs to the pages. */
function fileOf(path) {
  for (const [name, folder] of [['assets', ASSETS], ['data', DATA]]) {
    if (path.startsWith(`${sep}${name}${sep}`)) {
      return join(folder, path.slice(name.length + 2));
    }
  }
  return join(WEB, path);
}

/** Starts a server, which keeps what is put; resolves to its address and a function that ends it. */
export function serve() {
  const kept = new Map();
  const server = createServer(async (request, response) => {
    const path = normalize(decodeURIComponent(new URL(request.url, 'http://host').pathname));
    if (request.method === 'PUT') {
      kept.set(path, Buffer.concat(await request.toArray()));
      response.writeHead(204).end();
      return;
    }
    if (kept.has(path)) {
      response.writeHead(200, { 'content-type': 'application/octet-stream' }).end(kept.get(path));
      return;
    }
    const file = fileOf(path);
    const found = await stat(file).catch(() => undefined);
    if (!found?.isFile()) {
      response.writeHead(404).end();
      return;
    }
    response.writeHead(200, {
      'content-type': TYPES[extname(file)] ?? 'application/octet-stream',
      'content-length': found.size,
      'cache-control': 'no-store',
    });
    createReadStream(file).pipe(response);
  });
  return new Promise((resolve) => {
    server.listen(0, '127.0.0.1', () => {
      const close = () => {
        server.closeAllConnections();
        server.close();
      };
      resolve({ address: `http://127.0.0.1:${server.address().port}`, close });
    });
  });
}
