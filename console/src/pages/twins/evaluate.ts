import { idOf, type Evaluation, type Twin } from '@bendtwin/client';
import type { PageContext } from '../../page';
import { h } from '../../ui/dom';
import { field } from '../../ui/form';
import { moment } from '../../ui/format';
import { problemBox } from '../../ui/problem';
import { assessmentView, qualityView } from './assessment';
import type { Quality } from './quality';
import type { Scale } from './verdict/scale';
import { reasonsOf } from './verdict/reasons';
import { adviceView, reasonTable } from './verdict/why';

/** Captures to choose from. */
const CHOICES = 200;

/** A form that measures a twin on another capture of its object; `scale` has lengths of it, if they are known. */
export function evaluationView(context: PageContext, twin: Twin, scale: () => Scale | null): HTMLDetailsElement {
  const { api, signal } = context;
  const select = h('select', { required: true });
  const result = h('div', { 'aria-live': 'polite' });
  const button = h('button', { type: 'submit', disabled: true }, 'Evaluate');
  const submit = async (event: Event): Promise<void> => {
    event.preventDefault();
    button.disabled = true;
    result.replaceChildren(h('p', { class: 'muted' }, 'The twin is simulated and compared…'));
    try {
      const path = `/v1/${twin.name}/evaluations`;
      const evaluation = await api.send<Evaluation>('POST', path, { capture: select.value }, signal);
      const quality = evaluation.quality as Quality;
      const reasons = reasonsOf(quality, scale());
      const judged = { twin, evaluate: () => select.focus() };
      const parts = [assessmentView(quality, adviceView(quality, reasons, judged)), reasonTable(reasons), qualityView(quality)];
      result.replaceChildren(...parts.filter((view) => view !== null));
    } catch (error) {
      if (!signal.aborted) result.replaceChildren(problemBox(error));
    }
    button.disabled = false;
  };
  const fill = async (): Promise<void> => {
    const { captures } = await api.get('/v1/captures', { query: { page_size: CHOICES }, signal });
    select.replaceChildren(
      ...captures.map(({ name, display_name, create_time }) => {
        const own = name === twin.capture ? ', its own' : '';
        return h(
          'option',
          { value: name, selected: idOf(name) === context.query.get('evaluate') },
          `${display_name || 'without a name'}, ${moment(create_time)}${own}`,
        );
      }),
    );
    button.disabled = captures.length === 0;
  };
  const form = h(
    'form',
    { onsubmit: (event) => void submit(event) },
    field(
      'Capture',
      select,
      'The twin is first registered to another recording of its object; all frames then count as future.',
    ),
    h('div', { class: 'buttons' }, button),
  );
  const details = h('details', { class: 'card' }, h('summary', {}, 'Evaluate on a capture'), form, result);
  details.addEventListener(
    'toggle',
    () =>
      details.open &&
      select.options.length === 0 &&
      void fill().catch((error: unknown) => result.replaceChildren(problemBox(error))),
  );
  return details;
}
