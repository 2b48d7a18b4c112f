// A page of figures and tables with text between them.
import { wheelColours } from './colours';
import type { FigureItem, Figures, FigureSeries } from './data';
import { Charts, type Line } from './plots';
import type { Page } from './run_page';
import { el, table } from './text';

const values = (v: (number | null)[]): Float64Array => Float64Array.from(v, (x) => x ?? NaN);

function lines(series: FigureSeries[]): Line[] {
  let next = 0;
  return series.map((s) => ({
    label: s.name,
    x: values(s.x),
    y: values(s.y),
    error: s.error.length > 0 ? values(s.error) : undefined,
    colour: wheelColours[(s.colour >= 0 ? s.colour : next++) % wheelColours.length],
    width: 1.8,
    ...(s.style === 'points' ? { points: true } : {}),
    ...(s.style === 'dashed' ? { dash: [7, 5] } : {}),
  }));
}

/** Text as it is typed: numbers to the right, an empty line begins a paragraph. */
const looksNumeric = (s: string): boolean => /^[+\-\u2212]?[\d.]+(e[+\-]?\d+)?( ?%)?$/i.test(s) || s === '' || /^\u2212?[\d.]+ (\u00b1|\+-) [\d.]+$/.test(s);

function figureTable(item: Extract<FigureItem, { kind: 'table' }>): HTMLElement {
  const numeric = item.columns.map((_, k) => item.rows.every((r) => looksNumeric(r[k])));
  const rows = item.rows.map((r) => r.map((c, k) => (numeric[k] ? el('span', { class: 'number' }, c.replace(/^-/, '\u2212')) : c)));
  return el('div', { class: 'card figure-table' }, item.title ? el('h3', {}, item.title) : null, table(item.columns, rows));
}

export function figurePage(host: HTMLElement, figures: Figures): Page {
  const charts = new Charts(null);
  if (figures.summary) host.append(el('div', { class: 'lead' }, el('div', { class: 'card' }, el('p', { class: 'sentence' }, figures.summary))));
  let grid: HTMLElement | null = null;
  for (const item of figures.items) {
    if (item.kind === 'plot') {
      if (!grid) host.append((grid = el('div', { class: 'grid figures' })));
      grid.append(
        charts.add(
          { title: item.title, unit: '', xLabel: item.x_label, yLabel: item.y_label, axis: 'other', logX: item.log_x, logY: item.log_y, free: true, height: 320, note: item.caption },
          lines(item.series),
        ),
      );
      continue;
    }
    grid = null;
    if (item.kind === 'table') host.append(figureTable(item));
    else for (const p of item.text.split(/\n\s*\n/)) if (p.trim()) host.append(el('p', { class: 'paragraph' }, p.trim()));
  }
  return { charts, mount: () => charts.mount() };
}
