import { h } from '../../ui/dom';
import { significant } from '../../ui/format';
import { table } from '../../ui/table';
import { flat } from './settings';

/** Digits of the numbers of settings, which have single precision: no more of them mean anything. */
export const EXACT = 7;

/** A value for people, with its numbers rounded; one that is left open follows effort, capture and device. */
export function settingWord(value: unknown, digits?: number): string {
  if (value === null || value === undefined) return 'open';
  if (typeof value === 'string') return value;
  return JSON.stringify(value, (_, part: unknown) => (typeof part === 'number' ? Number(significant(part, digits)) : part));
}

/** Settings in force as a table that is folded away; `chosen` are those that became of open ones. */
export function settingsView(title: string, settings: unknown, chosen?: unknown): HTMLElement {
  const values = new Map(flat(chosen ?? {}));
  const rows = flat(settings);
  return h(
    'details',
    { class: 'card' },
    h('summary', {}, title),
    table({
      caption: title,
      hidesCaption: true,
      rows,
      columns: [
        { header: 'Setting', cell: ([name]) => h('code', {}, name) },
        { header: 'Value', cell: ([name, value]) => shown(value, values.get(name)) },
      ],
    }),
  );
}

function shown(value: unknown, chosen: unknown): string {
  const isChosen = value === null && chosen !== null && chosen !== undefined;
  return isChosen ? `${settingWord(chosen, EXACT)} (chosen)` : settingWord(value, EXACT);
}
