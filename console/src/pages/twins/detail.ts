import { idOf, type Capture, type Twin } from '@bendtwin/client';
import type { OpenPage, PageContext } from '../../page';
import type { TurningTwin } from '../../view3d/moving/turning_twin';
import type { TwinShape } from '../../view3d/shape';
import { h } from '../../ui/dom';
import { facts } from '../../ui/form';
import { count, significant, size, time } from '../../ui/format';
import { menu } from '../../ui/menu';
import { thumbnail } from '../../ui/thumbnail';
import { LossView } from '../fits/curves';
import { deleteButton, faultPlace } from '../parts/actions';
import { captureText, findCapture } from '../parts/capture';
import { hasPoints } from '../parts/ingest';
import { LabelEditor } from '../parts/labels';
import { qualityView } from './assessment';
import { evaluationView } from './evaluate';
import { exportMenu } from './exports';
import { identifiabilityView } from './identifiability';
import { verdictLine } from './verdict/level';
import { parametersView } from './parameters';
import { pythonButton } from './python';
import { shareButton } from './share';
import type { Quality } from './quality';
import { sequencesView } from './recordings';
import { scaleOf, type Scale } from './verdict/scale';
import { whyView } from './verdict/why';
import './detail.css';

/** The page of a twin: what it looks like, what it is worth and why, and what can be done with it. */
export const open: OpenPage = async (context) => {
  const id = context.parameters['id'] ?? '';
  const twin = await context.api.get('/v1/twins/{id}', { id, signal: context.signal });
  const capture = twin.capture ? await findCapture(context, twin.capture) : null;
  const page = new TwinPage(context, id, twin, capture);
  void page.showObject();
  return page;
};

class TwinPage {
  readonly element: HTMLElement;
  readonly #path: string;
  readonly #quality: Quality;
  readonly #picture: HTMLElement;
  readonly #why = h('div');
  readonly #faults = faultPlace();
  readonly #losses: LossView | null;
  #turning: TurningTwin | null = null;
  /** Lengths of the object, once its shape is there; null if it does not come. */
  #scale: Scale | null | undefined = undefined;
  readonly #evaluation: HTMLDetailsElement;

  constructor(
    private readonly context: PageContext,
    private readonly id: string,
    private readonly twin: Twin,
    private readonly capture: Capture | null,
  ) {
    this.#path = `/v1/twins/${encodeURIComponent(id)}`;
    this.#quality = twin.quality as Quality;
    this.#picture = h('div', { class: 'twin-picture' }, this.poster());
    this.#losses = twin.fit ? new LossView(context, idOf(twin.fit)) : null;
    void this.#losses?.update(true);
    this.#evaluation = evaluationView(context, twin, () => this.#scale ?? null);
    this.showTitle(twin);
    this.showWhy();
    const view = `#/twins/${id}/view?colour=uncertainty&layers=skin,shadow`;
    this.element = h(
      'div',
      {},
      h('div', { class: 'twin-head' }, this.#picture, this.summary()),
      this.#why,
      qualityView(this.#quality),
      capture === null || !hasPoints(capture) ? null : sequencesView(context, idOf(capture.name), id),
      identifiabilityView(this.#quality, view),
      this.#evaluation,
      parametersView(context, id, () => settingsAsked(context, twin.fit ?? null)),
      this.#losses?.element,
      this.facts(),
    );
  }

  dispose(): void {
    this.#losses?.dispose();
    this.#turning?.dispose();
  }

  /** Loads the shape; the object takes the place of its picture, and its size joins the reasons. */
  async showObject(): Promise<void> {
    const { api, signal } = this.context;
    try {
      // The three-dimensional view is large: the page does not wait for it.
      const [{ loadShape }, { TurningTwin }] = await Promise.all([
        import('../../view3d/shape'), import('../../view3d/moving/turning_twin'),
      ]);
      const shape: TwinShape = await loadShape(api, this.id, signal);
      if (signal.aborted) return;
      this.#scale = scaleOf(shape.rest, shape.rods);
      this.showWhy();
      this.#turning = new TurningTwin(shape, { label: `The twin ${this.twin.display_name}: drag to rotate` });
      this.#picture.replaceChildren(this.#turning.stage.element);
      if (!matchMedia('(prefers-reduced-motion: reduce)').matches) this.#turning.play();
    } catch {
      // Without WebGL the picture stays; the playground says what is missing.
      if (this.#scale !== undefined || signal.aborted) return;
      this.#scale = null;
      this.showWhy();
    }
  }

  private showTitle({ display_name }: Twin): void {
    this.context.setTitle(display_name || 'Twin without a name');
  }

  private showWhy(): void {
    const evaluate = (): void => {
      this.#evaluation.open = true;
      this.#evaluation.querySelector('summary')?.focus();
    };
    const view = whyView(this.#quality, this.#scale, { twin: this.twin, evaluate });
    this.#why.replaceChildren(...(view === null ? [] : [view]));
  }

  private poster(): HTMLElement {
    const { api, signal } = this.context;
    return thumbnail(api, `${this.#path}/thumbnail?width=640`, `The twin ${this.twin.display_name}`, signal);
  }

  private summary(): HTMLElement {
    const { context, twin, id } = this;
    const labels = new LabelEditor<Twin>(context, 'twins', this.#path, twin, (changed) => this.showTitle(changed));
    return h(
      'div',
      { class: 'twin-summary' },
      verdictLine(this.#quality),
      h(
        'div',
        { class: 'buttons' },
        h('a', { class: 'button primary', href: `#/twins/${id}/play` }, 'Play'),
        exportMenu(context, this.#path, twin.display_name, this.#faults),
        pythonButton(twin),
      ),
      h('div', { class: 'buttons' }, ...this.otherActions()),
      this.#faults,
      facts([
        ['Capture', twin.capture ? captureText(this.capture) : 'imported'],
        ['Fit', twin.fit ? h('a', { href: `#/fits/${idOf(twin.fit)}` }, 'Open') : '–'],
        ['Created', time(twin.create_time)],
        ['Nodes', count(twin.node_count)],
      ]),
      labels.element,
    );
  }

  private otherActions(): HTMLElement[] {
    const { context, capture, id, twin } = this;
    const own = capture === null ? {} : { capture: idOf(capture.name) };
    const question = { title: 'Delete this twin?', text: 'It goes to the trash, if this server has one. Its capture and its fit are kept.' };
    const link = (text: string, href: string): HTMLElement => h('a', { class: 'button quiet', href }, text);
    return [
      ...(capture === null ? [] : [link('Beside its recording', `#/captures/${own.capture}/playback?twin=${id}`)]),
      link('Refine', `#/fits/new?${new URLSearchParams({ from: id, ...own })}`),
      shareButton(context, twin),
      menu('More', [
        h('a', { class: 'button', href: `#/twins/${id}/view` }, 'Nodes and springs in 3D'),
        deleteButton(context, this.#path, question, '#/twins', this.#faults),
      ], { class: 'quiet' }),
    ];
  }

  /** What few ask for: sizes and hashes. */
  private facts(): HTMLElement {
    const { twin } = this;
    return h(
      'details',
      { class: 'card' },
      h('summary', {}, 'Facts and hashes'),
      facts([
        ['Nodes', count(twin.node_count)],
        ['Springs', count(twin.spring_count)],
        ['Bending triplets', count(twin.triplet_count)],
        ['Control points', count(twin.control_count)],
        ['Frames per second', significant(twin.fps)],
        ['Substeps per frame', twin.substeps],
        ['Mass', twin.mass_kg === undefined ? 'unknown' : `${significant(twin.mass_kg)} kg`],
        ['File', size(twin.size_bytes)],
        ['Name in the API', h('code', {}, twin.name)],
        ['BLAKE3 of the file', h('code', {}, twin.digest)],
      ]),
    );
  }
}

/** The settings that its fit was asked for; null if it is not there any more. */
async function settingsAsked({ api, signal }: PageContext, fit: string | null): Promise<unknown> {
  if (fit === null) return null;
  try {
    return (await api.get('/v1/fits/{id}', { id: idOf(fit), signal })).job.settings;
  } catch {
    return null;
  }
}
