import type { LossCurve } from '../../api/types';
import type { PageContext } from '../../page';
import { h } from '../../ui/dom';
import { count } from '../../ui/format';
import { table } from '../../ui/table';
import { LossCharts } from './chart';
import { lastLosses, lossText, type LastLoss } from './losses';

/** Least time between two questions for the losses of a fit that runs [ms]. */
const PAUSE_MS = 1500;

/** The losses of a fit as curves and as a table of where each model is. */
export class LossView {
  readonly element = h('section', { hidden: true }, h('h2', {}, 'Losses'));
  readonly #charts = new LossCharts();
  readonly #table = h('div');
  #asked = 0;
  #isAsking = false;

  constructor(
    private readonly context: PageContext,
    /** The fit's uuid. */
    private readonly id: string,
  ) {
    this.element.append(this.#charts.element, this.#table);
  }

  /** Asks for the losses, unless that was done just now; `isLast` asks in any case. */
  async update(isLast: boolean): Promise<void> {
    const now = performance.now();
    if (!isLast && (this.#isAsking || (this.#asked > 0 && now - this.#asked < PAUSE_MS))) return;
    this.#isAsking = true;
    this.#asked = now;
    try {
      const { api, signal } = this.context;
      const { curves } = await api.get('/v1/fits/{id}/losses', { id: this.id, signal });
      if (!signal.aborted) this.show(curves);
    } catch {
      // The next event asks again; the page shows faults of the server.
    }
    this.#isAsking = false;
  }

  dispose(): void {
    this.#charts.dispose();
  }

  private show(curves: readonly LossCurve[]): void {
    this.element.hidden = curves.length === 0;
    if (curves.length === 0) return;
    this.#charts.update(curves);
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
        ],
      }),
    );
  }
}
