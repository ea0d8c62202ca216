/** Steps between marks of things that are counted, as frames and iterations. */
export const WHOLE = [1, 2, 5].flatMap((step) => [0, 1, 2, 3, 4].map((power) => step * 10 ** power)).sort((a, b) => a - b);

/** Colours of plots in the present scheme: text, lines of the grid, and those of the series. */
export interface Inks {
  readonly text: string;
  readonly grid: string;
  readonly series: readonly string[];
  /** The value of a variable of the styles, as `--warn`. */
  readonly of: (name: string) => string;
}

export function inks(): Inks {
  const style = getComputedStyle(document.documentElement);
  const of = (name: string): string => style.getPropertyValue(name).trim();
  return { text: of('--muted'), grid: of('--border'), series: [1, 2, 3, 4, 5, 6].map((series) => of(`--series-${series}`)), of };
}

/** Width that a place has for a plot [px]. */
export function widthOf(place: HTMLElement): number {
  const { paddingLeft, paddingRight } = getComputedStyle(place);
  return Math.max(Math.floor(place.clientWidth - parseFloat(paddingLeft) - parseFloat(paddingRight)), 200) || 200;
}
