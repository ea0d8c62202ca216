import { h } from '../../ui/dom';
import { table } from '../../ui/table';
import { flat } from './settings';

/** A value for people; one that is left open follows effort, capture and device. */
export function settingWord(value: unknown): string {
  if (value === null || value === undefined) return 'open';
  return typeof value === 'string' ? value : JSON.stringify(value);
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
  return isChosen ? `${settingWord(chosen)} (chosen)` : settingWord(value);
}
