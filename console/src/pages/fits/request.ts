import { flat, put, readValue, type Settings } from '../parts/settings';
import { KNOWN_SETTINGS } from './known';

/** Fields of the form of a new fit, as typed. */
export interface FitForm {
  readonly effort: string;
  readonly within_s: string;
  readonly seed: string;
  readonly starts: string;
  readonly bending: boolean;
  readonly compareAxial: boolean;
  /** Any other settings: names with dots, and values as JSON or text. */
  readonly others: readonly (readonly [name: string, value: string])[];
}

/** Settings with separate fields in the form. */
const OWN = ['effort', 'within_s', 'seed', 'search.starts', 'bending', 'compare_axial'];

/**
 * The settings that a form asks for: those alone that differ from the defaults. Faults are by the
 * name of the setting, as those of the server are; everything else is the server's to judge.
 */
export function settingsOf(form: FitForm): { settings: Settings; faults: Map<string, string> } {
  const settings: Settings = {};
  const faults = new Map<string, string>();
  const set = (name: string, value: unknown): void => {
    if (!put(settings, name.split('.'), value)) faults.set(name, 'is given twice, or is a group and a value at once');
  };
  const number = (name: string, text: string): void => {
    if (text.trim() === '') return;
    const value = Number(text);
    if (!Number.isFinite(value)) faults.set(name, 'is not a number');
    else if (Number.isInteger(value) && !Number.isSafeInteger(value))
      faults.set(name, 'is too large for a browser: use the command line');
    else set(name, value);
  };
  if (form.effort !== 'standard') set('effort', form.effort);
  number('within_s', form.within_s);
  number('seed', form.seed);
  number('search.starts', form.starts);
  if (!form.bending) set('bending', false);
  if (form.compareAxial) set('compare_axial', true);
  for (const [name, value] of form.others) {
    if (name.trim() === '' && value.trim() === '') continue;
    if (name.trim() === '') faults.set('', 'A setting has a value but no name.');
    else if (value.trim() === '') faults.set(name.trim(), 'has no value');
    else set(name.trim(), readValue(value.trim()));
  }
  return { settings, faults };
}

/** Starts by effort, where they are left open: docs/use/settings.md, Effort. */
const STARTS: Record<string, number> = { draft: 1, standard: 2, best: 4 };
const LEAST_STARTS = 3;
const MOST_STARTS = 64;

/** The same form with twice as many starts, three at least. */
export function withMoreStarts(form: FitForm): FitForm {
  const known = Number(form.starts) || (STARTS[form.effort] ?? 1);
  return { ...form, starts: String(Math.min(Math.max(2 * known, LEAST_STARTS), MOST_STARTS)) };
}

/** The same form with this bound on nodes. */
export function withNodes(form: FitForm, nodes: number): FitForm {
  const others = form.others.filter(([name]) => name !== 'graph.max_nodes');
  return { ...form, others: [...others, ['graph.max_nodes', String(nodes)]] };
}

/** The form that gives these settings of a fit again. */
export function formOf(settings: unknown): FitForm {
  const values = new Map(flat(settings));
  const text = (name: string): string => {
    const value = values.get(name);
    return value === null || value === undefined ? '' : String(value);
  };
  const standards = new Map(KNOWN_SETTINGS.map(([name, standard]) => [name, standard]));
  const others = [...values].filter(([name, value]) => {
    const standard = standards.get(name);
    const isStandard =
      standard !== undefined && standard !== '' && JSON.stringify(JSON.parse(standard)) === JSON.stringify(value);
    return !OWN.includes(name) && !isStandard;
  });
  return {
    effort: text('effort') || 'standard',
    within_s: text('within_s'),
    seed: text('seed') === '0' ? '' : text('seed'),
    starts: text('search.starts'),
    bending: values.get('bending') !== false,
    compareAxial: values.get('compare_axial') === true,
    others: others.map(([name, value]) => [name, JSON.stringify(value)]),
  };
}
