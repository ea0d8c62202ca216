import type { OtherTexts } from '../parts/labels';

const KEY = 'bendtwin.uploads';

/** Labels of a capture, given when it is sent. */
export interface Labels {
  readonly name: string;
  /** Texts beside the name, without those that are empty. */
  readonly texts: Readonly<OtherTexts>;
  readonly note: string;
  readonly tags: readonly string[];
}

/** An upload that was begun and did not end: enough to resume once its files are chosen again. */
export interface Kept extends Labels {
  /** Fingerprint of the files. */
  readonly files: string;
  /** Name of the file or folder to choose. */
  readonly source: string;
  readonly kind: 'file' | 'folder';
  readonly sizeBytes: number;
  /** Settings of the ingest as JSON, or empty. */
  readonly ingest: string;
  /** Address of the upload at the server, or null if it was not begun there. */
  readonly address: string | null;
}

/** Uploads that were begun in this browser and did not end. */
export function kept(storage: Storage = localStorage): Kept[] {
  try {
    const all: unknown = JSON.parse(storage.getItem(KEY) ?? '[]');
    // Pages of before had no texts.
    return Array.isArray(all) ? all.filter(isKept).map((upload) => ({ ...upload, texts: upload.texts ?? {} })) : [];
  } catch {
    return [];
  }
}

/** Keeps an upload, in the place of an earlier one of the same files. */
export function keep(upload: Kept, storage: Storage = localStorage): void {
  const others = kept(storage).filter(({ files }) => files !== upload.files);
  store([...others, upload], storage);
}

/** Forgets the upload of these files. */
export function forget(files: string, storage: Storage = localStorage): void {
  store(
    kept(storage).filter((upload) => upload.files !== files),
    storage,
  );
}

function store(all: readonly Kept[], storage: Storage): void {
  try {
    storage.setItem(KEY, JSON.stringify(all));
  } catch {
    // A browser that keeps nothing: the upload continues, and after a reload the same files find
    // it.
  }
}

/** Checks an entry of the storage, which may be of another version of this page. */
function isKept(value: unknown): value is Omit<Kept, 'texts'> & Partial<Pick<Kept, 'texts'>> {
  if (typeof value !== 'object' || value === null) return false;
  const upload = value as Record<string, unknown>;
  const haveTexts = ['files', 'source', 'kind', 'name', 'note', 'ingest'].every(
    (key) => typeof upload[key] === 'string',
  );
  const { texts, tags, sizeBytes } = upload;
  return haveTexts && isTexts(texts) && Array.isArray(tags) && typeof sizeBytes === 'number';
}

/** Pages of before had none. */
function isTexts(value: unknown): boolean {
  if (value === undefined) return true;
  if (typeof value !== 'object' || value === null || Array.isArray(value)) return false;
  return Object.values(value).every((text) => typeof text === 'string');
}
