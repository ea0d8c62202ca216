/** A file below a folder that was given: its path from there on, `/` between parts. */
export interface FolderFile {
  readonly path: string;
  readonly file: File;
}

/** What is sent as one capture: a single file, or the files of a folder that are read. */
export type Package =
  | { readonly kind: 'file'; readonly name: string; readonly file: File }
  | {
      readonly kind: 'folder';
      readonly name: string;
      readonly files: readonly FolderFile[];
      /** Files that are not read. */
      readonly left: number;
      /** Note about the files that are left out, in a sentence. */
      readonly note: string | null;
    };

/** Files that are a capture each, by their names. */
const ARCHIVE = /\.(zip|tar|tgz|tar\.gz|mcap|mcap\.zstd?)$/i;
/** Files of markers of motion capture, which are a capture each if they are given by themselves. */
const MARKERS = /\.(c3d|csv|trc)$/i;
const MCAP = /\.mcap(\.zstd?)?$/i;
/** Files of a recording that `ros2 bag record` split, beside the `metadata.yaml` that lists them. */
const SPLIT = /^(metadata\.yaml|(calibration|grippers)\.json|[^/]*\.mcap(\.zstd?)?)$/i;
/** What is read beside an MCAP file. */
const BESIDE_MCAP = /^(calibration|grippers)\.json$/;
/** Files of kinds that captures have, or that people take for captures. */
const OF_CAPTURES = /\.(json|pkl|npy|npz|png|jpe?g|csv|c3d|tsv|trc|mp4|avi|mkv|mov|bag|db3|glb|ply|obj|txt\.gz|exr|tiff?)$/i;
/** Documents that are larger are not looked into [bytes]. */
const DOCUMENT_BYTES = 64 * 2 ** 20;

/** A person's name for a capture, from the name of its file. */
export function nameOf(fileName: string): string {
  return asName(fileName.replace(ARCHIVE, '').replace(MARKERS, '') || fileName);
}

/** A text as a name that the server takes: without control characters, of 200 characters at most. */
function asName(text: string): string {
  return [...text.replace(/\p{Cc}/gu, ' ')].slice(0, 200).join('');
}

/**
 * The captures in a folder, `root` being its name: each with the files that the server's reader
 * reads of it, as docs/formats/capture.md lists them. Archives in it are separate captures. Of a
 * folder in which no capture is recognised all files are sent, for the server to say what is
 * missing, unless no file in it is of a kind that captures have.
 */
export async function packagesOf(root: string, given: readonly FolderFile[]): Promise<Package[]> {
  const files = given.filter(
    ({ path }) => !path.split('/').some((part) => part.startsWith('.') || part === '__MACOSX'),
  );
  files.sort((a, b) => (a.path < b.path ? -1 : 1));
  const captures = byFolder(files, captureFolders(files.map(({ path }) => path)));
  const packages: Package[] = [];
  for (const [folder, own] of captures.inside) {
    const read = await filesRead(own);
    const name = asName(folder.split('/').at(-2) ?? root);
    packages.push({ kind: 'folder', name, files: read, left: own.length - read.length, note: noteOf(own) });
  }
  const single = captures.outside.filter(({ path }) => ARCHIVE.test(path));
  for (const one of single) packages.push(await packageOfOne(one, captures.outside));
  if (packages.length > 0 || !files.some(({ path }) => OF_CAPTURES.test(path))) return packages;
  return [{ kind: 'folder', name: asName(root), files, left: 0, note: null }];
}

/** A file that is a capture; an MCAP file with the documents beside it, if there are some among `all`. */
async function packageOfOne({ path, file }: FolderFile, all: readonly FolderFile[]): Promise<Package> {
  const name = nameOf(file.name);
  const folder = path.slice(0, path.lastIndexOf('/') + 1);
  const around = all
    .filter((other) => MCAP.test(path) && other.path.startsWith(folder) && !ARCHIVE.test(other.path))
    .map((other) => ({ ...other, path: other.path.slice(folder.length) }));
  const documents = matching(around, BESIDE_MCAP);
  if (documents.length === 0) return { kind: 'file', name, file };
  // The folder may hold anything, so of a damaged document nothing is guessed.
  const beside = await named(around, [GRIPPERS], BESIDE_MCAP, documents);
  return { kind: 'folder', name, files: [...beside, { path: path.slice(folder.length), file }], left: 0, note: null };
}

/** A folder may have a recording twice: as tracked points, which are read, and as the images that they were made of. */
function noteOf(files: readonly FolderFile[]): string | null {
  const has = (pattern: RegExp): boolean => files.some(({ path }) => pattern.test(path));
  const isTwice = has(/^final_data\.pkl$/) && has(/^color\//) && !has(/^(recordings|capture)\.json$/);
  if (!isTwice) return null;
  return 'It has tracked points (final_data.pkl) and images: the points are used. Without that file the images are used.';
}

/** Files by the folder, of those given, that they lie in; their paths begin there. */
function byFolder(
  files: readonly FolderFile[],
  folders: readonly string[],
): { inside: Map<string, FolderFile[]>; outside: FolderFile[] } {
  const inside = new Map(folders.map((folder): [string, FolderFile[]] => [folder, []]));
  const outside: FolderFile[] = [];
  for (const { path, file } of files) {
    const folder = foldersOf(path).find((prefix) => inside.has(prefix));
    if (folder === undefined) outside.push({ path, file });
    else inside.get(folder)?.push({ path: path.slice(folder.length), file });
  }
  return { inside, outside };
}

/** The folders that a file lies in, as prefixes of its path, the outermost first. */
function foldersOf(path: string): string[] {
  const ends = [...path.matchAll(/\//g)].map(({ index }) => index + 1);
  return ['', ...ends.map((end) => path.slice(0, end))];
}

/** Folders with a capture, as prefixes of paths: the outermost ones, for a capture may have captures in it. */
function captureFolders(paths: readonly string[]): string[] {
  const found = new Set<string>();
  const withColor = new Set(paths.flatMap((path) => /^(?:.*\/)?(?=color\/)/.exec(path) ?? []));
  const withMcap = new Set(paths.flatMap((path) => /^(?:.*\/)?(?=[^/]*\.mcap(\.zstd?)?$)/i.exec(path)?.[0] ?? []));
  for (const path of paths) {
    const at = path.lastIndexOf('/') + 1;
    const [folder, name] = [path.slice(0, at), path.slice(at)];
    if (['recordings.json', 'capture.json', 'final_data.pkl', 'transforms.json'].includes(name)) found.add(folder);
    if (name === 'metadata.json' && withColor.has(folder)) found.add(folder);
    if (name === 'metadata.yaml' && withMcap.has(folder)) found.add(folder);
  }
  // In this order a folder follows right after those that it lies in, and after what else lies in them.
  const outermost: string[] = [];
  for (const folder of [...found].sort()) {
    const last = outermost.at(-1);
    if (last === undefined || !folder.startsWith(last)) outermost.push(folder);
  }
  return outermost;
}

/** The files of a capture's folder that are read. */
async function filesRead(files: readonly FolderFile[]): Promise<FolderFile[]> {
  const has = (name: string): boolean => files.some(({ path }) => path === name);
  if (has('recordings.json')) return severalRead(files);
  if (has('capture.json')) return named(files, ['capture.json', GRIPPERS], BUNDLE);
  if (has('final_data.pkl')) return matching(files, PROCESSED_CASE);
  if (has('metadata.json')) return matching(files, RAW_CASE).filter(({ path }) => !BESIDE_RAW_CASE.test(path));
  if (has('metadata.yaml')) return named(files, [GRIPPERS], SPLIT);
  if (has('transforms.json')) return named(files, ['transforms.json', GRIPPERS], NERFSTUDIO);
  return [...files];
}

/** Document of a robot's grippers, which may name arrays. */
const GRIPPERS = 'grippers.json';
/** Files that are read whether or not a document names them. */
const BUNDLE = /^(capture|calibration|grippers)\.json$|\.npy$/i;
const NERFSTUDIO = /^(transforms|calibration|grippers)\.json$/;
const PROCESSED_CASE = /^(final_data\.pkl|metadata\.json|split\.json|gt_track_3d\.pkl)$/;
/**
 * Kinds of files that the readers of raw cases read: masks and calibrations have many forms and places, and the
 * report names what was left out.
 */
const RAW_CASE = /\.(json|pkl|png|jpe?g|np[yz]|glb|ya?ml|xml|parquet)$/i;
/** What lies in PhysTwin's raw cases beside what is read. */
const BESIDE_RAW_CASE = /^(pcd\/|shape\/(?!(matching\/final_mesh|object)\.glb$))/i;

function matching(files: readonly FolderFile[], pattern: RegExp): FolderFile[] {
  return files.filter(({ path }) => pattern.test(path));
}

/** Several recordings: each folder as what it is by itself. */
async function severalRead(files: readonly FolderFile[]): Promise<FolderFile[]> {
  const read = files.filter(({ path }) => path === 'recordings.json');
  const folders = new Set(
    files.flatMap(({ path }) => (path.includes('/') ? [path.slice(0, path.indexOf('/') + 1)] : [])),
  );
  for (const folder of folders) {
    const own = files
      .filter(({ path }) => path.startsWith(folder))
      .map((f) => ({ ...f, path: f.path.slice(folder.length) }));
    read.push(...(await filesRead(own)).map((f) => ({ ...f, path: folder + f.path })));
  }
  return read;
}

/**
 * Files of a pattern, and those that documents name, literally or by `{frame}` or `{frame:06}`. Of the documents those
 * that are there count.
 */
async function named(
  files: readonly FolderFile[],
  documents: readonly string[],
  always: RegExp,
  ifDamaged = files,
): Promise<FolderFile[]> {
  const texts: string[] = [];
  for (const { file } of files.filter(({ path }) => documents.includes(path))) {
    const own = file.size > DOCUMENT_BYTES ? null : textsOf(await file.text());
    // The server says what is wrong with it.
    if (own === null) return [...ifDamaged];
    texts.push(...own);
  }
  const names = new Set(texts);
  const patterns = texts.filter((text) => text.includes('{frame')).map(patternOf);
  return files.filter(({ path }) => always.test(path) || names.has(path) || patterns.some((p) => p.test(path)));
}

function patternOf(text: string): RegExp {
  const parts = text.split(/\{frame(?::\d+)?\}/).map((part) => part.replace(/[^\w/]/g, '\\$&'));
  return new RegExp(`^${parts.join('\\d+')}$`);
}

/** All texts in a JSON document, as paths; null if the text is not JSON. */
function textsOf(json: string): string[] | null {
  const texts: string[] = [];
  try {
    JSON.parse(json.replace(/^\ufeff/, ''), (_key, value: unknown) => {
      if (typeof value === 'string')
        texts.push(
          value
            .split('/')
            .filter((part) => part !== '' && part !== '.')
            .join('/'),
        );
      return value;
    });
  } catch {
    return null;
  }
  return texts;
}
