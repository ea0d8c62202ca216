import { idOf } from '@bendtwin/client';
import type { PageContext } from '../../page';
import { confirm, type Question } from '../../ui/dialog';
import { h, type Child } from '../../ui/dom';
import { field } from '../../ui/form';
import { counted } from '../../ui/format';
import { textOf } from '../../ui/problem';
import { readTags } from './tags';
import './selection.css';

/** A row that can be selected: `captures/{uuid}`, and its name for people. */
export interface Selectable {
  readonly name: string;
  readonly display_name: string;
}

export interface SelectionOptions {
  /** What a row is, as `capture`. */
  readonly noun: string;
  /** Words of the question before rows are deleted; may ask the server. */
  readonly question: (rows: readonly Selectable[]) => Promise<Pick<Question, 'title' | 'text'>> | Pick<Question, 'title' | 'text'>;
  /** Called after rows have changed, to load the list anew. */
  readonly onChange: () => void;
  /** Further actions beside those of all lists, for the rows that are selected, as a link that compares them. */
  readonly actions?: (rows: readonly Selectable[]) => Child;
}

/**
 * Rows of a list that are selected together, and the bar of what can be done with them: add tags, delete. They stay
 * selected on other pages of the list. The bar is there while any is selected.
 */
export class MultiSelection {
  readonly element = h('section', { class: 'selection', 'aria-label': 'Selection', hidden: true });
  readonly #rows = new Map<string, Selectable>();
  readonly #boxes = new Map<string, HTMLInputElement>();
  readonly #count = h('strong', { role: 'status' });
  readonly #actions = h('span', { class: 'selection-actions' });
  readonly #form = h('div', { class: 'selection-form' });
  readonly #faults = h('div');
  readonly #buttons: HTMLButtonElement[];

  constructor(
    private readonly context: PageContext,
    private readonly options: SelectionOptions,
  ) {
    this.#buttons = [
      h('button', { type: 'button', class: 'small', onclick: () => this.#askTags() }, 'Add tags'),
      h('button', { type: 'button', class: 'small danger', onclick: () => void this.#delete() }, 'Delete'),
      h('button', { type: 'button', class: 'small', onclick: () => this.clear() }, 'Clear the selection'),
    ];
    this.element.append(
      h('div', { class: 'selection-row' }, this.#count, this.#actions, ...this.#buttons),
      this.#form,
      this.#faults,
    );
  }

  /** A box that selects a row. */
  box(row: Selectable): HTMLElement {
    const label = `Select ${row.display_name || 'one without a name'}`;
    const input = h('input', { type: 'checkbox', checked: this.#rows.has(row.name), 'aria-label': label });
    input.addEventListener('change', () => {
      if (input.checked) this.#rows.set(row.name, row);
      else this.#rows.delete(row.name);
      this.#update();
    });
    this.#boxes.set(row.name, input);
    return input;
  }

  clear(): void {
    this.#rows.clear();
    for (const box of this.#boxes.values()) box.checked = false;
    this.#faults.replaceChildren();
    this.#update();
  }

  #update(): void {
    const rows = [...this.#rows.values()];
    this.element.hidden = rows.length === 0;
    this.#count.textContent = `${counted(rows.length, this.options.noun)} selected`;
    const actions = this.options.actions?.(rows);
    this.#actions.replaceChildren(h('span', {}, actions));
    if (rows.length === 0) this.#form.replaceChildren();
  }

  async #delete(): Promise<void> {
    const rows = [...this.#rows.values()];
    const { api, signal } = this.context;
    await this.#each(rows, 'moved to the trash', async () => {
      const question = await this.options.question(rows);
      if (!(await confirm({ ...question, action: 'Delete', isDangerous: true }))) return null;
      return async ({ name }) => void (await api.fetch(`/v1/${name}`, { method: 'DELETE', signal }));
    });
  }

  /** Shows the form of tags, or takes it away. */
  #askTags(): void {
    if (this.#form.childElementCount > 0) return this.#form.replaceChildren();
    const input = h('input', { spellcheck: 'false', required: true });
    const submit = (event: Event): void => {
      event.preventDefault();
      const { tags, faults } = readTags(input.value);
      if (faults.length > 0) return this.#tell(faults);
      const { api, signal } = this.context;
      void this.#each([...this.#rows.values()], 'tagged', () =>
        Promise.resolve(async ({ name }) => void (await api.send('PATCH', `/v1/${name}`, { add_tags: tags }, signal))),
      );
    };
    const form = h(
      'form',
      { class: 'selection-row', onsubmit: submit },
      field('Tags to add', input, 'Words, separated by spaces.'),
      h('button', { type: 'submit', class: 'primary' }, 'Add'),
    );
    form.addEventListener('keydown', (event) => event.key === 'Escape' && this.#form.replaceChildren());
    this.#form.replaceChildren(form);
    input.focus();
  }

  /** Does something with each row, once it is known what. Those that refuse it stay selected, and say why. */
  async #each(
    rows: readonly Selectable[],
    done: string,
    prepare: () => Promise<((row: Selectable) => Promise<void>) | null>,
  ): Promise<void> {
    const { signal, announce } = this.context;
    this.#buttons.forEach((button) => (button.disabled = true));
    this.#faults.replaceChildren();
    const faults: string[] = [];
    try {
      const act = await prepare();
      for (const row of act === null ? [] : rows) {
        try {
          await act?.(row);
          this.#rows.delete(row.name);
        } catch (error) {
          faults.push(`${row.display_name || idOf(row.name)}: ${textOf(error)}`);
        }
        if (signal.aborted) return;
      }
      if (act !== null) {
        announce(`${counted(rows.length - faults.length, this.options.noun)} ${done}`);
        this.#form.replaceChildren();
        this.options.onChange();
      }
    } catch (error) {
      faults.push(textOf(error));
    }
    this.#buttons.forEach((button) => (button.disabled = false));
    for (const [name, box] of this.#boxes) box.checked = this.#rows.has(name);
    this.#update();
    if (faults.length > 0) this.#tell(faults);
  }

  #tell(faults: readonly string[]): void {
    this.#faults.replaceChildren(
      h('div', { class: 'problem', role: 'alert' }, ...faults.map((text) => h('p', {}, h('bdi', {}, text)))),
    );
  }
}
