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

/** Characters of the server; undefined where the page comes from another server. */
export function characters(): Promise<readonly ServedCharacter[] | undefined> {
  return list<ServedCharacter>('v1/characters');
}

/** Sessions that are open; none where there is no server. */
export async function sessions(): Promise<readonly ServedSession[]> {
  return (await list<ServedSession>('v1/sessions')) ?? [];
}

async function list<T>(path: string): Promise<readonly T[] | undefined> {
  try {
    const response = await fetch(new URL(path, SERVER));
    const isList = response.ok && response.headers.get('content-type')?.includes('json');
    return isList ? ((await response.json()) as readonly T[]) : undefined;
  } catch {
    return undefined;
  }
}
