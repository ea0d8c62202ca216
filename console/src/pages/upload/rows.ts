import { idOf } from '@bendtwin/client';
import type { PageContext } from '../../page';
import { badge } from '../../ui/badge';
import { h, nodes } from '../../ui/dom';
import { progress } from '../../ui/form';
import { duration, name, percent, size } from '../../ui/format';
import { textOf } from '../../ui/problem';
import { stateBadge, stateOf } from '../captures/state';
import { prose } from '../parts/text';
import { sourceText, surveyView } from './offers';
import { Readings, type Reading } from './readings';
import { surveyed } from './take';
import { isUnderWay, type Transfer, type TransferState, type Transfers } from './transfers';

const WORDS: Record<TransferState, [string, Parameters<typeof badge>[1]]> = {
  queued: ['waits for other uploads', 'neutral'],
  sending: ['uploading', 'busy'],
  waiting: ['interrupted', 'warn'],
  stored: ['uploaded', 'neutral'],
  known: ['already exists', 'neutral'],
  failed: ['failed', 'bad'],
  cancelled: ['cancelled', 'neutral'],
};

/** The uploads of this page as a list that follows them, and the reading of what arrived, until the page is left. */
export function transferList(transfers: Transfers, context: PageContext): HTMLElement {
  const { signal, announce } = context;
  const readings = new Readings(context);
  const element = h('ul', { class: 'transfers', 'aria-label': 'Uploads' });
  const rows = new Map<number, Row>();
  const update = (): void => {
    for (const shown of transfers.all) {
      const row = rows.get(shown.id) ?? new Row(shown, transfers);
      if (row.update(shown)) announce(`${shown.name}: ${WORDS[shown.state][0]}`);
      if (shown.capture !== null && row.tell(readings.of(shown.capture))) announce(`${shown.name}: ${row.verdict}`);
      if (!rows.has(shown.id)) element.prepend(row.element);
      rows.set(shown.id, row);
    }
    for (const [id, row] of rows) {
      if (transfers.all.some((shown) => shown.id === id)) continue;
      row.element.remove();
      rows.delete(id);
    }
    element.hidden = rows.size === 0;
  };
  transfers.addEventListener('change', update, { signal });
  readings.addEventListener('change', update, { signal });
  update();
  return element;
}

/** A row of an upload. Its elements stay while it changes, so that the focus does. */
class Row {
  readonly element: HTMLElement;
  readonly #state = h('span');
  readonly #bar: HTMLProgressElement;
  readonly #text = h('p', { class: 'muted' });
  readonly #verdict = h('p', { hidden: true });
  readonly #open = h('a', { class: 'button small', hidden: true }, 'Open the capture');
  readonly #button: HTMLButtonElement;
  #last: TransferState | null = null;

  constructor(shown: Transfer, transfers: Transfers) {
    this.#bar = progress(`Progress of ${shown.name}`, 0);
    const act = (): void =>
      this.#last !== null && !UNDER_WAY.has(this.#last) ? transfers.remove(shown.id) : transfers.cancel(shown.id);
    this.#button = h('button', { type: 'button', class: 'small', onclick: act });
    const survey = surveyed(shown.source);
    this.element = h(
      'li',
      { class: 'card' },
      h('div', { class: 'transfer-head' }, h('strong', {}, name(shown.name)), this.#state, this.#open, this.#button),
      h('p', { class: 'muted' }, sourceText(shown.source, shown.sizeBytes)),
      survey === null ? null : surveyView(survey),
      this.#bar,
      this.#text,
      this.#verdict,
    );
  }

  /** The verdict that is shown, and the way on. */
  get verdict(): string {
    return this.#verdict.textContent;
  }

  /** Shows how the capture is read; true if that has just ended. */
  tell(reading: Reading | null): boolean {
    if (reading === null || this.#last === null) return false;
    const { capture, sentence } = reading;
    const known = this.#last === 'known' ? [badge(...WORDS.known), ' '] : [];
    this.#state.replaceChildren(...nodes([known, stateBadge(capture)]));
    const isNew = sentence !== '' && this.#verdict.hidden;
    if (!isNew) return false;
    const way = h('a', { href: `#/${capture.name}` }, stateOf(capture) === 'good' ? 'See the report' : 'See what to do');
    this.#verdict.replaceChildren(prose(sentence), ' ', way);
    this.#verdict.hidden = false;
    return true;
  }

  /** Shows the current upload; true if its state has changed. */
  update(shown: Transfer): boolean {
    this.#bar.value = shown.sizeBytes > 0 ? shown.offset / shown.sizeBytes : shown.state === 'stored' ? 1 : 0;
    this.#bar.hidden = !isUnderWay(shown);
    this.#text.textContent = textFor(shown);
    if (shown.state === this.#last) return false;
    this.#last = shown.state;
    this.#state.replaceChildren(badge(...WORDS[shown.state]));
    this.#button.textContent = isUnderWay(shown) ? 'Cancel' : 'Clear';
    this.#button.setAttribute('aria-label', `${isUnderWay(shown) ? 'Cancel' : 'Clear'} ${shown.name}`);
    if (shown.capture !== null) this.#open.setAttribute('href', `#/captures/${idOf(shown.capture)}`);
    this.#open.hidden = shown.capture === null;
    return true;
  }
}

const UNDER_WAY: ReadonlySet<TransferState> = new Set(['queued', 'sending', 'waiting']);

function textFor({ state, offset, sizeBytes, rate, error }: Transfer): string {
  const there = `${size(offset)} of ${size(sizeBytes)} (${percent(sizeBytes > 0 ? offset / sizeBytes : 0)})`;
  if (state === 'waiting') return `${textOf(error)} ${there} have arrived; the upload continues by itself.`;
  if (state === 'failed') return textOf(error);
  if (state !== 'sending') return '';
  const speed = rate === null || rate <= 0 ? '' : `, ${size(rate)}/s, ${duration((sizeBytes - offset) / rate)} left`;
  return there + speed;
}
