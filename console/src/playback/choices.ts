import { idOf, type Twin } from '@bendtwin/client';
import type { PageContext } from '../page';
import { h } from '../ui/dom';
import type { Quality } from '../pages/twins/quality';
import { errorText } from '../pages/twins/verdict/reasons';
import { moment } from '../ui/format';
import type { Head } from './file/head';

/** Twins to choose from. */
const MOST_TWINS = 100;
/** Stands for no twin in an address. */
export const NO_TWIN = 'none';

/** A list to choose from, with its label. */
export function choice(
  label: string,
  options: readonly (readonly [value: string, text: string])[],
  chosen: string,
  changed: (value: string) => void,
): HTMLElement {
  const select = h('select', {}, ...options.map(([value, text]) => {
    return h('option', { value, selected: value === chosen }, text);
  }));
  select.addEventListener('change', () => changed(select.value));
  return h('label', { class: 'playback-choice' }, h('span', {}, label), select);
}

/** The name of a sequence: that of its recording, and its own. */
export function sequenceText({ sequences }: Head, index: number): string {
  const { recording_name: recording = '', name = '' } = sequences[index] ?? {};
  return (recording === name || name === '' ? recording : `${recording}, ${name}`) || 'without a name';
}

/** Sequences to choose from; nothing where there is one. */
export function sequenceChoice(head: Head, chosen: number, changed: (index: number) => void): HTMLElement | null {
  if (head.sequences.length < 2) return null;
  const options = head.sequences.map((_, index) => [String(index), `${index + 1}: ${sequenceText(head, index)}`] as const);
  return choice('Sequence', options, String(chosen), (value) => changed(Number(value)));
}

/** Twins of a capture, the latest first. */
export async function twinsOf({ api, signal }: PageContext, capture: string): Promise<readonly Twin[]> {
  const query = { capture: `captures/${capture}`, page_size: MOST_TWINS };
  return (await api.get('/v1/twins', { query, signal })).twins;
}

/** The twin to begin with: what the address asks for, or else the twin with the least error; empty without one. */
export function firstTwin(asked: string | null, twins: readonly Pick<Twin, 'name' | 'error_m'>[]): string {
  if (asked !== null && asked !== '') return asked;
  const error = (twin: Pick<Twin, 'error_m'>): number => twin.error_m ?? Infinity;
  const [first, ...others] = twins;
  if (first === undefined) return '';
  return idOf(others.reduce((best, twin) => (error(twin) < error(best) ? twin : best), first).name);
}

/** Twins to choose from, and one more that the address names. */
export function twinChoice(twins: readonly Twin[], chosen: string, changed: (id: string) => void): HTMLElement {
  const known = twins.map(({ name, display_name, create_time, error_m, quality }) => {
    const error = error_m === null ? '' : `, ${errorText(quality as Quality)}`;
    return [idOf(name), `${display_name || 'without a name'}, ${moment(create_time)}${error}`] as const;
  });
  const isKnown = chosen === '' || chosen === NO_TWIN || known.some(([id]) => id === chosen);
  const other = isKnown ? [] : [[chosen, 'the twin of the address'] as const];
  const options = [[NO_TWIN, 'no twin'] as const, ...other, ...known];
  return choice('Prediction of', options, chosen || NO_TWIN, changed);
}
