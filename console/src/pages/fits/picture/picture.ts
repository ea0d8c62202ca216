import { hasEnded, idOf, Problem, type Fit, type FitPreview } from '@bendtwin/client';
import type { PageContext } from '../../../page';
import { errorWords } from '../../parts/error';
import { h } from '../../../ui/dom';
import type { Moving } from '../../../view3d/moving/moving';
import { drawsInSoftware } from '../../../view3d/renderer_kind';
import { previewWords, readPreview } from './preview';
import type { PreviewScene } from './preview_scene';
import './picture.css';

/**
 * The picture at the top of the page of a fit: the recording with what the fit predicts of it while it runs, then
 * its twin. It moves unless the system asks for less motion.
 */
export class FitPicture {
  readonly element = h('section', { class: 'fit-picture', 'aria-label': 'Picture', hidden: true });
  readonly #place = h('div');
  readonly #words = h('p', { class: 'fit-error' });
  readonly #legend = h(
    'p',
    { class: 'fit-legend', hidden: true },
    h('span', { class: 'fit-recorded' }, 'recorded'),
    h('span', { class: 'fit-predicted' }, 'predicted'),
  );
  readonly #toggle = h('button', { type: 'button', class: 'small', onclick: () => this.#move(!this.#moves) });
  #scene: Moving | null = null;
  /** What is shown, or is being loaded: `recording`, or the name of a twin. */
  #subject = '';
  /** The preview that is shown, and the error of the fit by which it was asked for: each has another. */
  #shown: FitPreview | null = null;
  #error: number | null = null;
  #isAsking = false;
  #preview: Promise<PreviewScene | null> | null = null;
  #moves = !matchMedia('(prefers-reduced-motion: reduce)').matches;

  constructor(
    private readonly context: PageContext,
    /** Called with the error of standing still [m], once it is known. */
    private readonly onBaseline: (metres: number) => void,
  ) {
    this.element.append(this.#place, h('div', { class: 'fit-caption' }, this.#words, this.#legend, this.#toggle));
  }

  /** Shows what a fit has by now. */
  update(fit: Fit): void {
    if (fit.twin) {
      this.#words.textContent = twinWords(fit);
      this.#legend.hidden = true;
      void this.#showTwin(idOf(fit.twin));
      return;
    }
    const error = fit.job.progress?.error_m ?? null;
    // A fit that waits may have a capture that is yet to be read, or cannot be.
    if (fit.job.state === 'QUEUED' || (hasEnded(fit.job) && error === null)) return;
    void this.#showPreview(fit, error);
  }

  dispose(): void {
    this.#scene?.dispose();
    this.#scene = null;
    this.#subject = 'nothing more';
  }

  async #showTwin(twin: string): Promise<void> {
    if (this.#subject === twin) return;
    this.#subject = twin;
    const { api, signal } = this.context;
    try {
      const [{ loadShape }, { TurningTwin }] = await Promise.all([
        import('../../../view3d/shape'), import('../../../view3d/moving/turning_twin'),
      ]);
      const shape = await loadShape(api, twin, signal);
      if (this.#subject !== twin || signal.aborted) return;
      // Without a GPU it would keep a core busy.
      if (drawsInSoftware()) this.#moves = false;
      this.#put(new TurningTwin(shape, { label: 'The twin', hasGround: true, onHeld: () => this.#move(false) }));
    } catch (error) {
      // The page says that the twin was deleted, and a page without a picture is complete.
      if (!(error instanceof Problem && error.status === 404)) this.#fail(error);
      else this.element.hidden = true;
    }
  }

  async #showPreview(fit: Fit, error: number | null): Promise<void> {
    const { api, signal } = this.context;
    if (this.#subject === '') {
      this.#subject = 'recording';
      this.#preview = this.#open(idOf(fit.capture));
    }
    if (this.#shown !== null) this.#words.textContent = previewWords(this.#shown, hasEnded(fit.job));
    if (error === null || error === this.#error || this.#isAsking) return;
    this.#isAsking = true;
    try {
      const query = { tensors: 'base64' } as const;
      const reply = await api.get('/v1/fits/{id}/preview', { id: idOf(fit.name), query, signal });
      const scene = await this.#preview;
      await scene?.show(readPreview(reply));
      this.onBaseline(reply.baseline_m);
      if (scene !== null && this.#scene === scene) {
        [this.#shown, this.#error] = [reply, error];
        this.#words.textContent = previewWords(reply, hasEnded(fit.job));
        this.#legend.hidden = false;
        this.element.hidden = false;
      }
    } catch {
      // It has a twin by now, or the next event asks again.
    }
    this.#isAsking = false;
  }

  /** Opens the recording; null where there is nothing to draw with. */
  async #open(capture: string): Promise<PreviewScene | null> {
    try {
      const { PreviewScene } = await import('./preview_scene');
      const { api, signal } = this.context;
      const scene = await PreviewScene.open(api, capture, signal);
      if (this.#subject !== 'recording' || signal.aborted) {
        scene.dispose();
        return null;
      }
      this.#put(scene);
      this.element.hidden = !scene.hasPoints;
      return scene;
    } catch (error) {
      this.#fail(error);
      return null;
    }
  }

  /** Puts a picture in the place of the one before. */
  #put(scene: Moving): void {
    this.#scene?.dispose();
    this.#scene = scene;
    this.#place.replaceChildren(scene.stage.element);
    this.element.hidden = false;
    this.#move(this.#moves);
  }

  #move(moves: boolean): void {
    this.#moves = moves;
    this.#toggle.textContent = moves ? 'Pause' : 'Play';
    if (moves) this.#scene?.play();
    else this.#scene?.pause();
  }

  #fail(error: unknown): void {
    if (this.context.signal.aborted) return;
    this.#place.replaceChildren(h('p', { class: 'muted' }, error instanceof Error ? error.message : String(error)));
    this.#toggle.hidden = true;
    this.element.hidden = false;
  }
}

/** The error of the twin of a fit, in a sentence; empty if it is not known. */
function twinWords({ error_m, measure }: Fit): string {
  if (error_m === null || error_m === undefined) return '';
  return `${errorWords(error_m, measure)} on frames that it was not fitted to.`;
}
