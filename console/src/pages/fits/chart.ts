import uPlot from 'uplot';
import 'uplot/dist/uPlot.min.css';

import { h } from '../../ui/dom';
import { WHOLE, inks, widthOf } from '../parts/plot';
import type { StageChart } from './losses';

const TITLES: Record<string, string> = { search: 'Search', refine: 'Refinement' };
/** Words for an iteration of a stage. */
const ITERATIONS: Record<string, string> = { search: 'generation', refine: 'pass' };
const HEIGHT = 260;

/** The values of charts: their name, how they are written, and their axis. */
export interface Quantity {
  readonly name: string;
  readonly unit: string;
  readonly isLogarithmic: boolean;
  readonly text: (value: number) => string;
}

export const LOSSES: Quantity = {
  name: 'Loss',
  unit: '',
  isLogarithmic: true,
  text: (value) => value.toExponential(2),
};

export const ERRORS: Quantity = {
  name: 'Error',
  unit: 'mm',
  isLogarithmic: false,
  text: (value) => `${Number(value.toPrecision(3))} mm`,
};

/** Curves over the iterations of stages, a chart for each. The charts stay while curves grow. */
export class StageCharts {
  readonly element = h('div', { class: 'charts' });
  #charts = new Map<string, { plot: uPlot; lines: string; place: HTMLElement }>();
  #shown: readonly StageChart[] = [];
  readonly #resized = new ResizeObserver(() => this.resize());
  readonly #scheme = matchMedia('(prefers-color-scheme: dark)');
  readonly #repaint = (): void =>
    this.#shown.forEach((chart) => this.draw(chart, this.#charts.get(chart.stage)?.lines ?? ''));

  constructor(private readonly quantity: Quantity) {
    this.#resized.observe(this.element);
    this.#scheme.addEventListener('change', this.#repaint);
  }

  update(charts: readonly StageChart[]): void {
    this.#shown = charts;
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
    const { name, unit } = this.quantity;
    const what = ` ${name.toLowerCase()}${unit === '' ? '' : ` [${unit}]`} by ${iterationWord(chart.stage)}`;
    place.replaceChildren(h('figcaption', {}, h('strong', {}, title), what));
    if (known === undefined) this.element.append(place);
    const plot = new uPlot(optionsOf(chart, this.quantity, widthOf(place)), dataOf(chart), place);
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

function iterationWord(stage: string): string {
  return ITERATIONS[stage] ?? 'iteration';
}

function optionsOf({ stage, lines }: StageChart, quantity: Quantity, width: number): uPlot.Options {
  const { text, grid, series: colors } = inks();
  const axis = { stroke: text, grid: { stroke: grid, width: 1 }, ticks: { stroke: grid, width: 1 }, labelSize: 20 };
  const { name, unit, isLogarithmic } = quantity;
  const word = iterationWord(stage);
  return {
    width,
    height: HEIGHT,
    // As the lines.
    legend: { markers: { width: 2, dash: (_plot, index) => (lines[index - 1]?.isSolid ? 'solid' : 'dotted') } },
    hooks: { setCursor: [tellLast] },
    scales: { x: { time: false }, y: isLogarithmic ? { distr: 3 } : { range: (_plot, _low, high) => [0, 1.1 * high || 1] } },
    axes: [
      { ...axis, size: 32, incrs: WHOLE, label: capital(word) },
      {
        ...axis,
        size: 56,
        label: unit === '' ? name : `${name} [${unit}]`,
        values: (_plot, splits) =>
          splits.map((v) => (v === null ? '' : isLogarithmic ? v.toExponential(0) : String(Number(v.toPrecision(3))))),
      },
    ],
    series: [
      { label: capital(word) },
      ...lines.map(({ label, isSolid, model }) => ({
        label,
        stroke: colors[model % colors.length] ?? text,
        width: isSolid ? 2 : 1,
        ...(isSolid ? {} : { dash: [2, 3] }),
        spanGaps: true,
        // A single value has no line, and few are measured.
        points: { show: (plot: uPlot) => plot.data[0].length < (isLogarithmic ? 2 : 20) && (isSolid || isLogarithmic) },
        value: (_plot: uPlot, value: number | null) => (value === null ? '–' : quantity.text(value)),
      })),
    ],
  };
}

function capital(word: string): string {
  return word.charAt(0).toUpperCase() + word.slice(1);
}
