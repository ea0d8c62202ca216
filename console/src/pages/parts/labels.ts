import type { PageContext } from '../../page';
import { h } from '../../ui/dom';
import { field } from '../../ui/form';
import { problemBox } from '../../ui/problem';
import { readTags } from './tags';

/** A resource with labels: a capture, a fit or a twin. */
export interface Labelled {
  readonly display_name: string;
  readonly note: string;
  readonly tags: readonly string[];
}

/** Tags as links to the list with that tag. */
export function tagLinks(list: 'captures' | 'fits' | 'twins', tags: readonly string[]): HTMLElement[] {
  return tags.map((tag) => h('a', { class: 'tag', href: `#/${list}?${new URLSearchParams({ tag })}` }, tag));
}

/** Note and tags of a resource, with a form that changes them and its name. */
export class LabelEditor<T extends Labelled> {
  readonly element = h('section', { class: 'labels', 'aria-label': 'Note and tags' });
  #shown: T;

  constructor(
    private readonly context: PageContext,
    private readonly list: 'captures' | 'fits' | 'twins',
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
    const { note, tags } = this.#shown;
    const edit = h(
      'button',
      { type: 'button', class: 'small', onclick: () => this.edit() },
      'Edit name, note and tags',
    );
    this.element.replaceChildren(
      note !== '' ? h('p', { class: 'note' }, h('bdi', {}, note)) : '',
      h('div', { class: 'tags' }, ...tagLinks(this.list, tags), edit),
    );
    if (focus) edit.focus();
  }

  private edit(): void {
    const { display_name, note: text, tags } = this.#shown;
    const named = h('input', { value: display_name, maxlength: '200' });
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
        const change = { display_name: named.value.trim(), note: note.value.trim(), tags: read.tags };
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
      field('Name', named),
      field('Note', note),
      field('Tags', words, 'Words, separated by spaces.'),
      fault,
      h('div', { class: 'buttons' }, save, h('button', { type: 'button', onclick: () => this.show(true) }, 'Cancel')),
    );
    form.addEventListener('keydown', (event) => event.key === 'Escape' && this.show(true));
    this.element.replaceChildren(form);
    named.focus();
  }
}
