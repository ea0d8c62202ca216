import type { Capture, Supplement } from '@bendtwin/client';
import type { PageContext } from '../../../page';
import { confirm } from '../../../ui/dialog';
import { h } from '../../../ui/dom';
import { field } from '../../../ui/form';
import { size, time } from '../../../ui/format';
import { guideLink } from '../../../ui/guide';
import { problemBox } from '../../../ui/problem';
import { actionButton, download, faultPlace } from '../../parts/actions';
import { readAgain } from '../../parts/ingest';
import type { Settings } from '../../parts/settings';

/** Kinds of files that can be added to a capture. */
const KINDS = [
  {
    kind: 'masks',
    label: 'Masks of another tool',
    hint: 'A ZIP or tar archive with a folder mask/.',
    accept: '.zip,.tar,.gz,.tgz',
    file: 'masks',
    section: 'masks',
    // Marks would make other masks.
    change: { until: 'points', strokes: [] } as Settings,
  },
  {
    kind: 'calibration',
    label: 'Calibration',
    hint: 'calibration.json, as bendtwin capture calibrate writes it.',
    accept: '.json,application/json',
    file: 'calibration.json',
    section: 'calibration',
    // A board would go before it.
    change: { calibration: { board: null } } as Settings,
  },
] as const;

/** Files that were added to a capture after its upload: each can be replaced and removed. */
export class Supplements {
  readonly element = h('details', { class: 'card', hidden: true });
  readonly #faults = faultPlace();
  readonly #next = h('div', { role: 'status' });

  constructor(
    private readonly context: PageContext,
    private readonly id: string,
    /** Called with the capture after a change. */
    private readonly onChange: (capture: Capture) => void,
    /** Called with the capture once it is read again. */
    private readonly onStart: (capture: Capture) => void,
  ) {}

  show(capture: Capture): void {
    const there = capture.supplements;
    if (there.length > 0) this.element.open = true;
    this.element.replaceChildren(
      h('summary', {}, 'Add masks or a calibration'),
      ...KINDS.map((kind) => this.#row(capture, kind, there.find((own) => own.kind === kind.kind))),
      this.#faults,
      this.#next,
    );
  }

  #row(capture: Capture, kind: (typeof KINDS)[number], there: Supplement | undefined): HTMLElement {
    const path = `/v1/${capture.name}/supplements/${kind.kind}`;
    const input = h('input', { type: 'file', accept: kind.accept });
    input.addEventListener('change', () => {
      const [file] = input.files ?? [];
      if (file !== undefined) void this.#add(path, kind, file, input);
    });
    const remove = async (): Promise<void> => {
      const question = { title: `Remove the ${kind.kind}?`, text: 'The next reading is without them.' };
      if (!(await confirm({ ...question, action: 'Remove', isDangerous: true }))) return;
      const { api, signal } = this.context;
      await api.fetch(path, { method: 'DELETE', signal });
      this.#changed(await api.get('/v1/captures/{id}', { id: this.id, signal }), `${kind.label}: removed.`, {});
    };
    const current = there && h(
      'div',
      { class: 'row' },
      h('span', {}, `${kind.label}: ${size(there.size_bytes)}, added `, time(there.create_time)),
      download(this.context, 'Download', path, kind.file, this.#faults),
      actionButton(this.context, 'Remove', this.#faults, remove, 'danger'),
    );
    const hint = [kind.hint, ' ', guideLink(kind.section)];
    return h('div', {}, current, field(there ? `${kind.label}: replace` : kind.label, input, hint));
  }

  async #add(path: string, { label, change }: (typeof KINDS)[number], file: File, input: HTMLInputElement): Promise<void> {
    const { context } = this;
    input.disabled = true;
    this.#faults.replaceChildren();
    this.#next.replaceChildren(h('p', {}, `Sending ${size(file.size)}…`));
    try {
      const headers = { 'content-type': 'application/octet-stream' };
      const sent = { method: 'PUT', body: file, headers, signal: context.signal };
      this.#changed(await context.api.json<Capture>(path, sent), `${label}: added.`, change);
    } catch (error) {
      this.#next.replaceChildren();
      if (!context.signal.aborted) this.#faults.replaceChildren(problemBox(error));
      input.value = '';
    }
    input.disabled = false;
  }

  /** Shows the present capture, and offers to read it again with it. */
  #changed(capture: Capture, text: string, change: Settings): void {
    const { context } = this;
    this.show(capture);
    this.onChange(capture);
    const again = async (): Promise<void> => {
      this.onStart(await readAgain(context, capture, change));
      this.#next.replaceChildren();
    };
    this.#next.replaceChildren(
      h('p', {}, `${text} It takes effect when the recording is read again.`),
      actionButton(context, 'Read again', this.#faults, again, 'primary'),
    );
  }
}
