import { describe, expect, it } from 'vitest';
import { formOf, readBoard, type Board, type BoardForm } from './board';

const FORM: BoardForm = {
  pattern: 'charuco',
  columns: '7',
  rows: ' 5 ',
  squareMm: '30',
  markerMm: '22,5',
  dictionary: 'DICT_5X5_100',
  legacy: true,
};
const BOARD: Board = {
  pattern: 'charuco',
  columns: 7,
  rows: 5,
  square_m: 0.03,
  marker_m: 0.0225,
  dictionary: 'DICT_5X5_100',
  legacy: true,
};

describe('a board', () => {
  it('is read in millimetres', () => {
    expect(readBoard(FORM)).toEqual({ board: BOARD });
    expect(readBoard({ ...FORM, pattern: 'april_grid' })).toEqual({ board: { ...BOARD, pattern: 'april_grid', legacy: false } });
  });

  it('goes into the form and out of it', () => {
    expect(readBoard(formOf(BOARD))).toEqual({ board: BOARD });
    const odd = { ...BOARD, square_m: 0.0391, marker_m: 0.1 / 3 };
    expect(readBoard(formOf(odd))).toEqual({ board: { ...odd, marker_m: 0.0333333333 } });
    expect(formOf(null)).toMatchObject({ pattern: 'charuco', columns: '', dictionary: 'DICT_5X5_100' });
  });

  it('that cannot be says where', () => {
    const faults = (changes: Partial<BoardForm>): [string, string][] => {
      const read = readBoard({ ...FORM, ...changes });
      return 'faults' in read ? [...read.faults] : [];
    };
    expect(faults({ columns: '', rows: '1' })).toEqual([
      ['columns', 'a whole number from 2 to 100'],
      ['rows', 'a whole number from 2 to 100'],
    ]);
    expect(faults({ columns: '7.5', squareMm: 'x' }).map(([name]) => name)).toEqual(['columns', 'squareMm']);
    expect(faults({ markerMm: '30' })).toEqual([['markerMm', 'less than 30']]);
  });
});
