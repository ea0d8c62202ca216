import { h, type Child } from '../../ui/dom';
import { table } from '../../ui/table';
import { flat } from './settings';
import { EXACT, settingWord } from './settings_view';

/** Most resources beside each other. */
export const MOST = 6;

/** Rows of a list that were chosen to be compared. They stay chosen on other pages of the list. */
export class Selection {
  readonly #chosen = new Set<string>();
  readonly button: HTMLAnchorElement;

  constructor(private readonly kind: 'fits' | 'twins') {
    this.button = h('a', { class: 'button', role: 'link' });
    this.update();
  }

  /** A box that chooses a row. */
  box(id: string, label: string): HTMLElement {
    const input = h('input', { type: 'checkbox', checked: this.#chosen.has(id), 'aria-label': `Compare ${label}` });
    input.addEventListener('change', () => {
      if (input.checked) this.#chosen.add(id);
      else this.#chosen.delete(id);
      this.update();
    });
    return input;
  }

  private update(): void {
    showComparison(this.button, this.kind, [...this.#chosen]);
  }
}

/** A link to the comparison of these resources, by their ids. */
export function compareLink(kind: 'fits' | 'twins', ids: readonly string[]): HTMLAnchorElement {
  const link = h('a', { class: 'button small', role: 'link' });
  showComparison(link, kind, ids);
  return link;
}

function showComparison(link: HTMLAnchorElement, kind: 'fits' | 'twins', ids: readonly string[]): void {
  const count = ids.length;
  const can = count >= 2 && count <= MOST;
  link.textContent = can ? `Compare ${count}` : `Compare (choose 2 to ${MOST})`;
  // A link without an address is one that cannot be followed.
  if (can) link.setAttribute('href', `#/${kind}/compare?ids=${ids.join(',')}`);
  else link.removeAttribute('href');
  link.setAttribute('aria-disabled', String(!can));
}

/** The ids in the address of a comparison, without repeats. */
export function comparedIds(query: URLSearchParams): string[] {
  return [...new Set((query.get('ids') ?? '').split(',').filter((id) => /^[0-9a-f-]{36}$/.test(id)))].slice(0, MOST);
}

/** A line of a comparison: what is compared, and the cell of each resource. */
export interface Line {
  readonly text: string;
  readonly cells: readonly Child[];
}

/** A line of numbers, of which some may be missing; the least is marked if they differ and `marksLeast`. */
export function numberLine(
  text: string,
  values: readonly (number | null | undefined)[],
  word: (value: number) => string,
  marksLeast: boolean,
): Line {
  const known = values.filter((value): value is number => typeof value === 'number');
  const least = marksLeast && new Set(known).size > 1 ? Math.min(...known) : null;
  const cell = (value: number | null | undefined): Child => {
    if (typeof value !== 'number') return '–';
    if (value !== least) return word(value);
    return h('strong', { class: 'best' }, word(value), h('span', { class: 'visually-hidden' }, ' (best)'));
  };
  return { text, cells: values.map(cell) };
}

/** Resources side by side: a column for each, with its name as the header, and a row for each line. */
export function compareTable(caption: string, names: readonly string[], lines: readonly Line[]): HTMLElement {
  return table<Line>({
    caption,
    rows: lines,
    columns: [
      { header: 'Property', cell: ({ text }) => text },
      ...names.map((header, index) => ({ header, cell: ({ cells }: Line) => cells[index] ?? '' })),
    ],
  });
}

/** Lines of the settings in which resources differ. */
export function differingSettings(all: readonly unknown[]): Line[] {
  const maps = all.map((settings) => new Map(settings === null ? [] : flat(settings)));
  const names = [...new Set(maps.flatMap((map) => [...map.keys()]))];
  return names.flatMap((text) => {
    const cells = (digits: number): string[] =>
      maps.map((map) => (map.has(text) ? settingWord(map.get(text), digits) : '–'));
    const count = new Set(cells(EXACT)).size;
    if (count === 1) return [];
    // Three digits, or as many as tell those that differ apart.
    const digits = [3, 4, 5, 6].find((some) => new Set(cells(some)).size === count) ?? EXACT;
    return [{ text, cells: cells(digits) }];
  });
}

/** Distinct names: those that several have are followed by a number. */
export function distinctNames(names: readonly string[]): string[] {
  const isTwice = (name: string): boolean => names.filter((other) => other === name).length > 1;
  return names.map((name, index) =>
    isTwice(name) ? `${name || 'without a name'} (${index + 1})` : name || 'without a name',
  );
}
