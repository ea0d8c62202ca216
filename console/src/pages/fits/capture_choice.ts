import type { Capture } from '@bendtwin/client';
import type { PageContext } from '../../page';
import { badge } from '../../ui/badge';
import { h } from '../../ui/dom';
import { moment } from '../../ui/format';
import { capturePicture } from '../captures/picture';
import { whyNoFit } from '../captures/state';
import { Combobox, type Option } from '../parts/combobox';
import './capture_choice.css';

/** Captures that are shown together: the last ones that match. */
const MOST = 20;

/** The field in which the capture of a fit is searched and chosen. Those that cannot be fitted say why. */
export class CaptureChoice {
  readonly element: HTMLElement;
  readonly #combobox: Combobox<Capture>;
  readonly #picture = h('span', { class: 'capture-choice-picture', hidden: true });
  readonly #fault = h('p', { class: 'fault', role: 'alert' });

  constructor(
    private readonly context: PageContext,
    chosen: Capture | null,
    private readonly onChange: () => void,
  ) {
    const load = async (search: string): Promise<Option<Capture>[]> => {
      const query = { search, page_size: MOST };
      const { captures } = await context.api.get('/v1/captures', { query, signal: context.signal });
      return captures.map((capture) => this.#option(capture));
    };
    const onChoose = (capture: Capture | null): void => this.#chosen(capture);
    this.#combobox = new Combobox({ label: 'Capture', noun: 'capture', load, onChoose, signal: context.signal });
    this.element = h('div', {}, h('div', { class: 'capture-choice' }, this.#picture, this.#combobox.element), this.#fault);
    if (chosen !== null) this.#combobox.choose(this.#option(chosen));
  }

  /** The name of the capture, `captures/{uuid}`; empty while none is chosen. */
  get value(): string {
    return this.#combobox.value?.name ?? '';
  }

  #chosen(capture: Capture | null): void {
    this.#picture.hidden = capture === null;
    this.#picture.replaceChildren(...(capture === null ? [] : [capturePicture(this.context, capture)]));
    const reason = capture === null ? null : whyNoFit(capture);
    this.#fault.textContent = reason === null ? '' : `This capture cannot be fitted: ${reason}.`;
    this.onChange();
  }

  #option(capture: Capture): Option<Capture> {
    const { display_name, create_time, verdict } = capture;
    const text = display_name || 'without a name';
    const reason = whyNoFit(capture);
    const content = h(
      'span',
      { class: 'capture-option' },
      capturePicture(this.context, capture),
      h(
        'span',
        {},
        h('bdi', {}, text),
        h('span', { class: 'muted' }, moment(create_time), reason === null ? '' : `, cannot be fitted: ${reason}`),
      ),
      verdict !== null && verdict !== '' && badge(verdict),
    );
    return { item: capture, id: capture.name, text, content, reason };
  }
}
