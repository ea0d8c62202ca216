import uPlot from 'uplot';
import 'uplot/dist/uPlot.min.css';

import type { LossCurve } from '../../api/types';
import { h } from '../../ui/dom';
import { WHOLE, inks, widthOf } from '../parts/plot';
import { chartsOf, type StageChart } from './losses';

const TITLES: Record<string, string> = { search: 'Search', refine: 'Refinement' };
const HEIGHT = 260;

/** Losses as curves over a logarithmic axis, a chart for each stage. The charts stay while curves grow. */
export class LossCharts {
  readonly element = h('div', { class: 'charts' });
  #charts = new Map<string, { plot: uPlot; lines: string; place: HTMLElement }>();
  #shown: readonly StageChart[] = [];
  readonly #resized = new ResizeObserver(() => this.resize());
  readonly #scheme = matchMedia('(prefers-color-scheme: dark)');
  readonly #repaint = (): void =>
    this.#shown.forEach((chart) => this.draw(chart, this.#charts.get(chart.stage)?.lines ?? ''));

  constructor() {
    this.#resized.observe(this.element);
    this.#scheme.addEventListener('change', this.#repaint);
  }

  update(curves: readonly LossCurve[]): void {
    this.#shown = chartsOf(curves);
    for (const chart of this.#shown) {
      const known = this.#charts.get(chart.stage);
      const lines = JSON.stringify(chart.lines.map(({ label }) => label));
      if (known?.lines !== lines) this.draw(chart, lines);
      else {
        known.plot.setData(dataOf(chart));
        tellLast(known.plot);
      }
    }
    this.resize();
  }

  dispose(): void {
    this.#resized.disconnect();
    this.#scheme.removeEventListener('change', this.#repaint);
    for (const { plot } of this.#charts.values()) plot.destroy();
  }

  /** Draws a chart, in place of the previous one of its stage. */
  private draw(chart: StageChart, lines: string): void {
    const known = this.#charts.get(chart.stage);
    known?.plot.destroy();
    const place = known?.place ?? h('figure', { class: 'chart' });
    const title = TITLES[chart.stage] ?? chart.stage;
    place.replaceChildren(h('figcaption', {}, h('strong', {}, title), ' loss over iterations'));
    if (known === undefined) this.element.append(place);
    const plot = new uPlot(optionsOf(chart, widthOf(place)), dataOf(chart), place);
    tellLast(plot);
    // What it shows is in a table besides.
    plot.root.setAttribute('aria-hidden', 'true');
    this.#charts.set(chart.stage, { plot, lines, place });
  }

  /** Charts are as wide as their places, which the page lays out. */
  private resize(): void {
    for (const { plot, place } of this.#charts.values()) {
      const width = widthOf(place);
      if (plot.width !== width) plot.setSize({ width, height: HEIGHT });
    }
  }
}

/** Shows the last values, unless others are pointed at. */
function tellLast(plot: uPlot): void {
  if (plot.cursor.idx === null || plot.cursor.idx === undefined) plot.setLegend({ idx: plot.data[0].length - 1 }, false);
}

function dataOf({ iterations, lines }: StageChart): uPlot.AlignedData {
  return [iterations as number[], ...lines.map(({ values }) => values as (number | null)[])];
}

function optionsOf({ lines }: StageChart, width: number): uPlot.Options {
  const { text, grid, series: colors } = inks();
  const axis = { stroke: text, grid: { stroke: grid, width: 1 }, ticks: { stroke: grid, width: 1 } };
  return {
    width,
    height: HEIGHT,
    // As the lines: those of the best are solid.
    legend: { markers: { width: 2, dash: (_plot, index) => (lines[index - 1]?.isBest ? 'solid' : 'dotted') } },
    hooks: { setCursor: [tellLast] },
    scales: { x: { time: false }, y: { distr: 3 } },
    axes: [
      { ...axis, incrs: WHOLE },
      { ...axis, size: 64, values: (_plot, splits) => splits.map((v) => (v === null ? '' : v.toExponential(0))) },
    ],
    series: [
      { label: 'Iteration' },
      ...lines.map(({ label, isBest, model }) => ({
        label,
        stroke: colors[model % colors.length] ?? text,
        width: isBest ? 2 : 1,
        ...(isBest ? {} : { dash: [2, 3] }),
        spanGaps: true,
        // A single value has no line.
        points: { show: (plot: uPlot) => plot.data[0].length < 2 },
        value: (_plot: uPlot, value: number | null) => (value === null ? '–' : value.toExponential(2)),
      })),
    ],
  };
}
