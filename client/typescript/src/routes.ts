import type { paths } from './schema.js';

/** Methods of HTTP with typed requests. */
export type Verb = 'get' | 'post' | 'patch';

/** The body of a message in JSON. */
type Json<Message> = Message extends { content: { 'application/json': infer Body } } ? Body : never;

type Operation<P extends keyof paths, V extends Verb> = paths[P] extends Record<V, infer Found> ? Found : never;

type Answer<P extends keyof paths, V extends Verb> =
  Operation<P, V> extends { responses: infer Answers } ? Json<Answers[keyof Answers & (200 | 201 | 202)]> : never;

/** Routes that answer to a method with JSON. */
export type Path<V extends Verb = 'get'> = { [P in keyof paths]: [Answer<P, V>] extends [never] ? never : P }[keyof paths];

/** The body of a route's answer. */
export type Reply<P extends Path<V>, V extends Verb = 'get'> = Answer<P, V>;

/** The query of a route. */
export type Query<P extends Path<V>, V extends Verb = 'get'> =
  Operation<P, V> extends { parameters: { query?: infer Found } } ? NonNullable<Found> : never;

/** The body of a request to a route. */
export type Body<P extends Path<V>, V extends Verb> =
  Operation<P, V> extends { requestBody: infer Message } ? Json<Message> : never;

/** What a request to a route is given: the parts of its address, its query, its body. */
export type Arguments<P extends Path<V>, V extends Verb> = {
  readonly query?: Query<P, V>;
  /** Ends the request. */
  readonly signal?: AbortSignal;
} & (P extends `${string}{id}${string}` ? { readonly id: string } : unknown) &
  ([Body<P, V>] extends [never] ? unknown : { readonly body: Body<P, V> }) &
  (V extends 'post' ? { /** Idempotency key, with which the request can be repeated. */ readonly key?: string } : unknown);

/** Arguments, which may be left out where none is required. */
export type Given<P extends Path<V>, V extends Verb> =
  Record<never, never> extends Arguments<P, V> ? [Arguments<P, V>?] : [Arguments<P, V>];

/** The address of a route: its `{id}` and its query filled in. Fields that are undefined or empty are left out. */
export function addressOf(route: string, id?: string, query?: object): string {
  const path = route.replace('{id}', encodeURIComponent(id ?? ''));
  const given = Object.entries(query ?? {}).filter(([, value]) => value !== undefined && value !== '');
  const search = new URLSearchParams(given.map(([name, value]): [string, string] => [name, String(value)]));
  return search.size === 0 ? path : `${path}?${search}`;
}

/** The uuid in a resource's name, `fits/{uuid}`. */
export function idOf(name: string): string {
  return name.slice(name.indexOf('/') + 1);
}
