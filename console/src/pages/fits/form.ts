import { h, type Child } from '../../ui/dom';
import { field } from '../../ui/form';
import { prose } from '../parts/text';
import { KNOWN_SETTINGS } from './known';
import type { FitForm } from './request';

const EFFORTS: readonly (readonly [string, string, string])[] = [
  ['draft', 'Draft', 'a first look: few nodes, short search'],
  ['standard', 'Standard', 'good for most objects'],
  ['best', 'Best', 'several times longer, for a twin to plan with'],
];

/** The fields of a fit's settings, and places for what is wrong with each. */
export class SettingsForm {
  readonly element: HTMLElement;
  readonly #efforts: readonly HTMLInputElement[];
  readonly #within: HTMLInputElement;
  readonly #seed: HTMLInputElement;
  readonly #starts: HTMLInputElement;
  readonly #bending: HTMLInputElement;
  readonly #axial: HTMLInputElement;
  readonly #rows = h('div', { class: 'setting-rows' });
  readonly #faults = new Map<string, HTMLElement>();
  #count = 0;

  constructor(form: FitForm) {
    const number = (value: string, attributes = {}): HTMLInputElement =>
      h('input', { inputmode: 'decimal', value, ...attributes });
    this.#efforts = EFFORTS.map(([value]) =>
      h('input', { type: 'radio', name: 'effort', value, checked: form.effort === value }),
    );
    this.#within = number(form.within_s, { placeholder: 'no limit' });
    this.#seed = number(form.seed, { placeholder: '0' });
    this.#starts = number(form.starts, { placeholder: 'by effort' });
    this.#bending = h('input', { type: 'checkbox', checked: form.bending });
    this.#axial = h('input', { type: 'checkbox', checked: form.compareAxial });
    const names = KNOWN_SETTINGS.map(([name]) => h('option', { value: name }));
    this.element = h(
      'div',
      {},
      this.efforts(),
      h(
        'div',
        { class: 'field-row' },
        this.own('within_s', 'Finish within [s]', this.#within),
        this.own('search.starts', 'Starts', this.#starts, 'More make a twin less dependent on chance.'),
        this.own('seed', 'Seed', this.#seed),
      ),
      this.checkbox('bending', this.#bending, 'Bending: springs alone do not resist being folded'),
      this.checkbox('compare_axial', this.#axial, 'Compare with axial springs alone (takes about twice as long)'),
      h('datalist', { id: 'known-settings' }, ...names),
      h('fieldset', {}, h('legend', {}, 'Other settings'), this.#rows, this.adder()),
    );
    for (const [name, value] of form.others) this.addRow(name, value);
  }

  /** The fields as typed. */
  get value(): FitForm {
    return {
      effort: this.#efforts.find(({ checked }) => checked)?.value ?? 'standard',
      within_s: this.#within.value,
      seed: this.#seed.value,
      starts: this.#starts.value,
      bending: this.#bending.checked,
      compareAxial: this.#axial.checked,
      others: this.rows().map(({ name, value }) => [name.value, value.value]),
    };
  }

  /** Shows faults at their fields, and returns those without a field. */
  show(faults: ReadonlyMap<string, string>): string[] {
    const places = new Map(this.#faults);
    for (const { name, fault } of this.rows()) places.set(name.value.trim(), fault);
    for (const place of [...this.#faults.values(), ...this.rows().map(({ fault }) => fault)]) mark(place, '');
    const rest: string[] = [];
    for (const [name, text] of faults) {
      const place = places.get(name) ?? [...places].find(([own]) => own !== '' && own.startsWith(`${name}.`))?.[1];
      if (place === undefined) rest.push(name === '' || text.startsWith(name) ? text : `${name}: ${text}`);
      else mark(place, text);
    }
    this.element.querySelector<HTMLElement>('[aria-invalid=true]')?.focus();
    return rest;
  }

  private efforts(): HTMLElement {
    const choices = EFFORTS.map(([, word, text], index) => {
      return h(
        'label',
        { class: 'choice' },
        this.#efforts[index] ?? '',
        h('span', {}, h('strong', {}, word), ` – ${text}`),
      );
    });
    return h('fieldset', {}, h('legend', {}, 'Effort'), ...choices, this.place('effort'));
  }

  private own(name: string, label: string, input: HTMLInputElement, hint?: Child): HTMLElement {
    const element = field(label, input, hint);
    element.append(this.place(name));
    return element;
  }

  private checkbox(name: string, input: HTMLInputElement, text: string): HTMLElement {
    return h('div', { class: 'field' }, h('label', { class: 'choice' }, input, h('span', {}, text)), this.place(name));
  }

  private place(name: string): HTMLElement {
    const place = h('p', { class: 'fault' });
    this.#faults.set(name, place);
    return place;
  }

  private adder(): HTMLElement {
    const add = (): void => this.addRow('', '').focus();
    return h('button', { type: 'button', class: 'small', onclick: add }, 'Add a setting');
  }

  private addRow(name: string, value: string): HTMLInputElement {
    this.#count += 1;
    const label = `Setting ${this.#count}`;
    const named = h('input', {
      value: name,
      list: 'known-settings',
      spellcheck: 'false',
      'aria-label': `${label}, name`,
      class: 'code',
      placeholder: 'graph.max_nodes',
    });
    const given = h('input', {
      value,
      spellcheck: 'false',
      'aria-label': `${label}, value`,
      class: 'code',
      placeholder: '400',
    });
    const hint = h('p', { class: 'hint' });
    const explain = (): void => ((hint.textContent = explanation(named.value.trim())), undefined);
    named.addEventListener('input', explain);
    explain();
    const row = h('div', { class: 'setting-row' });
    const remove = h(
      'button',
      { type: 'button', class: 'small', 'aria-label': `Remove ${label.toLowerCase()}`, onclick: () => row.remove() },
      'Remove',
    );
    row.append(named, h('span', { 'aria-hidden': 'true' }, '='), given, remove, hint, h('p', { class: 'fault' }));
    this.#rows.append(row);
    return named;
  }

  private rows(): { name: HTMLInputElement; value: HTMLInputElement; fault: HTMLElement }[] {
    return [...this.#rows.children].flatMap((row) => {
      const [name, value] = row.querySelectorAll('input');
      const fault = row.querySelector<HTMLElement>('.fault');
      return name === undefined || value === undefined || fault === null ? [] : [{ name, value, fault }];
    });
  }
}

/** Shows a fault at a place, and announces it to screen readers at the field beside it. */
function mark(place: HTMLElement, text: string): void {
  place.replaceChildren(...(text === '' ? [] : [prose(text)]));
  place.setAttribute('role', 'alert');
  for (const input of place.parentElement?.querySelectorAll('input') ?? []) {
    if (text === '') input.removeAttribute('aria-invalid');
    else input.setAttribute('aria-invalid', 'true');
  }
}

/** Meaning and values of a setting. */
function explanation(wanted: string): string {
  const known = KNOWN_SETTINGS.find(([name]) => name === wanted);
  if (known === undefined) return '';
  const [, standard, allowed, meaning] = known;
  const without =
    standard === 'null'
      ? 'left open if not given'
      : standard === ''
        ? ''
        : `${standard.replaceAll('"', '')} if not given`;
  return `${meaning} ${[allowed, without].filter((part) => part !== '').join('; ')}.`;
}
