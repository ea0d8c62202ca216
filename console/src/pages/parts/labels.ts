import type { PageContext } from '../../page';
import { h } from '../../ui/dom';
import { facts, field } from '../../ui/form';
import { problemBox } from '../../ui/problem';
import { readTags } from './tags';

/** A resource with labels: a capture, a fit or a twin. */
export interface Labelled extends Texts {
  readonly note: string;
  readonly tags: readonly string[];
  /** Owner of the key with which it was made; empty if unknown. */
  readonly owner: string;
}

/** Texts of one line that people state about a resource. */
export interface Texts {
  readonly display_name: string;
  /** Of captures. */
  readonly recorded_by?: string;
}

/** Those of an upload beside its name. */
export type OtherTexts = Partial<Omit<Texts, 'display_name'>>;

type List = 'captures' | 'fits' | 'twins';

const NAME = { key: 'display_name', label: 'Name' } as const;

/** The texts of each kind of resource: fields of the editor, and of the form of an upload. */
export const TEXTS: Readonly<Record<List, readonly { key: keyof Texts; label: string }[]>> = {
  captures: [NAME, { key: 'recorded_by', label: 'Recorded by' }],
  fits: [NAME],
  twins: [NAME],
};

/** Tags as links to the list with that tag. */
export function tagLinks(list: List, tags: readonly string[]): HTMLElement[] {
  return tags.map((tag) => h('a', { class: 'tag', href: `#/${list}?${new URLSearchParams({ tag })}` }, tag));
}

/** Texts, note and tags of a resource, with a form that changes them and its name. */
export class LabelEditor<T extends Labelled> {
  readonly element = h('section', { class: 'labels', 'aria-label': 'About' });
  #shown: T;

  constructor(
    private readonly context: PageContext,
    private readonly list: List,
    /** `/v1/twins/{uuid}`. */
    private readonly path: string,
    resource: T,
    /** Called with the resource after a change. */
    private readonly onChange: (resource: T) => void,
  ) {
    this.#shown = resource;
    this.show();
  }

  private show(focus = false): void {
    const { note, tags, owner } = this.#shown;
    const parts = [...TEXTS[this.list].map(({ label }) => label.toLowerCase()), 'note'].join(', ');
    const edit = h(
      'button',
      { type: 'button', class: 'small', onclick: () => this.edit() },
      `Edit ${parts} and tags`,
    );
    const stated = TEXTS[this.list].map(({ key, label }) => [key, label, this.#shown[key] ?? ''] as const);
    const about = [...stated, ['owner', 'Owner', owner] as const];
    const others = about.filter(([key, , text]) => key !== 'display_name' && text !== '');
    this.element.replaceChildren(
      others.length > 0 ? facts(others.map(([, label, text]) => [label, h('bdi', {}, text)])) : '',
      note !== '' ? h('p', { class: 'note' }, h('bdi', {}, note)) : '',
      h('div', { class: 'tags' }, ...tagLinks(this.list, tags), edit),
    );
    if (focus) edit.focus();
  }

  private edit(): void {
    const { note: text, tags } = this.#shown;
    const texts = TEXTS[this.list].map(({ key, label }) => {
      const input = h('input', { value: this.#shown[key] ?? '', maxlength: '200' });
      return { key, label, input };
    });
    const note = h('textarea', { rows: '4', maxlength: '10000' });
    note.value = text;
    const words = h('input', { value: tags.join(' '), spellcheck: 'false' });
    const fault = h('div');
    const save = h('button', { type: 'submit', class: 'primary' }, 'Save');
    const submit = async (event: Event): Promise<void> => {
      event.preventDefault();
      const read = readTags(words.value);
      if (read.faults.length > 0) return fault.replaceChildren(problemBox(new Error(read.faults.join(' '))));
      save.disabled = true;
      try {
        const stated = Object.fromEntries(texts.map(({ key, input }) => [key, input.value.trim()]));
        const change = { ...stated, note: note.value.trim(), tags: read.tags };
        this.#shown = await this.context.api.send<T>('PATCH', this.path, change, this.context.signal);
        this.onChange(this.#shown);
        this.show(true);
        this.context.announce('Saved');
      } catch (error) {
        if (!this.context.signal.aborted) fault.replaceChildren(problemBox(error));
        save.disabled = false;
      }
    };
    const form = h(
      'form',
      { class: 'card', onsubmit: (event) => void submit(event) },
      ...texts.map(({ label, input }) => field(label, input)),
      field('Note', note),
      field('Tags', words, 'Words, separated by spaces.'),
      fault,
      h('div', { class: 'buttons' }, save, h('button', { type: 'button', onclick: () => this.show(true) }, 'Cancel')),
    );
    form.addEventListener('keydown', (event) => event.key === 'Escape' && this.show(true));
    this.element.replaceChildren(form);
    texts[0]?.input.focus();
  }
}
