/** A JSON object of settings. */
export type Settings = Record<string, unknown>;

/** A fault in a line of settings: its number from 0, or null if it is about all of them. */
export interface SettingsFault {
  readonly line: number | null;
  readonly text: string;
}

/** Settings that were typed, a `name = value` a line, as JSON with the names' dots as its levels. */
export function readSettings(text: string): { value: Settings; isEmpty: boolean; faults: SettingsFault[] } {
  const value: Settings = {};
  const faults: SettingsFault[] = [];
  const seen = new Set<string>();
  text.split('\n').forEach((line, index) => {
    if (line.trim() === '') return;
    const at = line.indexOf('=');
    const [name, given] = at < 0 ? ['', ''] : [line.slice(0, at).trim(), line.slice(at + 1).trim()];
    const say = (fault: string): void => void faults.push({ line: index, text: fault });
    if (at < 0 || !/^\w+(\.\w+)*$/.test(name)) say(`"${line.trim()}": write name = value, for example graph.max_nodes = 400.`);
    else if (given === '') say(`${name} has no value.`);
    else if (seen.has(name)) say(`${name} occurs twice.`);
    else if (!put(value, name.split('.'), readValue(given))) say(`${name} is both a group and a value.`);
    seen.add(name);
  });
  return { value, isEmpty: Object.keys(value).length === 0, faults };
}

/** A value as JSON, or as text if it is not JSON. */
export function readValue(text: string): unknown {
  try {
    return JSON.parse(text);
  } catch {
    return text;
  }
}

/** Sets a value by its path; false if there is a value on the way, or a group at its end. */
export function put(into: Settings, path: readonly string[], value: unknown): boolean {
  const [first, ...rest] = path;
  if (first === undefined) return false;
  const own = Object.hasOwn(into, first) ? into[first] : undefined;
  if (rest.length === 0) {
    if (own !== undefined) return false;
    // An own property for any name, including `__proto__`.
    Object.defineProperty(into, first, { value, enumerable: true, writable: true, configurable: true });
    return true;
  }
  if (own !== undefined && !isGroup(own)) return false;
  const group: Settings = own ?? {};
  Object.defineProperty(into, first, { value: group, enumerable: true, writable: true, configurable: true });
  return put(group, rest, value);
}

/** Settings by their dotted names, in their order. */
export function flat(settings: unknown, prefix = ''): [string, unknown][] {
  const isEmpty = isGroup(settings) && Object.keys(settings).length === 0;
  if (!isGroup(settings) || (isEmpty && prefix !== '')) return [[prefix, settings]];
  return Object.entries(settings).flatMap(([name, value]) => flat(value, prefix === '' ? name : `${prefix}.${name}`));
}

/** True for a group of settings. */
export function isGroup(value: unknown): value is Settings {
  return typeof value === 'object' && value !== null && !Array.isArray(value);
}

/**
 * Faults in the server's message about settings, by the name of the setting: messages are `name:
 * text` or `name is 0: text`, separated by semicolons. Faults without a name have the empty one.
 */
export function faultsByName(detail: string): Map<string, string> {
  const text = detail.replace(/^[^:]*settings are not accepted: /, '');
  const faults = new Map<string, string>();
  for (const part of text.split(/; (?=[a-z_][\w.]*(?::| is ))/)) {
    const [, name = ''] = /^([a-z_][\w.]*)(?::| is )/.exec(part) ?? [];
    const isNamed = text !== detail && name !== '';
    const own = isNamed ? name : '';
    const message = isNamed && part.startsWith(`${name}: `) ? part.slice(name.length + 2) : part;
    faults.set(own, faults.has(own) ? `${faults.get(own)}; ${message}` : message);
  }
  return faults;
}
