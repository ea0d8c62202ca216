import type { Entry } from './entries';
import { describe } from './layouts';

/** Something that is missing or odd, with the section of the guide that helps, if there is one. */
export interface Note {
  readonly text: string;
  readonly section?: string;
}

/** What was found in files before they are sent. */
export interface Survey {
  /** The form of the recording, as `Raw recording`. */
  readonly format: string;
  /** Numbers and forms, as `3 cameras`. */
  readonly facts: readonly string[];
  /** Parts of a recording, and whether each was found. */
  readonly parts: readonly (readonly [name: string, isThere: boolean])[];
  readonly notes: readonly Note[];
  /** True if nothing that a fit needs is missing: it is sent without a question. */
  readonly isComplete: boolean;
}

/** A survey of something that was recognised, but not looked into. */
export function closed(format: string, note: string, isComplete = false): Survey {
  return { format, facts: [], parts: [], notes: note === '' ? [] : [{ text: note }], isComplete };
}

/** Files by which the folder of a capture is known, in the order of docs/formats/capture.md. */
const MARKS = ['recordings.json', 'capture.json', 'final_data.pkl', 'transforms.json', 'metadata.json'];
const MCAP = /\.mcap(\.zstd?)?$/i;

/** What the files of a folder or an archive are; `isWhole` is false if only its beginning is known. */
export async function surveyOf(all: readonly Entry[], isWhole: boolean): Promise<Survey> {
  const entries = all.filter(({ path }) => !path.split('/').some((part) => part.startsWith('.') || part === '__MACOSX'));
  const roots = rootsOf(entries.map(({ path }) => path));
  const [root] = roots;
  if (roots.length > 1) {
    const text = `It contains ${roots.length} captures: unpack it and drop the folder, then each is uploaded as a capture.`;
    return closed('Several captures', text);
  }
  if (root !== undefined) {
    const own = entries.filter(({ path }) => path.startsWith(root)).map((entry) => ({ ...entry, path: entry.path.slice(root.length) }));
    const survey = await describe(own);
    return isWhole ? survey : partly(survey);
  }
  if (entries.some(({ path }) => MCAP.test(path))) return closed('MCAP recording', 'Its topics are looked at after the upload.');
  if (!isWhole) return closed('Archive', 'Its beginning does not say what it contains.');
  const found = 'none of capture.json, metadata.json, final_data.pkl and transforms.json';
  return closed('Not recognised', `It has ${found}: the server will say what it needs.`);
}

/** Of a part nothing is known to be missing. */
function partly(survey: Survey): Survey {
  if (survey.isComplete) return survey;
  const parts = survey.parts.filter(([, isThere]) => isThere);
  return { ...survey, facts: [], parts, notes: [{ text: 'Only the beginning of this archive could be looked into.' }] };
}

/** The outermost folders with a capture, as prefixes of paths. */
function rootsOf(paths: readonly string[]): string[] {
  const folders = new Set(
    paths.flatMap((path) => {
      const at = path.lastIndexOf('/') + 1;
      return MARKS.includes(path.slice(at)) ? [path.slice(0, at)] : [];
    }),
  );
  // In this order a folder follows those that it lies in.
  const roots: string[] = [];
  for (const folder of [...folders].sort()) if (!roots.some((root) => folder.startsWith(root))) roots.push(folder);
  return roots;
}
