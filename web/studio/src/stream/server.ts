/** A character of the server, as far as it is shown. */
export interface ServedCharacter {
  readonly name: string;
  readonly state: string;
  /** Where its manifest is, once a stage is made. */
  readonly manifest: string | null;
  readonly bytes_sent: number | null;
}

/** A session of the server, as far as it is shown. */
export interface ServedSession {
  readonly number: number;
  readonly characters: readonly { readonly name: string; readonly level: number; readonly levels: number; readonly is_complete: boolean }[];
  readonly sent: { readonly secs: number; readonly bandwidth_bps: number; readonly bytes: number };
}

/** Where the server of the page is: `articula serve --studio` has the pages one folder below its own address. */
export const SERVER = new URL('../', document.baseURI);

/**
 * Whether the server of these pages has characters. It says so in a file that lies beside the pages on any other server
 * too, so nothing is asked for that is not there.
 */
export async function hasCharacters(): Promise<boolean> {
  const said = (await read(new URL('server.json', document.baseURI))) as { characters?: boolean } | undefined;
  return said?.characters === true;
}

/** Characters of the server; undefined where the page comes from another server. */
export async function characters(): Promise<readonly ServedCharacter[] | undefined> {
  return (await hasCharacters()) ? list<ServedCharacter>('v1/characters') : undefined;
}

/** Sessions that are open; none where there is no server. */
export async function sessions(): Promise<readonly ServedSession[]> {
  return (await list<ServedSession>('v1/sessions')) ?? [];
}

/** Gives the server a character, a ZIP file of an item. */
export async function put(name: string, bytes: Uint8Array): Promise<void> {
  const response = await fetch(new URL(`v1/characters/${name}`, SERVER), { method: 'PUT', body: bytes as BufferSource });
  if (!response.ok) {
    throw new Error(`${name}: the server answers ${response.status}: ${(await response.text()).slice(0, 300)}`);
  }
}

async function list<T>(path: string): Promise<readonly T[] | undefined> {
  return (await read(new URL(path, SERVER))) as readonly T[] | undefined;
}

/** Reads JSON of the server; undefined if there is none. */
async function read(url: URL): Promise<unknown> {
  try {
    const response = await fetch(url);
    const isJson = response.ok && response.headers.get('content-type')?.includes('json');
    return isJson ? await response.json() : undefined;
  } catch {
    return undefined;
  }
}
