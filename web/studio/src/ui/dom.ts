/** Elements as functions: attributes, properties, listeners (`on…`) and children. */
type Attributes = Record<string, unknown>;
type Child = Node | string | undefined | false;

/** Makes an element. `class`, `for` and other attributes by name; listeners by `onclick` and the like. */
export function h<K extends keyof HTMLElementTagNameMap>(
  name: K,
  attributes: Attributes = {},
  ...children: readonly Child[]
): HTMLElementTagNameMap[K] {
  const element = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith('aria-') && value !== undefined) {
      element.setAttribute(key, String(value));
    } else if (value === undefined || value === false) {
      continue;
    } else if (key.startsWith('on')) {
      element.addEventListener(key.slice(2), value as EventListener);
    } else {
      element.setAttribute(key, value === true ? '' : String(value));
    }
  }
  element.append(...children.filter((child): child is Node | string => child !== undefined && child !== false));
  return element;
}

let made = 0;

/** Returns an id that no other element has. */
export function freshId(): string {
  made += 1;
  return `id${made}`;
}

/** Saves bytes as a file of the visitor. */
export function download(bytes: Uint8Array | string, name: string, type: string): void {
  const url = URL.createObjectURL(new Blob([bytes as BlobPart], { type }));
  h('a', { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}

/** Bytes in words. */
export function inBytes(bytes: number): string {
  return bytes < 1000 ? `${bytes} B` : bytes < 1e6 ? `${(bytes / 1e3).toFixed(1)} kB` : `${(bytes / 1e6).toFixed(2)} MB`;
}
