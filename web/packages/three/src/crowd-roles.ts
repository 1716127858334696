import { Crowd } from '@articula/core';

/** How important characters are: what is told of each, times what is told of its role. */
export class CrowdRoles {
  readonly #core: Crowd;
  readonly #importance = new Map<string, number>(Object.entries(JSON.parse(Crowd.usualRoles()) as Record<string, number>));
  readonly #own = new Map<number, number>();
  readonly #roles = new Map<number, string>();

  constructor(core: Crowd) {
    this.#core = core;
  }

  /** Names of the roles, with their importance. */
  get roles(): ReadonlyMap<string, number> {
    return this.#importance;
  }

  /** The role of a character, if it has one. */
  of(character: number): string | undefined {
    return this.#roles.get(character);
  }

  /** Changes the importance of a role, or adds it. */
  setRole(name: string, importance: number): void {
    this.#importance.set(name, positive(importance));
    for (const [character, role] of this.#roles) {
      if (role === name) {
        this.#tell(character);
      }
    }
  }

  /** Gives a character a role, or takes it. */
  setRoleAt(character: number, name: string | undefined): void {
    if (name === undefined) {
      this.#roles.delete(character);
    } else if (this.#importance.has(name)) {
      this.#roles.set(character, name);
    } else {
      throw new RangeError(`no role "${name}"; there are ${[...this.#importance.keys()].join(', ')}`);
    }
    this.#tell(character);
  }

  setImportance(character: number, importance: number): void {
    this.#own.set(character, positive(importance));
    this.#tell(character);
  }

  #tell(character: number): void {
    const role = this.#roles.get(character);
    const ofRole = role === undefined ? 1 : (this.#importance.get(role) ?? 1);
    this.#core.setImportance(character, (this.#own.get(character) ?? 1) * ofRole);
  }
}

function positive(importance: number): number {
  if (!(importance > 0 && Number.isFinite(importance))) {
    throw new RangeError(`an importance is a positive number, found ${importance}`);
  }
  return importance;
}
