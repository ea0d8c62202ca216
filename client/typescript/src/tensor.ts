import type { Tensor } from './types.js';

/** A tensor as raw bytes, as replies with `?tensors=base64` have it: little-endian, row-major. */
export type PackedTensor = Exclude<Tensor, unknown[]>;

/** Bytes of a number. */
const SIZES = { FLOAT32: 4, FLOAT64: 8, UINT32: 4, INT32: 4, UINT8: 1, INT16_SCALED: 2 } as const;

/** Values of a tensor of numbers, FLOAT32 or INT16_SCALED; none if it was left out. Throws if it is something else. */
export function floats(tensor: Tensor | undefined, name = 'the tensor'): Float32Array {
  if (tensor === undefined) return new Float32Array(0);
  if (Array.isArray(tensor) || tensor.dtype !== 'INT16_SCALED') return new Float32Array(bytesOf(tensor, 'FLOAT32', name));
  const { scale = 1, offset = 0 } = tensor;
  return Float32Array.from(new Int16Array(bytesOf(tensor, 'INT16_SCALED', name)), (code) => code * scale + offset);
}

/** Values of a FLOAT64 tensor; none if it was left out. Throws if it is something else. */
export function doubles(tensor: Tensor | undefined, name = 'the tensor'): Float64Array {
  return tensor === undefined ? new Float64Array(0) : new Float64Array(bytesOf(tensor, 'FLOAT64', name));
}

/** Values of a UINT32 tensor; none if it was left out. Throws if it is something else. */
export function indices(tensor: Tensor | undefined, name = 'the tensor'): Uint32Array {
  return tensor === undefined ? new Uint32Array(0) : new Uint32Array(bytesOf(tensor, 'UINT32', name));
}

/** Values of a UINT8 tensor; none if it was left out. Throws if it is something else. */
export function bytes(tensor: Tensor | undefined, name = 'the tensor'): Uint8Array {
  return tensor === undefined ? new Uint8Array(0) : new Uint8Array(bytesOf(tensor, 'UINT8', name));
}

/** A FLOAT32 tensor of rows, as requests have it. */
export function packed(values: Float32Array, shape: number[]): PackedTensor {
  return { dtype: 'FLOAT32', shape, data: base64(new Uint8Array(values.buffer, values.byteOffset, values.byteLength)) };
}

/** Bytes as base64. */
export function base64(bytes: Uint8Array): string {
  let text = '';
  // In parts, since the number of arguments of a call is limited.
  for (let at = 0; at < bytes.length; at += 0x8000) text += String.fromCharCode(...bytes.subarray(at, at + 0x8000));
  return btoa(text);
}

/** Decodes base64; throws if the text is invalid. */
export function bytesOfBase64(text: string): Uint8Array<ArrayBuffer> {
  return Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
}

function bytesOf(tensor: Tensor, dtype: PackedTensor['dtype'], name: string): ArrayBuffer {
  if (Array.isArray(tensor)) throw new Error(`${name} is a list, not base64`);
  if (tensor.dtype !== dtype) throw new Error(`${name} is ${tensor.dtype}, not ${dtype}`);
  const found = bytesOfBase64(tensor.data);
  const count = tensor.shape.reduce((product, length) => product * length, 1);
  if (found.length !== count * SIZES[dtype]) {
    throw new Error(`${name} has ${found.length} bytes, which its shape [${tensor.shape.join(', ')}] does not say`);
  }
  return found.buffer;
}
