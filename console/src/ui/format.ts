import { h } from './dom';

const NOTHING = '–';
const UNITS = ['B', 'kB', 'MB', 'GB', 'TB'];
const number = new Intl.NumberFormat('en');

/** A count with separators, as 12,300. */
export function count(value: number): string {
  return number.format(value);
}

/** `1 twin`, `2 twins`. */
export function counted(value: number, noun: string, plural = `${noun}s`): string {
  return `${count(value)} ${value === 1 ? noun : plural}`;
}

/** A word at the start of a header. */
export function capitalised(word: string): string {
  return word.charAt(0).toUpperCase() + word.slice(1);
}

/** A size [bytes] with three digits, as 1.25 MB. */
export function size(bytes: number | null | undefined): string {
  if (bytes === null || bytes === undefined) return NOTHING;
  let value = bytes;
  let unit = 0;
  while (value >= 999.5 && unit < UNITS.length - 1) {
    value /= 1000;
    unit += 1;
  }
  return `${unit === 0 ? value : Number(value.toPrecision(3))} ${UNITS[unit]}`;
}

/** A length [m] in millimetres with three digits, as 4.13 mm. */
export function millimetres(metres: number | null | undefined): string {
  if (metres === null || metres === undefined || !Number.isFinite(metres)) return NOTHING;
  // Less than a nanometre is rounding.
  const value = Math.abs(metres) < 1e-9 ? 0 : metres * 1000;
  return `${Math.abs(value) >= 100 ? value.toFixed(0) : Number(value.toPrecision(3))} mm`;
}

/** A number with three digits or as many as are wanted, as 0.123; a whole number with all of its digits. */
export function significant(value: number, digits = 3): string {
  return String(Number.isInteger(value) ? value : Number(value.toPrecision(digits)));
}

/** A share, 0..=1, in per cent. */
export function percent(share: number): string {
  return `${Math.round(share * 100)} %`;
}

/** A time span [s], as 4.2 s, 3 min 5 s or 2 h 10 min. */
export function duration(seconds: number | null | undefined): string {
  if (seconds === null || seconds === undefined || !Number.isFinite(seconds)) return NOTHING;
  if (seconds < 9.95) return `${seconds.toFixed(1)} s`;
  const whole = Math.round(seconds);
  if (whole < 60) return `${whole} s`;
  if (whole < 3600) return `${Math.floor(whole / 60)} min ${whole % 60} s`;
  if (whole < 86400) return `${Math.floor(whole / 3600)} h ${Math.floor((whole % 3600) / 60)} min`;
  return `${Math.floor(whole / 86400)} d ${Math.floor((whole % 86400) / 3600)} h`;
}

/** A moment (RFC 3339) as time of the day where it is today, else with its date. */
export function moment(text: string, now = new Date()): string {
  const date = new Date(text);
  if (Number.isNaN(date.getTime())) return text;
  const pad = (value: number): string => String(value).padStart(2, '0');
  const time = `${pad(date.getHours())}:${pad(date.getMinutes())}`;
  if (date.toDateString() === now.toDateString()) return `${time}:${pad(date.getSeconds())}`;
  return `${date.getFullYear()}-${pad(date.getMonth() + 1)}-${pad(date.getDate())} ${time}`;
}

/** A moment as an element that has the whole of it. */
export function time(text: string | null | undefined): HTMLElement {
  if (text === null || text === undefined) return h('span', {}, NOTHING);
  return h('time', { datetime: text, title: text }, moment(text));
}

/** A name given by a person, in any script, or a replacement for an empty one. */
export function name(text: string, otherwise = 'without a name'): HTMLElement {
  return text.trim() === '' ? h('i', { class: 'muted' }, otherwise) : h('bdi', {}, text);
}

/** Milliseconds since a moment (RFC 3339). */
export function since(text: string, now = Date.now()): number {
  return Math.max(now - Date.parse(text), 0);
}
