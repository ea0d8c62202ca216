import { describe, expect, it } from 'vitest';
import type { Appearance } from '../../view3d/appearance';
import type { Surface } from '../../view3d/surface/surface';
import { readLook } from './picture';

const coloured: Appearance = { skinColours: new Uint8Array(3), splats: null };
const empty = new Float32Array(0);
const none = new Uint32Array(0);
const splats = {
  carriers: { starts: none, nodes: none, weights: empty, frames: none, offsets: empty },
  scales: empty, rotations: empty, opacities: empty, colours: empty,
};

describe('the layers of a twin', () => {
  const layers = (appearance: Appearance | null, query = '', surface: Surface | null = null): string[] =>
    [...readLook(new URLSearchParams(query), { appearance, surface }).layers];

  it('have springs unless there are splats that these would pierce, or a surface that hides them', () => {
    expect(layers(null)).toContain('springs');
    expect(layers(coloured)).toContain('springs');
    expect(layers({ ...coloured, splats })).toEqual(['skin', 'appearance', 'shadow']);
    const surface = { carriers: splats.carriers, triangles: none, colours: new Uint8Array(0), tubes: [] };
    expect(layers(null, '', surface)).toEqual(['skin', 'appearance', 'shadow']);
  });

  it('are those of the address where it names some', () => {
    expect(layers({ ...coloured, splats }, 'layers=springs,nothing')).toEqual(['springs']);
  });
});
