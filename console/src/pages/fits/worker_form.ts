import type { Worker } from '@bendtwin/client';
import { h } from '../../ui/dom';
import { field } from '../../ui/form';
import { counted } from '../../ui/format';
import { backendWord, satisfies, wanted, type Requirements } from '../parts/requirements';

const GIB = 2 ** 30;

/** The fields of the worker that a fit asks for. They offer what the registered workers have. */
export class WorkerForm {
  readonly element: HTMLDetailsElement;
  readonly #backend: HTMLSelectElement;
  readonly #memory: HTMLInputElement;
  readonly #labels: readonly HTMLInputElement[];
  readonly #others = h('input', { spellcheck: 'false', placeholder: 'gpu=h100, lab=2' });
  readonly #fault = h('p', { class: 'fault', role: 'alert' });
  readonly #found = h('p', { class: 'hint', role: 'status' });

  constructor(
    private readonly workers: readonly Worker[],
    asked: Requirements,
  ) {
    const backends = sorted([...workers.map(({ backend }) => backend), asked.backend]);
    this.#backend = h(
      'select',
      {},
      h('option', { value: '' }, 'Any'),
      ...backends.map((value) => h('option', { value, selected: value === asked.backend }, backendWord(value))),
    );
    this.#memory = h('input', {
      inputmode: 'decimal',
      list: 'worker-memory',
      placeholder: 'any',
      value: asked.memory_bytes > 0 ? String(asked.memory_bytes / GIB) : '',
    });
    const sizes = sorted(workers.map((worker) => String(Math.floor((worker.memory_total_bytes ?? 0) / GIB))));
    this.#labels = sorted([...workers.flatMap(({ labels }) => labels), ...asked.labels]).map((value) =>
      h('input', { type: 'checkbox', value, checked: asked.labels.includes(value) }),
    );
    const memory = field('Least device memory [GiB]', this.#memory);
    memory.append(this.#fault);
    const hint = 'Labels that the worker must have (--label), separated by commas.';
    this.element = h(
      'details',
      { class: 'card', open: wanted(asked) !== 'any', oninput: () => this.tell() },
      h('summary', {}, 'Worker'),
      h(
        'datalist',
        { id: 'worker-memory' },
        ...sizes.filter((size) => size !== '0').map((value) => h('option', { value })),
      ),
      h('div', { class: 'field-row' }, field('Kind', this.#backend), memory),
      ...this.offered(),
      field(this.#labels.length > 0 ? 'Other labels' : 'Labels', this.#others, hint),
      this.#found,
    );
    this.tell();
  }

  /** The chosen requirements; null if they are invalid, which is shown then. */
  get value(): Requirements | null {
    const text = this.#memory.value.trim();
    const memory = Math.ceil(Number(text) * GIB);
    if (!Number.isSafeInteger(memory) || memory < 0) return null;
    const others = this.#others.value.split(',').map((label) => label.trim());
    const ticked = this.#labels.filter(({ checked }) => checked).map(({ value }) => value);
    return { backend: this.#backend.value, memory_bytes: memory, labels: sorted([...ticked, ...others]) };
  }

  /** Goes to what is wrong. */
  focus(): void {
    this.element.open = true;
    this.#memory.focus();
  }

  private offered(): HTMLElement[] {
    if (this.#labels.length === 0) return [];
    const choices = this.#labels.map((box) => h('label', { class: 'choice' }, box, h('bdi', {}, box.value)));
    return [h('fieldset', {}, h('legend', {}, 'Labels'), ...choices)];
  }

  /** Says how many workers there are of the kind that is asked for. */
  private tell(): void {
    const asked = this.value;
    this.#fault.textContent = asked === null ? 'is not a size' : '';
    if (asked === null) this.#memory.setAttribute('aria-invalid', 'true');
    else this.#memory.removeAttribute('aria-invalid');
    const found = this.workers.filter((one) => asked !== null && !one.draining && satisfies(one, asked)).length;
    const all = counted(this.workers.length, 'worker');
    const some = `${found} of ${all} can take the fit.`;
    const none = `None of ${all} can take the fit: it waits for one that can.`;
    this.#found.textContent = asked === null ? '' : found > 0 ? some : none;
  }
}

/** Each text once, in order, without empty ones. */
function sorted(texts: readonly string[]): string[] {
  return [...new Set(texts)].filter((text) => text !== '').sort();
}
