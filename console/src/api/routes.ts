import type { paths } from './schema';

/** Routes that answer to GET with JSON. */
export type Path = {
  [P in keyof paths]: paths[P] extends { get: { responses: { 200: { content: { 'application/json': unknown } } } } }
    ? P
    : never;
}[keyof paths];

/** The body of a route's answer to GET. */
export type Reply<P extends Path> = paths[P] extends {
  get: { responses: { 200: { content: { 'application/json': infer Body } } } };
}
  ? Body
  : never;

/** The query of a route. */
export type Query<P extends Path> = paths[P] extends { get: { parameters: { query?: infer Q } } }
  ? NonNullable<Q>
  : never;

/** The address of a route: its `{id}` and its query filled in. Fields that are undefined or empty are left out. */
export function addressOf(route: string, id?: string, query?: object): string {
  const path = route.replace('{id}', encodeURIComponent(id ?? ''));
  const given = Object.entries(query ?? {}).filter(([, value]) => value !== undefined && value !== '');
  const search = new URLSearchParams(given.map(([name, value]) => [name, String(value)]));
  return search.size === 0 ? path : `${path}?${search}`;
}

/** The uuid in a resource's name, `fits/{uuid}`. */
export function idOf(name: string): string {
  return name.slice(name.indexOf('/') + 1);
}
