import type { PageContext } from '../../page';
import { h } from '../../ui/dom';
import { field } from '../../ui/form';
import { isolated } from './text';

/** Filters of a list: text, tag, and others by their names in the API's query. */
export interface Filters {
  readonly element: HTMLElement;
  /** The fields of the query that are filled in. */
  query(): Record<string, string>;
  /** What they let through, to stand behind a number of rows, as ` with state “failed”`; empty without any. */
  words(): string;
}

/** A choice among a few values: its name in the query, its label, and values with their words. */
export interface Choice {
  readonly name: string;
  readonly label: string;
  readonly values: readonly (readonly [string, string])[];
}

/** Pause after a key before the list is asked for [ms]. */
const PAUSE_MS = 250;

/** Filters above a list. They stand in the page's address, so that a link or the way back has them. */
export function filters(context: PageContext, choices: readonly Choice[], onChange: () => void): Filters {
  const search = h('input', { type: 'search', value: context.query.get('search') ?? '', maxlength: '200' });
  const tag = h('input', { value: context.query.get('tag') ?? '', spellcheck: 'false', maxlength: '50' });
  const selects = choices.map(({ name, values }) => {
    const options = values.map(([value, word]) =>
      h('option', { value, selected: context.query.get(name) === value }, word),
    );
    return [name, h('select', {}, ...options)] as const;
  });
  const query = (): Record<string, string> => {
    const all = [['search', search.value.trim()], ['tag', tag.value.trim()], ...selects.map(([n, s]) => [n, s.value])];
    return Object.fromEntries(all.filter(([, value]) => value !== ''));
  };
  let pause = 0;
  const change = (): void => {
    clearTimeout(pause);
    pause = window.setTimeout(() => {
      if (context.signal.aborted) return;
      const kept = [...context.query].filter(
        ([name]) => !['search', 'tag', ...choices.map((c) => c.name)].includes(name),
      );
      context.setQuery(new URLSearchParams([...kept, ...Object.entries(query())]));
      onChange();
    }, PAUSE_MS);
  };
  const element = h(
    'search',
    { class: 'controls' },
    field('Search in names and notes', search),
    field('Tag', tag),
    ...selects.map(([name, select]) => field(choices.find((c) => c.name === name)?.label ?? name, select)),
  );
  element.addEventListener('input', change);
  const words = (): string => filterWords(query(), choices);
  return { element, query, words };
}

/** Fields of a query in words: what rows have that match it. */
export function filterWords(query: Readonly<Record<string, string>>, choices: readonly Choice[]): string {
  const parts = Object.entries(query).map(([name, value]) => {
    if (name === 'search') return `“${isolated(value)}” in the name or note`;
    const choice = choices.find((own) => own.name === name);
    const word = choice?.values.find(([own]) => own === value)?.[1] ?? value;
    return `${(choice?.label ?? name).toLowerCase()} “${isolated(word)}”`;
  });
  return parts.length === 0 ? '' : ` with ${parts.join(', ')}`;
}
