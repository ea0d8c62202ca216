import { base64, packed, type TwinGeometry } from '@bendtwin/client';
import { describe, expect, it } from 'vitest';
import { readShape } from './shape';

function packedIndices(values: readonly number[], shape: number[]): ReturnType<typeof packed> {
  const numbers = new Uint32Array(values);
  return { dtype: 'UINT32', shape, data: base64(new Uint8Array(numbers.buffer)) };
}

function reply(): Partial<TwinGeometry> {
  return {
    rest_positions: packed(new Float32Array([0, 0, 0, 0.1, 0, 0]), [2, 3]),
    controls: packed(new Float32Array([0.1, 0, 0.2]), [1, 3]),
    hands: packedIndices([0], [1]),
    edges: packedIndices([0, 1, 1, 2], [2, 2]),
    rest_lengths: packed(new Float32Array([0.1, 0.2]), [2]),
    rod_starts: packedIndices([0, 2], [2]),
    rod_nodes: packedIndices([1, 0], [2]),
    ground: { normal: [], offset_m: 0.5 },
    gravity: [0, 0, -9.81],
  };
}

describe('readShape', () => {
  it('reads arrays, and defaults for missing ones', () => {
    const shape = readShape(reply());
    expect([...shape.springs]).toEqual([0, 1, 1, 2]);
    expect(shape.rods.map((rod) => [...rod])).toEqual([[1, 0]]);
    expect(shape.ground).toEqual({ normal: [0, 0, 1], offset_m: 0.5 });
    expect([shape.skin.starts.length, shape.massKg, shape.springStiffness.length]).toEqual([1, null, 0]);
    expect(shape.skinSd.length).toBe(0);
  });

  it('refuses arrays that do not belong together', () => {
    expect(() => readShape({ ...reply(), edges: packedIndices([0, 3, 1, 2], [2, 2]) })).toThrow('edges');
    expect(() => readShape({ ...reply(), hands: packedIndices([0, 0], [2]) })).toThrow('hands has 2 values');
    const sd = packed(new Float32Array([0.001]), [1]);
    expect(() => readShape({ ...reply(), skin_sd: sd })).toThrow('skin_sd has 1 values');
    const short = { ...packed(new Float32Array(3), [1, 3]), shape: [2, 3] };
    expect(() => readShape({ ...reply(), rest_positions: short })).toThrow('12 bytes');
    const bytes = { ...packed(new Float32Array(6), [2, 3]), dtype: 'FLOAT64' as const };
    expect(() => readShape({ ...reply(), rest_positions: bytes })).toThrow('FLOAT64');
  });
});
