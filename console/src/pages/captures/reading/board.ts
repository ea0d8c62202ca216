/** A flat board for calibrating, as the settings of an ingest have it. */
export interface Board {
  readonly pattern: 'charuco' | 'april_grid';
  readonly columns: number;
  readonly rows: number;
  readonly square_m: number;
  readonly marker_m: number;
  readonly dictionary: string;
  readonly legacy: boolean;
}

/** What is typed into the form of a board, sizes in millimetres. */
export interface BoardForm {
  readonly pattern: Board['pattern'];
  readonly columns: string;
  readonly rows: string;
  readonly squareMm: string;
  readonly markerMm: string;
  readonly dictionary: string;
  readonly legacy: boolean;
}

type Numbers = 'columns' | 'rows' | 'squareMm' | 'markerMm';

/** Kinds of boards with the words for their sizes, and their usual dictionary. */
export const PATTERNS = {
  charuco: {
    label: 'ChArUco: a chessboard with markers in its white squares',
    columns: 'Squares in a row',
    rows: 'Rows of squares',
    squareMm: 'Side of a square [mm]',
    markerMm: 'Side of a marker [mm]',
    hint: 'Squares of both colours count.',
    dictionary: 'DICT_5X5_100',
  },
  april_grid: {
    label: 'AprilGrid: a grid of AprilTags, as Kalibr draws it',
    columns: 'Tags in a row',
    rows: 'Rows of tags',
    squareMm: 'Centre to centre of neighbouring tags [mm]',
    markerMm: 'Side of a tag [mm]',
    hint: 'Centre to centre is tagSize × (1 + tagSpacing) of Kalibr.',
    dictionary: 'DICT_APRILTAG_36h11',
  },
} as const;

/** Usual dictionaries of markers, by OpenCV's names. */
export const DICTIONARIES: readonly string[] = [
  ...['4X4', '5X5', '6X6', '7X7'].flatMap((bits) => [50, 100, 250, 1000].map((count) => `DICT_${bits}_${count}`)),
  'DICT_ARUCO_ORIGINAL',
  'DICT_APRILTAG_16h5',
  'DICT_APRILTAG_25h9',
  'DICT_APRILTAG_36h10',
  'DICT_APRILTAG_36h11',
];

/** The board of a form, or what is wrong with its fields. */
export function readBoard(form: BoardForm): { board: Board } | { faults: ReadonlyMap<Numbers, string> } {
  const faults = new Map<Numbers, string>();
  const number = (name: Numbers, least: number, most: number, isWhole: boolean): number => {
    // A comma is how many write the decimal point.
    const value = Number(form[name].trim().replace(',', '.') || NaN);
    if (!(value >= least && value <= most) || (isWhole && !Number.isInteger(value))) {
      faults.set(name, `a ${isWhole ? 'whole ' : ''}number from ${least} to ${most}`);
    }
    return value;
  };
  const columns = number('columns', 2, 100, true);
  const rows = number('rows', 2, 100, true);
  const square = number('squareMm', 0.1, 10_000, false);
  const marker = number('markerMm', 0.1, 10_000, false);
  if (faults.size === 0 && marker >= square) faults.set('markerMm', `less than ${square}`);
  if (faults.size > 0) return { faults };
  const { pattern, dictionary, legacy } = form;
  const sizes = { columns, rows, square_m: metres(square), marker_m: metres(marker) };
  return { board: { pattern, ...sizes, dictionary, legacy: legacy && pattern === 'charuco' } };
}

/** The form of a board, or an empty one. */
export function formOf(board: Board | null): BoardForm {
  const pattern = board?.pattern ?? 'charuco';
  const mm = (metres: number | undefined): string => (metres === undefined ? '' : String(Number((1000 * metres).toPrecision(9))));
  return {
    pattern,
    columns: String(board?.columns ?? ''),
    rows: String(board?.rows ?? ''),
    squareMm: mm(board?.square_m),
    markerMm: mm(board?.marker_m),
    dictionary: board?.dictionary ?? PATTERNS[pattern].dictionary,
    legacy: board?.legacy ?? false,
  };
}

function metres(mm: number): number {
  return Number((mm / 1000).toPrecision(12));
}
