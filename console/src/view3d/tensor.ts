/** Throws if any index is not below a count. */
export function within(values: Uint32Array, count: number, name: string): void {
  if (values.some((value) => value >= count)) throw new Error(`${name} names what is not there`);
}

/** Values, of which there have to be as many as this; throws otherwise. */
export function ofLength<A extends Uint32Array | Float32Array | Uint8Array>(values: A, length: number, name: string): A {
  if (values.length !== length) throw new Error(`${name} has ${values.length} values in place of ${length}`);
  return values;
}
