import type { Api } from '../../api/client';
import type { Twin } from '../../api/types';
import { idOf } from '../../api/routes';
import { textOf } from '../../ui/problem';
import type { Labels } from './kept';
import { nameOf, type Package } from './select';
import { contentOf, refusal } from './sniff';
import { Transfers } from './transfers';
import { packagesOfDrop, packagesOfFiles } from './tree';

/** Options for the next files. */
export interface Options {
  readonly labels: Labels;
  /** Settings of the ingest as JSON, or empty. */
  readonly ingest: string;
}

const NOTHING_READ =
  'It contains no capture: it has none of the files of a capture, such as capture.json, metadata.json or final_data.pkl.';

/** Event `said` with a sentence about files that were not taken. */
class Intake extends EventTarget {
  options: Options = { labels: { name: '', texts: {}, note: '', tags: [] }, ingest: '' };
  sentences: readonly string[] = [];
  /** Number of drops whose files are being looked through. */
  busy = 0;

  say(sentences: readonly string[]): void {
    this.sentences = sentences;
    this.dispatchEvent(new Event('said'));
  }

  /** Notes that files are looked through, and, with -1, that they no longer are. */
  look(by: 1 | -1): void {
    this.busy += by;
    this.dispatchEvent(new Event('said'));
  }
}

/** Where files are taken in, on any page. */
export const intake = new Intake();

const ALL = new WeakMap<Api, Transfers>();

/** The uploads of this page of the browser. */
export function transfersOf(api: Api): Transfers {
  const known = ALL.get(api) ?? new Transfers(api);
  ALL.set(api, known);
  return known;
}

/** Uploads what was dropped or chosen, and goes to where that is seen. Twins are imported. */
export function take(api: Api, given: DataTransfer | readonly File[]): void {
  // What was dropped can be asked for only now; that it was read comes later.
  const packages = given instanceof DataTransfer ? packagesOfDrop(given) : packagesOfFiles(given);
  intake.look(1);
  location.hash = '#/upload';
  void packages
    .then((all) => takeAll(api, all))
    .catch((error: unknown) => intake.say([textOf(error)]))
    .finally(() => intake.look(-1));
}

async function takeAll(api: Api, packages: readonly Package[]): Promise<void> {
  const sentences: string[] = packages.length === 0 ? [NOTHING_READ] : [];
  const { labels, ingest } = intake.options;
  for (const source of packages) {
    const content = source.kind === 'folder' ? 'capture' : await contentOf(source.file);
    const refused = refusal(source.kind === 'file' ? source.file.name : source.name, content);
    if (refused !== null) sentences.push(refused);
    else if (content === 'twin' && source.kind === 'file') sentences.push(...(await importTwin(api, source.file)));
    else {
      // A name that was given is that of one.
      const name = packages.length === 1 && labels.name !== '' ? labels.name : source.name;
      transfersOf(api).add(source, { ...labels, name }, ingest);
    }
  }
  intake.say(sentences);
}

/** Imports the file of a twin and goes to it; else what is wrong, in a sentence. */
async function importTwin(api: Api, file: File): Promise<string[]> {
  const name = nameOf(file.name.replace(/\.safetensors$/i, ''));
  try {
    const twin = await api.json<Twin>(`/v1/twins?${new URLSearchParams({ display_name: name })}`, {
      method: 'POST',
      headers: { 'content-type': 'application/octet-stream' },
      body: file,
    });
    location.hash = `#/twins/${idOf(twin.name)}`;
    return [];
  } catch (error) {
    return [`${file.name}: ${textOf(error)}`];
  }
}
