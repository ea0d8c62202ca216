import { Problem } from '@bendtwin/client';
import { allowDownload, mayDownload } from '../../api/visit';
import type { OpenPage, Page, PageContext } from '../../page';
import { PlayPage } from '../../play/play_page';
import type { ProblemText } from '../../play/protocol/messages';
import { loadTwin, type ShownTwin } from '../../play/twin';
import { h } from '../../ui/dom';
import { Legend } from '../../view3d/legend';
import { Ground } from '../../view3d/place/ground';
import { Stage } from '../../view3d/stage';
import { TwinView } from '../../view3d/twin_view';
import { download, faultPlace } from '../parts/actions';

/** Scopes by which a twin may be downloaded: that of a link, or those of people who have a token as well. */
const READING = ['share:export', 'twins:read', 'twins:read:own'];

/** A twin for people with a link and without a token: the object, its name, and a button to play with it. */
export const open: OpenPage = async (context) => {
  const id = context.parameters['id'] ?? '';
  try {
    const { scopes } = await context.api.get('/v1/caller', { signal: context.signal });
    allowDownload(scopes.some((scope) => READING.includes(scope)));
    return new VisitPage(context, id, await loadTwin(context, id));
  } catch (error) {
    const ended = endOf(context, error);
    if (ended === null) throw error;
    return { element: ended };
  }
};

class VisitPage implements Page {
  readonly element = h('div', { class: 'visit' });
  #shown: Page;

  constructor(
    private readonly context: PageContext,
    private readonly id: string,
    private readonly twin: ShownTwin,
  ) {
    this.#shown = atRest(context, id, twin, () => this.#play());
    this.element.append(this.#shown.element);
  }

  dispose(): void {
    this.#shown.dispose?.();
  }

  #play(): void {
    const page = new VisitedPlay(this.context, this.twin, (end) => this.element.replaceChildren(end));
    this.#shown.dispose?.();
    this.#shown = page;
    this.element.replaceChildren(page.element);
    page.connect(`/v1/twins/${encodeURIComponent(this.id)}/play`, true);
  }
}

/** The playground of a visit, which says so when the link has ended. */
class VisitedPlay extends PlayPage {
  constructor(
    private readonly visit: PageContext,
    private readonly twin: ShownTwin,
    private readonly end: (element: HTMLElement) => void,
  ) {
    super(visit, twin);
  }

  override ended(problem: ProblemText | null): void {
    super.ended(problem);
    // A socket that is refused says nothing about the reason; the twin does.
    const asked = this.visit.api.get('/v1/twins/{id}', { id: this.twin.id, signal: this.visit.signal });
    asked.catch((error: unknown) => {
      const ended = endOf(this.visit, error);
      if (ended === null || this.visit.signal.aborted) return;
      this.dispose();
      this.end(ended);
    });
  }
}

/** The twin at rest, with what can be done. */
function atRest(
  context: PageContext,
  id: string,
  { shape, name }: ShownTwin,
  play: () => void,
): Page {
  const stage = new Stage(`The twin ${name} at rest`);
  const legend = new Legend();
  stage.overlay.append(legend.element);
  const view = new TwinView(stage, shape, legend);
  new Ground(stage, shape.rest).place(shape.ground);
  view.above(shape.ground);
  if (!stage.setView(context.query.get('view') ?? '')) stage.lookAt(shape.rest);
  const faults = faultPlace();
  const path = `/v1/twins/${encodeURIComponent(id)}/content`;
  const element = h('div', {},
    stage.element,
    h('div', { class: 'visit-actions' },
      h('button', { type: 'button', class: 'primary', onclick: play }, 'Play'),
      mayDownload() && download(context, 'Download', path, `${id}.safetensors`, faults),
      h('span', { class: 'hint' }, 'Drag to rotate. Play to pull, lift and drop it.')),
    faults);
  const dispose = (): void => {
    view.dispose();
    stage.dispose();
  };
  return { element, dispose };
}

/** What is shown in place of a twin that the link does not open any more; null for other errors. */
function endOf(context: PageContext, error: unknown): HTMLElement | null {
  if (!(error instanceof Problem)) return null;
  const text = (title: string, advice: string): HTMLElement => {
    context.setTitle(title);
    return h('p', { role: 'status' }, advice);
  };
  if (error.reason === 'SHARE_ENDED') {
    return text('This link has expired', 'Ask the person who sent it for a new one.');
  }
  if (error.status === 401) {
    return text('This link does not work', 'It is incomplete, or it expired long ago. Ask the person who sent it for a new one.');
  }
  if (error.status === 404) return text('There is nothing here any more', 'The twin was deleted. Ask the person who sent the link.');
  return null;
}
