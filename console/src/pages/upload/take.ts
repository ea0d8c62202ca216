import { idOf, type Twin } from '@bendtwin/client';
import type { Api } from '../../api/client';
import { textOf } from '../../ui/problem';
import { Intake, type Offer } from './intake';
import { nameOf, type Package } from './select';
import { contentOf, kindOf, refusal } from './sniff';
import type { Survey } from './survey/survey';
import { Transfers, fingerprintOfPackage } from './transfers';
import { packagesOfDrop, packagesOfFiles } from './tree';

const NOTHING_READ =
  'It contains no capture: it has none of the files of a capture, such as capture.json, metadata.json or final_data.pkl.';

/** Where files are taken in, on any page. */
export const intake = new Intake();

const ALL = new WeakMap<Api, Transfers>();

/** The uploads of this page of the browser. */
export function transfersOf(api: Api): Transfers {
  const known = ALL.get(api) ?? new Transfers(api);
  ALL.set(api, known);
  return known;
}

/** Surveys of what is sent. */
const SURVEYS = new WeakMap<Package, Survey>();

/** What was found in files before they were sent; null if they were not looked into. */
export function surveyed(source: Package): Survey | null {
  return SURVEYS.get(source) ?? null;
}

/**
 * Takes what was dropped or chosen, and goes to where that is seen. Twins are imported, complete captures and those
 * whose upload was begun before are uploaded; of others a person sees first what was found in them.
 */
export function take(api: Api, given: DataTransfer | readonly File[]): void {
  // What was dropped can be asked for only now; that it was read comes later.
  const packages = given instanceof DataTransfer ? packagesOfDrop(given) : packagesOfFiles(given);
  intake.look(1);
  location.hash = '#/upload';
  void packages
    .then((all) => takeAll(api, all))
    .catch((error: unknown) => intake.refuse(textOf(error)))
    .finally(() => intake.look(-1));
}

async function takeAll(api: Api, packages: readonly Package[]): Promise<void> {
  if (packages.length === 0) intake.refuse(NOTHING_READ);
  // Fetched when it is needed: files can be dropped on any page.
  const { look } = await import('./survey/look');
  for (const source of packages) {
    try {
      await takeOne(api, source, packages.length === 1, look);
    } catch (error) {
      // The others are taken all the same.
      intake.refuse(`${source.kind === 'file' ? source.file.name : source.name}: ${textOf(error)}`);
    }
  }
}

async function takeOne(api: Api, source: Package, isOnly: boolean, look: (source: Package) => Promise<Survey>): Promise<void> {
  const content = source.kind === 'folder' ? 'capture' : await contentOf(source.file);
  if (source.kind === 'file' && content !== 'capture') {
    if (content === 'twin') return importTwin(api, source.file);
    return intake.refuse(refusal(source.file.name, content, await kindOf(source.file)) ?? '');
  }
  const survey = await look(source);
  SURVEYS.set(source, survey);
  const offer = { files: fingerprintOfPackage(source), source, survey, isOnly };
  if (survey.isComplete || transfersOf(api).wasBegun(source)) send(api, offer);
  else intake.offer(offer);
}

/** Uploads what was offered, with the labels that are given now. */
export function accept(api: Api, offer: Offer): void {
  intake.dismiss(offer.id);
  send(api, offer);
}

function send(api: Api, { source, isOnly }: Pick<Offer, 'source' | 'isOnly'>): void {
  const { labels, ingest } = intake.options;
  // A name that was given is that of one.
  const name = isOnly && labels.name !== '' ? labels.name : source.name;
  transfersOf(api).add(source, { ...labels, name }, ingest);
}

/** Imports the file of a twin and goes to it. */
async function importTwin(api: Api, file: File): Promise<void> {
  const name = nameOf(file.name.replace(/\.safetensors$/i, ''));
  const twin = await api.json<Twin>(`/v1/twins?${new URLSearchParams({ display_name: name })}`, {
    method: 'POST',
    headers: { 'content-type': 'application/octet-stream' },
    body: file,
  });
  location.hash = `#/twins/${idOf(twin.name)}`;
}
