import { expect, test } from 'vitest';

import { base64, doubles, floats, packed } from './tensor.js';

test('numbers are read as they were packed, whole or scaled', () => {
  expect([...floats(packed(Float32Array.of(0.5, -2), [2]), 'x')]).toEqual([0.5, -2]);
  const codes = new Uint8Array(Int16Array.of(-2, 0, 2).buffer);
  const scaled = { dtype: 'INT16_SCALED', shape: [1, 3], data: base64(codes), scale: 0.5, offset: 1 } as const;
  expect([...floats({ ...scaled, shape: [1, 3] }, 'x')]).toEqual([0, 1, 2]);
  expect(() => floats({ ...scaled, shape: [2, 3] }, 'x')).toThrow('x has 6 bytes');
  expect(() => floats({ ...scaled, dtype: 'UINT8', shape: [6] }, 'x')).toThrow('not FLOAT32');
  expect(floats(undefined, 'x')).toHaveLength(0);
  const precise = { dtype: 'FLOAT64', shape: [2], data: base64(new Uint8Array(Float64Array.of(0.1, -1).buffer)) } as const;
  expect([...doubles({ ...precise, shape: [2] })]).toEqual([0.1, -1]);
});
