import { counted } from '../../../ui/format';
import type { Entry } from './entries';
import { rawSurvey, type Raw } from './raw';
import type { Note, Survey } from './survey';

/** Documents that are larger are not looked into [bytes]. */
const DOCUMENT_BYTES = 16 * 2 ** 20;

/** What the folder of a capture contains, paths beginning there. */
export async function describe(entries: readonly Entry[]): Promise<Survey> {
  const has = (name: string): boolean => entries.some(({ path }) => path === name);
  if (has('recordings.json')) return several(entries);
  if (has('capture.json')) return bundle(entries);
  if (has('final_data.pkl')) return processedCase(has('metadata.json'));
  if (has('transforms.json')) return nerfstudio(entries);
  return rawSurvey('Raw recording', await rawCase(entries), []);
}

/** Several recordings: each folder as what it is by itself. */
async function several(entries: readonly Entry[]): Promise<Survey> {
  const folders = [...new Set(entries.flatMap(({ path }) => (path.includes('/') ? [path.slice(0, path.indexOf('/') + 1)] : [])))];
  const all = await Promise.all(
    folders.map((folder) =>
      describe(entries.filter(({ path }) => path.startsWith(folder)).map((entry) => ({ ...entry, path: entry.path.slice(folder.length) }))),
    ),
  );
  const notes = all.flatMap((own, index) => own.notes.map(({ text }): Note => ({ text: `${folders[index]}: ${text}` })));
  const isComplete = all.length > 0 && all.every((own) => own.isComplete);
  return { format: 'Several recordings of one object', facts: [counted(folders.length, 'recording')], parts: [], notes, isComplete };
}

function processedCase(hasMetadata: boolean): Survey {
  const notes = hasMetadata ? [] : [{ text: 'No metadata.json, which states the frame rate: it is refused without.' }];
  return { format: 'Tracked points (PhysTwin case)', facts: [], parts: [], notes, isComplete: hasMetadata };
}

interface Bundle {
  readonly sequences?: readonly unknown[];
  readonly raw?: {
    readonly frame_count?: number;
    readonly cameras?: readonly {
      readonly pose?: unknown;
      readonly poses?: unknown;
      readonly color?: string;
      readonly depth?: { readonly files?: string };
      readonly masks?: { readonly object?: readonly string[] };
      readonly tracks?: unknown;
    }[];
    readonly mesh?: unknown;
  };
}

async function bundle(entries: readonly Entry[]): Promise<Survey> {
  const document = await json<Bundle>(entries, 'capture.json');
  if (document === null) return damaged('capture.json');
  const { raw, sequences } = document;
  if (raw === undefined) {
    const hasPoints = entries.some(({ path }) => /(^|\/)object_points\.npy$/.test(path));
    const notes = hasPoints ? [] : [{ text: 'No object_points.npy, which has the tracked points: it is refused without.' }];
    return { format: 'Tracked points', facts: [counted(sequences?.length ?? 0, 'sequence')], parts: [], notes, isComplete: hasPoints };
  }
  const cameras = raw.cameras ?? [];
  const paths = entries.map(({ path }) => path);
  const isThere = (pattern: string | undefined): boolean => pattern !== undefined && matching(paths, pattern).length > 0;
  const every = (test: (camera: (typeof cameras)[number]) => boolean): boolean => cameras.length > 0 && cameras.every(test);
  return rawSurvey(
    'Raw recording (bundle)',
    {
      cameras: cameras.length,
      frames: raw.frame_count ?? null,
      color: [...new Set(cameras.map(({ color = '' }) => endingOf(color)))],
      depth: every(({ depth }) => isThere(depth?.files)),
      masks: cameras.some(({ masks }) => (masks?.object ?? []).some(isThere)),
      calibration: paths.includes('calibration.json') || every(({ pose, poses }) => pose !== undefined || poses !== undefined),
      tracks: cameras.some(({ tracks }) => tracks !== undefined),
      mesh: raw.mesh !== undefined,
    },
    every(({ color }) => isThere(color)) ? [] : [{ text: 'The colour images that capture.json names are missing.' }],
  );
}

/** Files of a pattern with `{frame}` or `{frame:06}`. */
function matching(paths: readonly string[], pattern: string): string[] {
  const parts = pattern.split(/\{frame(?::\d+)?\}/).map((part) => part.replace(/[^\w/]/g, '\\$&'));
  const all = new RegExp(`^${parts.join('\\d+')}$`);
  return paths.filter((path) => all.test(path));
}

const COLOR = /^(?:(?:colou?r|rgb|images?)\/([^/]+)|([^/]+)\/(?:colou?r|rgb|images?))\/[^/]+\.(png|jpe?g)$/i;
const DEPTH = /^(?:depth[^/]*\/([^/]+)|([^/]+)\/depth[^/]*)\/[^/]+\.(npy|png)$/i;
const MASK = /^(?:[^/]+\/)?masks?\/.*\.(png|jpe?g|np[yz]|json)$/i;
const MASK_DOCUMENT = /(^|\/)(mask_info[^/]*|labels)\.json$/i;
const TRACKS = /^(?:cotracker\/|[^/]+\/tracks\.npz$)/i;

/** A raw case: a folder for each kind of image, and in it one for each camera, or the other way round. */
async function rawCase(entries: readonly Entry[]): Promise<Raw> {
  const paths = entries.map(({ path }) => path);
  const count = (pattern: RegExp): Map<string, number> => {
    const cameras = new Map<string, number>();
    for (const path of paths) {
      const found = pattern.exec(path);
      const camera = found?.[1] ?? found?.[2];
      if (camera !== undefined) cameras.set(camera, (cameras.get(camera) ?? 0) + 1);
    }
    return cameras;
  };
  const [color, depth] = [count(COLOR), count(DEPTH)];
  const metadata = await json<{ intrinsics?: readonly unknown[] }>(entries, 'metadata.json');
  return {
    cameras: Math.max(color.size, metadata?.intrinsics?.length ?? 0),
    frames: color.size > 0 ? Math.max(...color.values()) : 0,
    color: [...new Set(paths.filter((path) => COLOR.test(path)).map(endingOf))],
    depth: depth.size > 0 && depth.size >= color.size,
    masks: paths.some((path) => MASK.test(path) && !MASK_DOCUMENT.test(path)),
    calibration: paths.some((path) => /^(calibrate\.(pkl|json)|calibration\.json)$/.test(path)),
    tracks: paths.some((path) => TRACKS.test(path)),
    mesh: paths.some((path) => /^shape\/.*\.glb$/i.test(path)),
  };
}

interface Transforms {
  readonly frames?: readonly {
    readonly file_path?: string;
    readonly depth_file_path?: string;
    readonly mask_path?: string;
    readonly camera_label?: string | number;
  }[];
}

async function nerfstudio(entries: readonly Entry[]): Promise<Survey> {
  const document = await json<Transforms>(entries, 'transforms.json');
  if (document === null) return damaged('transforms.json');
  const frames = document.frames ?? [];
  const cameras = new Set(frames.map(({ camera_label: label, file_path = '' }) => String(label ?? file_path.replace(/[^/\\]*$/, ''))));
  const raw = {
    cameras: cameras.size,
    frames: cameras.size > 0 ? Math.ceil(frames.length / cameras.size) : 0,
    color: [...new Set(frames.map(({ file_path = '' }) => endingOf(file_path)))],
    depth: frames.some((frame) => frame.depth_file_path !== undefined),
    masks: frames.some((frame) => frame.mask_path !== undefined),
    // Each frame states its pose.
    calibration: true,
    tracks: false,
    mesh: false,
  };
  return rawSurvey('Raw recording (nerfstudio)', raw, []);
}

function damaged(name: string): Survey {
  return { format: 'Capture', facts: [], parts: [], notes: [{ text: `${name} cannot be read: it is no JSON.` }], isComplete: false };
}

/** The ending of a file's name, as `PNG`. */
function endingOf(path: string): string {
  const ending = path.slice(path.lastIndexOf('.') + 1).toUpperCase();
  return ending === 'JPG' ? 'JPEG' : ending;
}

/** A document; null if it is not there, too large, or no JSON object. */
async function json<T extends object>(entries: readonly Entry[], name: string): Promise<T | null> {
  const bytes = await entries.find(({ path }) => path === name)?.read(DOCUMENT_BYTES);
  if (bytes === undefined || bytes === null) return null;
  try {
    const value: unknown = JSON.parse(new TextDecoder().decode(bytes));
    return typeof value === 'object' && value !== null ? (value as T) : null;
  } catch {
    return null;
  }
}
