import { sleep } from '@bendtwin/client';
import { h, type Child } from '../../ui/dom';
import { field } from '../../ui/form';
import { counted } from '../../ui/format';
import { textOf } from '../../ui/problem';
import './combobox.css';

/** Pause after a key before the server is asked [ms]. */
const PAUSE_MS = 200;

/** A thing to choose. */
export interface Option<Item> {
  readonly item: Item;
  readonly id: string;
  /** Its name, which stands in the field once it is chosen. */
  readonly text: string;
  /** What is shown in the list. */
  readonly content: Child;
  /** Why it cannot be chosen; null: it can. */
  readonly reason: string | null;
}

export interface ComboboxOptions<Item> {
  readonly label: string;
  /** What an option is, as `capture`. */
  readonly noun: string;
  /** Asks for the options that match a text; an empty text matches all. */
  readonly load: (text: string) => Promise<readonly Option<Item>[]>;
  /** Called with what was chosen, and with null when it is given up for another text. */
  readonly onChoose: (item: Item | null) => void;
  readonly signal: AbortSignal;
}

let comboboxes = 0;

/** A field with a list of what matches the text in it, by the pattern `combobox` of ARIA. */
export class Combobox<Item> {
  readonly element: HTMLElement;
  readonly #id = `combobox-${(comboboxes += 1)}`;
  readonly #input: HTMLInputElement;
  readonly #list: HTMLElement;
  readonly #status = h('p', { role: 'status', class: 'visually-hidden' });
  #options: readonly Option<Item>[] = [];
  #active = -1;
  #chosen: Option<Item> | null = null;
  #asked = 0;

  constructor(private readonly of: ComboboxOptions<Item>) {
    const { label, noun } = of;
    this.#list = h('ul', { id: `${this.#id}-list`, role: 'listbox', 'aria-label': label, class: 'combobox-list', hidden: true });
    this.#input = h('input', {
      role: 'combobox',
      'aria-expanded': 'false',
      'aria-controls': this.#list.id,
      'aria-autocomplete': 'list',
      autocomplete: 'off',
      spellcheck: 'false',
      required: true,
      placeholder: `Search for a ${noun}`,
    });
    this.#input.addEventListener('input', () => this.#typed());
    this.#input.addEventListener('focus', () => this.#input.select());
    this.#input.addEventListener('click', () => void this.#open(''));
    this.#input.addEventListener('keydown', (event) => this.#pressed(event));
    this.#input.addEventListener('blur', () => this.#close());
    // The field keeps the focus.
    this.#list.addEventListener('pointerdown', (event) => event.preventDefault());
    this.element = h('div', { class: 'combobox' }, field(label, this.#input), this.#list, this.#status);
  }

  get value(): Item | null {
    return this.#chosen?.item ?? null;
  }

  /** Chooses an option as if it had been clicked. */
  choose(option: Option<Item>): void {
    this.#chosen = option;
    this.#close();
    this.of.onChoose(option.item);
  }

  #typed(): void {
    if (this.#chosen !== null) this.of.onChoose(null);
    this.#chosen = null;
    this.#input.setCustomValidity(this.#input.value === '' ? '' : `Choose a ${this.of.noun} from the list.`);
    void this.#open(this.#input.value, PAUSE_MS);
  }

  async #open(text: string, pause = 0): Promise<void> {
    const mine = (this.#asked += 1);
    if (pause > 0) await sleep(pause, this.of.signal);
    if (mine !== this.#asked || this.of.signal.aborted) return;
    try {
      const options = await this.of.load(text.trim());
      if (mine !== this.#asked || this.of.signal.aborted || document.activeElement !== this.#input) return;
      this.#options = options;
      this.#show(options.length === 0 ? `No ${this.of.noun} matches.` : null);
      this.#status.textContent = counted(options.length, this.of.noun);
    } catch (error) {
      if (mine !== this.#asked || this.of.signal.aborted) return;
      this.#options = [];
      this.#show(textOf(error));
    }
  }

  /** Shows the options, or a text in their place. */
  #show(instead: string | null): void {
    const rows = this.#options.map((option, index) => {
      const choose = (): void => (option.reason === null ? this.choose(option) : undefined);
      return h(
        'li',
        {
          id: `${this.#id}-${index}`,
          role: 'option',
          'aria-selected': String(option.id === this.#chosen?.id),
          'aria-disabled': option.reason === null ? null : 'true',
          onclick: choose,
        },
        option.content,
      );
    });
    const none = h('li', { role: 'option', 'aria-disabled': 'true', class: 'muted' }, instead);
    this.#list.replaceChildren(...(instead === null ? rows : [none]));
    this.#list.hidden = false;
    this.#input.setAttribute('aria-expanded', 'true');
    this.#activate(-1);
  }

  /** Closes the list; what was typed goes, if something is chosen. */
  #close(): void {
    this.#asked += 1;
    this.#list.hidden = true;
    this.#input.setAttribute('aria-expanded', 'false');
    this.#input.removeAttribute('aria-activedescendant');
    this.#status.textContent = '';
    if (this.#chosen === null) return;
    this.#input.value = this.#chosen.text;
    this.#input.setCustomValidity('');
  }

  #activate(index: number): void {
    this.#active = index;
    [...this.#list.children].forEach((row, own) => row.classList.toggle('active', own === index));
    const row = this.#list.children[index];
    if (row === undefined) return this.#input.removeAttribute('aria-activedescendant');
    this.#input.setAttribute('aria-activedescendant', row.id);
    row.scrollIntoView({ block: 'nearest' });
  }

  #pressed(event: KeyboardEvent): void {
    const isOpen = !this.#list.hidden;
    const count = this.#options.length;
    if (event.key === 'ArrowDown' || event.key === 'ArrowUp') {
      event.preventDefault();
      if (!isOpen) void this.#open('');
      else if (count > 0) this.#activate(nextIndex(this.#active, count, event.key === 'ArrowDown' ? 1 : -1));
    } else if (event.key === 'Enter' && isOpen) {
      // Not the whole form is meant.
      event.preventDefault();
      const option = this.#options[this.#active];
      if (option?.reason === null) this.choose(option);
    } else if (event.key === 'Escape' && isOpen) {
      event.preventDefault();
      this.#close();
    }
  }
}

/** The next one of `count` options, -1 being none: after the last comes the first. */
export function nextIndex(index: number, count: number, by: 1 | -1): number {
  return index < 0 ? (by > 0 ? 0 : count - 1) : (index + by + count) % count;
}
