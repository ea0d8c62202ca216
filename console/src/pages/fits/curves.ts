import type { LossCurve } from '@bendtwin/client';
import type { PageContext } from '../../page';
import { h } from '../../ui/dom';
import { count, millimetres } from '../../ui/format';
import { table } from '../../ui/table';
import { ERRORS, LOSSES, StageCharts } from './chart';
import { chartsOf, errorCharts, lastLosses, lossText, type LastLoss } from './losses';

/** Least time between two questions for the losses of a fit that runs [ms]. */
const PAUSE_MS = 1500;

/** The errors of a fit in millimetres as curves, and its losses with a table of where each model is. */
export class LossView {
  readonly errors = h('section', { hidden: true }, h('h2', {}, 'Error over training frames'));
  readonly element = h('section', { hidden: true }, h('h2', {}, 'Losses'));
  readonly #errorCharts = new StageCharts(ERRORS);
  readonly #lossCharts = new StageCharts(LOSSES);
  readonly #table = h('div');
  #curves: readonly LossCurve[] = [];
  #baseline: number | null = null;
  #asked = 0;
  #isAsking = false;

  constructor(
    private readonly context: PageContext,
    /** The fit's uuid. */
    private readonly id: string,
  ) {
    this.errors.append(this.#errorCharts.element);
    this.element.append(this.#lossCharts.element, this.#table);
  }

  /** The error of standing still [m], once it is known. */
  set baseline(metres: number) {
    if (this.#baseline === metres) return;
    this.#baseline = metres;
    this.show();
  }

  /** Asks for the curves, unless that was done just now; `isLast` asks in any case. */
  async update(isLast: boolean): Promise<void> {
    const now = performance.now();
    if (!isLast && (this.#isAsking || (this.#asked > 0 && now - this.#asked < PAUSE_MS))) return;
    this.#isAsking = true;
    this.#asked = now;
    try {
      const { api, signal } = this.context;
      const { curves } = await api.get('/v1/fits/{id}/losses', { id: this.id, signal });
      this.#curves = curves;
      if (!signal.aborted) this.show();
    } catch {
      // The next event asks again; the page shows faults of the server.
    }
    this.#isAsking = false;
  }

  dispose(): void {
    this.#errorCharts.dispose();
    this.#lossCharts.dispose();
  }

  private show(): void {
    const curves = this.#curves;
    const errors = errorCharts(curves, this.#baseline);
    this.errors.hidden = errors.length === 0;
    this.element.hidden = curves.length === 0;
    if (curves.length === 0) return;
    this.#errorCharts.update(errors);
    this.#lossCharts.update(chartsOf(curves));
    this.#table.replaceChildren(
      table<LastLoss>({
        caption: 'Last and lowest loss of each model',
        rows: lastLosses(curves),
        columns: [
          { header: 'Model', cell: ({ variant }) => variant },
          { header: 'Stage', cell: ({ stage }) => stage },
          { header: 'Iterations', isNumeric: true, cell: ({ iteration }) => count(iteration) },
          { header: 'Last loss', isNumeric: true, cell: ({ loss }) => lossText(loss) },
          { header: 'Lowest loss', isNumeric: true, cell: ({ best }) => lossText(best) },
          { header: 'Training error', isNumeric: true, cell: ({ error_m }) => millimetres(error_m) },
        ],
      }),
    );
  }
}
