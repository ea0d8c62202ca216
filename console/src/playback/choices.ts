import { idOf } from '../api/routes';
import type { PageContext } from '../page';
import { h } from '../ui/dom';
import { moment } from '../ui/format';
import type { Head } from './file/head';

/** Twins to choose from. */
const MOST_TWINS = 100;

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

/** Sequences to choose from; nothing where there is one. */
export function sequenceChoice(head: Head, chosen: number, changed: (index: number) => void): HTMLElement | null {
  if (head.sequences.length < 2) return null;
  const options = head.sequences.map(({ recording_name: recording, name }, index) => {
    const text = recording === name || name === '' ? recording : `${recording}, ${name}`;
    return [String(index), `${index + 1}: ${text || 'without a name'}`] as const;
  });
  return choice('Sequence', options, String(chosen), (value) => changed(Number(value)));
}

/** Twins of a capture to choose from, and one more that the address names. */
export async function twinChoice(
  context: PageContext,
  capture: string,
  chosen: string,
  changed: (id: string) => void,
): Promise<HTMLElement> {
  const { api, signal } = context;
  const query = { capture: `captures/${capture}`, page_size: MOST_TWINS };
  const { twins } = await api.get('/v1/twins', { query, signal });
  const known = twins.map((twin) => {
    return [idOf(twin.name), `${twin.display_name || 'without a name'}, ${moment(twin.create_time)}`] as const;
  });
  const isKnown = chosen === '' || known.some(([id]) => id === chosen);
  const other = isKnown ? [] : [[chosen, 'the twin of the address'] as const];
  return choice('Prediction of', [['', 'no twin'], ...other, ...known], chosen, changed);
}
