/** What went wrong, by kind. Other kinds may be added. */
export type ArticulaErrorCode =
  | 'argument'
  | 'cancelled'
  | 'invalid'
  | 'mismatch'
  | 'missing'
  | 'skeleton'
  | 'too-large'
  | 'unmapped'
  | 'unsupported'
  | 'write'
  | (string & {});

/** The facts of an {@link ArticulaError}, as they pass between threads. */
export interface ArticulaFault {
  readonly code: ArticulaErrorCode;
  readonly message: string;
  /** The file that has the fault. */
  readonly file?: string | undefined;
  /** Where in the file. */
  readonly place?: string | undefined;
}

/** An error in a file or in how it is used. */
export class ArticulaError extends Error implements ArticulaFault {
  readonly code: ArticulaErrorCode;
  readonly file: string | undefined;
  readonly place: string | undefined;

  constructor(fault: ArticulaFault, cause?: unknown) {
    super(fault.message, cause === undefined ? undefined : { cause });
    this.name = 'ArticulaError';
    this.code = fault.code;
    this.file = fault.file;
    this.place = fault.place;
  }

  /** Returns an error of the modules as an `ArticulaError`, and others as they are. */
  static from(error: unknown): unknown {
    const fault = faultOf(error);
    return fault === undefined || error instanceof ArticulaError ? error : new ArticulaError(fault, error);
  }
}

/** Returns the facts of an error that is an `ArticulaError` by its name. */
export function faultOf(error: unknown): ArticulaFault | undefined {
  if (!(error instanceof Error) || error.name !== 'ArticulaError') {
    return undefined;
  }
  const { code, file, place } = error as Error & Partial<Record<'code' | 'file' | 'place', unknown>>;
  return {
    code: typeof code === 'string' ? code : 'invalid',
    message: error.message,
    file: typeof file === 'string' ? file : undefined,
    place: typeof place === 'string' ? place : undefined,
  };
}

/** Calls `work`; an error of the modules leaves it as an {@link ArticulaError}. */
export function guarded<T>(work: () => T): T {
  try {
    return work();
  } catch (error) {
    throw ArticulaError.from(error);
  }
}
