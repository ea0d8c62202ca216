import { describe, expect, it } from 'vitest';
import { DIVERGING, SEQUENTIAL, colourAt, rangeOf, shareOf, texels, type Colour } from './colour';

/** Lightness of a colour as the eye has it (CIE L*). */
function lightness(colour: Colour): number {
  const [r, g, b] = colour.map((part) => (part <= 0.04045 ? part / 12.92 : ((part + 0.055) / 1.055) ** 2.4));
  const y = 0.2126 * r! + 0.7152 * g! + 0.0722 * b!;
  return 116 * Math.cbrt(y) - 16;
}

describe('colour maps', () => {
  it('go from end to end and stay there', () => {
    expect(colourAt(SEQUENTIAL, 0)).toEqual([0x44 / 255, 0x01 / 255, 0x54 / 255]);
    expect(colourAt(SEQUENTIAL, 2)).toEqual([0xfd / 255, 0xe7 / 255, 0x25 / 255]);
    expect(colourAt(SEQUENTIAL, Number.NaN)).toEqual(colourAt(SEQUENTIAL, 0));
  });

  it('can be read without colours: more is lighter', () => {
    const steps = Array.from({ length: 33 }, (_, i) => lightness(colourAt(SEQUENTIAL, i / 32)));
    steps.slice(1).forEach((step, i) => expect(step).toBeGreaterThan(steps[i]!));
  });

  it('have ends that differ in blue and yellow, which nearly everyone sees', () => {
    const [low, high] = [colourAt(DIVERGING, 0), colourAt(DIVERGING, 1)];
    const blue = ([r, g, b]: Colour): number => b - (r + g) / 2;
    expect(blue(low) - blue(high)).toBeGreaterThan(0.6);
  });

  it('are textures of bytes', () => {
    const bytes = texels(DIVERGING, 256);
    expect([bytes.length, bytes[3], bytes[0], bytes[4 * 255]]).toEqual([1024, 255, 0x0a, 0xb3]);
  });
});

describe('ranges', () => {
  it('leave out outliers and NaN', () => {
    const values = Array.from({ length: 1000 }, (_, i) => i);
    const range = rangeOf([...values, Number.NaN, 1e30]);
    expect(range.low).toBeCloseTo(10, 0);
    expect(range.high).toBeCloseTo(990, 0);
    expect(rangeOf([])).toEqual({ low: 0, high: 1 });
  });

  it('say where a value lies', () => {
    expect(shareOf({ low: 2, high: 4 }, 3)).toBe(0.5);
    expect(shareOf({ low: 2, high: 2 }, 9)).toBe(0.5);
  });
});
